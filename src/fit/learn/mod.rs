//! From registered faces to a model: align, learn each region, smooth, blend, learn the rest.
//!
//! By way of [`smooth`] and [`surround`]; [`measures`](mod@measures) and [`describe`](mod@describe) put it into words, [`semantic`] makes
//! named controls of it, [`attributes`] are what [`labels`] tell of its faces, [`about`] says who they are and
//! [`persons`] which of them are one person's, and [`crease`] how clean its seams are.

pub mod about;
pub mod attributes;
pub mod crease;
pub mod describe;
mod distribution;
mod feature;
pub mod labels;
pub mod measures;
pub mod persons;
pub mod semantic;
pub mod smooth;
pub mod surround;

use faer::Mat;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use self::describe::describe;
use self::measures::{SEMANTIC, measures};
use self::persons::Persons;
use self::semantic::{Method, Table};
use crate::fit::head::template::Template;
use crate::fit::mesh::align::{Rigid, procrustes, vertex_areas, without_proportions};
use crate::fit::mesh::geodesic::Geodesic;
use crate::fit::statistics::gram::sums;
use crate::fit::statistics::pca::Spectrum;
use crate::fit::{FitError, FitResult};
use crate::model::{About, Blending, Block, Control, MAX_COEFFICIENTS, ModelParts, Modes};
use crate::quantise::{BLOCK_ERROR, COORDINATES, Quantised};
pub(crate) use distribution::quantiles;
use distribution::{controls, correlation};
pub(crate) use feature::spectrum;
use feature::{Feature, Ground, loose_parts};

pub use feature::{FEATURES, FeatureRule};

const HEAD: &str = "head";
/// The head block leaves this part of what tau lets a feature leave. Where features sit and how
/// large they are is in it, so what it lacks is an error of each of them: with the same tau chin
/// and forehead of a face that was not learned from come back 1.4 mm off, with a fifth 0.7 mm.
const HEAD_LEAVES: f64 = 0.2;

/// How a model is learned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// The part of the variance that the modes of each feature keep (eq. 6); the head block leaves
    /// a fifth as much.
    pub tau: f64,
    /// Blending distance and its limits.
    pub blending: Blending,
    /// The mirror image of each face counts as one more: what one person has on the left another has on the right.
    /// Each mode is then the same on both sides or the opposite, and semantic controls of the left and of the right are
    /// each other's images.
    pub both_sides: bool,
    /// How semantic controls are found.
    pub semantic: Method,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            tau: 0.95,
            blending: Blending {
                alpha: 10.0,
                limits: [3.0, 15.0],
            },
            both_sides: true,
            semantic: Method::Constrained,
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
    /// How each face stands to the others, scans of one person each by itself.
    pub faces: Vec<FaceReport>,
    /// Root mean square distance that alignment left, of all faces, mm.
    pub alignment: f64,
    /// The people's mean before it was rounded, mm.
    pub mean: Vec<DVec3>,
    /// Each person's face in the model's pose, mm: the mean of the scans.
    pub aligned: Vec<Vec<DVec3>>,
    /// Coefficients of each person's face, sigmas: those of the population, for they have no edits.
    pub coefficients: Vec<Vec<f64>>,
    /// What semantic controls do to each other's measures, a table a method.
    pub tables: Vec<Table>,
    /// The population's modes before they were rounded, one a coefficient: displacements of all vertices, those
    /// of the surround at the model's blending distance, mm a sigma.
    pub modes: Vec<Vec<DVec3>>,
}

/// How a face stands to the others that are learned from.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct FaceReport {
    /// What alignment left: the root mean square distance of its skin's vertices from the mean's, mm.
    pub alignment: f64,
    /// The root mean square distance of its skin's vertices from their middle, mm.
    pub size: f64,
}

/// So many robust standard deviations from the median a face is far beyond the others. Of the 300 registered people that the
/// default model is learned from the farthest from the mean is 2.6 of them away, and of normal ones 1 in 30,000 is.
const FAR: f64 = 4.0;

/// Of fewer faces nobody knows what is usual.
const FEWEST_USUAL: usize = 8;

