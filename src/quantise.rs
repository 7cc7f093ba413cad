//! Modes as 16-bit integers with one step a block: the one place that knows how.

use crate::{Error, Result};

/// The finest step in use: 1 micrometre, far below what a scanner or an eye resolves.
pub const FINEST_STEP: f32 = 0.001;

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
    /// Rounds `values` (mm) with [`FINEST_STEP`], or the finest coarser step in which the largest
    /// fits.
    pub fn new(values: &[f64]) -> Self {
        let largest = values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let step = FINEST_STEP.max((largest / f64::from(i16::MAX)) as f32 * 1.000_001);
        Self {
            step,
            integers: values
                .iter()
                .map(|v| (v / f64::from(step)).round() as i16)
                .collect(),
        }
    }

    /// Takes integers and a step that were read from a file.
    ///
    /// # Errors
    /// When the step is not a positive length of at most 1 mm.
    pub fn from_parts(step: f32, integers: Vec<i16>) -> Result<Self> {
        if !(step > 0.0 && step <= 1.0) {
            return Err(Error::Blob(format!("a quantisation step of {step} mm")));
        }
        Ok(Self { step, integers })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_off_by_at_most_half_a_step() {
        for scale in [1e-4, 1.0, 30.0, 90.0] {
            let values: Vec<f64> = (-50..=50).map(|i| f64::from(i) / 50.0 * scale).collect();
            let quantised = Quantised::new(&values);
            for (value, &integer) in values.iter().zip(&quantised.integers) {
                let back = f64::from(quantised.step) * f64::from(integer);
                // A millionth for the rounding of the step itself to f32.
                assert!((back - value).abs() <= f64::from(quantised.step) * 0.500_1 + scale * 1e-6);
            }
        }
    }
}
