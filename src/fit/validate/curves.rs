//! Reconstruction error against the number of coefficients, on the faces a basis was learned from
//! and on others (semantic reshaping, Figs. 5 and 6).

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use serde::Serialize;

use super::areas::Areas;
use super::held_out::{less, whole_faces};
use super::wide;
use crate::fit::FitResult;
use crate::fit::head::template::Template;
use crate::fit::learn::persons::{Persons, shuffled};
use crate::fit::learn::{Learner, Settings};
use crate::fit::statistics::gram::inner;
use crate::fit::statistics::subspace::Subspace;

/// Errors of one basis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Curve {
    /// What the basis is.
    pub basis: String,
    /// By increasing number of coefficients.
    pub points: Vec<Point>,
}

/// Mean distances between corresponding vertices, mm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Point {
    /// How many coefficients the basis has.
    pub coefficients: usize,
    /// On the features of the faces it was learned from.
    pub training: f64,
    /// On the features of others.
    pub test: f64,
    /// On all skin of the others.
    pub test_skin: f64,
}

/// The curves of one split.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Curves {
    /// Faces that bases were learned from.
    pub training: usize,
    /// Other faces.
    pub test: usize,
    /// One a basis.
    pub curves: Vec<Curve>,
}

/// The parts of the variance a block for which region PCA is tried: some give few coefficients,
/// some nearly all there are.
const TAUS: [f64; 10] = [0.3, 0.5, 0.65, 0.75, 0.83, 0.9, 0.94, 0.97, 0.985, 0.995];

/// The name of the blocks of region PCA.
pub const REGIONS: &str = "region PCA, blended";
/// The name of the PCA of whole faces.
pub const WHOLE: &str = "whole-face PCA";

/// Learns from the faces of `training` people, drawn at random, and tries those of `test` others: one scan of each.
///
/// # Errors
/// As [`Learner::new`].
pub fn curves(
    template: &Template,
    faces: &[Vec<Vec3>],
    persons: &Persons,
    [training, test]: [usize; 2],
    seed: u64,
    settings: &Settings,
) -> FitResult<Curves> {
    let areas = Areas::new(template)?;
    let each = persons.one_each();
    let order = shuffled(each.len(), seed).into_iter();
    let order: Vec<usize> = order.map(|person| each[person]).collect();
    let (learned, rest) = order.split_at(training.min(order.len()));
    let rest = &rest[..test.min(rest.len())];
    let learned = wide(learned.iter().map(|&i| &faces[i]));
    let each = Persons::each(learned.len());
    let learner = Learner::new(template, learned, &each, settings)?;
    let of_training: Vec<Vec<DVec3>> = (learner.aligned.iter())
        .map(|face| less(face, &learner.mean))
        .collect();
    let of_test: Vec<Vec<DVec3>> = wide(rest.iter().map(|&i| &faces[i]))
        .iter()
        .map(|face| less(&learner.align(face), &learner.mean))
        .collect();

    let mut regions = Vec::new();
    for tau in TAUS {
        let bases = learner.bases(tau)?;
        let subspace = Subspace::new(&bases.modes, &areas.skin)?;
        let left = |fields: &[Vec<DVec3>]| -> Vec<[f64; 2]> {
            (subspace.fields(&subspace.coefficients(fields)).par_iter())
                .zip(fields)
                .map(|(back, field)| means(&less(field, back), &areas))
                .collect()
        };
        regions.push(point(
            bases.modes.len(),
            &left(&of_training),
            &left(&of_test),
        ));
    }

    let mirror = settings.both_sides.then_some(template);
    let spectrum = whole_faces(learner.aligned, &learner.mean, &areas.skin, mirror)?;
    let pca = spectrum.truncate(spectrum.eigenvalues.len());
    let steps: Vec<usize> = (1..=pca.modes.len())
        .filter(|k| k % 5 == 0 || *k == pca.modes.len())
        .collect();
    // By step, then by face.
    let left = |fields: &[Vec<DVec3>]| -> Vec<Vec<[f64; 2]>> {
        let mut rows: Vec<Vec<f64>> = (fields.par_iter())
            .map(|field| {
                let x = (areas.skin.iter()).flat_map(|&v| field[v as usize].to_array());
                x.zip(&spectrum.mean).map(|(x, m)| x - m).collect()
            })
            .collect();
        let amounts = inner(&pca.modes, &rows);
        let mut first = 0;
        let mut found = Vec::new();
        for &k in &steps {
            let measured = rows.par_iter_mut().enumerate().map(|(f, x)| {
                for (mode, i) in pca.modes[first..k].iter().zip(first..) {
                    let c = amounts[(i, f)];
                    x.iter_mut().zip(mode).for_each(|(x, m)| *x -= c * m);
                }
                let mut whole = vec![DVec3::ZERO; fields[f].len()];
                for (&v, d) in areas.skin.iter().zip(x.chunks_exact(3)) {
                    whole[v as usize] = DVec3::from_slice(d);
                }
                means(&whole, &areas)
            });
            found.push(measured.collect());
            first = k;
        }
        found
    };
    let (training, test) = (left(&of_training), left(&of_test));
    let whole = (steps.iter().zip(training.iter().zip(&test)))
        .map(|(&k, (training, test))| point(k, training, test))
        .collect();
    Ok(Curves {
        training: of_training.len(),
        test: of_test.len(),
        curves: vec![
            Curve {
                basis: WHOLE.into(),
                points: whole,
            },
            Curve {
                basis: REGIONS.into(),
                points: regions,
            },
        ],
    })
}

/// The mean length of what is left, over the features and over all skin, mm.
fn means(left: &[DVec3], areas: &Areas) -> [f64; 2] {
    let mean = |vertices: &[u32]| {
        let sum: f64 = vertices.iter().map(|&v| left[v as usize].length()).sum();
        sum / vertices.len().max(1) as f64
    };
    let features = areas.vertices.last().map_or(&[][..], |v| v);
    [mean(features), mean(&areas.skin)]
}

fn point(coefficients: usize, training: &[[f64; 2]], test: &[[f64; 2]]) -> Point {
    let mean = |faces: &[[f64; 2]], of: usize| {
        faces.iter().map(|face| face[of]).sum::<f64>() / faces.len().max(1) as f64
    };
    Point {
        coefficients,
        training: mean(training, 0),
        test: mean(test, 0),
        test_skin: mean(test, 1),
    }
}
