//! The kernels of phiz, their plain twins, and the same by nalgebra, each as a function to be timed.
//!
//! A plain twin is what one would write first, compiled with the same flags: the compiler may use the
//! same instructions wherever it finds a way.

use std::ops::Range;

use glam::Vec3;
use nalgebra::{DMatrix, DVector};
use phiz::{Face, FaceModel, Random, Randomize, bench};
use wasm_bindgen::prelude::wasm_bindgen;

/// The modes of a block, or of what follows it, as the plain twins have them.
struct Plain {
    /// A mode after another, in steps.
    modes: Vec<Vec<i16>>,
    step: f32,
    coefficients: Range<usize>,
    sums: Vec<f32>,
    matrix: DMatrix<f32>,
    product: DVector<f32>,
}

#[wasm_bindgen]
pub struct Bench {
    model: FaceModel,
    face: Face,
    coefficients: Vec<i32>,
    sigmas: Vec<f32>,
    plain: Vec<Plain>,
    triangles: Vec<[u32; 3]>,
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    seen: f64,
}

#[wasm_bindgen]
impl Bench {
    /// Of a model's blob, not packed.
    #[wasm_bindgen(constructor)]
    pub fn new(blob: &[u8]) -> Bench {
        let model = FaceModel::parse(blob).expect("a model");
        let mut face = model.face();
        let draw = Randomize {
            seed: Some(1),
            ..Default::default()
        };
        face.randomize(&draw).expect("a seed is enough");
        // One that was drawn has no edits, whose modes would not be summed.
        let mut all = face.coefficients();
        all.iter_mut()
            .filter(|c| **c == 0.0)
            .for_each(|c| *c = 0.125);
        face.set_coefficients(&all).expect("as many as there were");
        let plain = bench::all_modes(&model)
            .map(|(modes, coefficients)| {
                let (count, numbers, step) = (modes.count(), modes.numbers(), modes.step());
                let mode = |k| (0..numbers).map(|i| modes.get(k, i)).collect();
                Plain {
                    modes: (0..count).map(mode).collect(),
                    step,
                    coefficients,
                    sums: vec![0.0; numbers],
                    matrix: DMatrix::from_fn(numbers, count, |i, k| {
                        f32::from(modes.get(k, i)) * step
                    }),
                    product: DVector::zeros(numbers),
                }
            })
            .filter(|plain| !plain.sums.is_empty())
            .collect();
        let padded = |points: &[Vec3]| [points, &[Vec3::ZERO]].concat();
        Bench {
            coefficients: bench::coefficients(&face),
            sigmas: face.coefficients(),
            plain,
            triangles: model.parts().topology.triangles(),
            positions: padded(face.positions()),
            normals: padded(face.normals()),
            seen: 0.0,
            face,
            model,
        }
    }

    /// Bytes of all modes, with those of what follows.
    pub fn mode_bytes(&self) -> usize {
        bench::mode_bytes(&self.model)
    }

    pub fn read_modes(&mut self) {
        self.seen += f64::from(bench::read_modes(&self.model));
    }

    pub fn sum_modes(&mut self) {
        self.seen += bench::sum_modes(&self.model, &self.coefficients);
    }

    /// All of the face's positions: sums of modes, added to the mean.
    pub fn sum_positions(&mut self) {
        bench::sum_positions(&mut self.face);
    }

    pub fn sum_modes_plainly(&mut self) {
        for plain in &mut self.plain {
            plain.sums.fill(0.0);
            for (mode, c) in plain
                .modes
                .iter()
                .zip(&self.sigmas[plain.coefficients.clone()])
            {
                let weight = c * plain.step;
                for (sum, &q) in plain.sums.iter_mut().zip(mode) {
                    *sum += weight * f32::from(q);
                }
            }
            self.seen += f64::from(plain.sums[0]);
        }
    }

    /// The same, by matrices.
    pub fn sum_modes_by_nalgebra(&mut self) {
        for plain in &mut self.plain {
            let own = DVector::from_column_slice(&self.sigmas[plain.coefficients.clone()]);
            plain.product.gemv(1.0, &plain.matrix, &own, 0.0);
            self.seen += f64::from(plain.product[0]);
        }
    }

    pub fn normals(&mut self) {
        bench::normals(&self.model, &self.positions, &mut self.normals);
    }

    pub fn normals_plainly(&mut self) {
        self.normals.fill(Vec3::ZERO);
        for &[a, b, c] in &self.triangles {
            let start = self.positions[a as usize];
            let normal =
                (self.positions[b as usize] - start).cross(self.positions[c as usize] - start);
            for v in [a, b, c] {
                self.normals[v as usize] += normal;
            }
        }
        for normal in &mut self.normals {
            *normal = normal.normalize_or_zero();
        }
    }

    /// The mean and the modes as they were before they were rounded for the file, as far as that can be
    /// told: rounding is off by anything up to half a step, so as much is put back at random.
    pub fn floats(&self) -> Vec<f32> {
        let parts = self.model.parts();
        let mut random = Random::new(1);
        let mut floats: Vec<f32> = parts.mean.iter().flat_map(|p| p.to_array()).collect();
        for block in &parts.blocks {
            for k in 0..block.modes.count() {
                floats.extend((0..block.modes.numbers()).map(|i| {
                    let off = random.uniform() as f32 - 0.5;
                    (f32::from(block.modes.get(k, i)) + off) * block.modes.step()
                }));
            }
        }
        floats
    }

    /// x, y and z a vertex.
    pub fn positions(&self) -> Vec<f32> {
        self.face
            .positions()
            .iter()
            .flat_map(|p| p.to_array())
            .collect()
    }

    /// Those that were computed last.
    pub fn last_normals(&self) -> Vec<f32> {
        let all = &self.normals[..self.normals.len() - 1];
        all.iter().flat_map(|p| p.to_array()).collect()
    }

    /// So that nothing is left out as useless.
    pub fn seen(&self) -> f64 {
        self.seen
    }
}
