// The build's part in finding faces and people in photos: MediaPipe's packages as files of this site, in
// folders of their own that no page loads before a photo is there.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join } from 'node:path';

const require = createRequire(import.meta.url);

/** What a page takes of a package. @param {string} name @param {string[]} files */
function folderOf(name, files) {
  const description = require.resolve(`@mediapipe/${name}/package.json`);
  /** @type {{ version: string }} */
  const { version } = require(description);
  const modules = ['solution_simd_wasm_bin', 'solution_wasm_bin'].flatMap((build) => [`${name}_${build}.js`, `${name}_${build}.wasm`]);
  // Files of one version never change: whoever has them need not ask again.
  return { folder: `${name}-${version}/`, source: dirname(description), files: [`${name}.js`, `${name}.binarypb`, ...files, ...modules] };
}

const FACES = folderOf('face_mesh', ['face_mesh_solution_packed_assets.data', 'face_mesh_solution_packed_assets_loader.js']);
const PERSON = folderOf('selfie_segmentation', ['selfie_segmentation.tflite']);
const PACKAGES = [FACES, PERSON];

/** Where they are, relative to the page. */
export const FOLDERS = { faces: FACES.folder, person: PERSON.folder };

const EVALUATES = /new Function\(|new_\(Function|\beval\(/;
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
  if (start < 0 || end < 0 || script.indexOf(from, start + 1) >= 0) throw new Error(`MediaPipe's script is not as expected: ${from}`);
  return script.slice(0, start) + by + script.slice(end);
}

/** @param {string} script */
function withoutEvaluation(script) {
  const changed = [
    ['return new Function("body"', 'var emval_handle_array', NAMED],
    ['function craftInvokerFunction(', 'function heap32VectorToArray(', INVOKER],
    ['function __emval_get_method_caller(', 'function __emval_incref(', CALLER],
  ].reduce((now, [from, to, by]) => replace(now, from, to, by), script);
  if (EVALUATES.test(changed)) throw new Error("MediaPipe's script still evaluates strings");
  return NOTICE + changed;
}

/** @param {typeof FACES} of @param {string} name */
function read({ source }, name) {
  const bytes = readFileSync(join(source, name));
  if (!name.endsWith('wasm_bin.js')) return bytes;
  const script = bytes.toString('utf8');
  return EVALUATES.test(script) ? Buffer.from(withoutEvaluation(script)) : bytes;
}

/** @returns {import('vite').Plugin} */
export function mediapipe() {
  const all = PACKAGES.flatMap((of) => of.files.map((name) => ({ path: of.folder + name, read: () => read(of, name) })));
  return {
    name: 'mediapipe',
    generateBundle() {
      // The packages say Apache-2.0 and come without the text, which has to go along.
      for (const { folder } of PACKAGES) {
        this.emitFile({ type: 'asset', fileName: `${folder}LICENSE`, source: readFileSync(new URL('../LICENSE-APACHE', import.meta.url)) });
      }
      for (const file of all) this.emitFile({ type: 'asset', fileName: file.path, source: file.read() });
    },
    configureServer(server) {
      server.middlewares.use((request, response, next) => {
        const file = all.find(({ path }) => request.url?.split('?')[0].endsWith(`/${path}`));
        if (!file) return next();
        const types = { js: 'text/javascript', wasm: 'application/wasm' };
        response.setHeader('content-type', types[/** @type {'js'} */ (file.path.split('.').pop())] ?? 'application/octet-stream');
        response.end(file.read());
      });
    },
  };
}
