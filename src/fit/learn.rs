//! From registered faces to a model: align, learn each region, smooth, blend, learn the rest.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::align::{Rigid, procrustes, vertex_areas, without_proportions};
use super::describe::describe;
use super::geodesic::Geodesic;
use super::measures::measures;
use super::pca::Pca;
use super::smooth::{Smoother, Smoothing};
use super::surround::{self, Loose, border, spread};
use super::template::Template;
use super::{FitError, FitResult};
use crate::model::{About, Blending, Block, Control, FALLOFF_REACH, LIMIT, ModelParts};
use crate::quantise::{BLOCK_ERROR, COORDINATES, CORRELATIONS, Quantised};

/// A feature: a block of its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeatureRule {
    /// The block's name.
    pub name: &'static str,
    /// The template regions that it covers.
    pub regions: &'static [&'static str],
    /// Smoothing near the border: a length in mm. Longer is a gentler seam and less shape. The
    /// forehead, on which people differ by hardly a crease, shows seams that a cheek hides.
    pub border: f64,
    /// Smoothing where no border is near, mm. On the chin, a cleft that one mode has to itself
    /// would be a cut; elsewhere it is below the size of a nostril's rim.
    pub inside: f64,
}

/// The features of a model; the head block, which takes what they leave over, comes after them.
pub const FEATURES: [FeatureRule; 5] = [
    FeatureRule {
        name: "eyes",
        regions: &["left eye", "right eye"],
        border: 9.0,
        inside: 0.7,
    },
    FeatureRule {
        name: "nose",
        regions: &["nose"],
        border: 9.0,
        inside: 0.7,
    },
    FeatureRule {
        name: "mouth",
        regions: &["mouth"],
        border: 9.0,
        inside: 0.7,
    },
    FeatureRule {
        name: "chin",
        regions: &["chin"],
        border: 9.0,
        inside: 2.0,
    },
    FeatureRule {
        name: "forehead",
        regions: &["forehead"],
        border: 18.0,
        inside: 0.7,
    },
];
/// The band in which smoothing goes over from border to inside, in lengths of the border's.
const SMOOTHING_BAND: f64 = 1.5;
const HEAD: &str = "head";
/// Percentiles in steps of 1/64: with the 300 faces of a small population finer steps are noise.
const QUANTILES: usize = 65;
/// Neighbouring table entries differ by at least this many sigmas, so that the table can be
/// inverted.
const QUANTILE_GAP: f64 = 1e-4;

/// How a model is learned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// The part of the variance that the modes of each block keep (eq. 6).
    pub tau: f64,
    /// Blending distance and its limits.
    pub blending: Blending,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            tau: 0.95,
            blending: Blending {
                alpha: 10.0,
                limits: [3.0, 15.0],
            },
        }
    }
}

/// A model and how it was learned.
#[derive(Debug, Clone)]
pub struct Learned {
    /// The model.
    pub parts: ModelParts,
    /// A line a block.
    pub blocks: Vec<BlockReport>,
    /// Root mean square distance that alignment left, mm.
    pub alignment: f64,
    /// The training faces in the model's pose, mm.
    pub aligned: Vec<Vec<DVec3>>,
    /// Coefficients of the training faces, sigmas.
    pub coefficients: Vec<Vec<f64>>,
    /// The modes before they were rounded, one a coefficient: displacements of all vertices, those
    /// of the surround at the model's blending distance, mm a sigma.
    pub modes: Vec<Vec<DVec3>>,
}

/// What learning a block came to.
#[derive(Debug, Clone, PartialEq)]
pub struct BlockReport {
    /// The block.
    pub name: String,
    /// Modes kept.
    pub modes: usize,
    /// The part of the variance that they have.
    pub variance: f64,
    /// What smoothing left of the displacement of a random face of the block, 0..=1: at +-3 sigma
    /// of the coefficient the surface moves this part of 3 standard deviations.
    pub kept_by_smoothing: f64,
}

