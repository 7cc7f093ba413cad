//! The most probable coefficients under constraints.
//!
//! Coefficients (in sigmas) are normal with mean 0 and the population's correlation R. Drawing a
//! face around what is locked, or with some attributes, and dragging a vertex are all conditional
//! distributions of it.

use glam::{DVec3, Vec3};
use nalgebra::DMatrix;

use crate::model::{FaceModel, LIMIT, along};

/// The product of two matrices, in one place of the code, column by column: nalgebra's own for matrices
/// of any size has kernels that take as much of the module as drawing a face, and these are small.
#[inline(never)]
pub(super) fn product(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut product = DMatrix::zeros(a.nrows(), b.ncols());
    for (mut column, right) in product.column_iter_mut().zip(b.column_iter()) {
        column.gemv(1.0, a, &right, 0.0);
    }
    product
}

/// The inverse of a positive definite matrix times another; `None` when it is not definite.
#[inline(never)]
pub(super) fn solve(matrix: DMatrix<f64>, right: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    Some(matrix.cholesky()?.solve(right))
}

#[inline(never)]
fn select(matrix: &DMatrix<f64>, rows: &[usize], columns: &[usize]) -> DMatrix<f64> {
    DMatrix::from_fn(rows.len(), columns.len(), |i, j| {
        matrix[(rows[i], columns[j])]
    })
}

/// Attributes are met one after the other, so many times: what one undoes of another by their
/// correlation r is left to r^2 each time, and what the limits of coefficients cut off is found
/// elsewhere.
const ROUNDS: usize = 40;
/// They are met when none is off by more than this part of its limits.
const MET: f64 = 1e-6;

/// A drawn coefficient within its limits.
pub(super) fn within(sigmas: f64) -> f64 {
    let limit = f64::from(LIMIT);
    // Not `clamp`, as in `drag`.
    sigmas.max(-limit).min(limit)
}

impl FaceModel {
    /// A draw from N(0, R) given the coefficients that are not `free`, from independent standard
    /// normal numbers (times a spread) in `white`. Matheron's rule: draw jointly, then correct the
    /// free ones by the regression on what the held ones are off by.
    pub(crate) fn conditional_sample(
        &self,
        white: &[f64],
        present: &[f64],
        free: &[usize],
    ) -> Vec<f64> {
        let white = DMatrix::from_column_slice(white.len(), 1, white);
        let joint = product(&self.derived.cholesky, &white);
        let held = complement(free, white.len());
        let mut drawn: Vec<f64> = joint.iter().copied().collect();
        let off = DMatrix::from_fn(held.len(), 1, |i, _| present[held[i]] - joint[held[i]]);
        if let Some(gain) = self.regression(free, &held) {
            for (&i, correction) in free.iter().zip(product(&gain, &off).iter()) {
                drawn[i] += correction;
            }
        }
        held.iter().for_each(|&i| drawn[i] = present[i]);
        drawn
    }

