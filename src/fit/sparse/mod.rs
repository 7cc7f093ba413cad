//! A sparse, local basis of faces: the sparse localized deformation components of Neumann et al.
//! (2013), limited to the parts of a face as in semantic reshaping, section 3.2.
//!
//! Faces are rows of X (F x 3n: n vertices, displacements from the mean in mm), components are
//! rows of C (K x 3n, mm for a weight of 1), and weights W (F x K) say how much of which component
//! a face has:
//!
//! ```text
//! minimise  ||X - W C||^2 + sum_k sum_i lambda_ki |c_k^(i)|   with  max_f |W_fk| = 1
//! ```
//!
//! where `c_k^(i)` is the displacement of vertex i by component k (semantic reshaping, eq. 3; in
//! Neumann et al. the squares are halved). Weights have a sign. The length of a vertex's
//! displacement is penalised as a whole, so vertices leave a component one by one. Semantic
//! reshaping says that lambda is one inside a component's region and zero elsewhere; with a penalty
//! that is backwards, so here it is small inside and high outside.
//!
//! [`Kind::Regions`] (the default) gives each component a part of the face and a band around it;
//! [`Kind::Distance`] is Neumann et al.'s own rule, by the distance from the component's centre,
//! wherever that is. Components and weights are improved in turn ([`learn`]) until the objective
//! stands still; [`compare`](mod@compare) measures what a basis is worth on faces that it has not
//! seen.

mod admm;
pub mod compare;
mod start;
mod support;
mod weights;

use std::borrow::Cow;
use std::collections::BTreeMap;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par, Side};
use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

pub use support::{Region, face_parts, head_parts};

use crate::fit::error::faces_are;
use crate::fit::mesh::geodesic::Geodesic;
use crate::fit::statistics::pca::Pca;
use crate::fit::{FitError, FitResult};
use admm::{Blocks, Effort};
use start::Start;

/// Where the components of a basis may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// Each in one of the regions and a band around it (semantic reshaping, section 3.2). The
    /// regions share the components by how much each explains.
    Regions {
        /// The width of the band, mm along the surface. Beyond it a component is exactly zero.
        band: f64,
        /// The penalty inside the region, mm a face: a displacement at weight 1 that no more than
        /// this is gained by is none.
        inside: f64,
        /// The penalty at the end of the band, mm a face.
        outside: f64,
    },
    /// Each around a centre (Neumann et al. 2013, eq. 6): the vertex that it moves most, found
    /// again at each iteration.
    Distance {
        /// Within this distance of the centre nothing is penalised, mm along the surface.
        near: f64,
        /// From this distance on the penalty is full.
        far: f64,
        /// The full penalty, mm a face.
        penalty: f64,
    },
}

impl Kind {
    /// Regions with bands of 18 mm, in which a component fades out like the features of a
    /// model do.
    pub const REGIONS: Self = Kind::Regions {
        band: 18.0,
        inside: 1e-3,
        outside: 0.3,
    };
    /// Supports as large as the parts of a face.
    pub const DISTANCE: Self = Kind::Distance {
        near: 15.0,
        far: 45.0,
        penalty: 0.1,
    };
}

/// How a basis is learned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// How many components there are: K.
    pub components: usize,
    /// Where they may be.
    pub kind: Kind,
    /// Outer iterations at most.
    pub iterations: usize,
    /// The iterations stop when the objective changed by less than this part over
    /// [`Settings::window`] of them and the components' own residual is below
    /// [`Settings::residual`].
    pub tolerance: f64,
    /// Iterations over which the objective has to stand still.
    pub window: usize,
    /// Steps of ADMM an outer iteration, at most.
    pub steps: usize,
    /// Primal and dual residual of ADMM below which it is done, relative to the components.
    pub residual: f64,
    /// Sweeps over the weights an outer iteration.
    pub sweeps: usize,
    /// Whether weights are tried that go on beyond where the step led, which near the end is a
    /// slow way in one direction; kept where the objective falls. Only with [`Kind::Regions`].
    pub bold: bool,
}

/// Faces that are looked at together.
const FACES_AT_ONCE: usize = 16;

/// The first bold step, as a part of the plain one that it goes beyond; what it grows by while it
/// pays, and shrinks by when it does not.
const STRIDE: f64 = 1.0;
const GROW: f64 = 1.5;
const SHRINK: f64 = 0.3;
/// Plain iterations before the first bold one: the way is no way yet.
const PLAIN: usize = 3;

