//! The elastic sheet: how a displacement of the template is kept smooth while scan and landmarks
//! pull at it.

use faer::linalg::solvers::Solve;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};
use glam::DVec3;

use crate::fit::mesh::align::vertex_areas;
use crate::fit::mesh::cotangent::cotangent_edges;
use crate::fit::{FitError, FitResult};

/// A sparse matrix by rows.
struct Rows {
    starts: Vec<u32>,
    entries: Vec<(u32, f64)>,
}

impl Rows {
    fn row(&self, i: usize) -> &[(u32, f64)] {
        &self.entries[self.starts[i] as usize..self.starts[i + 1] as usize]
    }
}

/// The bending energy u' K M^-1 K u of displacements of a mesh at rest (K cotangent weights, M
/// vertex areas), factored for several stiffnesses.
///
/// A stiffness is given as a length l: the weight of bending against a surface that pulls at every
/// vertex is l^4, so detail of the pull much finer than l is resisted.
pub struct Sheet {
    /// The area around each vertex at rest, mm^2.
    pub areas: Vec<f64>,
    bending: Rows,
    points: Vec<Vec<(u32, f64)>>,
    levels: Vec<Level>,
}

struct Level {
    weight: f64,
    factor: faer::sparse::linalg::solvers::Llt<usize, f64>,
    /// The factored system's inverse times each point's weights on the vertices, n a point.
    responses: Mat<f64>,
}

/// What pulls at the sheet.
#[derive(Debug, Clone, Default)]
pub struct Pull {
    /// Where each vertex ought to move in the direction of `normals`, mm from where it rests.
    pub targets: Vec<DVec3>,
    /// The direction in which it is pulled.
    pub normals: Vec<DVec3>,
    /// How much each vertex is pulled, 0 to 1, times its area.
    pub weights: Vec<f64>,
    /// Points of the sheet (their place in its list), where they ought to move, and how much they
    /// are pulled, in mm^2 of surface.
    pub points: Vec<(usize, DVec3, f64)>,
}

/// The average of a direction's square over all directions: what a pull along normals weighs in
/// one coordinate, so that the factored system is near the true one.
const DIRECTION: f64 = 1.0 / 3.0;

impl Sheet {
    /// A sheet of some vertices of a mesh: `triangles` index `positions`; every vertex should be
    /// in a triangle. `lengths` are the stiffnesses, mm; `open` says how much of its area each
    /// vertex will be pulled with, at most; `points` are the places where single points may pull
    /// (weights on vertices).
    ///
    /// # Errors
    /// When the mesh has a vertex of no area, so that the system is singular.
    pub fn new(
        positions: &[DVec3],
        triangles: &[[u32; 3]],
        open: &[f64],
        points: Vec<Vec<(u32, f64)>>,
        lengths: &[f64],
    ) -> FitResult<Self> {
        let n = positions.len();
        let mut areas = vertex_areas(positions, triangles);
        let typical = areas.iter().sum::<f64>() / n as f64;
        // Slivers would make bending there infinitely stiff.
        areas.iter_mut().for_each(|a| *a = a.max(0.02 * typical));
        let mut laplacian: Vec<Vec<(u32, f64)>> = vec![Vec::new(); n];
        for (a, b, weight) in cotangent_edges(positions, triangles) {
            laplacian[a as usize].push((b, -weight));
            laplacian[b as usize].push((a, -weight));
        }
        for (i, row) in laplacian.iter_mut().enumerate() {
            let sum: f64 = row.iter().map(|e| e.1).sum();
            row.push((i as u32, -sum));
            row.sort_unstable_by_key(|e| e.0);
        }
        let mut bending = Rows {
            starts: vec![0],
            entries: Vec::new(),
        };
        let mut dense = vec![0.0; n];
        let mut touched = Vec::new();
        for i in 0..n {
            for &(j, a) in &laplacian[i] {
                for &(k, b) in &laplacian[j as usize] {
                    if dense[k as usize] == 0.0 {
                        touched.push(k);
                    }
                    dense[k as usize] += a * b / areas[j as usize];
                }
            }
            touched.sort_unstable();
            touched.dedup();
            bending
                .entries
                .extend(touched.iter().map(|&k| (k, dense[k as usize])));
            bending.starts.push(bending.entries.len() as u32);
            touched.drain(..).for_each(|k| dense[k as usize] = 0.0);
        }
        let mut sheet = Self {
            areas,
            bending,
            points,
            levels: Vec::new(),
        };
        for &length in lengths {
            let level = sheet.factor(length, open)?;
            sheet.levels.push(level);
        }
        Ok(sheet)
    }

    fn factor(&self, length: f64, open: &[f64]) -> FitResult<Level> {
        let n = self.areas.len();
        let weight = length.powi(4);
        let mut triplets = Vec::with_capacity(self.bending.entries.len());
        for (i, &open) in open.iter().enumerate() {
            for &(j, b) in self.bending.row(i) {
                let pull = if i == j as usize {
                    self.areas[i] * open.max(0.02) * DIRECTION
                } else {
                    0.0
                };
                triplets.push(Triplet::new(i, j as usize, weight * b + pull));
            }
        }
        // Sums in an order that does not depend on the number of threads.
        faer::set_global_parallelism(faer::Par::Seq);
        let factor = SparseColMat::try_new_from_triplets(n, n, &triplets)
            .map_err(|e| FitError::Input(format!("the elastic sheet: {e:?}")))?
            .sp_cholesky(Side::Lower)
            .map_err(|e| FitError::Input(format!("the elastic sheet: {e:?}")))?;
        let mut right = Mat::zeros(n, self.points.len());
        for (p, stencil) in self.points.iter().enumerate() {
            stencil
                .iter()
                .for_each(|&(v, s)| right[(v as usize, p)] += s);
        }
        let responses = factor.solve(&right);
        Ok(Level {
            weight,
            factor,
            responses,
        })
    }

