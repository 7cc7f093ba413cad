export { aroundGaze, isEyeball } from './eyeballs.js';
export { toGlb } from './glb.js';
export { toObj } from './obj.js';
export { toPly } from './ply.js';
export { toStl } from './stl.js';
export { expressionTargets, morphTargets } from './targets.js';