/// Faces that are far beyond the others in what alignment leaves or in size, as a failed registration or another unit
/// makes them: which, by how many robust standard deviations of the logarithm (1.4826 times the median distance from
/// the median), and in what (`"distance from the mean"` or `"size"`), the farthest first.
pub fn far_beyond(faces: &[FaceReport]) -> Vec<(usize, f64, &'static str)> {
    if faces.len() < FEWEST_USUAL {
        return Vec::new();
    }
    let off = |values: Vec<f64>| -> Vec<f64> {
        let middle = median(values.clone());
        let off: Vec<f64> = values.iter().map(|x| x - middle).collect();
        let sigma = 1.4826 * median(off.iter().map(|x| x.abs()).collect());
        off.iter().map(|x| x / sigma).collect()
    };
    let distances = off(faces.iter().map(|face| face.alignment.ln()).collect());
    let sizes = off(faces.iter().map(|face| face.size.ln()).collect());
    let away = (distances.iter().enumerate()).map(|(i, &off)| (i, off, "distance from the mean"));
    // Nobody is too near to the mean, and everybody may be too large or too small.
    let sized = sizes
        .iter()
        .enumerate()
        .map(|(i, off)| (i, off.abs(), "size"));
    let mut found: Vec<_> = away.chain(sized).filter(|face| face.1 > FAR).collect();
    found.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    found
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    (values[(n - 1) / 2] + values[n / 2]) / 2.0
}

/// What learning a block came to.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
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

/// Learns a model from faces in the template's topology (mm, any pose), of which `persons` tells whom each is of.
///
/// Who was scanned several times has one face, the mean of the scans: people vary by how they differ from each other,
/// and not by how one scan differs from the next, nor more by those of whom there are more.
///
/// Steps: generalised Procrustes alignment of the whole skin; for each feature, of faces from which
/// the proportions of the whole head are taken out, a second rigid alignment on its own region (a
/// nose is not where it sits), PCA of the faces and their mirror images, smoothing folded into the modes
/// (section 6.1) and spreading to the surround (6.2); then PCA of what all features together leave
/// of each face, over the whole head. `about` is put into the model, with tau and whether mirror images counted added to
/// what it says it is made by.
///
/// # Errors
/// With fewer than 3 people, persons of other faces, faces of another topology, a region that does not vary, or a tau
/// outside (0, 1] or one that keeps more modes than a model file holds.
pub fn learn(
    template: &Template,
    faces: Vec<Vec<DVec3>>,
    persons: &Persons,
    about: About,
    settings: &Settings,
) -> FitResult<Learned> {
    let learner = Learner::new(template, faces, persons, settings)?;
    let bases = learner.bases(settings.tau)?;
    let bases = learner.that_fit(bases, settings.tau, MOST_MODES)?;
    let how = match settings.both_sides {
        true => format!("tau {}", settings.tau),
        false => format!("tau {}, one-sided", settings.tau),
    };
    let about = About {
        made_by: format!("{} ({how})", about.made_by),
        ..about
    };
    learner.model(bases, about, settings.semantic)
}

/// Modes that a model file holds beside those of its semantic controls.
const MOST_MODES: usize = MAX_COEFFICIENTS - SEMANTIC;

/// Vertices nearer to each other than this are at the same place, mm: a file's rounding.
const SAME: f64 = 1e-3;

/// Which faces are there before: `(face, the first that is the same)`, in their order. A face that is
/// there twice would count twice, and among few it leaves measures without a spread.
pub fn doubled(faces: &[impl AsRef<[DVec3]>]) -> Vec<(usize, usize)> {
    let same = |a: &[DVec3], b: &[DVec3]| {
        a.len() == b.len() && a.iter().zip(b).all(|(p, q)| p.distance(*q) < SAME)
    };
    (1..faces.len())
        .filter_map(|i| {
            Some((
                i,
                (0..i).find(|&j| same(faces[i].as_ref(), faces[j].as_ref()))?,
            ))
        })
        .collect()
}