    /// Moves `displacements` towards the minimum of pull and bending at one stiffness (its place
    /// among the lengths), by `steps` of conjugate gradients with the factored system as
    /// preconditioner.
    pub fn relax(&self, level: usize, pull: &Pull, displacements: &mut [DVec3], steps: usize) {
        let level = &self.levels[level];
        let weight = level.weight;
        let preconditioner = Preconditioner::new(level, &self.points, &pull.points);
        let n = self.areas.len();
        let apply = |u: &[DVec3]| -> Vec<DVec3> {
            let mut out: Vec<DVec3> = (0..n)
                .map(|i| {
                    let row = self.bending.row(i).iter();
                    let bent: DVec3 = row.map(|&(j, b)| u[j as usize] * b).sum();
                    let w = pull.weights[i] * self.areas[i];
                    bent * weight + pull.normals[i] * (w * pull.normals[i].dot(u[i]))
                })
                .collect();
            for &(p, _, w) in &pull.points {
                let stencil = &self.points[p];
                let at: DVec3 = stencil.iter().map(|&(v, s)| u[v as usize] * s).sum();
                stencil
                    .iter()
                    .for_each(|&(v, s)| out[v as usize] += at * (s * w));
            }
            out
        };
        let mut right: Vec<DVec3> = (0..n)
            .map(|i| {
                let w = pull.weights[i] * self.areas[i];
                let normal = pull.normals[i];
                normal * (w * normal.dot(pull.targets[i]))
            })
            .collect();
        for &(p, target, w) in &pull.points {
            let stencil = &self.points[p];
            stencil
                .iter()
                .for_each(|&(v, s)| right[v as usize] += target * (s * w));
        }
        let dot =
            |a: &[DVec3], b: &[DVec3]| -> f64 { a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum() };
        let now = apply(displacements);
        let mut residual: Vec<DVec3> = right.iter().zip(now).map(|(a, b)| *a - b).collect();
        let mut direction = preconditioner.solve(&residual);
        let mut size = dot(&residual, &direction);
        for step in 0..steps {
            if size <= 0.0 {
                break;
            }
            let image = apply(&direction);
            let length = size / dot(&direction, &image);
            for i in 0..n {
                displacements[i] += direction[i] * length;
                residual[i] -= image[i] * length;
            }
            if step + 1 == steps {
                break;
            }
            let z = preconditioner.solve(&residual);
            let next = dot(&residual, &z);
            let turn = next / size;
            size = next;
            direction
                .iter_mut()
                .zip(z)
                .for_each(|(d, z)| *d = z + *d * turn);
        }
    }
}

/// The factored system with the points that pull in it, by the Woodbury identity.
struct Preconditioner<'a> {
    level: &'a Level,
    /// The points that pull.
    points: Vec<usize>,
    stencils: &'a [Vec<(u32, f64)>],
    /// Of the points among each other; absent when none pulls.
    small: Option<faer::linalg::solvers::Llt<f64>>,
}

impl<'a> Preconditioner<'a> {
    fn new(
        level: &'a Level,
        stencils: &'a [Vec<(u32, f64)>],
        pulling: &[(usize, DVec3, f64)],
    ) -> Self {
        let pulling: Vec<_> = pulling.iter().filter(|p| p.2 > 0.0).collect();
        let small = Mat::from_fn(pulling.len(), pulling.len(), |i, j| {
            let (p, _, w) = *pulling[i];
            let stencil = stencils[p].iter();
            let response = stencil
                .map(|&(v, s)| s * level.responses[(v as usize, pulling[j].0)])
                .sum::<f64>();
            response + if i == j { 1.0 / w } else { 0.0 }
        });
        Self {
            level,
            points: pulling.iter().map(|p| p.0).collect(),
            stencils,
            small: small.llt(Side::Lower).ok().filter(|_| !pulling.is_empty()),
        }
    }

    fn solve(&self, right: &[DVec3]) -> Vec<DVec3> {
        let right = Mat::from_fn(right.len(), 3, |i, axis| right[i][axis]);
        let mut z = self.level.factor.solve(&right);
        if let Some(small) = &self.small {
            let at = Mat::from_fn(self.points.len(), 3, |i, axis| {
                let stencil = self.stencils[self.points[i]].iter();
                stencil
                    .map(|&(v, s)| s * z[(v as usize, axis)])
                    .sum::<f64>()
            });
            let forces = small.solve(&at);
            for (i, &p) in self.points.iter().enumerate() {
                for axis in 0..3 {
                    let force = forces[(i, axis)];
                    let column = self.level.responses.col(p);
                    let mut z = z.as_mut().col_mut(axis);
                    for v in 0..z.nrows() {
                        z[v] -= column[v] * force;
                    }
                }
            }
        }
        (0..z.nrows())
            .map(|i| DVec3::new(z[(i, 0)], z[(i, 1)], z[(i, 2)]))
            .collect()
    }
}
