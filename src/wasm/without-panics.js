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

/** The files that the places of panics name: Rust's own, other crates' and ours. */
const FILE = /(?:\/rustc\/[0-9a-f]{40}\/library\/|crates\/|src\/)[\w/.-]+?\.rs/g;

/** What panics of Rust's own libraries and of nalgebra would say; no message of an error has these words. */
const SENTENCES = [
  'index out of bounds: the len is ',
  ' but the index is ',
  ' out of range for slice of length ',
  'copy_from_slice: source slice length (',
  ') does not match destination slice length (',
  'Dot product dimensions mismatch for shapes ',
  ': left rows != right rows.',
  'Allocation from iterator error: the iterator did not yield the correct number of elements.',
  'one-time initialization may not be performed recursively',
  'internal error: entered unreachable code: invalid Once state',
  'a Display implementation returned an error unexpectedly',
  'chunk size must be non-zero',
  'mid > len',
  'Formatting argument out of range',
  'attempt to join into collection with len > usize::MAX',
  'Tried to shrink to a larger capacity',
  'Gemv: dimensions mismatch.',
  'Axcpy: mismatched vector shapes.',
  'Axpy: mismatched vector shapes.',
  'Matrix slicing out of bounds.',
  'Data storage buffer dimension mismatch.',
  'Matrix index out of bounds.',
  'Matrix addition/subtraction dimensions mismatch.',
  'Cannot compute the trace of non-square matrix.',
  'Incompatible shape for transposition.',
  'Matrix init. from row iterator: iterator not long enough.',
  'The input matrix must be square.',
  'called `Result::unwrap()` on an `Err` value',
  'called `Option::unwrap()` on a `None` value',
  'a formatting trait implementation returned an error when the underlying stream did not',
  'slice index starts at ',
  ' but ends at ',
  'range start index ',
  'range end index ',
  'swap_remove index (is ',
  ') should be < len (is ',
  'assertion `left ',
  ' right` failed',
  '\n  left: ',
  '\n right: ',
  'attempt to divide by zero',
  'attempt to calculate the remainder with a divisor of zero',
  'RefCell already mutably borrowed',
  'RefCell already borrowed',
];

/**
 * Wipes what nobody reads any more: what panics would say, and the places that they would name, a record of file, line
 * and column each.
 * @param {Buffer} wasm @returns {{ places: number, sentences: number }} how many
 */
function forget(wasm) {
  let at = 8;
  const number = () => {
    let [value, shift] = [0, 0];
    for (;;) {
      const byte = wasm[at++];
      value |= (byte & 0x7f) << shift;
      shift += 7;
      if (byte < 0x80) return value >>> 0;
    }
  };
  /** Where in memory and in the file each segment of data is. @type {{ memory: number, file: number, size: number }[]} */
  const segments = [];
  while (at < wasm.length) {
    const section = wasm[at++];
    const end = number() + at;
    if (section === 11) {
      for (let n = number(); n > 0; n--) {
        if (number() !== 0 || wasm[at++] !== 0x41) throw new Error(`${from}: data that is not at a fixed place`);
        const memory = number();
        at += 1; // the end of the expression
        const size = number();
        segments.push({ memory, file: at, size });
        at += size;
      }
    }
    at = end;
  }
  /** @type {Map<number, number>} */
  const files = new Map();
  for (const { memory, file, size } of segments) {
    for (const { index, 0: name } of wasm.toString('latin1', file, file + size).matchAll(FILE)) files.set(memory + index, name.length);
  }
  let sentences = 0;
  for (const { file, size } of segments) {
    for (const sentence of SENTENCES) {
      for (let i = wasm.indexOf(sentence, file); i >= 0 && i + sentence.length <= file + size; i = wasm.indexOf(sentence, i)) {
        wasm.fill(0, i, i + sentence.length);
        sentences += 1;
      }
    }
  }
  let places = 0;
  const named = new Set();
  for (const { memory, file, size } of segments) {
    for (let i = -memory & 3; i + 16 <= size; i += 4) {
      const [name, length] = [wasm.readUInt32LE(file + i), wasm.readUInt32LE(file + i + 4)];
      if (length === 0 || files.get(name) !== length) continue;
      wasm.fill(0, file + i, file + i + 16);
      named.add(name);
      places += 1;
      i += 12;
    }
    for (const name of named) {
      const start = name - memory;
      if (start >= 0 && start < size) wasm.fill(0, file + start, file + start + (files.get(name) ?? 0));
    }
  }
  return { places, sentences };
}

const wasm = readFileSync(from);
const { places, sentences } = forget(wasm);
const module = binaryen.readBinary(wasm);
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
if (sentences < 20) throw new Error(`${from}: only ${sentences} sentences of panics were found`);
if (places < 100) throw new Error(`${from}: only ${places} places of panics were found`);
writeFileSync(to, module.emitBinary());
module.dispose();
