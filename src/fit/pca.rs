//! Principal components of displacement fields (region morphing, section 5, eqs. 4 to 6).

use faer::{Mat, Side};

use super::{FitError, FitResult};

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
    /// Eigenvectors come from the F x F Gram matrix in f64. Each mode's sign is chosen so that its
    /// largest component is positive.
    ///
    /// # Errors
    /// With fewer than 3 samples, without variance, or when `tau` is not in (0, 1].
    pub fn learn(samples: &[Vec<f64>], tau: f64) -> FitResult<Self> {
        let f = samples.len();
        if f < 3 {
            return Err(FitError::Input(format!(
                "{f} faces are too few to learn from; 3 is the least"
            )));
        }
        if !(tau > 0.0 && tau <= 1.0) {
            return Err(FitError::Input(format!(
                "tau must be over 0 and at most 1, not {tau}"
            )));
        }
        let dimension = samples[0].len();
        let mut x = Mat::from_fn(dimension, f, |i, j| samples[j][i]);
        for i in 0..dimension {
            let mean = (0..f).map(|j| x[(i, j)]).sum::<f64>() / f as f64;
            (0..f).for_each(|j| x[(i, j)] -= mean);
        }
        // faer splits sums by the number of threads; on one they are the same everywhere.
        faer::set_global_parallelism(faer::Par::Seq);
        let gram = x.transpose() * &x;
        let eigen = gram
            .self_adjoint_eigen(Side::Lower)
            .map_err(|e| FitError::Input(format!("the eigenvalues did not converge: {e:?}")))?;
        // faer gives them in increasing order.
        let order: Vec<usize> = (0..f).rev().collect();
        let eigenvalues: Vec<f64> = order
            .iter()
            .map(|&j| eigen.S()[j].max(0.0) / (f - 1) as f64)
            .collect();
        let total: f64 = eigenvalues.iter().sum();
        // A nanometre of standard deviation over the whole field is no variation.
        if total < 1e-12 {
            return Err(FitError::Input("the faces do not vary here".into()));
        }
        let mut kept = 0;
        let mut sum = 0.0;
        while kept < f - 1 && sum < tau * total && eigenvalues[kept] > total * 1e-12 {
            sum += eigenvalues[kept];
            kept += 1;
        }
        let mut pca = Self {
            modes: Vec::with_capacity(kept),
            sigmas: Vec::with_capacity(kept),
            eigenvalues,
            coefficients: vec![Vec::with_capacity(kept); f],
        };
        for (k, &column) in order[..kept].iter().enumerate() {
            let sigma = pca.eigenvalues[k].sqrt();
            let vector = eigen.U().col(column);
            let length = sigma * ((f - 1) as f64).sqrt();
            let mut mode: Vec<f64> = {
                let field = &x * vector;
                (0..dimension).map(|i| field[i] / length).collect()
            };
            let largest = mode
                .iter()
                .fold(0.0_f64, |m, &v| if v.abs() > m.abs() { v } else { m });
            let sign = largest.signum();
            mode.iter_mut().for_each(|v| *v *= sign);
            for (j, row) in pca.coefficients.iter_mut().enumerate() {
                row.push(sign * vector[j] * ((f - 1) as f64).sqrt());
            }
            pca.modes.push(mode);
            pca.sigmas.push(sigma);
        }
        Ok(pca)
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
        let pca = Pca::learn(&samples(30, 12), 1.0).unwrap();
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
        let pca = Pca::learn(&data, 1.0).unwrap();
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
        let pca = Pca::learn(&samples(60, 20), 0.9).unwrap();
        let total: f64 = pca.eigenvalues.iter().sum();
        let sum = |k: usize| pca.eigenvalues[..k].iter().sum::<f64>();
        assert!(sum(pca.modes.len()) >= 0.9 * total);
        assert!(sum(pca.modes.len() - 1) < 0.9 * total);
    }

    #[test]
    fn too_few_or_equal_faces_are_refused() {
        assert!(Pca::learn(&samples(2, 5), 0.95).is_err());
        assert!(Pca::learn(&vec![vec![1.0; 6]; 5], 0.95).is_err());
        assert!(Pca::learn(&samples(5, 5), 1.5).is_err());
    }
}