/// An aligned population, from which models of any tau are made.
pub struct Learner<'a> {
    template: &'a Template,
    blending: Blending,
    /// The template's mirror map, where mirror images count.
    mirror: Option<&'a [u32]>,
    skin: Vec<u32>,
    areas: Vec<f64>,
    /// How each face stands to the others, in their order.
    pub faces: Vec<FaceReport>,
    /// The mean face as a model file holds it, mm.
    pub mean: Vec<DVec3>,
    /// The mean face before it was rounded, mm.
    exact: Vec<DVec3>,
    stored: Vec<Vec3>,
    /// Each person's face in the model's pose, mm.
    pub aligned: Vec<Vec<DVec3>>,
    features: Vec<Feature>,
}

/// The modes of all blocks, before they are rounded.
#[derive(Debug, Clone)]
pub struct Bases {
    /// A line a block: the features in their order, then the head.
    pub reports: Vec<BlockReport>,
    /// Displacements of all vertices, those of the surround at the model's blending distance, one
    /// a coefficient, mm a sigma.
    pub modes: Vec<Vec<DVec3>>,
    /// Coefficients of each person's face, sigmas.
    pub coefficients: Vec<Vec<f64>>,
    /// Which modes are the opposite of their mirror image: of a training face's image the coefficients have the
    /// other sign. None where images do not count.
    pub odd: Vec<bool>,
    blocks: Vec<Block>,
}

