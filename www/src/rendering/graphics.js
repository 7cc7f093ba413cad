/** @type {boolean | undefined} */
let byProcessor;

/**
 * Whether a processor draws what a graphics card is for: smooth edges would take half of its time, and
 * textures that are sharp at a slant some. Only a context tells, and cannot be made otherwise afterwards.
 */
export function drawnByProcessor() {
  byProcessor ??= ask();
  return byProcessor;
}

function ask() {
  const context = document.createElement('canvas').getContext('webgl2');
  if (!context) return false;
  const info = context.getExtension('WEBGL_debug_renderer_info');
  const name = String(context.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : context.RENDERER));
  context.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}