/// Learns a model from faces in the template's topology (mm, any pose).
///
/// Steps: generalised Procrustes alignment of the whole skin; for each feature, of faces from which
/// the proportions of the whole head are taken out, a second rigid alignment on its own region (a
/// nose is not where it sits), PCA, smoothing folded into the modes
/// (section 6.1) and spreading to the surround (6.2); then PCA of what all features together leave
/// of each face, over the whole head. `about` is put into the model as it is.
///
/// # Errors
/// With fewer than 3 faces, faces of another topology, a region that does not vary, or a tau
/// outside (0, 1].
pub fn learn(
    template: &Template,
    faces: Vec<Vec<DVec3>>,
    about: About,
    settings: &Settings,
) -> FitResult<Learned> {
    let n = template.positions.len();
    let tau = settings.tau;
    if !(tau > 0.0 && tau <= 1.0) {
        return Err(FitError::Input(format!(
            "tau must be over 0 and at most 1, not {tau}"
        )));
    }
    if faces.len() < 3 {
        return Err(FitError::Input(format!(
            "{} faces are too few to learn from; 3 is the least",
            faces.len()
        )));
    }
    if let Some(other) = faces.iter().position(|f| f.len() != n) {
        return Err(FitError::Input(format!(
            "face {other} has {} vertices, the template {n}",
            faces[other].len()
        )));
    }
    let triangles = template.triangles();
    let areas = vertex_areas(&template.positions, &triangles);
    let skin = template.part_vertices("skin")?;
    let mut aligned = faces;
    let mean = procrustes(&mut aligned, &template.positions, &skin, &areas);
    // From here on it is the mean that a model file holds: what surrounds follow is found on it.
    let mean: Vec<DVec3> = mean.iter().map(|&p| on_grid(p)).collect();
    let stored: Vec<Vec3> = mean.iter().map(|p| p.as_vec3()).collect();
    let alignment = rms(aligned.iter().flat_map(|face| {
        skin.iter()
            .map(|&v| face[v as usize].distance(mean[v as usize]))
    }));

    let graph = Geodesic::new(&mean, &triangles);
    let loose = loose_parts(template, &mean)?;
    let mut residual: Vec<Vec<f64>> = aligned
        .iter()
        .map(|face| flat(face, &mean, 0..n as u32))
        .collect();
    let mut coefficients: Vec<Vec<f64>> = vec![Vec::new(); aligned.len()];
    // How wide, high and deep a head is belongs to the head block. Left in the features it would
    // make their borders the places where one person's proportions meet the average's.
    let proportioned: Vec<Vec<DVec3>> = aligned
        .par_iter()
        .map(|face| without_proportions(face, &mean, &skin, &areas))
        .collect();
    let mut blocks = Vec::new();
    let mut reports = Vec::new();
    let mut modes = Vec::new();
    for rule in FEATURES {
        let feature = learn_feature(&Feature {
            template,
            rule,
            triangles: &triangles,
            areas: &areas,
            skin: &skin,
            mean: &mean,
            stored: &stored,
            proportioned: &proportioned,
            graph: &graph,
            loose: &loose,
            settings,
        })?;
        residual
            .par_iter_mut()
            .zip(&feature.coefficients)
            .for_each(|(left, row)| {
                for (c, mode) in row.iter().zip(&feature.whole_modes) {
                    for (left, m) in left.chunks_exact_mut(3).zip(mode) {
                        (0..3).for_each(|axis| left[axis] -= c * m[axis]);
                    }
                }
            });
        append(&mut coefficients, &feature.coefficients);
        modes.extend(feature.whole_modes);
        blocks.push(Block {
            first_coefficient: blocks.iter().map(|b: &Block| b.sigmas.len()).sum(),
            ..feature.block
        });
        reports.push(feature.report);
    }

    let head = Pca::learn(&residual, settings.tau)
        .map_err(|e| FitError::Input(format!("block {HEAD:?}: {e}")))?;
    reports.push(BlockReport {
        name: HEAD.into(),
        modes: head.modes.len(),
        variance: explained(&head),
        kept_by_smoothing: 1.0,
    });
    append(&mut coefficients, &head.coefficients);
    modes.extend(head.modes.iter().zip(&head.sigmas).map(|(mode, &sigma)| {
        let moved = mode.chunks_exact(3).map(DVec3::from_slice);
        moved.map(|d| d * sigma).collect::<Vec<_>>()
    }));
    blocks.push(Block {
        name: HEAD.into(),
        regions: region_numbers(template, &[HEAD])?,
        support: (0..n as u32).collect(),
        modes: quantise(&head.modes, &head.sigmas),
        sigmas: head.sigmas.iter().map(|&s| s as f32).collect(),
        first_coefficient: blocks.iter().map(|b| b.sigmas.len()).sum(),
        surround: None,
    });
    // The features' coefficients have mean zero, so their part of the mean face is none.
    let mut parts = ModelParts {
        about: About {
            faces: aligned.len() as u32,
            ..about
        },
        mean: stored,
        topology: template.topology.clone(),
        controls: controls(&blocks, &coefficients),
        blocks,
        correlation: correlation(&coefficients),
        landmarks: template.landmarks.clone(),
        measures: measures(template)?,
        blending: settings.blending,
    };
    describe(&mut parts)?;
    Ok(Learned {
        parts,
        blocks: reports,
        alignment,
        aligned,
        coefficients,
        modes,
    })
}

