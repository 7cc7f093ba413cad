//! What a basis is worth on faces that it has not seen (semantic reshaping, section 5.1, Figs. 5
//! and 6), beside other bases with as many components.

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use super::{Kind, Settings, SparseBasis, face_parts, learn, principal};
use crate::Random;
use crate::fit::head::template::Template;
use crate::fit::mesh::align::{Rigid, procrustes, vertex_areas};
use crate::fit::mesh::mirror::with_mirror_images;
use crate::fit::{FitError, FitResult};

/// How the comparison is made.
#[derive(Debug, Clone)]
pub struct Trial {
    /// How many faces each basis learns from.
    pub train: usize,
    /// How many other faces each is tested on.
    pub test: usize,
    /// The seed of the split into the two.
    pub seed: u64,
    /// The numbers of components that are tried.
    pub components: Vec<usize>,
}

/// The bases that are compared.
pub const BASES: [&str; 5] = [
    "PCA",
    "PCA, mirrored",
    "regions, one-sided",
    "regions",
    "distance",
];

/// Errors of one basis by number of components.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Curve {
    /// One of [`BASES`].
    pub basis: &'static str,
    /// Numbers of components.
    pub components: Vec<usize>,
    /// The mean distance between a training face's vertices and their reconstructions, mm.
    pub train: Vec<f64>,
    /// The same of faces that were not learned from.
    pub test: Vec<f64>,
    /// Whether each optimisation converged.
    pub converged: Vec<bool>,
}

/// The mean distance of a basis' vertices in faces from their plain least-squares reconstructions,
/// mm. The faces are in the pose of the basis' mean.
///
/// # Errors
/// When a face lacks vertices of the basis, or the basis is none.
pub fn error(basis: &SparseBasis, faces: &[Vec<DVec3>]) -> FitResult<f64> {
    let projection = basis.projection(0.0)?;
    let sums: Vec<f64> = faces
        .par_iter()
        .map(|face| {
            let there = basis.reconstruct(&projection.weights(face)?);
            let lengths = basis.vertices.iter().zip(there);
            Ok(lengths.map(|(&v, p)| p.distance(face[v as usize])).sum())
        })
        .collect::<FitResult<_>>()?;
    Ok(sums.iter().sum::<f64>() / (faces.len() * basis.vertices.len()) as f64)
}

/// Learns every basis of [`BASES`] with every number of components from the same faces and
/// measures each on the others. `faces` are registered faces in any pose, mm, each of another person, so that nobody is
/// among both; `settings` are those of the sparse bases but for the number of components and the kind; `done` is told
/// of each basis that was learned.
///
/// What is measured is the skin of the five parts of the face ([`face_parts`]); training faces are
/// aligned to each other on it, test faces each to the training faces' mean. PCA stops at one
/// component less than there are training faces; from there on its curve is level. The curve "PCA,
/// mirrored" learns from as many mirror images besides, as the sparse bases do but for the
/// one-sided one.
///
/// # Errors
/// When there are too few faces for the split, or a basis cannot be learned.
pub fn compare(
    template: &Template,
    faces: &[Vec<DVec3>],
    trial: &Trial,
    settings: &Settings,
    kinds: [Kind; 2],
    done: impl Fn(),
) -> FitResult<Vec<Curve>> {
    if trial.train.saturating_add(trial.test) > faces.len() || trial.test < 1 {
        return Err(FitError::Input(format!(
            "{} faces are too few to learn from {} and to test on {} others",
            faces.len(),
            trial.train,
            trial.test
        )));
    }
    let mut order: Vec<usize> = (0..faces.len()).collect();
    let mut random = Random::new(trial.seed);
    // Fisher and Yates.
    for i in (1..order.len()).rev() {
        order.swap(i, (random.uniform() * (i + 1) as f64) as usize);
    }
    let take = |numbers: &[usize]| -> Vec<Vec<DVec3>> {
        numbers.iter().map(|&i| faces[i].clone()).collect()
    };
    let plain = take(&order[..trial.train]);
    let test = take(&order[trial.train..trial.train + trial.test]);
    let mirrored = with_mirror_images(&plain, &template.topology.mirror);

    let parts = face_parts(template)?;
    let triangles = template.triangles();
    let areas = vertex_areas(&template.positions, &triangles);
    let mut skin: Vec<u32> = parts.iter().flat_map(|p| &p.vertices).copied().collect();
    skin.sort_unstable();
    let aligned = |mut train: Vec<Vec<DVec3>>| {
        let mean = procrustes(&mut train, &template.positions, &skin, &areas, None);
        let mut test = test.clone();
        test.par_iter_mut().for_each(|face| {
            let motion = Rigid::fit(face, &mean, &skin, &areas);
            face.iter_mut().for_each(|p| *p = motion.apply(*p));
        });
        (train, test)
    };
    let sets = [aligned(plain), aligned(mirrored)];
    let sparse = |name: &'static str, set: usize, kind: Kind| -> FitResult<Curve> {
        let (train, test) = &sets[set];
        let mut curve = Curve::new(name);
        for &components in &trial.components {
            let own = Settings {
                components,
                kind,
                ..*settings
            };
            let (basis, report) = learn(train, &triangles, &parts, &own, |_, _| {})?;
            let seen = &train[..trial.train];
            curve.push(components, &basis, seen, test, report.converged)?;
            done();
        }
        Ok(curve)
    };
    let whole = |name: &'static str, set: usize| -> FitResult<Curve> {
        let (train, test) = &sets[set];
        let most = trial.components.iter().copied().max().unwrap_or(1);
        let full = principal(train, &parts, most.min(train.len() - 1))?;
        let mut curve = Curve::new(name);
        for &components in &trial.components {
            let mut basis = full.clone();
            basis.components.truncate(components);
            basis.sigmas.truncate(components);
            let seen = &train[..trial.train];
            curve.push(components, &basis, seen, test, true)?;
            done();
        }
        Ok(curve)
    };
    Ok(vec![
        whole(BASES[0], 0)?,
        whole(BASES[1], 1)?,
        sparse(BASES[2], 0, kinds[0])?,
        sparse(BASES[3], 1, kinds[0])?,
        sparse(BASES[4], 1, kinds[1])?,
    ])
}

impl Curve {
    fn new(basis: &'static str) -> Self {
        Self {
            basis,
            components: Vec::new(),
            train: Vec::new(),
            test: Vec::new(),
            converged: Vec::new(),
        }
    }

    fn push(
        &mut self,
        components: usize,
        basis: &SparseBasis,
        train: &[Vec<DVec3>],
        test: &[Vec<DVec3>],
        converged: bool,
    ) -> FitResult<()> {
        self.components.push(components);
        self.train.push(error(basis, train)?);
        self.test.push(error(basis, test)?);
        self.converged.push(converged);
        Ok(())
    }
}