impl Default for Settings {
    fn default() -> Self {
        Self {
            components: 65,
            kind: Kind::REGIONS,
            iterations: 200,
            tolerance: 1e-3,
            window: 5,
            steps: 10,
            residual: 1e-3,
            sweeps: 1,
            bold: true,
        }
    }
}

/// A component of a [`SparseBasis`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Component {
    /// The name of its region, or nothing where it is around a centre.
    pub region: Option<String>,
    /// The vertex that it moves most, of the template.
    pub centre: u32,
    /// The vertices that it moves, of the template, increasing.
    pub support: Vec<u32>,
    /// Their displacements at a weight of 1, mm.
    pub displacements: Vec<DVec3>,
}

/// Sparse, local components and what the training faces have of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SparseBasis {
    /// The vertices that are modelled, of the template, increasing.
    pub vertices: Vec<u32>,
    /// Where they are in the mean of the training faces, mm.
    pub mean: Vec<DVec3>,
    /// K components.
    pub components: Vec<Component>,
    /// What each training face has of each component, F rows of K.
    pub weights: Vec<Vec<f64>>,
    /// The standard deviation of each component's weights over the training faces (divisor F - 1).
    pub sigmas: Vec<f64>,
}

/// How the optimisation went.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// The objective at the start and after each outer iteration, mm^2.
    pub objective: Vec<f64>,
    /// The residual of the last ADMM, relative to the components.
    pub residual: f64,
    /// Whether the objective stood still before the limit was reached. A basis of which this is
    /// not so is as good as its objective, but could be better.
    pub converged: bool,
    /// How long the start took, and the iterations, seconds: no part of what is written, which is the same of each run.
    #[serde(skip)]
    pub seconds: [f64; 2],
}

/// What is optimised, in numbers: for other programs that shall do the same (`tests/peers`).
/// Vertices are in the order of [`Problem::vertices`].
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// The vertices, of the template.
    pub vertices: Vec<u32>,
    /// X, F rows of 3n, mm.
    pub samples: Vec<Vec<f64>>,
    /// lambda at the start, K rows of n, mm^2 a mm; infinite where a component cannot be.
    pub lambda: Vec<Vec<f64>>,
    /// The components to begin with, K rows of 3n, mm.
    pub components: Vec<Vec<f64>>,
    /// The weights to begin with, F rows of K.
    pub weights: Vec<Vec<f64>>,
}

/// Learns a basis of faces that are rigidly aligned (mm, all of one topology with `triangles`).
///
/// The vertices of all regions together are modelled, and what else the faces have is left out.
/// With [`Kind::Distance`] only that union counts. Distances are measured on the mean face along
/// all triangles. `progress` is told the number of each outer iteration and the objective after
/// it, from 0, the start.
///
/// An iteration improves the weights, then the components; neither step raises the objective, but
/// [`Kind::Distance`] moves the supports between them. The result does not depend on how many
/// threads there are.
///
/// # Errors
/// With fewer than 3 faces or faces that do not fit the triangles, regions that are empty or
/// overlap, a setting out of its range, or more components than the faces vary in.
pub fn learn(
    faces: &[Vec<DVec3>],
    triangles: &[[u32; 3]],
    regions: &[Region],
    settings: &Settings,
    progress: impl FnMut(usize, f64),
) -> FitResult<(SparseBasis, Report)> {
    let face = |i: usize| Cow::Borrowed(&faces[i][..]);
    Learner::new(faces.len(), face, triangles, regions, settings)?.run(progress)
}

/// As [`learn`], of faces that are asked for one at a time, each more than once: all of them at once
/// may be more memory than what is learned.
pub(super) fn learn_from(
    faces: usize,
    face: impl Fn(usize) -> Vec<DVec3> + Sync,
    triangles: &[[u32; 3]],
    regions: &[Region],
    settings: &Settings,
) -> FitResult<SparseBasis> {
    let face = |i: usize| Cow::Owned(face(i));
    let learner = Learner::new(faces, face, triangles, regions, settings)?;
    Ok(learner.run(|_, _| ())?.0)
}

/// The problem that [`learn`] solves, as it is at the start.
///
/// # Errors
/// As [`learn`].
pub fn problem(
    faces: &[Vec<DVec3>],
    triangles: &[[u32; 3]],
    regions: &[Region],
    settings: &Settings,
) -> FitResult<Problem> {
    let face = |i: usize| Cow::Borrowed(&faces[i][..]);
    Ok(Learner::new(faces.len(), face, triangles, regions, settings)?.problem())
}