struct Feature<'a> {
    template: &'a Template,
    rule: FeatureRule,
    triangles: &'a [[u32; 3]],
    areas: &'a [f64],
    skin: &'a [u32],
    mean: &'a [DVec3],
    /// The mean in the model's f32.
    stored: &'a [Vec3],
    proportioned: &'a [Vec<DVec3>],
    graph: &'a Geodesic<'a>,
    loose: &'a [Loose],
    settings: &'a Settings,
}

struct LearnedFeature {
    block: Block,
    /// Modes (mm a sigma) over the whole mesh, surround included.
    whole_modes: Vec<Vec<DVec3>>,
    coefficients: Vec<Vec<f64>>,
    report: BlockReport,
}

fn learn_feature(f: &Feature) -> FitResult<LearnedFeature> {
    let n = f.mean.len();
    let regions = region_numbers(f.template, f.rule.regions)?;
    let support: Vec<u32> = (0..n as u32)
        .filter(|&v| regions.contains(&f.template.topology.regions[v as usize]))
        .collect();
    let samples: Vec<Vec<f64>> = f
        .proportioned
        .par_iter()
        .map(|face| {
            let motion = Rigid::fit(face, f.mean, &support, f.areas);
            let own: Vec<DVec3> = face.iter().map(|&p| motion.apply(p)).collect();
            flat(&own, f.mean, support.iter().copied())
        })
        .collect();
    let pca = Pca::learn(&samples, f.settings.tau)
        .map_err(|e| FitError::Input(format!("region {:?}: {e}", f.rule.name)))?;

    let mut inside = vec![false; n];
    support.iter().for_each(|&v| inside[v as usize] = true);
    let edge = border(f.triangles, &inside);
    let from_border = f.graph.distances(&edge, f64::INFINITY);
    // Cavities and eyeballs are inside, however far in; the region's depth is that of its skin.
    let from_border: Vec<f64> = support
        .iter()
        .map(|&v| match f.skin.binary_search(&v) {
            Ok(_) => from_border[v as usize],
            Err(_) => f64::INFINITY,
        })
        .collect();
    let smoothing = Smoothing {
        inside: f.rule.inside,
        border: f.rule.border,
        band: SMOOTHING_BAND * f.rule.border,
    };
    let smoother = Smoother::new(smoothing, f.mean, f.triangles, &support, &from_border)?;
    let smooth: Vec<Vec<f64>> = pca
        .modes
        .par_iter()
        .map(|mode| smoother.smooth(mode))
        .collect();

    let reach = f64::from(f.settings.blending.limits[1] * FALLOFF_REACH);
    let surround = surround::build(
        f.graph,
        f.stored,
        &f.template.topology,
        &support,
        f.loose,
        reach,
    )?;
    let alpha = f.settings.blending.alpha;
    let whole_modes = smooth
        .par_iter()
        .zip(&pca.sigmas)
        .map(|(mode, sigma)| {
            let scaled: Vec<f64> = mode.iter().map(|m| m * sigma).collect();
            spread(&scaled, &support, &surround, alpha, n)
        })
        .collect();
    let energy = |modes: &[Vec<f64>]| -> f64 {
        let of = |mode: &Vec<f64>| mode.iter().map(|m| m * m).sum::<f64>();
        modes
            .iter()
            .zip(&pca.sigmas)
            .map(|(mode, s)| of(mode) * s * s)
            .sum()
    };
    Ok(LearnedFeature {
        report: BlockReport {
            name: f.rule.name.into(),
            modes: pca.modes.len(),
            variance: explained(&pca),
            kept_by_smoothing: (energy(&smooth) / energy(&pca.modes)).sqrt(),
        },
        block: Block {
            name: f.rule.name.into(),
            regions,
            modes: quantise(&smooth, &pca.sigmas),
            sigmas: pca.sigmas.iter().map(|&s| s as f32).collect(),
            first_coefficient: 0,
            support,
            surround: Some(surround),
        },
        whole_modes,
        coefficients: pca.coefficients,
    })
}

