//! Numbers as integers with a step: the one place that knows which, and how far off they are.
//!
//! What a face is made of in the first place (the mean, its texture coordinates, correlations) is
//! kept finely on fixed grids of powers of two, whose points are f32 exactly, so that a number on
//! its grid is read as it was written. Modes, which are nearly all of a model, get one step a
//! block, for a stated error.

use crate::error::Number;
use crate::{Error, Result};

/// Points at whole multiples of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// The distance between two points: a power of two.
    pub step: f64,
}

impl Grid {
    /// The index of the point nearest to a number; saturates at the ends of i32.
    pub fn index(self, number: f64) -> i32 {
        (number / self.step).round() as i32
    }

    /// A point.
    pub fn point(self, index: i32) -> f64 {
        f64::from(index) * self.step
    }

    /// The point nearest to a number.
    pub fn nearest(self, number: f64) -> f64 {
        self.point(self.index(number))
    }
}

/// The mean's coordinates, mm: off by a micrometre at most.
pub const COORDINATES: Grid = Grid { step: 1.0 / 512.0 };
/// Distances of a surround, mm: at a blending distance of 10 mm half a step is two ten-thousandths
/// of what follows.
pub const DISTANCES: Grid = Grid { step: 1.0 / 128.0 };
/// Texture coordinates: a step is a sixteenth of a pixel on a picture of 2048.
pub const TEXTURE: Grid = Grid {
    step: 1.0 / 32_768.0,
};
/// Correlations.
pub const CORRELATIONS: Grid = Grid {
    step: 1.0 / 16_384.0,
};

/// Coefficients live on a grid of 1/65536 sigma, so that a face, its code and its undo history are
/// the same numbers everywhere. At a mode of 5 mm a step of the grid is 0.08 micrometres: measures are
/// held to 0.1.
pub(crate) const PER_SIGMA: f64 = 65_536.0;

/// Nothing but what is held needs all of the grid: other coefficients take every eighth point of it,
/// so that up to 4 sigmas they are 16 bits, which is what sums are fastest of.
const COARSE: f64 = 8.0;

/// The point of the coarse grid nearest to a coefficient in sigmas.
pub(crate) fn grid(coefficient: f32) -> i32 {
    coarse(f64::from(coefficient) * PER_SIGMA)
}

/// The nearest point of the coarse grid.
pub(crate) fn coarse(point: f64) -> i32 {
    ((point / COARSE).round() * COARSE) as i32
}

/// A point of the grid as a coefficient in sigmas.
pub(crate) fn sigmas(point: i32) -> f32 {
    (f64::from(point) / PER_SIGMA) as f32
}

/// A length in mm at the nearest whole micrometre, which is what a code keeps of it.
pub(crate) fn micrometres(mm: f32) -> f32 {
    (mm * 1000.0).round() / 1000.0
}

/// The finest step of modes in use: 1 micrometre, far below what a scanner or an eye resolves.
pub const FINEST_STEP: f32 = 0.001;

/// Steps of modes are whole multiples of this, mm, so that sums of modes are exact in f64: with
/// [`STEPS`] and the grid of coefficients the last bit of a position is 2^-40 mm, the first 4 m.
pub const STEP_GRID: f64 = 1.0 / (1 << 20) as f64;
/// Where vertices only follow, steps may be finer, by this power of two.
pub const STEPS: u32 = 4;

/// How far rounding a block's modes moves the vertices of random faces, mm RMS. A vertex is moved
/// by two blocks, its feature's and the head's, so a face is off by 1.4 times as much.
pub const BLOCK_ERROR: f64 = 0.015;

/// Numbers stored as `value = step * integer`.
///
/// A number is off by at most half a step; a face with k coefficients of size c_i is off by at
/// most `step / 2 * sum |c_i|` in each coordinate.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantised {
    /// The value of 1, in mm.
    pub step: f32,
    /// The integers.
    pub integers: Vec<i16>,
}

