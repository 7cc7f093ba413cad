//! Shapes of the template written on the base mesh's vertices, of which there are a quarter as many.
//!
//! The template is a linear function of the base mesh (its stencils), so a displacement of the
//! template has a least-squares counterpart on the base mesh. What is lost is what a subdivision
//! surface with that cage cannot do: detail below its edge length.

use faer::linalg::solvers::Solve;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};
use glam::DVec3;

use super::template::Template;
use crate::fit::{FitError, FitResult};

/// Keeps base vertices in place that the template does not fix: eyeballs follow an affine map of
/// their helpers only. A millionth of what one vertex of the template weighs.
const RIDGE: f64 = 1e-6;

/// The least-squares map from displacements of the template to displacements of its base mesh.
pub struct Cage {
    /// The base vertices that the template depends on, increasing.
    pub vertices: Vec<u32>,
    factor: faer::sparse::linalg::solvers::Llt<usize, f64>,
    rows: Vec<Vec<(u32, f64)>>,
}

impl Cage {
    /// Prepares a template.
    ///
    /// # Errors
    /// When its stencils are not sound.
    pub fn new(template: &Template) -> FitResult<Self> {
        let stencils = &template.stencils;
        let mut vertices: Vec<u32> = stencils.entries.iter().map(|e| e.0).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let rows: Vec<Vec<(u32, f64)>> = stencils
            .starts
            .windows(2)
            .map(|row| {
                stencils.entries[row[0] as usize..row[1] as usize]
                    .iter()
                    .map(|&(v, w)| (vertices.partition_point(|&other| other < v) as u32, w))
                    .collect()
            })
            .collect();
        let n = vertices.len();
        let mut triplets: Vec<Triplet<usize, usize, f64>> =
            (0..n).map(|i| Triplet::new(i, i, RIDGE)).collect();
        for row in &rows {
            for &(i, a) in row {
                for &(j, b) in row {
                    triplets.push(Triplet::new(i as usize, j as usize, a * b));
                }
            }
        }
        faer::set_global_parallelism(faer::Par::Seq);
        let factor = SparseColMat::try_new_from_triplets(n, n, &triplets)
            .map_err(|e| FitError::Input(format!("the base mesh's system: {e:?}")))?
            .sp_cholesky(Side::Lower)
            .map_err(|e| FitError::Input(format!("the base mesh's system: {e:?}")))?;
        Ok(Self {
            vertices,
            factor,
            rows,
        })
    }

    /// The displacements of the base vertices that come closest to those of the template.
    pub fn fit(&self, displacements: &[DVec3]) -> Vec<DVec3> {
        let mut right = Mat::zeros(self.vertices.len(), 3);
        for (row, d) in self.rows.iter().zip(displacements) {
            for &(i, w) in row {
                for axis in 0..3 {
                    right[(i as usize, axis)] += w * d[axis];
                }
            }
        }
        let x = self.factor.solve(&right);
        (0..x.nrows())
            .map(|i| DVec3::new(x[(i, 0)], x[(i, 1)], x[(i, 2)]))
            .collect()
    }

    /// The template's displacements for those of the base vertices.
    pub fn apply(&self, base: &[DVec3]) -> Vec<DVec3> {
        self.rows
            .iter()
            .map(|row| row.iter().map(|&(i, w)| base[i as usize] * w).sum())
            .collect()
    }
}