fn quantise(modes: &[Vec<f64>], sigmas: &[f64]) -> Quantised {
    let scaled: Vec<f64> = modes
        .iter()
        .zip(sigmas)
        .flat_map(|(mode, s)| mode.iter().map(move |m| m * s))
        .collect();
    Quantised::new(&scaled, Quantised::step_for(BLOCK_ERROR, modes.len()))
}

/// The point that a model file keeps of a point of the mean.
fn on_grid(p: DVec3) -> DVec3 {
    DVec3::from(p.to_array().map(|x| COORDINATES.nearest(x)))
}

fn explained(pca: &Pca) -> f64 {
    let total: f64 = pca.eigenvalues.iter().sum();
    pca.sigmas.iter().map(|s| s * s).sum::<f64>() / total
}

fn append(rows: &mut [Vec<f64>], more: &[Vec<f64>]) {
    rows.iter_mut()
        .zip(more)
        .for_each(|(row, more)| row.extend(more));
}

fn rms(distances: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = distances.fold((0_usize, 0.0), |(n, sum), d| (n + 1, sum + d * d));
    (sum / count.max(1) as f64).sqrt()
}

/// Displacements of some vertices from the mean, x, y, z each.
fn flat(face: &[DVec3], mean: &[DVec3], vertices: impl Iterator<Item = u32>) -> Vec<f64> {
    vertices
        .flat_map(|v| (face[v as usize] - mean[v as usize]).to_array())
        .collect()
}

/// Numbers of named regions.
fn region_numbers(template: &Template, names: &[&str]) -> FitResult<Vec<u8>> {
    names
        .iter()
        .map(|name| {
            let found = template
                .topology
                .region_names
                .iter()
                .position(|r| r == name);
            found.map(|r| r as u8).ok_or_else(|| {
                FitError::Input(format!("the template has no region called {name:?}"))
            })
        })
        .collect()
}

/// The eyeballs, each with the skin that lies on it (the lids): all that is nearer than 2 mm, and
/// at least the nearest vertex.
fn loose_parts(template: &Template, mean: &[DVec3]) -> FitResult<Vec<Loose>> {
    let skin = template.part_vertices("skin")?;
    ["left eyeball", "right eyeball"]
        .iter()
        .map(|name| {
            let ball = template.part_vertices(name)?;
            let part = template.topology.parts.iter().position(|p| p.name == *name);
            let gap = |v: u32| {
                let p = mean[v as usize];
                ball.iter()
                    .map(|&b| p.distance(mean[b as usize]))
                    .fold(f64::INFINITY, f64::min)
            };
            let mut near: Vec<(f64, u32)> = skin.par_iter().map(|&v| (gap(v), v)).collect();
            near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let close = near.iter().take_while(|(gap, _)| *gap < 2.0).count().max(1);
            Ok(Loose {
                part: part.unwrap_or_default() as u32,
                members: ball,
                leaders: near[..close].iter().map(|(_, v)| *v).collect(),
            })
        })
        .collect()
}

