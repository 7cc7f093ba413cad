/** A wasm file as the bundler that brings it makes it: its address, its bytes, or compiled. */
declare const wasm: import('./index.js').Wasm;
export default wasm;
