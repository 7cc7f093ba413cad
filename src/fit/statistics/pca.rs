//! Principal components of displacement fields (region morphing, section 5, eqs. 4 to 6).

use faer::{Mat, Side};
use rayon::prelude::*;

use super::gram::{columns, gram, sums};
use crate::fit::{FitError, FitResult};

/// A truncated PCA.
#[derive(Debug, Clone, PartialEq)]
pub struct Pca {
    /// Unit-length modes, one a row of `dimension` numbers, by decreasing variance.
    pub modes: Vec<Vec<f64>>,
    /// The standard deviation of each mode's coefficient: the square root of the eigenvalue of
    /// the covariance (divisor F - 1).
    pub sigmas: Vec<f64>,
    /// All eigenvalues of the covariance, decreasing, also those of modes that were left out.
    pub eigenvalues: Vec<f64>,
    /// Coefficients of the training samples in sigmas, one row a sample.
    pub coefficients: Vec<Vec<f64>>,
}

impl Pca {
    /// Learns from samples (rows of equal length) that are displacements from their mean; a mean
    /// that is left in them is taken out first. Keeps the fewest modes whose variances reach
    /// `tau` of the total (eq. 6), at most one less than there are samples.
    ///
    /// # Errors
    /// With fewer than 3 samples, without variance, or when `tau` is not in (0, 1].
    pub fn learn(samples: Vec<Vec<f64>>, tau: f64) -> FitResult<Self> {
        let spectrum = Spectrum::of(samples)?;
        let kept = spectrum.modes_for(tau)?;
        Ok(spectrum.truncate(kept))
    }
}

/// All of a PCA, from which any number of modes can be taken.
///
/// Eigenvectors come from the F x F Gram matrix in f64.
pub struct Spectrum {
    /// Displacements from the samples' mean, one a row.
    samples: Vec<Vec<f64>>,
    /// What was their mean, as displacements.
    pub mean: Vec<f64>,
    /// Unit eigenvectors of the Gram matrix, a column each, by decreasing eigenvalue.
    vectors: Mat<f64>,
    /// The eigenvalues of the covariance (divisor F - 1), decreasing.
    pub eigenvalues: Vec<f64>,
}

impl Spectrum {
    /// The spectrum of samples (rows of equal length), about their mean.
    ///
    /// # Errors
    /// With fewer than 3 samples, or without variance.
    pub fn of(mut samples: Vec<Vec<f64>>) -> FitResult<Self> {
        let f = samples.len();
        if f < 3 {
            return Err(FitError::Input(format!(
                "{f} faces are too few to learn from; 3 is the least"
            )));
        }
        let dimension = samples[0].len();
        let mut mean = vec![0.0; dimension];
        for sample in &samples {
            mean.iter_mut().zip(sample).for_each(|(m, x)| *m += x);
        }
        mean.iter_mut().for_each(|m| *m /= f as f64);
        samples.par_iter_mut().for_each(|sample| {
            sample.iter_mut().zip(&mean).for_each(|(x, m)| *x -= m);
        });
        let gram = gram(dimension, |rows| columns(&samples, rows));
        let eigen = gram
            .self_adjoint_eigen(Side::Lower)
            .map_err(|e| FitError::Input(format!("the eigenvalues did not converge: {e:?}")))?;
        // faer gives them in increasing order.
        let eigenvalues: Vec<f64> = (0..f)
            .rev()
            .map(|j| eigen.S()[j].max(0.0) / (f - 1) as f64)
            .collect();
        // A nanometre of standard deviation over the whole field is no variation.
        if eigenvalues.iter().sum::<f64>() < 1e-12 {
            return Err(FitError::Input("the faces do not vary here".into()));
        }
        Ok(Self {
            vectors: Mat::from_fn(f, f, |i, j| eigen.U()[(i, f - 1 - j)]),
            eigenvalues,
            samples,
            mean,
        })
    }

    /// The fewest modes whose variances reach `tau` of the total (eq. 6), at most one less than
    /// there are samples.
    ///
    /// # Errors
    /// When `tau` is not in (0, 1].
    pub fn modes_for(&self, tau: f64) -> FitResult<usize> {
        if !(tau > 0.0 && tau <= 1.0) {
            return Err(FitError::Input(format!(
                "tau must be over 0 and at most 1, not {tau}"
            )));
        }
        let total: f64 = self.eigenvalues.iter().sum();
        let most = self.most();
        let mut sum = 0.0;
        let reached = self.eigenvalues[..most].iter().position(|value| {
            sum += value;
            sum >= tau * total
        });
        Ok(reached.map_or(most, |last| last + 1))
    }

