// The build's part in finding faces: `@mediapipe/face_mesh` as files of this site, in a folder of
// their own that no page loads before a photo is there.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join } from 'node:path';

const require = createRequire(import.meta.url);
const source = dirname(require.resolve('@mediapipe/face_mesh/package.json'));
/** @type {{ version: string }} */
const { version } = require('@mediapipe/face_mesh/package.json');

/** Files of one version never change: whoever has them need not ask again. */
export const FACE_MESH = `face_mesh-${version}/`;

const FILES = [
  'face_mesh.js',
  'face_mesh.binarypb',
  'face_mesh_solution_packed_assets.data',
  'face_mesh_solution_packed_assets_loader.js',
  'face_mesh_solution_simd_wasm_bin.js',
  'face_mesh_solution_simd_wasm_bin.wasm',
  'face_mesh_solution_wasm_bin.js',
  'face_mesh_solution_wasm_bin.wasm',
];

const NOTICE = '/* Changed for phiz: embind makes its functions without evaluating strings. */\n';

// Emscripten wrote these three with `new Function`, which the site's policy forbids. What stands here
// is what it writes with -sDYNAMIC_EXECUTION=0.
const NAMED = 'return{[name]:function(){return body.apply(this,arguments)}}[name]}';
const INVOKER = `function craftInvokerFunction(humanName,argTypes,classType,cppInvokerFunc,cppTargetFunc){
var argCount=argTypes.length;if(argCount<2){throwBindingError("argTypes array size mismatch! Must at least get return value and 'this' types!")}
var isMethod=argTypes[1]!==null&&classType!==null;
var needsDestructorStack=argTypes.slice(1).some(type=>type!==null&&type.destructorFunction===undefined);
var returns=argTypes[0].name!=="void";
return createNamedFunction(humanName,function(){
if(arguments.length!==argCount-2){throwBindingError("function "+humanName+" called with "+arguments.length+" arguments, expected "+(argCount-2)+" args!")}
var destructors=needsDestructorStack?[]:null;
var wired=isMethod?[argTypes[1].toWireType(destructors,this)]:[];
for(var i=0;i<argCount-2;++i){wired.push(argTypes[i+2].toWireType(destructors,arguments[i]))}
var rv=cppInvokerFunc.apply(null,[cppTargetFunc].concat(wired));
if(needsDestructorStack){runDestructors(destructors)}
else{var types=isMethod?argTypes.slice(1):argTypes.slice(2);types.forEach((type,i)=>{if(type.destructorFunction!==null){type.destructorFunction(wired[i])}})}
if(returns){return argTypes[0].fromWireType(rv)}})}`;
const CALLER = `function __emval_get_method_caller(argCount,argTypes){
var types=__emval_lookupTypes(argCount,argTypes);var retType=types[0];var rest=types.slice(1);
var signatureName=retType.name+"_$"+rest.map(type=>type.name).join("_")+"$";
var returnId=emval_registeredMethods[signatureName];if(returnId!==undefined){return returnId}
returnId=__emval_addMethodCaller(function(handle,name,destructors,args){
var offset=0;var values=rest.map(type=>{var value=type.readValueFromPointer(args+offset);offset+=type.argPackAdvance;return value});
var rv=handle[name].apply(handle,values);
rest.forEach((type,i)=>{if(type.deleteObject){type.deleteObject(values[i])}});
if(!retType.isVoid){return retType.toWireType(destructors,rv)}});
emval_registeredMethods[signatureName]=returnId;return returnId}`;

/**
 * @param {string} script @param {string} from @param {string} to the beginning of what stays after it
 * @param {string} by
 */
function replace(script, from, to, by) {
  const start = script.indexOf(from);
  const end = script.indexOf(to, start);
  if (start < 0 || end < 0 || script.indexOf(from, start + 1) >= 0) throw new Error(`@mediapipe/face_mesh is not as expected: ${from}`);
  return script.slice(0, start) + by + script.slice(end);
}

/** @param {string} script */
function withoutEvaluation(script) {
  const changed = [
    ['return new Function("body"', 'var emval_handle_array', NAMED],
    ['function craftInvokerFunction(', 'function heap32VectorToArray(', INVOKER],
    ['function __emval_get_method_caller(', 'function __emval_incref(', CALLER],
  ].reduce((now, [from, to, by]) => replace(now, from, to, by), script);
  if (/new Function\(|new_\(Function|\beval\(/.test(changed)) throw new Error('@mediapipe/face_mesh still evaluates strings');
  return NOTICE + changed;
}

/** @param {string} name */
function read(name) {
  const bytes = readFileSync(join(source, name));
  return name.endsWith('wasm_bin.js') ? Buffer.from(withoutEvaluation(bytes.toString('utf8'))) : bytes;
}

/** @returns {import('vite').Plugin} */
export function faceMesh() {
  return {
    name: 'face-mesh',
    generateBundle() {
      // The package says Apache-2.0 and comes without the text, which has to go along.
      this.emitFile({ type: 'asset', fileName: `${FACE_MESH}LICENSE`, source: readFileSync(new URL('../LICENSE-APACHE', import.meta.url)) });
      for (const name of FILES) this.emitFile({ type: 'asset', fileName: FACE_MESH + name, source: read(name) });
    },
    configureServer(server) {
      server.middlewares.use((request, response, next) => {
        const name = FILES.find((file) => request.url?.split('?')[0].endsWith(`/${FACE_MESH}${file}`));
        if (!name) return next();
        const types = { js: 'text/javascript', wasm: 'application/wasm' };
        response.setHeader('content-type', types[/** @type {'js'} */ (name.split('.').pop())] ?? 'application/octet-stream');
        response.end(read(name));
      });
    },
  };
}
