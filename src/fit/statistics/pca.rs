//! Principal components of displacement fields (region morphing, section 5, eqs. 4 to 6).

use faer::{Mat, Side};
use rayon::prelude::*;

use super::gram::{columns, gram, inner, sums};
use crate::fit::error::faces_are;
use crate::fit::{FitError, FitResult};

/// A truncated PCA.
#[derive(Debug, Clone, PartialEq)]
pub struct Pca {
    /// Unit-length modes, one a row of `dimension` numbers, by decreasing variance.
    pub modes: Vec<Vec<f64>>,
    /// The standard deviation of each mode's coefficient: the square root of the eigenvalue of
    /// the covariance.
    pub sigmas: Vec<f64>,
    /// All eigenvalues of the covariance, decreasing, also those of modes that were left out.
    pub eigenvalues: Vec<f64>,
    /// Coefficients of the training samples in sigmas, one row a sample.
    pub coefficients: Vec<Vec<f64>>,
    /// Which modes are the opposite of their mirror image; the others are their own, where the samples' images
    /// counted too ([`Spectrum::of_both_sides`]), and of no symmetry elsewhere.
    pub odd: Vec<bool>,
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
/// Eigenvectors come from F x F Gram matrices in f64.
pub struct Spectrum {
    /// Displacements from the samples' mean, one a row.
    samples: Vec<Vec<f64>>,
    /// What was their mean, as displacements.
    pub mean: Vec<f64>,
    /// Unit eigenvectors of the Gram matrix, a column each, by decreasing eigenvalue.
    vectors: Mat<f64>,
    /// The eigenvalues of the covariance, decreasing: its divisor is one less than the samples, with their mirror
    /// images where these count.
    pub eigenvalues: Vec<f64>,
    /// Which of the eigenvectors are of a mode that is the opposite of its mirror image.
    odd: Vec<bool>,
    /// The mirror map of the rows' vertices, where images count.
    mirror: Option<Vec<u32>>,
}

impl Spectrum {
    /// The spectrum of samples (rows of equal length), about their mean.
    ///
    /// # Errors
    /// With fewer than 3 samples, or without variance.
    pub fn of(samples: Vec<Vec<f64>>) -> FitResult<Self> {
        Self::about(samples, None)
    }

    /// The spectrum of samples (rows of x, y, z a vertex, x to the subject's left) and as many more: the mirror
    /// image of each, by the vertices' `mirror` map. Each mode is its own mirror image or the opposite of it.
    ///
    /// Of a sample and its image the even part is the same and the odd part the opposite, so the covariance falls
    /// into that of the even parts and that of the odd ones, and images need not be kept.
    ///
    /// # Errors
    /// As [`Spectrum::of`].
    pub fn of_both_sides(samples: Vec<Vec<f64>>, mirror: Vec<u32>) -> FitResult<Self> {
        Self::about(samples, Some(mirror))
    }

