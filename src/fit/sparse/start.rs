//! Where the optimisation begins: components taken off the samples one after another (deflation).

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par, Side};
use nalgebra::Matrix3;
use rayon::prelude::*;

use crate::fit::{FitError, FitResult};

/// Components and weights to begin with.
pub(super) struct Start {
    /// The region or the centre that each component has, as the kind of basis needs it.
    pub place: Vec<usize>,
    /// K rows of 3n.
    pub components: Vec<Vec<f64>>,
    /// F x K, column-major; the largest of each column is 1 or -1.
    pub weights: Vec<f64>,
}

/// Below this part of the variance nothing is left to explain.
const NOTHING: f64 = 1e-12;

/// Components that belong to regions: the rank-1 singular value decompositions of each region's
/// samples, one after another, are its principal components. They are shared among the regions by
/// how much each explains, the most telling first, so that the first ones of a larger basis are
/// those of a smaller one. `ramps` fade a component out around its region, which is then taken off
/// before the next region looks at what is left.
///
/// `samples` are F x 3n, column-major.
pub(super) fn by_regions(
    samples: &[f64],
    f: usize,
    ramps: &[Vec<f64>],
    components: usize,
) -> FitResult<Start> {
    let n = samples.len() / (3 * f);
    let spectra: Vec<(Vec<f64>, Mat<f64>)> = ramps
        .par_iter()
        .map(|ramp| {
            let inside: Vec<usize> = (0..n).filter(|&i| ramp[i] <= 0.0).collect();
            let columns: Vec<f64> = inside
                .iter()
                .flat_map(|i| &samples[3 * f * i..3 * f * (i + 1)])
                .copied()
                .collect();
            let x = MatRef::from_column_major_slice(&columns, f, 3 * inside.len());
            let mut gram = Mat::<f64>::zeros(f, f);
            matmul(&mut gram, Accum::Replace, x, x.transpose(), 1.0, Par::Seq);
            let eigen = gram
                .self_adjoint_eigen(Side::Lower)
                .map_err(|e| FitError::Input(format!("the eigenvalues did not converge: {e:?}")))?;
            // faer gives them in increasing order.
            let values = (0..f).rev().map(|j| eigen.S()[j].max(0.0)).collect();
            Ok((values, Mat::from_fn(f, f, |i, j| eigen.U()[(i, f - 1 - j)])))
        })
        .collect::<FitResult<_>>()?;
    let total: f64 = spectra.iter().flat_map(|(values, _)| values).sum();
    let mut ranked: Vec<(f64, usize, usize)> = spectra
        .iter()
        .enumerate()
        .flat_map(|(region, (values, _))| {
            let kept = values.iter().enumerate();
            kept.filter(|(_, value)| **value > NOTHING * total)
                .map(move |(at, &value)| (value, region, at))
        })
        .collect();
    if ranked.len() < components {
        return Err(FitError::Input(format!(
            "{components} components are more than the {} ways in which the faces vary, \
             counted region by region",
            ranked.len()
        )));
    }
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    ranked.truncate(components);

    let mut start = Start {
        place: ranked.iter().map(|&(_, region, _)| region).collect(),
        components: vec![vec![0.0; 3 * n]; components],
        weights: vec![0.0; f * components],
    };
    for (k, weights) in start.weights.chunks_exact_mut(f).enumerate() {
        let vector = spectra[start.place[k]].1.col(ranked[k].2);
        let largest = vector.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let each = weights.iter_mut().zip(vector.iter());
        each.for_each(|(w, v)| *w = v / largest);
    }
    // One region after another; weights of one region are orthogonal. What is left of a coordinate
    // of a vertex knows of no other.
    let squares: Vec<f64> = start.weights.chunks_exact(f).map(square).collect();
    let mut order: Vec<usize> = (0..components).collect();
    order.sort_by_key(|&k| start.place[k]);
    let found: Vec<Vec<f64>> = (samples.par_chunks_exact(f).enumerate())
        .map(|(column, x)| {
            let mut left = x.to_vec();
            let each = order.iter().map(|&k| {
                let fade = (1.0 - ramps[start.place[k]][column / 3]).max(0.0);
                take_off(
                    &mut left,
                    &start.weights[k * f..(k + 1) * f],
                    squares[k],
                    fade,
                )
            });
            each.collect()
        })
        .collect();
    for (column, found) in found.iter().enumerate() {
        for (&k, c) in order.iter().zip(found) {
            start.components[k][column] = *c;
        }
    }
    Ok(start)
}

/// Components anywhere (Neumann et al. 2013, section 4.3): the vertex that moves most in what is
/// left gives the weights of the next component, by a rank-1 singular value decomposition of its
/// motion; `support` is 0 where the component may be and 1 where not. A component's place is its
/// centre, a place in the list of vertices.
pub(super) fn by_distance(
    samples: &[f64],
    f: usize,
    components: usize,
    mut support: impl FnMut(usize) -> Vec<f64>,
) -> FitResult<Start> {
    let n = samples.len() / (3 * f);
    let mut start = Start {
        place: Vec::with_capacity(components),
        components: vec![vec![0.0; 3 * n]; components],
        weights: vec![0.0; f * components],
    };
    let mut left = samples.to_vec();
    let mut total = 0.0;
    for k in 0..components {
        let motion: Vec<f64> = left
            .par_chunks_exact(3 * f)
            .map(|vertex| vertex.iter().map(|x| x * x).sum())
            .collect();
        let centre = (0..n)
            .max_by(|&a, &b| motion[a].total_cmp(&motion[b]).then(b.cmp(&a)))
            .unwrap_or(0);
        total = f64::max(total, motion[centre]);
        if motion[centre] <= NOTHING * total {
            return Err(FitError::Input(format!(
                "nothing is left of the faces after {k} of {components} components"
            )));
        }
        let vertex = &left[3 * f * centre..3 * f * (centre + 1)];
        let axis = |a: usize| &vertex[a * f..(a + 1) * f];
        let covariance =
            Matrix3::from_fn(|a, b| axis(a).iter().zip(axis(b)).map(|(x, y)| x * y).sum::<f64>());
        let eigen = covariance.symmetric_eigen();
        let direction = eigen
            .eigenvectors
            .column(eigen.eigenvalues.imax())
            .into_owned();
        let weights = &mut start.weights[k * f..(k + 1) * f];
        for (face, w) in weights.iter_mut().enumerate() {
            *w = (0..3).map(|a| direction[a] * axis(a)[face]).sum();
        }
        let largest = weights.iter().fold(0.0_f64, |m, w| m.max(w.abs()));
        weights.iter_mut().for_each(|w| *w /= largest);
        let map = support(centre);
        let total = square(weights);
        let each = left.par_chunks_exact_mut(f).zip(&mut start.components[k]);
        each.enumerate().for_each(|(column, (x, c))| {
            *c = take_off(x, weights, total, 1.0 - map[column / 3]);
        });
        start.place.push(centre);
    }
    Ok(start)
}

fn square(weights: &[f64]) -> f64 {
    weights.iter().map(|w| w * w).sum()
}

/// What weights, whose squares sum to `square`, make of what is left of a coordinate, faded, and
/// taken off it.
fn take_off(left: &mut [f64], weights: &[f64], square: f64, fade: f64) -> f64 {
    if fade <= 0.0 {
        return 0.0;
    }
    let along: f64 = left.iter().zip(weights).map(|(x, w)| x * w).sum();
    let c = along / square * fade;
    left.iter_mut().zip(weights).for_each(|(x, w)| *x -= c * w);
    c
}
