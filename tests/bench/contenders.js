// What is measured, and beside what. Runs in Node and in a page alike: whoever calls gives the bytes.
//
// Contenders of one measurement take turns in rounds, another one first each round, so that a slow
// moment of the machine falls on all of them; a figure is the median of its rounds. Each does the same
// work on the committed model, which is checked.

const ROUNDS = 11;
/** A round lasts at least so long, ms: browsers tell the time in steps of a tenth of one. */
const ROUND = 12;

/** @param {number[]} numbers */
function median(numbers) {
  const sorted = numbers.toSorted((a, b) => a - b);
  const half = sorted.length / 2;
  return (sorted[Math.floor(half)] + sorted[Math.ceil(half) - 1]) / 2;
}

/**
 * Times contenders against each other.
 * @param {Record<string, (turn: number) => void>} contenders each does its work once, with another value each turn
 * @returns {Record<string, { us: number, spread: [number, number] }>} microseconds a turn
 */
function race(contenders) {
  const names = Object.keys(contenders);
  /** @type {Record<string, { turns: number, times: number[] }>} */
  const found = {};
  // Each turn is another value, however few there are in a round.
  let turn = 0;
  for (const name of names) {
    // Warm, and how many turns a round takes.
    let turns = 1;
    for (;;) {
      const start = performance.now();
      for (let i = 0; i < turns; i++) contenders[name](turn++);
      if (performance.now() - start > ROUND) break;
      turns *= 2;
    }
    found[name] = { turns, times: [] };
  }
  for (let round = 0; round < ROUNDS; round++) {
    for (let i = 0; i < names.length; i++) {
      const name = names[(i + round) % names.length];
      const { turns, times } = found[name];
      const start = performance.now();
      for (let i = 0; i < turns; i++) contenders[name](turn++);
      times.push((1000 * (performance.now() - start)) / turns);
    }
  }
  return Object.fromEntries(
    names.map((name) => {
      const { times } = found[name];
      return [name, { us: median(times), spread: [Math.min(...times), Math.max(...times)] }];
    }),
  );
}

/**
 * The modes as a page without phiz would have them: one dense f32 displacement a coefficient, measured
 * from the model itself, since positions are linear in the coefficients.
 * @param {import('phiz').FaceModel} model
 */
function denseModes(model) {
  const face = model.face();
  const zero = new Float32Array(face.coefficients.length);
  face.coefficients = zero;
  const mean = face.positions.slice();
  const modes = Array.from(zero, (_, i) => {
    const unit = zero.slice();
    unit[i] = 1;
    face.coefficients = unit;
    return face.positions.map((x, at) => x - mean[at]);
  });
  face.free();
  return { mean, modes };
}

/**
 * Plain JavaScript on typed arrays and three.js's normals: what a page does today. Only the modes whose
 * coefficient changed are added, which is the fastest there is, and drifts.
 * @param {typeof import('three')} three
 * @param {import('phiz').FaceModel} model
 * @param {{ mean: Float32Array, modes: Float32Array[] }} dense
 */
function plain(three, model, { mean, modes }) {
  const coefficients = new Float32Array(modes.length);
  const geometry = new three.BufferGeometry();
  const positions = mean.slice();
  geometry.setAttribute('position', new three.BufferAttribute(positions, 3));
  const { triangles, uvVertices } = model;
  geometry.setIndex(new three.BufferAttribute(triangles.map((corner) => uvVertices[corner]), 1));
  geometry.computeVertexNormals();
  return {
    geometry,
    positions,
    /** @param {Float32Array} wanted */
    event(wanted) {
      for (let k = 0; k < modes.length; k++) {
        const change = wanted[k] - coefficients[k];
        if (change === 0) continue;
        const mode = modes[k];
        for (let i = 0; i < positions.length; i++) positions[i] += change * mode[i];
      }
      coefficients.set(wanted);
      geometry.computeVertexNormals();
    },
  };
}