/// Principal components of the same vertices in the same form, to compare with: each moves
/// everything. At most one less than there are faces.
///
/// # Errors
/// With fewer than 3 faces, faces without the regions' vertices, or more components than the faces
/// vary in.
pub fn principal(
    faces: &[Vec<DVec3>],
    regions: &[Region],
    components: usize,
) -> FitResult<SparseBasis> {
    let settings = Settings {
        components,
        ..Settings::default()
    };
    let face = |i: usize| Cow::Borrowed(&faces[i][..]);
    check(faces.len(), &face, &[], regions, &settings)?;
    let mut vertices: Vec<u32> = regions.iter().flat_map(|r| &r.vertices).copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    let mean = crate::fit::mesh::align::mean_of(faces);
    let samples: Vec<Vec<f64>> = faces
        .iter()
        .map(|face| {
            let moved = vertices
                .iter()
                .map(|&v| face[v as usize] - mean[v as usize]);
            moved.flat_map(|d| d.to_array()).collect()
        })
        .collect();
    let pca = Pca::learn(samples, 1.0)?;
    if components > pca.modes.len() {
        return Err(FitError::Input(format!(
            "{components} components are more than the {} ways in which the faces vary",
            pca.modes.len()
        )));
    }
    let mut basis = SparseBasis {
        mean: vertices.iter().map(|&v| mean[v as usize]).collect(),
        components: Vec::with_capacity(components),
        weights: vec![Vec::with_capacity(components); faces.len()],
        sigmas: Vec::with_capacity(components),
        vertices,
    };
    for (k, (mode, sigma)) in pca
        .modes
        .iter()
        .zip(&pca.sigmas)
        .take(components)
        .enumerate()
    {
        let column = || pca.coefficients.iter().map(|row| row[k]);
        let largest = column().fold(0.0_f64, |m, c| m.max(c.abs()));
        basis.components.push(Component {
            region: None,
            centre: basis.vertices[centre(mode)],
            support: basis.vertices.clone(),
            displacements: mode
                .chunks_exact(3)
                .map(|d| DVec3::from_slice(d) * sigma * largest)
                .collect(),
        });
        for (row, c) in basis.weights.iter_mut().zip(column()) {
            row.push(c / largest);
        }
        // Coefficients of a PCA are in sigmas.
        basis.sigmas.push(1.0 / largest);
    }
    Ok(basis)
}

struct Learner<'a> {
    settings: Settings,
    regions: &'a [Region],
    triangles: &'a [[u32; 3]],
    /// The mean of all vertices of the faces.
    mean: Vec<DVec3>,
    f: usize,
    /// The modelled vertices, those that the same regions reach next to each other.
    order: Vec<u32>,
    /// F x 3n, column-major, vertices by `order`.
    samples: Vec<f64>,
    /// How far each region's components reach, or nothing for [`Kind::Distance`].
    ramps: Vec<Vec<f64>>,
    start: Start,
    seconds: f64,
}