impl<'a> Learner<'a> {
    /// Aligns faces in the template's topology (mm, any pose), takes the mean of each of `persons`, and finds how
    /// each feature varies.
    ///
    /// # Errors
    /// With fewer than 3 people, persons of other faces, faces of another topology, or a region that does not vary.
    pub fn new(
        template: &'a Template,
        faces: Vec<Vec<DVec3>>,
        persons: &Persons,
        settings: &Settings,
    ) -> FitResult<Self> {
        let blending = settings.blending;
        let mirror = settings.both_sides.then_some(&template.topology.mirror[..]);
        let n = template.positions.len();
        persons.check(faces.len())?;
        if persons.count() < 3 {
            return Err(FitError::Input(format!(
                "{} too few to learn from; 3 is the least",
                persons.said_to_be()
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
        let mut faces = faces;
        let align = |faces: &mut [Vec<DVec3>]| {
            procrustes(faces, &template.positions, &skin, &areas, mirror)
        };
        let mut exact = align(&mut faces);
        let people = (!persons.are_single()).then(|| {
            let mut people = persons.mean_faces(&faces);
            exact = align(&mut people);
            people
        });
        // From here on it is the mean that a model file holds: what surrounds follow is found on
        // it.
        let mean: Vec<DVec3> = exact.iter().map(|&p| on_grid(p)).collect();
        let stored: Vec<Vec3> = mean.iter().map(|p| p.as_vec3()).collect();
        if people.is_some() {
            faces.par_iter_mut().for_each(|face| {
                let motion = Rigid::fit(face, &mean, &skin, &areas);
                face.iter_mut().for_each(|p| *p = motion.apply(*p));
            });
        }
        let reports = reports(&faces, &mean, &skin);
        let aligned = people.unwrap_or(faces);
        let ground = Ground {
            template,
            graph: Geodesic::new(&mean, &triangles),
            loose: loose_parts(template, &mean)?,
            triangles,
            areas,
            skin,
            mean: &mean,
            stored: &stored,
            blending,
            mirror,
        };
        let supports = FEATURES
            .iter()
            .map(|rule| feature::support(rule, template))
            .collect::<FitResult<Vec<_>>>()?;
        // How wide, high and deep a head is belongs to the head block. Left in the features it
        // would make their borders the places where one person's proportions meet the average's.
        let mut shapes: Vec<Vec<Vec<f64>>> = (aligned.par_iter())
            .map(|face| {
                let even = without_proportions(face, &mean, &ground.skin, &ground.areas);
                let shape =
                    |support: &Vec<u32>| feature::shape(&even, &mean, support, &ground.areas);
                supports.iter().map(shape).collect()
            })
            .collect();
        let features = (FEATURES.iter().zip(supports).enumerate())
            .map(|(f, (&rule, support))| {
                let samples = shapes
                    .iter_mut()
                    .map(|shapes| std::mem::take(&mut shapes[f]));
                Feature::learn(rule, &ground, support, samples.collect())
            })
            .collect::<FitResult<_>>()?;
        let Ground { areas, skin, .. } = ground;
        Ok(Self {
            template,
            blending,
            mirror,
            skin,
            areas,
            faces: reports,
            mean,
            exact,
            stored,
            aligned,
            features,
        })
    }

    /// The bases that keep `tau` of the variance of each feature, and of the head leave a fifth as
    /// much.
    ///
    /// # Errors
    /// When tau is outside (0, 1], or what the features leave over does not vary.
    pub fn bases(&self, tau: f64) -> FitResult<Bases> {
        let n = self.mean.len();
        let mut coefficients: Vec<Vec<f64>> = vec![Vec::new(); self.aligned.len()];
        let (mut blocks, mut reports) = (Vec::new(), Vec::new());
        let (mut modes, mut odd) = (Vec::new(), Vec::new());
        for feature in &self.features {
            let count = feature.spectrum.modes_for(tau)?;
            let kept = feature.keep(count);
            append(&mut coefficients, &kept.pca.coefficients);
            odd.extend(&kept.pca.odd);
            reports.push(BlockReport {
                name: feature.rule.name.into(),
                modes: count,
                variance: feature.spectrum.explained(count),
                kept_by_smoothing: kept.by_smoothing(),
            });
            blocks.push(Block {
                name: feature.rule.name.into(),
                regions: feature.regions.clone(),
                modes: quantise(&kept.smooth, &kept.pca.sigmas),
                sigmas: kept.pca.sigmas.iter().map(|&s| s as f32).collect(),
                first_coefficient: modes.len(),
                support: feature.support.clone(),
                surround: Some(feature.surround.clone()),
                local_to: None,
            });
            modes.extend(kept.whole);
        }
        let residual = self.residual(&modes, &coefficients);
        let in_block = |e| FitError::Input(format!("block {HEAD:?}: {e}"));
        let all: Vec<u32> = (0..n as u32).collect();
        let spectrum = spectrum(residual, &all, self.mirror).map_err(in_block)?;
        let count = spectrum.modes_for(1.0 - HEAD_LEAVES * (1.0 - tau))?;
        let head = spectrum.truncate(count);
        append(&mut coefficients, &head.coefficients);
        odd.extend(&head.odd);
        reports.push(BlockReport {
            name: HEAD.into(),
            modes: count,
            variance: spectrum.explained(count),
            kept_by_smoothing: 1.0,
        });
        blocks.push(Block {
            name: HEAD.into(),
            regions: region_numbers(self.template, &[HEAD])?,
            support: all,
            modes: quantise(&head.modes, &head.sigmas),
            sigmas: head.sigmas.iter().map(|&s| s as f32).collect(),
            first_coefficient: modes.len(),
            surround: None,
            local_to: None,
        });
        modes.extend(head.modes.iter().zip(&head.sigmas).map(|(mode, &sigma)| {
            let moved = mode.chunks_exact(3).map(DVec3::from_slice);
            moved.map(|d| d * sigma).collect::<Vec<_>>()
        }));
        Ok(Bases {
            reports,
            modes,
            coefficients,
            odd,
            blocks,
        })
    }

    /// The bases of a tau, where these are at most as many modes as a model file holds.
    ///
    /// # Errors
    /// When they are more, with the largest tau in thousandths that keeps no more.
    fn that_fit(&self, bases: Bases, tau: f64, most: usize) -> FitResult<Bases> {
        let count = bases.modes.len();
        if count <= most {
            return Ok(bases);
        }
        // Its modes may be a gigabyte.
        drop(bases);
        let (mut fits, mut exceeds) = (0, (1000.0 * tau).ceil() as u32);
        while exceeds - fits > 1 {
            let middle = fits.midpoint(exceeds);
            let kept = self.bases(f64::from(middle) / 1000.0)?.modes.len();
            match kept <= most {
                true => fits = middle,
                false => exceeds = middle,
            }
        }
        let tau_that_fits = f64::from(fits) / 1000.0;
        Err(FitError::Input(format!(
            "tau {tau} keeps {count} modes, where a model holds {most} beside its named controls: at most tau \
             {tau_that_fits} does"
        )))
    }

    /// What modes with these coefficients leave of each face's displacement from the mean, x, y, z a
    /// vertex, mm.
    fn residual(&self, modes: &[Vec<DVec3>], coefficients: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let amounts = Mat::from_fn(modes.len(), self.aligned.len(), |k, f| coefficients[f][k]);
        let modes: Vec<&[f64]> = modes.iter().map(|m| bytemuck::cast_slice(m)).collect();
        let mut left = sums(&modes, amounts.as_ref());
        let mean: &[f64] = bytemuck::cast_slice(&self.mean);
        left.par_iter_mut()
            .zip(&self.aligned)
            .for_each(|(left, face)| {
                let face: &[f64] = bytemuck::cast_slice(face);
                for (left, (x, m)) in left.iter_mut().zip(face.iter().zip(mean)) {
                    *left = x - m - *left;
                }
            });
        left
    }

    /// The model with these bases, and with semantic controls.
    ///
    /// # Errors
    /// When the template lacks a landmark that a measure needs, when the faces hardly differ in one, and
    /// as [`semantic::learn`].
    pub fn model(self, bases: Bases, about: About, method: Method) -> FitResult<Learned> {
        let alignment = rms(self.faces.iter().map(|face| face.alignment));
        let both_sides = self.mirror.is_some();
        let Bases {
            reports,
            modes,
            coefficients,
            odd,
            blocks,
        } = bases;
        let people = self.aligned.len();
        let mut population = coefficients.clone();
        if self.mirror.is_some() {
            population.extend(coefficients.iter().map(|row| {
                let own = row.iter().zip(&odd);
                own.map(|(&c, &odd)| if odd { -c } else { c }).collect()
            }));
        }
        let block_of =
            (blocks.iter().enumerate()).flat_map(|(b, own)| own.coefficients().map(move |_| b));
        let block_of: Vec<usize> = block_of.collect();
        // The features' coefficients have mean zero, so their part of the mean face is none.
        let (landmarks, measures) = measures(self.template)?;
        let mut parts = ModelParts {
            about: About {
                faces: people as u32,
                ..about
            },
            mean: self.stored,
            topology: self.template.topology.clone(),
            controls: controls(&blocks, &coefficients, &odd),
            blocks,
            correlation: correlation(&population, people, &block_of, &odd),
            attributes: Vec::new(),
            landmarks,
            measures,
            blending: self.blending,
        };
        describe(&mut parts)?;
        // How features vary is a third of all that is kept of the faces.
        drop(self.features);
        let found = semantic::learn(self.template, &self.aligned, &parts, both_sides, method)?;
        parts.blocks.extend(found.blocks);
        parts.controls.extend(found.controls);
        let even = |c: &&Control| {
            c.limits[0] >= c.limits[1] || c.quantiles.windows(2).any(|q| q[0] >= q[1])
        };
        if let Some(control) = parts.controls.iter().find(even) {
            return Err(FitError::Input(format!(
                "{people} faces are too few, or too alike, to learn {:?} from",
                control.name
            )));
        }
        Ok(Learned {
            parts,
            blocks: reports,
            faces: self.faces,
            alignment,
            mean: self.exact,
            aligned: self.aligned,
            coefficients,
            tables: found.tables,
            modes,
        })
    }

    /// A face (all vertices, mm) moved rigidly to where the population's faces are.
    pub fn align(&self, face: &[DVec3]) -> Vec<DVec3> {
        let motion = Rigid::fit(face, &self.mean, &self.skin, &self.areas);
        face.iter().map(|&p| motion.apply(p)).collect()
    }

    /// A face's feature on a head of average proportions, aligned on itself, as the feature's modes
    /// see it: displacements from the mean, x, y, z a support vertex, mm. `face` is one that
    /// [`Learner::align`] gave.
    pub fn feature_shape(&self, feature: usize, face: &[DVec3]) -> Vec<f64> {
        let on_average = without_proportions(face, &self.mean, &self.skin, &self.areas);
        self.features[feature].shape(&on_average, &self.mean, &self.areas)
    }

    /// The vertices of a feature, increasing.
    pub fn support(&self, feature: usize) -> &[u32] {
        &self.features[feature].support
    }

    /// The features' names, each with how its region varies, and the modes that `tau` keeps.
    pub fn features(&self) -> impl Iterator<Item = (&'static str, &Spectrum)> {
        self.features.iter().map(|f| (f.rule.name, &f.spectrum))
    }
}

/// How aligned faces stand to their mean by their skin.
fn reports(faces: &[Vec<DVec3>], mean: &[DVec3], skin: &[u32]) -> Vec<FaceReport> {
    let one = |face: &Vec<DVec3>| {
        let at = |v: u32| face[v as usize];
        let skin = || skin.iter().copied();
        let centre = skin().map(at).sum::<DVec3>() / skin().len().max(1) as f64;
        FaceReport {
            alignment: rms(skin().map(|v| at(v).distance(mean[v as usize]))),
            size: rms(skin().map(|v| at(v).distance(centre))),
        }
    };
    faces.par_iter().map(one).collect()
}

fn quantise(modes: &[Vec<f64>], sigmas: &[f64]) -> Modes {
    let scaled: Vec<f64> = modes
        .iter()
        .zip(sigmas)
        .flat_map(|(mode, s)| mode.iter().map(move |m| m * s))
        .collect();
    let rounded = Quantised::new(&scaled, Quantised::step_for(BLOCK_ERROR, modes.len()));
    Modes::of(&rounded, modes.len())
}

/// The point that a model file keeps of a point of the mean.
fn on_grid(p: DVec3) -> DVec3 {
    DVec3::from(p.to_array().map(|x| COORDINATES.nearest(x)))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::truth::population;
    use crate::fit::{base_mesh_dir, test_head};

    #[test]
    fn a_tau_of_too_many_modes_is_refused_with_the_largest_that_is_not() {
        let Some(head) = test_head() else { return };
        let people = population::sample(head, &base_mesh_dir().unwrap(), 6, 3).unwrap();
        let each = Persons::each(6);
        let learner = Learner::new(head, people.faces, &each, &Settings::default()).unwrap();
        let count = |tau: f64| learner.bases(tau).unwrap().modes.len();
        let all = count(1.0);
        let most = all - 9;
        let bases = learner.bases(1.0).unwrap();
        let error = learner.that_fit(bases, 1.0, most).unwrap_err().to_string();
        let said = format!("tau 1 keeps {all} modes, where a model holds {most} beside");
        assert!(error.starts_with(&said), "{error}");
        let word = error.strip_suffix(" does").unwrap().rsplit(' ').next();
        let tau: f64 = word.unwrap().parse().unwrap();
        assert!(count(tau) <= most && count(tau + 0.001) > most, "{error}");
        let bases = learner.bases(tau).unwrap();
        assert!(learner.that_fit(bases, tau, most).is_ok());
    }

    #[test]
    fn a_face_far_beyond_the_others_is_told_by_what_it_is() {
        let mut random = crate::Random::new(3);
        let mut usual = || FaceReport {
            alignment: 3.0 * (0.2 * random.normal()).exp(),
            size: 90.0 * (0.04 * random.normal()).exp(),
        };
        let mut faces: Vec<FaceReport> = (0..50).map(|_| usual()).collect();
        // Nobody among fifty normal ones.
        assert!(far_beyond(&faces).is_empty());
        // Near the mean is no fault.
        faces[3].alignment = 0.1;
        faces[7].alignment = 30.0;
        faces[9].size = 9.0;
        let found: Vec<_> = far_beyond(&faces).into_iter().map(|f| (f.0, f.2)).collect();
        assert_eq!(found, [(9, "size"), (7, "distance from the mean")]);
        assert!(far_beyond(&faces[3..10]).is_empty());
    }
}
