//! Smoothing of a region's deformation (region morphing, section 6.1).
//!
//! Eqs. 7 to 9 ask for the T' that minimises the differences over edges plus the distance from T;
//! the minimum is linear: T' = (I + mu L)^-1 T, so it is folded into the modes offline. The paper
//! does not say what T_i is; here it is the translation reading T_i = [I | d_i], which smooths the
//! displacement field itself.
//!
//! Unit weights would blur coarse meshes more than fine ones. Here L has cotangent weights and the
//! vertices their areas, so mu is the square of a length: detail much finer than it goes, detail
//! much coarser stays. The region's border is free (Neumann), so with a length that grows towards
//! the border the displacement arrives there with no slope across it, which is what the fall-off
//! of the surround, also without slope there, continues without a crease.

use faer::Side;
use faer::linalg::solvers::Solve;
use faer::sparse::{SparseColMat, Triplet};
use glam::DVec3;

use crate::fit::mesh::cotangent::cotangent_edges;
use crate::fit::{FitError, FitResult};

/// How much a region is smoothed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Smoothing {
    /// The length inside the region, mm.
    pub inside: f64,
    /// The length at its border, mm.
    pub border: f64,
    /// The distance from the border at which the inside begins, mm.
    pub band: f64,
}

impl Smoothing {
    /// The length at some distance from the border, mm: a smooth step between the two.
    fn length(&self, distance: f64) -> f64 {
        let t = (distance / self.band).clamp(0.0, 1.0);
        let step = t * t * (3.0 - 2.0 * t);
        self.border + (self.inside - self.border) * step
    }
}

/// The factored system of one region.
pub struct Smoother {
    factor: faer::sparse::linalg::solvers::Llt<usize, f64>,
    areas: Vec<f64>,
}

impl Smoother {
    /// Prepares a region.
    ///
    /// `support` are its vertices (increasing), `triangles` those of the whole mesh, and
    /// `border_distance` gives each support vertex's distance from the border in mm (infinite for
    /// parts that have none: cavities and eyeballs).
    ///
    /// # Errors
    /// When the system cannot be factored.
    pub fn new(
        smoothing: Smoothing,
        positions: &[DVec3],
        triangles: &[[u32; 3]],
        support: &[u32],
        border_distance: &[f64],
    ) -> FitResult<Self> {
        let slot = |v: u32| support.binary_search(&v).ok();
        let inner: Vec<[u32; 3]> = triangles
            .iter()
            .filter(|t| t.iter().all(|&v| slot(v).is_some()))
            .copied()
            .collect();
        let all_areas = crate::fit::mesh::align::vertex_areas(positions, &inner);
        // A vertex without a triangle of the region around it is its own neighbourhood.
        let areas: Vec<f64> = support
            .iter()
            .map(|&v| all_areas[v as usize].max(1e-3))
            .collect();
        let mut triplets: Vec<Triplet<usize, usize, f64>> = areas
            .iter()
            .enumerate()
            .map(|(i, &area)| Triplet::new(i, i, area))
            .collect();
        for (a, b, weight) in cotangent_edges(positions, &inner) {
            let (Some(i), Some(j)) = (slot(a), slot(b)) else {
                continue;
            };
            let length = smoothing.length((border_distance[i] + border_distance[j]) / 2.0);
            let weight = weight * length * length;
            triplets.extend([
                Triplet::new(i, i, weight),
                Triplet::new(j, j, weight),
                Triplet::new(i, j, -weight),
                Triplet::new(j, i, -weight),
            ]);
        }
        let n = support.len();
        let matrix = SparseColMat::try_new_from_triplets(n, n, &triplets)
            .map_err(|e| FitError::Input(format!("the smoothing system: {e:?}")))?;
        let factor = matrix
            .sp_cholesky(Side::Lower)
            .map_err(|e| FitError::Input(format!("the smoothing system: {e:?}")))?;
        Ok(Self { factor, areas })
    }

    /// Smooths a displacement field: x, y, z a support vertex.
    pub fn smooth(&self, field: &[f64]) -> Vec<f64> {
        let right = faer::Mat::from_fn(self.areas.len(), 3, |i, axis| {
            field[3 * i + axis] * self.areas[i]
        });
        let solved = self.factor.solve(&right);
        (0..field.len()).map(|i| solved[(i / 3, i % 3)]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square sheet of n x n vertices a millimetre apart.
    fn sheet(n: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let at = |x: u32, y: u32| y * n + x;
        let positions = (0..n * n)
            .map(|i| DVec3::new(f64::from(i % n), f64::from(i / n), 0.0))
            .collect();
        let mut triangles = Vec::new();
        for y in 0..n - 1 {
            for x in 0..n - 1 {
                triangles.push([at(x, y), at(x + 1, y), at(x + 1, y + 1)]);
                triangles.push([at(x, y), at(x + 1, y + 1), at(x, y + 1)]);
            }
        }
        (positions, triangles)
    }

    fn smoother(length: f64, n: u32) -> Smoother {
        let (positions, triangles) = sheet(n);
        let support: Vec<u32> = (0..n * n).collect();
        let everywhere = Smoothing {
            inside: length,
            border: length,
            band: 1.0,
        };
        let far = vec![f64::INFINITY; support.len()];
        Smoother::new(everywhere, &positions, &triangles, &support, &far).unwrap()
    }

    #[test]
    fn a_translation_stays_and_the_mean_is_kept() {
        let smoother = smoother(3.0, 12);
        let still: Vec<f64> = (0..144).flat_map(|_| [1.0, -2.0, 0.5]).collect();
        for (a, b) in smoother.smooth(&still).iter().zip(&still) {
            assert!((a - b).abs() < 1e-9);
        }
        let bumpy: Vec<f64> = (0..432).map(|i| f64::from(i * 7919 % 101)).collect();
        let integral =
            |field: &[f64]| -> f64 { (0..144).map(|i| field[3 * i] * smoother.areas[i]).sum() };
        let (before, after) = (integral(&bumpy), integral(&smoother.smooth(&bumpy)));
        assert!((before - after).abs() < 1e-6 * before.abs());
    }

    #[test]
    fn a_wave_is_damped_as_the_length_says() {
        // In the continuum a wave of wavelength w keeps 1 / (1 + (2 pi length / w)^2) of itself.
        let n = 65;
        let (length, wavelength) = (2.0, 32.0);
        let wave = |i: usize| (std::f64::consts::TAU * (i % n) as f64 / wavelength).cos();
        let field: Vec<f64> = (0..n * n).flat_map(|i| [0.0, 0.0, wave(i)]).collect();
        let smooth = smoother(length, n as u32).smooth(&field);
        let expected = 1.0 / (1.0 + (std::f64::consts::TAU * length / wavelength).powi(2));
        let middle = 32 * n + 32;
        // One part in a hundred: a wave of 32 vertices is not quite the continuum's.
        assert!((smooth[3 * middle + 2] / field[3 * middle + 2] - expected).abs() < 0.01);
    }
}