/** @param {Uint8Array} bytes @returns {Promise<number>} how many they are in gzip */
async function inGzip(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new CompressionStream('gzip'));
  return (await new Response(stream).arrayBuffer()).byteLength;
}

/**
 * @param {{
 *   load: typeof import('phiz').load,
 *   three: typeof import('three'),
 *   packed: Uint8Array, blob: Uint8Array, head: Uint8Array,
 *   kernels: Record<'simd' | 'scalar', new (blob: Uint8Array) => any>,
 *   say: (what: string) => void,
 * }} given `packed` and `blob` are the model's file and what it inflates to, `head` the file of the head
 */
export async function measure({ load, three, packed, blob, head, kernels, say }) {
  const [simd, scalar] = await Promise.all(/** @type {const} */ (['simd', 'scalar']).map((build) => load(packed, { build })));
  const dense = denseModes(simd);
  const js = plain(three, simd, dense);
  const faces = { simd: simd.face(), scalar: scalar.face() };
  /** @type {any} */
  const report = { vertices: simd.vertexCount, triangles: simd.triangles.length / 3, modes: dense.modes.length, events: {} };

  // Slider events: where a slider puts the coefficients is asked outside of the clock.
  const { controls } = simd;
  const values = Array.from({ length: 16 }, (_, i) => 0.05 + (0.9 * ((i * 7) % 16)) / 16);
  /** @type {[string, string, number | undefined][]} */
  const sliders = [...new Set(controls.map((c) => c.group))].map((group) => [group, controls.find((c) => c.group === group).name, undefined]);
  // The smallest surround there is: nearly a feature by itself.
  const least = simd.blending.limits[0];
  for (const group of ['nose', 'mouth']) sliders.push([`${group}, next to no surround`, controls.find((c) => c.group === group).name, least]);
  /** How many vertices they move. @type {Record<string, number>} */
  report.moved = {};
  for (const [what, control, alpha] of sliders) {
    say(what);
    const face = simd.face();
    if (alpha) for (const own of [face, faces.simd, faces.scalar]) own.alpha = alpha;
    const before = face.positions.slice();
    const wanted = values.map((value) => {
      face.set(control, value);
      return face.coefficients.slice();
    });
    const after = face.positions;
    report.moved[what] = before.filter((_, i) => i % 3 === 0 && [i, i + 1, i + 2].some((k) => before[k] !== after[k])).length;
    for (const own of Object.values(faces)) own.coefficients = wanted[0];
    report.events[what] = race({
      'phiz, simd': (turn) => faces.simd.set(control, values[turn % 16]),
      'phiz, scalar': (turn) => faces.scalar.set(control, values[turn % 16]),
      'changed modes in JS, three.js': (turn) => js.event(wanted[turn % 16]),
    });
    face.free();
    if (alpha) for (const own of Object.values(faces)) own.alpha = simd.blending.alpha;
  }

  say('all sliders');
  const everything = values.map((_, seed) => {
    const face = simd.face();
    face.randomize({ seed });
    const { coefficients } = face;
    face.free();
    return coefficients;
  });
  report.events['all sliders'] = race({
    'phiz, simd': (turn) => (faces.simd.coefficients = everything[turn % 16]),
    'phiz, scalar': (turn) => (faces.scalar.coefficients = everything[turn % 16]),
    'changed modes in JS, three.js': (turn) => js.event(everything[turn % 16]),
  });
  // Contenders that disagree do not do the same work: f32 sums of differences of f32 are off by less
  // than a hundredth of a millimetre.
  faces.simd.coefficients = everything[3];
  faces.scalar.coefficients = everything[3];
  js.event(everything[3]);
  const far = (/** @type {Float32Array} */ a, /** @type {Float32Array} */ b) => a.reduce((most, x, i) => Math.max(most, Math.abs(x - b[i])), 0);
  report.positionsApartMm = far(js.positions, faces.simd.positions);
  if (!(report.positionsApartMm < 0.01)) throw new Error(`positions differ by ${report.positionsApartMm} mm`);
  if (far(faces.simd.positions, faces.scalar.positions) !== 0) throw new Error('the two builds differ');
  // three.js's normals of the very same positions.
  js.positions.set(faces.simd.positions);
  js.geometry.computeVertexNormals();
  report.normalsApart = far(js.geometry.attributes.normal.array, faces.simd.normals);

  say('the kernels');
  const bench = { simd: new kernels.simd(blob), scalar: new kernels.scalar(blob) };
  js.positions.set(bench.simd.positions());
  report.normals = race({
    'phiz, simd': () => bench.simd.normals(),
    'phiz, scalar': () => bench.scalar.normals(),
    'plain, simd': () => bench.simd.normals_plainly(),
    'three.js': () => js.geometry.computeVertexNormals(),
  });
  report.modeBytes = bench.simd.mode_bytes();
  const floats = bench.simd.floats();
  report.sums = race({
    'reading the bytes': () => bench.simd.read_modes(),
    'phiz, simd': () => bench.simd.sum_modes(),
    'phiz, simd, to positions': () => bench.simd.sum_positions(),
    'phiz, scalar': () => bench.scalar.sum_modes(),
    'plain, simd': () => bench.simd.sum_modes_plainly(),
    'nalgebra, simd': () => bench.simd.sum_modes_by_nalgebra(),
    'nalgebra, scalar': () => bench.scalar.sum_modes_by_nalgebra(),
  });
  if (!Number.isFinite(bench.simd.seen() + bench.scalar.seen())) throw new Error('the sums are no numbers');

  report.wire = { model: packed.length, floatsInGzip: await inGzip(new Uint8Array(floats.buffer)) };

  say('loading');
  /** @param {() => Promise<void>} once */
  const often = async (once) => {
    const times = [];
    for (let i = 0; i < 7; i++) {
      const start = performance.now();
      await once();
      times.push(performance.now() - start);
    }
    return median(times);
  };
  const shown = async (/** @type {Parameters<typeof load>[0]} */ file) => {
    const model = await load(file);
    const face = model.face();
    if (!(face.positions[0] !== 0)) throw new Error('no positions');
    face.free();
    model.free();
  };
  /** As a line gives them that takes 0.3 s: 32 kB every 5 ms or more. @param {Uint8Array} bytes */
  const afterTheLast = async (bytes) => {
    const times = [];
    for (let i = 0; i < 7; i++) {
      let [at, last] = [0, 0];
      const line = new ReadableStream({
        async pull(out) {
          await new Promise((come) => setTimeout(come, 5));
          const part = bytes.slice(at, (at += 32_768));
          last = performance.now();
          if (part.length > 0) out.enqueue(part);
          if (at >= bytes.length) out.close();
        },
      });
      await shown(line);
      times.push(performance.now() - last);
    }
    return median(times);
  };
  report.loadMs = {
    'head, to positions': await often(() => shown(head)),
    'model, to positions': await often(() => shown(packed)),
    'model, inflated before': await often(() => shown(blob)),
    'model, after its last bytes came': await afterTheLast(packed),
    'inflating alone': await often(async () => {
      const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('gzip'));
      await new Response(stream).arrayBuffer();
    }),
  };

  say('many faces');
  report.crowd = {};
  for (const count of [100, 1000]) {
    const before = faces.simd.positions.buffer.byteLength;
    const start = performance.now();
    const crowd = Array.from({ length: count }, (_, seed) => {
      const face = simd.face();
      face.randomize({ seed });
      return face;
    });
    const seconds = (performance.now() - start) / 1000;
    const bytes = crowd[count - 1].positions.buffer.byteLength - before;
    report.crowd[count] = { facesPerSecond: count / seconds, bytesPerFace: bytes / count };
    crowd.forEach((face) => face.free());
  }
  return report;
}