impl<'a> Learner<'a> {
    fn new<'f>(
        f: usize,
        face: impl Fn(usize) -> Cow<'f, [DVec3]> + Sync,
        triangles: &'a [[u32; 3]],
        regions: &'a [Region],
        settings: &Settings,
    ) -> FitResult<Self> {
        let began = std::time::Instant::now();
        check(f, &face, triangles, regions, settings)?;
        let n = face(0).len();
        let mut mean = vec![DVec3::ZERO; n];
        for i in 0..f {
            let positions = face(i);
            let each = mean.iter_mut().zip(positions.iter());
            each.for_each(|(sum, p)| *sum += *p);
        }
        mean.iter_mut().for_each(|sum| *sum /= f as f64);
        let mut order: Vec<u32> = regions.iter().flat_map(|r| &r.vertices).copied().collect();
        order.sort_unstable();
        if order.windows(2).any(|w| w[0] == w[1]) {
            return Err(FitError::Input("a vertex is in two regions".into()));
        }
        debug_assert!(order.iter().all(|&v| (v as usize) < n));
        let mut ramps = Vec::new();
        if let Kind::Regions { band, .. } = settings.kind {
            ramps = support::ramps(&mean, triangles, &order, regions, band);
            let reached =
                |i: usize| -> Vec<bool> { ramps.iter().map(|ramp| ramp[i].is_finite()).collect() };
            let mut by_reach: Vec<(Vec<bool>, usize)> =
                (0..order.len()).map(|i| (reached(i), i)).collect();
            by_reach.sort();
            let sorted = |list: &[f64]| by_reach.iter().map(|&(_, i)| list[i]).collect();
            ramps = ramps.iter().map(|ramp| sorted(ramp)).collect();
            order = by_reach.iter().map(|&(_, i)| order[i]).collect();
        }
        let mut samples = vec![0.0; 3 * f * order.len()];
        // A few at a time, so that a vertex's samples are written in runs.
        for first in (0..f).step_by(FACES_AT_ONCE) {
            let some: Vec<Cow<[DVec3]>> = (first..(first + FACES_AT_ONCE).min(f))
                .into_par_iter()
                .map(&face)
                .collect();
            samples
                .par_chunks_exact_mut(3 * f)
                .zip(&order)
                .for_each(|(columns, &v)| {
                    for (i, positions) in some.iter().enumerate() {
                        let d = positions[v as usize] - mean[v as usize];
                        (0..3).for_each(|axis| columns[axis * f + first + i] = d[axis]);
                    }
                });
        }
        drop(face);
        let square: f64 = samples.iter().map(|x| x * x).sum();
        // A nanometre of standard deviation over the whole field is no variation.
        if !(square > 1e-12) {
            return Err(FitError::Input("the faces do not vary here".into()));
        }
        let start = match settings.kind {
            Kind::Regions { .. } => start::by_regions(&samples, f, &ramps, settings.components)?,
            Kind::Distance { near, far, .. } => {
                let surface = Geodesic::new(&mean, triangles);
                start::by_distance(&samples, f, settings.components, |centre| {
                    support::distance_map(&surface, &order, order[centre], [near, far])
                })?
            }
        };
        Ok(Self {
            settings: *settings,
            regions,
            triangles,
            mean,
            f,
            order,
            samples,
            ramps,
            start,
            seconds: began.elapsed().as_secs_f64(),
        })
    }

    /// lambda of component k at a vertex, by its place in `order`; `maps` are those of
    /// [`Kind::Distance`].
    fn lambda(&self, maps: &[Vec<f64>], k: usize, i: usize) -> f64 {
        self.f as f64
            * match self.settings.kind {
                Kind::Regions {
                    inside, outside, ..
                } => inside + (outside - inside) * self.ramps[self.start.place[k]][i],
                Kind::Distance { penalty, .. } => penalty * maps[k][i],
            }
    }

    fn problem(&self) -> Problem {
        let (n, k) = (self.order.len(), self.settings.components);
        let mut maps = Maps::default();
        maps.find(self, &self.start.place);
        let mut by_vertex: Vec<usize> = (0..n).collect();
        by_vertex.sort_by_key(|&i| self.order[i]);
        Problem {
            vertices: by_vertex.iter().map(|&i| self.order[i]).collect(),
            samples: (0..self.f)
                .map(|face| {
                    let columns = by_vertex.iter().flat_map(|&i| 3 * i..3 * i + 3);
                    columns.map(|c| self.samples[c * self.f + face]).collect()
                })
                .collect(),
            lambda: (0..k)
                .map(|k| {
                    let at = |&i: &usize| self.lambda(&maps.now, k, i);
                    by_vertex.iter().map(at).collect()
                })
                .collect(),
            components: self
                .start
                .components
                .iter()
                .map(|row| {
                    let columns = by_vertex.iter().flat_map(|&i| 3 * i..3 * i + 3);
                    columns.map(|c| row[c]).collect()
                })
                .collect(),
            weights: rows(&self.start.weights, self.f),
        }
    }

    fn run(mut self, mut progress: impl FnMut(usize, f64)) -> FitResult<(SparseBasis, Report)> {
        let began = std::time::Instant::now();
        let (n, f, settings) = (self.order.len(), self.f, self.settings);
        let reached: Vec<Vec<usize>> = (0..n)
            .map(|i| {
                (0..settings.components)
                    .filter(|&k| {
                        let ramp = self.ramps.get(self.start.place[k]);
                        ramp.is_none_or(|ramp| ramp[i].is_finite())
                    })
                    .collect()
            })
            .collect();
        let mut weights = std::mem::take(&mut self.start.weights);
        let samples = std::mem::take(&mut self.samples);
        let mut blocks = Blocks::new(f, samples, &reached, &self.start.components);
        let square = blocks.square();
        let mut maps = Maps::default();
        maps.find(&self, &self.start.place);
        blocks.penalise(|k, i| self.lambda(&maps.now, k, i));
        let none = Effort {
            steps: 0,
            tolerance: 0.0,
        };
        let full = Effort {
            steps: settings.steps,
            tolerance: settings.residual,
        };
        let mut passed = blocks.pass(&weights, none)?;
        let mut stride = STRIDE;
        let mut report = Report {
            objective: vec![passed.moments.objective(square, &weights)],
            residual: f64::INFINITY,
            converged: false,
            seconds: [self.seconds, 0.0],
        };
        progress(0, report.objective[0]);
        for iteration in 1..=settings.iterations {
            let former = weights.clone();
            let stretched = weights::update(&mut weights, &mut passed.moments, settings.sweeps);
            if matches!(settings.kind, Kind::Distance { .. }) {
                let centres: Vec<usize> = blocks.components().iter().map(|c| centre(c)).collect();
                maps.find(&self, &centres);
                blocks.penalise(|k, i| self.lambda(&maps.now, k, i));
            }
            blocks.stretch(&stretched);
            // A bold step: farther along the way that the weights took. Where it does not pay, the
            // plain one is taken after all.
            let last = report.objective[report.objective.len() - 1];
            let mut objective = f64::INFINITY;
            let bold = settings.bold
                && iteration > PLAIN
                && !matches!(settings.kind, Kind::Distance { .. });
            if bold {
                let kept = blocks.state();
                let farther = weights::farther(&weights, &former, f, stride);
                passed = blocks.pass(&farther, full)?;
                objective = passed.moments.objective(square, &farther);
                if objective < last {
                    weights = farther;
                    stride *= GROW;
                } else {
                    blocks.restore(kept);
                    stride *= SHRINK;
                }
            }
            if !(objective < last) {
                passed = blocks.pass(&weights, full)?;
                objective = passed.moments.objective(square, &weights);
            }
            report.residual = passed.residual;
            report.objective.push(objective);
            progress(iteration, objective);
            let earlier = report.objective[(iteration).saturating_sub(settings.window)];
            if iteration >= settings.window
                && (earlier - objective).abs() <= settings.tolerance * earlier.abs()
                && report.residual <= settings.residual
            {
                report.converged = true;
                break;
            }
        }
        report.seconds[1] = began.elapsed().as_secs_f64();
        Ok((self.basis(&blocks.components(), &weights), report))
    }

    fn basis(&self, components: &[Vec<f64>], weights: &[f64]) -> SparseBasis {
        let mut weights = rows(weights, self.f);
        let mut by_vertex: Vec<usize> = (0..self.order.len()).collect();
        by_vertex.sort_by_key(|&i| self.order[i]);
        let components = components
            .iter()
            .enumerate()
            .map(|(k, values)| {
                // The sign that makes the component's largest number positive.
                let largest = values
                    .iter()
                    .fold(0.0_f64, |m, &v| if v.abs() > m.abs() { v } else { m });
                let sign = if largest < 0.0 { -1.0 } else { 1.0 };
                weights.iter_mut().for_each(|row| row[k] *= sign);
                let moved = by_vertex.iter().filter_map(|&i| {
                    let d = DVec3::from_slice(&values[3 * i..3 * i + 3]);
                    (d != DVec3::ZERO).then(|| (self.order[i], sign * d))
                });
                let (support, displacements) = moved.unzip();
                Component {
                    region: self
                        .ramps
                        .get(self.start.place[k])
                        .map(|_| self.regions[self.start.place[k]].name.clone()),
                    centre: self.order[centre(values)],
                    support,
                    displacements,
                }
            })
            .collect();
        let sigmas = (0..self.settings.components)
            .map(|k| {
                let mean = weights.iter().map(|row| row[k]).sum::<f64>() / self.f as f64;
                let square: f64 = weights.iter().map(|row| (row[k] - mean).powi(2)).sum();
                (square / (self.f - 1) as f64).sqrt()
            })
            .collect();
        let vertices: Vec<u32> = by_vertex.iter().map(|&i| self.order[i]).collect();
        SparseBasis {
            mean: vertices.iter().map(|&v| self.mean[v as usize]).collect(),
            vertices,
            components,
            weights,
            sigmas,
        }
    }
}

