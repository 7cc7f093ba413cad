//! One feature: its samples on its own region, smoothed and spread to its surround.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::smooth::{Smoother, Smoothing};
use super::surround::{self, Loose, border, spread};
use super::{flat, region_numbers};
use crate::fit::head::template::Template;
use crate::fit::mesh::align::Rigid;
use crate::fit::mesh::geodesic::Geodesic;
use crate::fit::mesh::mirror::among;
use crate::fit::statistics::pca::{Pca, Spectrum};
use crate::fit::{FitError, FitResult};
use crate::model::{Blending, FALLOFF_REACH, Surround};

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
        border: 10.5,
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

/// The mean head, and what features need to know of it.
pub(super) struct Ground<'a> {
    pub template: &'a Template,
    pub triangles: Vec<[u32; 3]>,
    pub areas: Vec<f64>,
    pub skin: Vec<u32>,
    pub mean: &'a [DVec3],
    /// The mean in the model's f32.
    pub stored: &'a [Vec3],
    pub graph: Geodesic<'a>,
    pub loose: Vec<Loose>,
    pub blending: Blending,
    /// The mirror map, where mirror images count.
    pub mirror: Option<&'a [u32]>,
}

/// A feature's population, whatever part of it is then kept.
pub(super) struct Feature {
    pub rule: FeatureRule,
    /// Numbers of the template's regions.
    pub regions: Vec<u8>,
    /// The vertices, increasing.
    pub support: Vec<u32>,
    pub spectrum: Spectrum,
    pub surround: Surround,
    smoother: Smoother,
    alpha: f32,
    vertices: usize,
}

/// The modes that are kept of a feature.
pub(super) struct Kept {
    pub pca: Pca,
    /// The PCA's modes, smoothed; x, y, z a support vertex.
    pub smooth: Vec<Vec<f64>>,
    /// Over the whole mesh, surround included, mm a sigma.
    pub whole: Vec<Vec<DVec3>>,
}

impl Feature {
    /// Learns a feature from the faces' [`shape`]s of its [`support`].
    pub fn learn(
        rule: FeatureRule,
        ground: &Ground,
        support: Vec<u32>,
        samples: Vec<Vec<f64>>,
    ) -> FitResult<Self> {
        let n = ground.mean.len();
        let regions = region_numbers(ground.template, rule.regions)?;
        let in_region = |e| FitError::Input(format!("region {:?}: {e}", rule.name));
        let spectrum = spectrum(samples, &support, ground.mirror).map_err(in_region)?;

        let mut inside = vec![false; n];
        support.iter().for_each(|&v| inside[v as usize] = true);
        let edge = border(&ground.triangles, &inside);
        let from_border = ground.graph.distances(&edge, f64::INFINITY);
        // Cavities and eyeballs are inside, however far in; the region's depth is that of its skin.
        let from_border: Vec<f64> = support
            .iter()
            .map(|&v| match ground.skin.binary_search(&v) {
                Ok(_) => from_border[v as usize],
                Err(_) => f64::INFINITY,
            })
            .collect();
        let smoothing = Smoothing {
            inside: rule.inside,
            border: rule.border,
            band: SMOOTHING_BAND * rule.border,
        };
        let smoother = Smoother::new(
            smoothing,
            ground.mean,
            &ground.triangles,
            &support,
            &from_border,
        )?;
        let reach = f64::from(ground.blending.limits[1] * FALLOFF_REACH);
        let surround = surround::build(
            &ground.graph,
            ground.stored,
            &ground.template.topology,
            &support,
            &ground.loose,
            reach,
        )?;
        Ok(Self {
            rule,
            regions,
            support,
            spectrum,
            surround,
            smoother,
            alpha: ground.blending.alpha,
            vertices: n,
        })
    }

    /// What the spectrum is of, for any face on a head of average proportions.
    pub fn shape(&self, face: &[DVec3], mean: &[DVec3], areas: &[f64]) -> Vec<f64> {
        shape(face, mean, &self.support, areas)
    }

    /// The first `modes` of it.
    pub fn keep(&self, modes: usize) -> Kept {
        let pca = self.spectrum.truncate(modes);
        let smooth: Vec<Vec<f64>> = pca
            .modes
            .par_iter()
            .zip(&pca.odd)
            .map(|(mode, &odd)| {
                let mut smooth = self.smoother.smooth(mode);
                self.spectrum.symmetrise(&mut smooth, odd);
                smooth
            })
            .collect();
        let whole = smooth
            .par_iter()
            .zip(&pca.sigmas)
            .map(|(mode, sigma)| {
                let scaled: Vec<f64> = mode.iter().map(|m| m * sigma).collect();
                spread(
                    &scaled,
                    &self.support,
                    &self.surround,
                    self.alpha,
                    self.vertices,
                )
            })
            .collect();
        Kept { pca, smooth, whole }
    }
}

/// How samples vary on some vertices (increasing; x, y, z each): with their mirror images, where these count.
///
/// # Errors
/// As [`Spectrum::of`], and when vertices have their images outside.
pub(crate) fn spectrum(
    samples: Vec<Vec<f64>>,
    vertices: &[u32],
    mirror: Option<&[u32]>,
) -> FitResult<Spectrum> {
    let Some(mirror) = mirror else {
        return Spectrum::of(samples);
    };
    let among = among(vertices, mirror)
        .ok_or_else(|| FitError::Input("what is on its one side is not on the other".into()))?;
    Spectrum::of_both_sides(samples, among)
}

/// The vertices of a feature, increasing.
pub(super) fn support(rule: &FeatureRule, template: &Template) -> FitResult<Vec<u32>> {
    let regions = region_numbers(template, rule.regions)?;
    let of = &template.topology.regions;
    Ok((0..of.len() as u32)
        .filter(|&v| regions.contains(&of[v as usize]))
        .collect())
}

/// The region of a face on a head of average proportions, aligned on itself: displacements from the
/// mean's.
pub(super) fn shape(face: &[DVec3], mean: &[DVec3], support: &[u32], areas: &[f64]) -> Vec<f64> {
    let motion = Rigid::fit(face, mean, support, areas);
    let own: Vec<DVec3> = face.iter().map(|&p| motion.apply(p)).collect();
    flat(&own, mean, support.iter().copied())
}

impl Kept {
    /// What smoothing left of the displacement of a random face, 0..=1.
    pub fn by_smoothing(&self) -> f64 {
        let energy = |modes: &[Vec<f64>]| -> f64 {
            let of = |mode: &Vec<f64>| mode.iter().map(|m| m * m).sum::<f64>();
            modes
                .iter()
                .zip(&self.pca.sigmas)
                .map(|(mode, s)| of(mode) * s * s)
                .sum()
        };
        (energy(&self.smooth) / energy(&self.pca.modes)).sqrt()
    }
}

/// The eyeballs, each with the skin that lies on it (the lids): all that is nearer than 2 mm, and
/// at least the nearest vertex.
pub(super) fn loose_parts(template: &Template, mean: &[DVec3]) -> FitResult<Vec<Loose>> {
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