    fn about(mut samples: Vec<Vec<f64>>, mirror: Option<Vec<u32>>) -> FitResult<Self> {
        let f = samples.len();
        if f < 3 {
            return Err(FitError::Input(format!(
                "{} too few to learn from; 3 is the least",
                faces_are(f)
            )));
        }
        let dimension = samples[0].len();
        let mut mean = vec![0.0; dimension];
        for sample in &samples {
            mean.iter_mut().zip(sample).for_each(|(m, x)| *m += x);
        }
        mean.iter_mut().for_each(|m| *m /= f as f64);
        if let Some(mirror) = &mirror {
            mean = part(&mean, mirror, 1.0);
        }
        samples.par_iter_mut().for_each(|sample| {
            sample.iter_mut().zip(&mean).for_each(|(x, m)| *x -= m);
        });
        let gram = gram(dimension, |rows| columns(&samples, rows));
        let parts = match &mirror {
            None => vec![(gram, false)],
            Some(mirror) => {
                let images: Vec<Vec<f64>> = samples.par_iter().map(|x| image(x, mirror)).collect();
                let across = inner(&samples, &images);
                // Inner products of the samples' even parts, and of their odd ones.
                [(1.0, false), (-1.0, true)]
                    .map(|(sign, odd)| {
                        let of = |i, j| (gram[(i, j)] + sign * across[(i, j)]) / 2.0;
                        (Mat::from_fn(f, f, of), odd)
                    })
                    .into()
            }
        };
        let mut found = Vec::new();
        for (gram, odd) in parts {
            let eigen = gram
                .self_adjoint_eigen(Side::Lower)
                .map_err(|e| FitError::Input(format!("the eigenvalues did not converge: {e:?}")))?;
            // faer gives them in increasing order.
            found.extend((0..f).rev().map(|j| {
                let vector: Vec<f64> = (0..f).map(|i| eigen.U()[(i, j)]).collect();
                (eigen.S()[j].max(0.0), odd, vector)
            }));
        }
        found.sort_by(|(a, ..), (b, ..)| b.total_cmp(a));
        let freedom = freedom(f, mirror.is_some());
        let eigenvalues: Vec<f64> = found.iter().map(|(value, ..)| value / freedom).collect();
        // A nanometre of standard deviation over the whole field is no variation, nor is being unlike one's own image.
        let even = found.iter().filter(|(_, odd, _)| !odd);
        if even.map(|(value, ..)| value).sum::<f64>() / freedom < 1e-12 {
            return Err(FitError::Input("the faces do not vary here".into()));
        }
        Ok(Self {
            vectors: Mat::from_fn(f, found.len(), |i, j| found[j].2[i]),
            odd: found.iter().map(|(_, odd, _)| *odd).collect(),
            eigenvalues,
            samples,
            mean,
            mirror,
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
        let images = if self.mirror.is_some() { 2 } else { 1 };
        real.count().min(images * self.samples.len() - 1)
    }

    /// Takes out of a field what a mode cannot have, whose mirror image is itself or the `odd` one's opposite:
    /// exactly, so that what is rounded keeps it. Nothing where images do not count.
    pub fn symmetrise(&self, field: &mut Vec<f64>, odd: bool) {
        if let Some(mirror) = &self.mirror {
            *field = part(field, mirror, if odd { -1.0 } else { 1.0 });
        }
    }

    /// The PCA with the first `modes`, or all there are. Each mode's sign is chosen so that its
    /// largest component is positive.
    pub fn truncate(&self, modes: usize) -> Pca {
        let kept = modes.min(self.most());
        let f = self.samples.len();
        let freedom = freedom(f, self.mirror.is_some()).sqrt();
        let sigmas: Vec<f64> = self.eigenvalues[..kept].iter().map(|e| e.sqrt()).collect();
        let turn = Mat::from_fn(f, kept, |i, k| self.vectors[(i, k)] / (sigmas[k] * freedom));
        let mut pca = Pca {
            modes: sums(&self.samples, turn.as_ref()),
            sigmas,
            eigenvalues: self.eigenvalues.clone(),
            coefficients: vec![Vec::with_capacity(kept); f],
            odd: self.odd[..kept].to_vec(),
        };
        // What the samples' other parts add up to in a mode is another's.
        (pca.modes.par_iter_mut().zip(&pca.odd))
            .for_each(|(mode, &odd)| self.symmetrise(mode, odd));
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

/// What the Gram matrix of F samples is divided by to be a covariance. With their mirror images they are twice as
/// many, and the Gram matrix of their even or odd parts has half the squares.
fn freedom(samples: usize, images: bool) -> f64 {
    if images {
        (2 * samples - 1) as f64 / 2.0
    } else {
        (samples - 1) as f64
    }
}

/// The mirror image of a field, x, y, z a vertex.
fn image(field: &[f64], mirror: &[u32]) -> Vec<f64> {
    let other = |&v: &u32| {
        let at = 3 * v as usize;
        [-field[at], field[at + 1], field[at + 2]]
    };
    mirror.iter().flat_map(other).collect()
}

/// The part of a field that is its own mirror image (`sign` 1), or the opposite of it (-1).
fn part(field: &[f64], mirror: &[u32], sign: f64) -> Vec<f64> {
    let both = field.iter().zip(image(field, mirror));
    both.map(|(x, image)| (x + sign * image) / 2.0).collect()
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

    /// The same modes, variances and coefficients as from twice as many samples, and each knows its side.
    #[test]
    fn mirror_images_count_as_samples() {
        let mirror = [1, 0, 3, 2, 4]; // two pairs, and a vertex in the middle
        let data = samples(7, 15);
        let both: Vec<Vec<f64>> = (data.iter().cloned())
            .chain(data.iter().map(|x| image(x, &mirror)))
            .collect();
        let plain = Spectrum::of(both).unwrap();
        let found = Spectrum::of_both_sides(data.clone(), mirror.to_vec()).unwrap();
        assert_eq!(image(&found.mean, &mirror), found.mean);
        let (plain, found) = (plain.truncate(9), found.truncate(9));
        assert!(found.odd.contains(&true) && found.odd.contains(&false));
        for k in 0..9 {
            let (mode, odd) = (&found.modes[k], found.odd[k]);
            let sign = if odd { -1.0 } else { 1.0 };
            let turned: Vec<f64> = image(mode, &mirror).iter().map(|x| sign * x).collect();
            assert_eq!(*mode, turned);
            assert!((found.sigmas[k] / plain.sigmas[k] - 1.0).abs() < 1e-9);
            let dot: f64 = mode.iter().zip(&plain.modes[k]).map(|(a, b)| a * b).sum();
            assert!((dot.abs() - 1.0).abs() < 1e-9, "{dot}");
            for (f, row) in found.coefficients.iter().enumerate() {
                assert!((row[k] - dot * plain.coefficients[f][k]).abs() < 1e-9);
                assert!((sign * row[k] - dot * plain.coefficients[7 + f][k]).abs() < 1e-9);
            }
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