/// The support maps of [`Kind::Distance`], those once found kept: centres seldom move.
#[derive(Default)]
struct Maps {
    found: BTreeMap<usize, Vec<f64>>,
    now: Vec<Vec<f64>>,
}

impl Maps {
    fn find(&mut self, learner: &Learner<'_>, centres: &[usize]) {
        let Kind::Distance { near, far, .. } = learner.settings.kind else {
            return;
        };
        let missing: Vec<usize> = centres
            .iter()
            .copied()
            .filter(|c| !self.found.contains_key(c))
            .collect();
        let surface = Geodesic::new(&learner.mean, learner.triangles);
        let maps: Vec<Vec<f64>> = missing
            .par_iter()
            .map(|&c| {
                support::distance_map(&surface, &learner.order, learner.order[c], [near, far])
            })
            .collect();
        self.found.extend(missing.into_iter().zip(maps));
        self.now = centres.iter().map(|c| self.found[c].clone()).collect();
    }
}

/// The place of the vertex that a component moves most.
fn centre(component: &[f64]) -> usize {
    let lengths = component
        .chunks_exact(3)
        .map(|d| d.iter().map(|x| x * x).sum::<f64>());
    let mut best = (0, -1.0);
    for (i, length) in lengths.enumerate() {
        if length > best.1 {
            best = (i, length);
        }
    }
    best.0
}