/// One control a mode, called after its block and number, with the population's distribution.
fn controls(blocks: &[Block], coefficients: &[Vec<f64>]) -> Vec<Control> {
    let of_block = |block: &Block| {
        let name = block.name.clone();
        block
            .coefficients()
            .enumerate()
            .map(move |(k, i)| (name.clone(), k, i))
            .collect::<Vec<_>>()
    };
    blocks
        .iter()
        .flat_map(of_block)
        .map(|(group, k, i)| Control {
            name: format!("{group} {}", k + 1),
            description: String::new(),
            direction: vec![(i as u32, 1.0)],
            reading: vec![(i as u32, 1.0)],
            quantiles: quantiles(coefficients.iter().map(|row| row[i]).collect()),
            group,
        })
        .collect()
}

/// The empirical quantiles at equally spaced percentiles (linear between order statistics), with
/// the limits at both ends and a least gap between neighbours.
fn quantiles(mut values: Vec<f64>) -> Vec<f32> {
    values.sort_by(f64::total_cmp);
    let last = QUANTILES - 1;
    let limit = f64::from(LIMIT);
    let mut table: Vec<f64> = (0..QUANTILES)
        .map(|q| {
            let at = q as f64 / last as f64 * (values.len() - 1) as f64;
            let low = (at as usize).min(values.len() - 2);
            values[low] + (values[low + 1] - values[low]) * (at - low as f64)
        })
        .collect();
    (table[0], table[last]) = (-limit, limit);
    // Inner entries beyond a limit or too close to their neighbours are pressed into order from
    // both ends.
    for q in 1..last {
        table[q] = table[q].max(table[q - 1] + QUANTILE_GAP);
    }
    for q in (1..last).rev() {
        table[q] = table[q].min(table[q + 1] - QUANTILE_GAP);
    }
    table.iter().map(|&q| q as f32).collect()
}

/// The correlation of the coefficients, shrunk towards independence by the amount that minimises
/// the expected error (Schaefer and Strimmer 2005, eq. 10), which also makes it positive definite
/// when there are fewer faces than coefficients.
fn correlation(coefficients: &[Vec<f64>]) -> Vec<f32> {
    let f = coefficients.len() as f64;
    let c = coefficients[0].len();
    let column = |i: usize| -> Vec<f64> {
        let values: Vec<f64> = coefficients.iter().map(|row| row[i]).collect();
        let mean = values.iter().sum::<f64>() / f;
        let length = values
            .iter()
            .map(|v| (v - mean).powi(2))
            .sum::<f64>()
            .sqrt();
        values.iter().map(|v| (v - mean) / length).collect()
    };
    let columns: Vec<Vec<f64>> = (0..c).map(column).collect();
    let mut sample = vec![0.0; c * c];
    let (mut noise, mut signal) = (0.0, 0.0);
    for i in 0..c {
        for j in 0..i {
            let r: f64 = columns[i].iter().zip(&columns[j]).map(|(a, b)| a * b).sum();
            sample[i * c + j] = r;
            sample[j * c + i] = r;
            noise += (1.0 - r * r).powi(2) / (f - 1.0);
            signal += r * r;
        }
    }
    // Some shrinkage always stays, so that rounding cannot cost definiteness: it moves an
    // eigenvalue by at most half a step of the grid for each of some hundred coefficients.
    let shrink = (noise / signal.max(1e-12)).clamp(0.01, 1.0);
    (0..c * c)
        .map(|at| {
            if at / c == at % c {
                1.0
            } else {
                CORRELATIONS.nearest(sample[at] * (1.0 - shrink)) as f32
            }
        })
        .collect()
}
