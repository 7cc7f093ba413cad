//! The kernels one by one, for the bench (`tests/bench`): what an event is made of cannot be timed
//! from outside. Not for anyone else; it may change with any version.

use std::ops::Range;

use glam::Vec3;
use wide::{i16x8, i32x4};

use crate::kernel::{CHUNK, Modes};
use crate::{Face, FaceModel};

/// The modes of all blocks, and those of what follows them, with their coefficients.
pub fn all_modes(model: &FaceModel) -> impl Iterator<Item = (&Modes, Range<usize>)> {
    let reach = &model.derived.reach;
    let each = model.parts().blocks.iter().enumerate();
    each.flat_map(|(b, block)| {
        let movers = reach.movers(b, block);
        movers.map(|(modes, _)| (modes, block.coefficients()))
    })
}

/// Sums all modes for coefficients in units of 1/65536 sigma; the sums are only looked at.
pub fn sum_modes(model: &FaceModel, coefficients: &[i32]) -> f64 {
    let mut seen = 0.0;
    let mut sums = [i32x4::ZERO; CHUNK / 4];
    for (modes, own) in all_modes(model) {
        for part in modes.weights(&coefficients[own]) {
            for first in (0..modes.numbers()).step_by(CHUNK) {
                modes.sum(&part, first, &mut sums);
                seen += part.unit * f64::from(sums[0].to_array()[0]);
            }
        }
    }
    seen
}

/// Sums all positions of a face, from the mean on, without normals.
pub fn sum_positions(face: &mut Face) {
    face.sum(false);
}

/// Reads all that [`sum_modes`] reads and does next to nothing with it.
pub fn read_modes(model: &FaceModel) -> i16 {
    let mut sums = [i16x8::ZERO; 8];
    for (modes, _) in all_modes(model) {
        for eight in modes.tiles().as_chunks::<8>().0 {
            for (sum, &numbers) in sums.iter_mut().zip(eight) {
                *sum |= numbers;
            }
        }
    }
    sums.iter().fold(i16x8::ZERO, |a, &b| a | b).to_array()[0]
}

/// How many bytes that is.
pub fn mode_bytes(model: &FaceModel) -> usize {
    all_modes(model)
        .map(|(modes, _)| 16 * modes.tiles().len())
        .sum()
}

/// The normals of all vertices; both slices are one longer than there are vertices.
pub fn normals(model: &FaceModel, positions: &[Vec3], normals: &mut [Vec3]) {
    model.derived.whole.normals(positions, normals);
}

/// The coefficients of a face in units of 1/65536 sigma.
pub fn coefficients(face: &Face) -> Vec<i32> {
    face.state().to_vec()
}