    /// The part of the variance that the first `modes` have, 0..=1.
    pub fn explained(&self, modes: usize) -> f64 {
        let total: f64 = self.eigenvalues.iter().sum();
        self.eigenvalues.iter().take(modes).sum::<f64>() / total
    }

    /// Modes that are more than rounding.
    fn most(&self) -> usize {
        let total: f64 = self.eigenvalues.iter().sum();
        let real = self.eigenvalues.iter().take_while(|&&e| e > total * 1e-12);
        real.count().min(self.samples.len() - 1)
    }

    /// The PCA with the first `modes`, or all there are. Each mode's sign is chosen so that its
    /// largest component is positive.
    pub fn truncate(&self, modes: usize) -> Pca {
        let kept = modes.min(self.most());
        let f = self.samples.len();
        let freedom = ((f - 1) as f64).sqrt();
        let sigmas: Vec<f64> = self.eigenvalues[..kept].iter().map(|e| e.sqrt()).collect();
        let turn = Mat::from_fn(f, kept, |i, k| self.vectors[(i, k)] / (sigmas[k] * freedom));
        let mut pca = Pca {
            modes: sums(&self.samples, turn.as_ref()),
            sigmas,
            eigenvalues: self.eigenvalues.clone(),
            coefficients: vec![Vec::with_capacity(kept); f],
        };
        for (k, mode) in pca.modes.iter_mut().enumerate() {
            let largest = mode
                .iter()
                .fold(0.0_f64, |m, &v| if v.abs() > m.abs() { v } else { m });
            let sign = largest.signum();
            mode.iter_mut().for_each(|v| *v *= sign);
            for (j, row) in pca.coefficients.iter_mut().enumerate() {
                row.push(sign * self.vectors[(j, k)] * freedom);
            }
        }
        pca
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;

    fn samples(f: usize, d: usize) -> Vec<Vec<f64>> {
        let mut random = Random::new(11);
        (0..f)
            .map(|_| (0..d).map(|i| random.normal() * (1.0 + i as f64)).collect())
            .collect()
    }

    #[test]
    fn modes_are_orthonormal_and_coefficients_have_unit_variance() {
        let pca = Pca::learn(samples(30, 12), 1.0).unwrap();
        for (a, mode) in pca.modes.iter().enumerate() {
            for (b, other) in pca.modes.iter().enumerate() {
                let dot: f64 = mode.iter().zip(other).map(|(x, y)| x * y).sum();
                assert!((dot - f64::from(u8::from(a == b))).abs() < 1e-9);
            }
            let variance = pca
                .coefficients
                .iter()
                .map(|row| row[a] * row[a])
                .sum::<f64>()
                / 29.0;
            assert!((variance - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn all_modes_give_the_samples_back() {
        let data = samples(8, 40);
        let pca = Pca::learn(data.clone(), 1.0).unwrap();
        let mean: Vec<f64> = (0..40)
            .map(|i| data.iter().map(|s| s[i]).sum::<f64>() / 8.0)
            .collect();
        for (sample, row) in data.iter().zip(&pca.coefficients) {
            for i in 0..40 {
                let back: f64 = mean[i]
                    + (0..row.len())
                        .map(|k| row[k] * pca.sigmas[k] * pca.modes[k][i])
                        .sum::<f64>();
                // The Gram matrix squares the condition number: half the digits of f64 remain.
                assert!((back - sample[i]).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn tau_keeps_the_fewest_modes_that_reach_it() {
        let pca = Pca::learn(samples(60, 20), 0.9).unwrap();
        let total: f64 = pca.eigenvalues.iter().sum();
        let sum = |k: usize| pca.eigenvalues[..k].iter().sum::<f64>();
        assert!(sum(pca.modes.len()) >= 0.9 * total);
        assert!(sum(pca.modes.len() - 1) < 0.9 * total);
    }

    #[test]
    fn too_few_or_equal_faces_are_refused() {
        assert!(Pca::learn(samples(2, 5), 0.95).is_err());
        assert!(Pca::learn(vec![vec![1.0; 6]; 5], 0.95).is_err());
        assert!(Pca::learn(samples(5, 5), 1.5).is_err());
    }
}