/// The rows of a column-major matrix with `f` rows.
fn rows(matrix: &[f64], f: usize) -> Vec<Vec<f64>> {
    (0..f)
        .map(|row| matrix.iter().skip(row).step_by(f).copied().collect())
        .collect()
}

/// Refuses what cannot be learned from.
fn check<'f>(
    faces: usize,
    face: &impl Fn(usize) -> Cow<'f, [DVec3]>,
    triangles: &[[u32; 3]],
    regions: &[Region],
    settings: &Settings,
) -> FitResult<()> {
    let refuse = |cause: String| Err(FitError::Input(cause));
    if faces < 3 {
        return refuse(format!(
            "{} too few to learn from; 3 is the least",
            faces_are(faces)
        ));
    }
    let n = face(0).len();
    for i in 0..faces {
        let each = face(i);
        if each.len() != n {
            let found = each.len();
            return refuse(format!("face {i} has {found} vertices, the first {n}"));
        }
        if each.iter().any(|p| !p.is_finite()) {
            return refuse(format!("face {i} has a vertex that is nowhere"));
        }
    }
    if triangles.as_flattened().iter().any(|&v| v as usize >= n) {
        return refuse(format!(
            "the faces have {n} vertices, the triangles have more"
        ));
    }
    if settings.components < 1 {
        return refuse("a basis has at least 1 component, not 0".into());
    }
    if settings.steps < 1 || settings.sweeps < 1 || settings.window < 1 {
        return refuse("steps, sweeps and the window are at least 1".into());
    }
    if regions.is_empty() {
        return refuse("there is no region to learn from".into());
    }
    for region in regions {
        if region.vertices.is_empty() {
            return refuse(format!("region {:?} has no vertices", region.name));
        }
        if region.vertices.iter().any(|&v| v as usize >= n) {
            let name = &region.name;
            return refuse(format!("region {name:?} has vertices that the faces lack"));
        }
    }
    let sound = match settings.kind {
        Kind::Regions {
            band,
            inside,
            outside,
        } => band > 0.0 && inside >= 0.0 && outside >= inside && outside.is_finite(),
        Kind::Distance { near, far, penalty } => {
            near >= 0.0 && far > near && penalty >= 0.0 && penalty.is_finite()
        }
    };
    if !sound {
        return refuse(format!(
            "lengths and penalties are positive and the farther or outer is the larger, not {:?}",
            settings.kind
        ));
    }
    Ok(())
}

impl SparseBasis {
    /// The same basis with weights in sigmas: every component's weights have unit variance over
    /// the training faces, and its displacements are those of one standard deviation. A component
    /// whose weights do not vary stays as it is.
    #[must_use]
    pub fn in_sigmas(mut self) -> Self {
        for (k, sigma) in self.sigmas.iter_mut().enumerate() {
            if *sigma > 0.0 {
                self.weights.iter_mut().for_each(|row| row[k] /= *sigma);
                let moved = &mut self.components[k].displacements;
                moved.iter_mut().for_each(|d| *d *= *sigma);
                *sigma = 1.0;
            }
        }
        self
    }