    /// Changes the free coefficients of a face by the least Mahalanobis length with which attributes
    /// read what is asked (Kaczmarz's projections, in turns), each coefficient within its limits, or
    /// no farther out than it was.
    ///
    /// With w the read-out and S the covariance of the free coefficients given the others, all of
    /// the way is gone when all are free, and else the part (w . S w) / (w . R w) of it, as if
    /// what the others tell of the attribute were yet unknown.
    pub(crate) fn steer(&self, drawn: &mut [f64], free: &[usize], asked: &[(usize, f64)]) {
        if asked.is_empty() || free.is_empty() {
            return;
        }
        // Nothing is held nearly always, and nothing then has to be taken out of the correlation.
        let given =
            (free.len() < self.parts().population()).then(|| self.conditional_covariance(free));
        let limits: Vec<f64> = (free.iter())
            .map(|&i| drawn[i].abs().max(LIMIT.into()))
            .collect();
        let steps: Vec<_> = (asked.iter())
            .map(|&(which, wanted)| {
                let attribute = &self.parts().attributes[which];
                let (all, whole) = &self.derived.along[which];
                let (along, own) = match &given {
                    None => (all.clone(), *whole),
                    Some(covariance) => {
                        let weights: Vec<f32> =
                            free.iter().map(|&i| attribute.reading[i]).collect();
                        along(covariance, &weights)
                    }
                };
                let reads = attribute.read(drawn);
                let goal = reads + (wanted - reads) * own / whole;
                let [least, most] = attribute.limits.map(f64::from);
                (attribute, along, own, goal, (most - least) * MET)
            })
            .collect();
        for _ in 0..ROUNDS {
            let mut off = false;
            for (attribute, along, own, goal, met) in &steps {
                let missing = goal - attribute.read(drawn);
                off |= missing.abs() > *met;
                let amount = missing / own.max(1e-12);
                for ((&i, a), &limit) in free.iter().zip(along).zip(&limits) {
                    // Not `clamp`, as in `drag`.
                    drawn[i] = (drawn[i] + amount * a).max(-limit).min(limit);
                }
            }
            if !off {
                return;
            }
        }
    }

    /// The change of the free coefficients of least Mahalanobis length, given that the others do
    /// not change, that moves a vertex with the given Jacobian (mm a sigma) by `wanted` (mm).
    pub(crate) fn probable_change(
        &self,
        jacobian: &[Vec3],
        wanted: DVec3,
        free: &[usize],
    ) -> Vec<f64> {
        let covariance = self.conditional_covariance(free);
        let j = DMatrix::from_fn(3, free.len(), |axis, i| f64::from(jacobian[free[i]][axis]));
        let spread = product(&covariance, &j.transpose());
        let mut gram = product(&j, &spread);
        // A vertex may be unable to move along some axis (nothing free reaches it): the ridge of a
        // millionth of its mobility makes that axis stay instead of asking for the impossible.
        let ridge = gram.trace() * 1e-6 + 1e-12;
        (0..3).for_each(|i| gram[(i, i)] += ridge);
        match solve(gram, &DMatrix::from_column_slice(3, 1, &wanted.to_array())) {
            Some(pull) => product(&spread, &pull).as_slice().to_vec(),
            None => vec![0.0; free.len()],
        }
    }

    /// The covariance of the free coefficients given the others. Those of local blocks, of which
    /// the population knows nothing, count as independent.
    pub(crate) fn conditional_covariance(&self, free: &[usize]) -> DMatrix<f64> {
        let population = self.parts().population();
        let correlation = &self.derived.correlation;
        let people: Vec<usize> = free.iter().copied().filter(|&i| i < population).collect();
        let mut among = select(correlation, &people, &people);
        let held = complement(&people, population);
        if let Some(gain) = self.regression(&people, &held) {
            among -= product(&gain, &select(correlation, &held, &people));
        }
        let place = |i: usize| people.iter().position(|&p| p == i);
        let places: Vec<Option<usize>> = free.iter().map(|&i| place(i)).collect();
        DMatrix::from_fn(free.len(), free.len(), |a, b| {
            match (places[a], places[b]) {
                (Some(a), Some(b)) => among[(a, b)],
                _ => f64::from(u8::from(a == b)),
            }
        })
    }

    /// R_fh R_hh^-1, by which the free coefficients follow the held ones; `None` if none is held.
    fn regression(&self, free: &[usize], held: &[usize]) -> Option<DMatrix<f64>> {
        if held.is_empty() || free.is_empty() {
            return None;
        }
        let correlation = &self.derived.correlation;
        let across = select(correlation, held, free);
        // A principal submatrix of a positive definite matrix is one too.
        Some(solve(select(correlation, held, held), &across)?.transpose())
    }
}

fn complement(some: &[usize], count: usize) -> Vec<usize> {
    let mut held = vec![true; count];
    some.iter().for_each(|&i| held[i] = false);
    (0..count).filter(|&i| held[i]).collect()
}
