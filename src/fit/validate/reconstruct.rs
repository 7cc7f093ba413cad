//! The face of a linear model that is nearest to a given one, and how far off it is.

use std::ops::Range;

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use crate::fit::head::template::Template;
use crate::fit::learn::gram::{chunks, gram, sums};
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

/// The visible parts of a head in which errors are counted: each feature's skin, the rest of the
/// skin, and all features together.
pub struct Areas {
    /// Their names.
    pub names: Vec<String>,
    /// The vertices of each, increasing.
    pub vertices: Vec<Vec<u32>>,
    /// All of the skin.
    pub skin: Vec<u32>,
}

/// The name of all features together.
pub const FEATURES: &str = "all features";

impl Areas {
    /// Those of a template.
    ///
    /// # Errors
    /// When it has no skin.
    pub fn new(template: &Template) -> FitResult<Self> {
        let skin = template.part_vertices("skin")?;
        let name_of = |v: u32| {
            let topology = &template.topology;
            topology.region_names[topology.regions[v as usize] as usize].as_str()
        };
        let rules = crate::fit::learn::FEATURES;
        let (mut names, mut vertices) = (Vec::new(), Vec::new());
        for rule in rules {
            names.push(rule.name.to_owned());
            let inside = skin.iter().filter(|&&v| rule.regions.contains(&name_of(v)));
            vertices.push(inside.copied().collect::<Vec<u32>>());
        }
        let mut all: Vec<u32> = vertices.concat();
        all.sort_unstable();
        let rest = skin.iter().filter(|v| all.binary_search(v).is_err());
        vertices.push(rest.copied().collect());
        names.push("head".into());
        vertices.push(all);
        names.push(FEATURES.into());
        Ok(Self {
            names,
            vertices,
            skin,
        })
    }

    /// The diagonal of the bounding box of a head's skin, mm.
    pub fn diameter(&self, head: &[DVec3]) -> f64 {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &v in &self.skin {
            low = low.min(head[v as usize]);
            high = high.max(head[v as usize]);
        }
        low.distance(high)
    }

    /// The errors of a reconstruction in each area, mm.
    pub fn errors(&self, face: &[DVec3], reconstructed: &[DVec3]) -> Vec<Errors> {
        self.vertices
            .iter()
            .map(|area| Errors::between(area, face, reconstructed))
            .collect()
    }
}

/// Distances between corresponding vertices, mm.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Errors {
    /// The largest.
    pub max: f64,
    /// The mean.
    pub mean: f64,
    /// The root mean square.
    pub rms: f64,
}

impl Errors {
    /// Between two faces, or fields of displacements, on some vertices.
    pub fn between(vertices: &[u32], one: &[DVec3], other: &[DVec3]) -> Self {
        let apart = |&v: &u32| one[v as usize].distance(other[v as usize]);
        Self::of(vertices.iter().map(apart))
    }

    fn of(distances: impl Iterator<Item = f64>) -> Self {
        let (mut count, mut max, mut sum, mut squares) = (0_usize, 0.0_f64, 0.0, 0.0);
        for d in distances {
            count += 1;
            max = max.max(d);
            sum += d;
            squares += d * d;
        }
        let n = count.max(1) as f64;
        Self {
            max,
            mean: sum / n,
            rms: (squares / n).sqrt(),
        }
    }
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

    #[test]
    fn errors_are_the_largest_the_mean_and_the_root_mean_square() {
        let errors = Errors::of([3.0, 4.0, 0.0, 0.0].into_iter());
        assert_eq!((errors.max, errors.mean, errors.rms), (4.0, 1.75, 2.5));
    }
}
