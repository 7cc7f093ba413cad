//! The vector of a linear space of displacement fields that is nearest to a given one.

use std::ops::Range;

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use glam::DVec3;
use rayon::prelude::*;

use super::gram::{chunks, gram, sums};
use crate::fit::{FitError, FitResult};

/// Modes (displacements of all vertices, mm) as seen on some vertices.
pub struct Subspace<'a> {
    modes: &'a [Vec<DVec3>],
    vertices: &'a [u32],
    factor: faer::linalg::solvers::Llt<f64>,
}

impl<'a> Subspace<'a> {
    /// Prepares modes for least squares over `vertices`, each of which counts alike.
    ///
    /// # Errors
    /// When a mode is a sum of others on these vertices.
    pub fn new(modes: &'a [Vec<DVec3>], vertices: &'a [u32]) -> FitResult<Self> {
        Self::penalised(modes, vertices, Mat::zeros(modes.len(), modes.len()))
    }

    /// As [`Subspace::new`], but least is the sum of squares and c' P c of the coefficients c and
    /// the `penalty` P (mm^2).
    ///
    /// # Errors
    /// When a mode that is not penalised is a sum of others on these vertices.
    pub fn penalised(
        modes: &'a [Vec<DVec3>],
        vertices: &'a [u32],
        penalty: Mat<f64>,
    ) -> FitResult<Self> {
        let mut normal = gram(3 * vertices.len(), |rows| columns(modes, vertices, rows));
        // A ten-thousand-millionth keeps modes that are nearly alike apart from rounding.
        let trace: f64 = (0..modes.len()).map(|i| normal[(i, i)]).sum();
        (0..modes.len()).for_each(|i| normal[(i, i)] += 1e-10 * trace / modes.len() as f64);
        let factor = (normal + penalty)
            .llt(Side::Lower)
            .map_err(|_| FitError::Input("modes that are sums of each other".into()))?;
        Ok(Self {
            modes,
            vertices,
            factor,
        })
    }

    /// Least-squares coefficients for each of some displacement fields (all vertices, mm).
    pub fn coefficients(&self, fields: &[Vec<DVec3>]) -> Vec<Vec<f64>> {
        let (k, f) = (self.modes.len(), fields.len());
        let parts: Vec<Mat<f64>> = chunks(3 * self.vertices.len())
            .into_par_iter()
            .map(|rows| {
                let modes = columns(self.modes, self.vertices, rows.clone());
                modes.transpose() * columns(fields, self.vertices, rows)
            })
            .collect();
        let right = (parts.iter()).fold(Mat::zeros(k, f), |sum, part| sum + part);
        let solved = self.factor.solve(&right);
        (0..f)
            .map(|j| (0..k).map(|i| solved[(i, j)]).collect())
            .collect()
    }

    /// The displacement fields of some faces' coefficients, all vertices, mm.
    pub fn fields(&self, coefficients: &[Vec<f64>]) -> Vec<Vec<DVec3>> {
        fields(self.modes, coefficients)
    }
}

/// Sums of modes (displacements of all vertices), one for each face's coefficients.
pub fn fields(modes: &[Vec<DVec3>], coefficients: &[Vec<f64>]) -> Vec<Vec<DVec3>> {
    let amounts = Mat::from_fn(modes.len(), coefficients.len(), |k, f| coefficients[f][k]);
    let modes: Vec<&[f64]> = modes.iter().map(|m| bytemuck::cast_slice(m)).collect();
    (sums(&modes, amounts.as_ref()).into_iter())
        .map(|sum| sum.chunks_exact(3).map(DVec3::from_slice).collect())
        .collect()
}

/// Some rows (x, y, z of each vertex in turn; whole vertices) of the matrix that has the fields as
/// columns.
fn columns(fields: &[Vec<DVec3>], vertices: &[u32], rows: Range<usize>) -> Mat<f64> {
    let some = &vertices[rows.start / 3..rows.end / 3];
    let mut part = Mat::zeros(rows.len(), fields.len());
    for (column, field) in part.col_iter_mut().zip(fields) {
        let values = some.iter().flat_map(|&v| field[v as usize].to_array());
        column.iter_mut().zip(values).for_each(|(to, x)| *to = x);
    }
    part
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;

    fn noise(random: &mut Random, count: usize, n: usize) -> Vec<Vec<DVec3>> {
        let mut point = || DVec3::new(random.normal(), random.normal(), random.normal());
        (0..count)
            .map(|_| (0..n).map(|_| point()).collect())
            .collect()
    }

    #[test]
    fn what_is_in_the_subspace_is_found_again_and_the_rest_is_orthogonal() {
        let mut random = Random::new(5);
        let modes = noise(&mut random, 4, 50);
        let vertices: Vec<u32> = (0..50).filter(|v| v % 7 != 0).collect();
        let subspace = Subspace::new(&modes, &vertices).unwrap();
        let inside = fields(&modes, &[vec![0.5, -2.0, 0.0, 3.0]]).remove(0);
        let any = noise(&mut random, 1, 50).remove(0);
        let found = subspace.coefficients(&[inside, any.clone()]);
        for (c, wanted) in found[0].iter().zip([0.5, -2.0, 0.0, 3.0]) {
            // The ridge is 1e-10 of a mode.
            assert!((c - wanted).abs() < 1e-8);
        }
        let nearest = &subspace.fields(&found)[1];
        for mode in &modes {
            let dot: f64 = vertices
                .iter()
                .map(|&v| (any[v as usize] - nearest[v as usize]).dot(mode[v as usize]))
                .sum();
            assert!(dot.abs() < 1e-6, "{dot}");
        }
    }
}