impl Quantised {
    /// Rounds `values` (mm) with the finest step from `step` on in which the largest fits.
    pub fn new(values: &[f64], step: f32) -> Self {
        let largest = values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let step = f64::from(step).max(largest / f64::from(i16::MAX));
        let step = ((step / STEP_GRID).ceil() * STEP_GRID) as f32;
        Self {
            step,
            integers: values
                .iter()
                .map(|v| (v / f64::from(step)).round() as i16)
                .collect(),
        }
    }

    /// The step with which rounding moves the vertices of random faces by `error` mm RMS.
    ///
    /// A number rounded to a step is off by `step / sqrt(12)` RMS. The coefficients of `modes`
    /// modes have a standard deviation of 1, so a vertex is off by `step / sqrt(12)` times
    /// `sqrt(3 modes)`. Where modes hardly move, what is rounded to zero is off by less.
    pub fn step_for(error: f64, modes: usize) -> f32 {
        FINEST_STEP.max((2.0 * error / (modes.max(1) as f64).sqrt()) as f32)
    }

    /// Takes integers and a step that were read from a file.
    ///
    /// # Errors
    /// As [`sound_step`].
    #[cfg(feature = "fit")]
    pub(crate) fn from_parts(step: f32, integers: Vec<i16>) -> Result<Self> {
        Ok(Self {
            step: sound_step(step)?,
            integers,
        })
    }
}

/// The nearest step that modes may have.
pub fn nearest_step(step: f32) -> f32 {
    let finest = STEP_GRID / f64::from(1 << STEPS);
    ((f64::from(step) / finest).round() * finest) as f32
}

/// A step that was read from a file, or the nearest that modes may have.
///
/// # Errors
/// When it is not a positive length of at most 1 mm.
pub(crate) fn sound_step(step: f32) -> Result<f32> {
    let nearest = ((f64::from(step) / STEP_GRID).round() * STEP_GRID) as f32;
    match nearest > 0.0 && nearest <= 1.0 {
        true => Ok(nearest),
        false => Err(Error::Blob(format!(
            "a quantisation step of {} mm",
            Number(step.into())
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_off_by_at_most_half_a_step() {
        for scale in [1e-4, 1.0, 30.0, 90.0] {
            let values: Vec<f64> = (-50..=50).map(|i| f64::from(i) / 50.0 * scale).collect();
            let quantised = Quantised::new(&values, FINEST_STEP);
            for (value, &integer) in values.iter().zip(&quantised.integers) {
                let back = f64::from(quantised.step) * f64::from(integer);
                // A millionth for the rounding of the step itself to f32.
                assert!((back - value).abs() <= f64::from(quantised.step) * 0.500_1 + scale * 1e-6);
            }
        }
    }

    #[test]
    fn random_faces_are_off_by_the_stated_error() {
        let mut random = crate::Random::new(1);
        let (modes, vertices, error) = (12, 500, 0.02);
        let values: Vec<f64> = (0..modes * vertices * 3).map(|_| random.normal()).collect();
        let rounded = Quantised::new(&values, Quantised::step_for(error, modes));
        let (mut sum, faces) = (0.0, 100);
        for _ in 0..faces {
            let c: Vec<f64> = (0..modes).map(|_| random.normal()).collect();
            for i in 0..vertices * 3 {
                let off: f64 = (0..modes)
                    .map(|k| {
                        let at = k * vertices * 3 + i;
                        let back = f64::from(rounded.step) * f64::from(rounded.integers[at]);
                        c[k] * (back - values[at])
                    })
                    .sum();
                sum += off * off;
            }
        }
        let rms = (sum / f64::from(faces * vertices as i32)).sqrt();
        // 100 draws of the squares of 12 coefficients: a standard error of 2 %, half of that for
        // the root; four of them.
        assert!((rms / error - 1.0).abs() < 0.08, "{rms}");
    }

    #[test]
    fn points_of_a_grid_are_f32() {
        for grid in [COORDINATES, DISTANCES, TEXTURE, CORRELATIONS] {
            for index in [0, 1, -77, 12_345, (1 << 23) - 1] {
                let point = grid.point(index) as f32;
                assert_eq!(f64::from(point), grid.point(index));
                assert_eq!(grid.index(point.into()), index);
            }
        }
    }
}