    /// Where the modelled vertices are for some weights, in the order of
    /// [`SparseBasis::vertices`], mm.
    pub fn reconstruct(&self, weights: &[f64]) -> Vec<DVec3> {
        let mut positions = self.mean.clone();
        for (component, &w) in self.components.iter().zip(weights) {
            let mut at = 0;
            for (v, d) in component.support.iter().zip(&component.displacements) {
                // Both lists increase: each search goes on where the last one ended.
                at += self.vertices[at..].partition_point(|u| u < v);
                positions[at] += w * *d;
            }
        }
        positions
    }

    /// Prepares to find weights of faces. See [`Projection::weights`]. `ridge` is in mm^2: 0 for
    /// plain least squares, else the variance of what the basis cannot say, summed over all
    /// vertices, against which a weight of one sigma is held.
    ///
    /// # Errors
    /// When the ridge is negative or the basis has no soundly formed components.
    pub fn projection(&self, ridge: f64) -> FitResult<Projection<'_>> {
        if !(ridge >= 0.0 && ridge.is_finite()) {
            return Err(FitError::Input(format!(
                "the ridge {ridge} is not positive"
            )));
        }
        let (n, count) = (self.vertices.len(), self.components.len());
        if count == 0 {
            return Err(FitError::Input("a basis without components".into()));
        }
        let mut components = Mat::<f64>::zeros(3 * n, count);
        for (k, component) in self.components.iter().enumerate() {
            for (v, d) in component.support.iter().zip(&component.displacements) {
                let i = self.vertices.partition_point(|u| u < v);
                (0..3).for_each(|axis| components[(3 * i + axis, k)] = d[axis]);
            }
        }
        let mut normal = Mat::<f64>::zeros(count, count);
        let transposed = components.transpose();
        matmul(
            &mut normal,
            Accum::Replace,
            transposed,
            &components,
            1.0,
            Par::Seq,
        );
        for (k, sigma) in self.sigmas.iter().enumerate() {
            if *sigma > 0.0 {
                normal[(k, k)] += ridge / (sigma * sigma);
            }
        }
        let eigen = normal
            .self_adjoint_eigen(Side::Lower)
            .map_err(|e| FitError::Input(format!("the basis is no basis: {e:?}")))?;
        // What components have twice, or not at all, gets the least weights.
        let least = 1e-12 * eigen.S()[count - 1];
        let inverse = |i: usize| match eigen.S()[i] {
            s if s > least => 1.0 / s,
            _ => 0.0,
        };
        let u = eigen.U();
        let scaled = Mat::from_fn(count, count, |i, j| u[(i, j)] * inverse(j));
        let mut solve = Mat::<f64>::zeros(count, count);
        matmul(
            &mut solve,
            Accum::Replace,
            &scaled,
            u.transpose(),
            1.0,
            Par::Seq,
        );
        Ok(Projection {
            basis: self,
            components,
            solve,
        })
    }
}

/// Finds the weights of faces that a basis has not seen.
#[derive(Debug, Clone)]
pub struct Projection<'a> {
    basis: &'a SparseBasis,
    /// 3n x K.
    components: Mat<f64>,
    /// The inverse of the normal matrix, K x K.
    solve: Mat<f64>,
}

impl Projection<'_> {
    /// The weights of a face in the training faces' pose (all vertices of the template, mm): those
    /// that minimise `||x - w C||^2 + ridge sum_k (w_k / sigma_k)^2`.
    ///
    /// # Errors
    /// When the face lacks vertices of the basis.
    pub fn weights(&self, face: &[DVec3]) -> FitResult<Vec<f64>> {
        let vertices = &self.basis.vertices;
        if vertices.last().is_some_and(|&v| v as usize >= face.len()) {
            return Err(FitError::Input(format!(
                "the face has {} vertices, the basis is of more",
                face.len()
            )));
        }
        let x: Vec<f64> = vertices
            .iter()
            .zip(&self.basis.mean)
            .flat_map(|(&v, &m)| (face[v as usize] - m).to_array())
            .collect();
        let x = MatRef::from_column_major_slice(&x, x.len(), 1);
        let right = self.components.transpose() * x;
        let weights = &self.solve * right;
        Ok(weights.col(0).iter().copied().collect())
    }
}
