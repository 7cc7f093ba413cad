// Takes what a panic would say out of a module, so that it only traps.
//
//     node without-panics.js BINARYEN IN OUT
//
// On wasm a panic prints nothing and ends in a trap; the sentence is put together for nobody. But the
// code that does, and the places that call it with a file and a line, are a tenth of the module. Rust's
// own switch for that (panic=immediate-abort) needs a standard library that is built anew. A trap is
// what there was before: no check goes, and nothing runs on.
import { readFileSync, writeFileSync } from 'node:fs';
import { pathToFileURL } from 'node:url';

const [, , binaryenPath, from, to] = process.argv;
const { default: binaryen } = await import(pathToFileURL(binaryenPath).href);
const { Features } = binaryen;

/**
 * The functions of `core`, `alloc` and `std` that never return, and what writes values for programmers
 * (`{:?}`), which only these call: no message of an error does.
 */
const PANICS = new RegExp(
  [
    /\bfmt::(Debug|LowerHex|UpperHex)>::fmt(::h[0-9a-f]+)?$/,
    /\bfmt::builders::/,
    /\bFormatter>::debug_/,
    /\bpanicking::/, // panic_fmt, panic_bounds_check, assert_failed ...
    /\b(option|result)::(unwrap|expect)_failed$/,
    /\bslice::\w+(::\w+)*_fail$/,
    /\bstr::slice_error_fail/,
    /\bcell::panic_already/,
    /\bpanic_(on_ord_violation|access_error|for_nonpositive_argument)$/,
    /\braw_vec::(handle_error|capacity_overflow)$/,
    /\bFallibility>::capacity_overflow$/,
    /\balloc::handle_alloc_error$/,
    /\brust_(panic|begin_unwind)$/,
  ]
    .map(({ source }) => source)
    .join('|'),
);

const module = binaryen.readBinary(readFileSync(from));
module.setFeatures(
  Features.BulkMemory |
    Features.ReferenceTypes |
    Features.SignExt |
    Features.NontrappingFPToInt |
    Features.MutableGlobals |
    Features.Multivalue |
    Features.SIMD128,
);
let found = 0;
const functions = Array.from({ length: module.getNumFunctions() }, (_, i) => binaryen.getFunctionInfo(module.getFunctionByIndex(i)));
for (const { name, module: imported, params, results } of functions) {
  if (imported || !PANICS.test(name)) continue;
  module.removeFunction(name);
  module.addFunction(name, params, results, [], module.unreachable());
  found += 1;
}
// Another compiler may name them otherwise; then this is to be looked at again.
if (found < 10) throw new Error(`${from}: only ${found} functions that panic were found`);
writeFileSync(to, module.emitBinary());
module.dispose();
