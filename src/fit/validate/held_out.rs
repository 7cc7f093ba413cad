//! Cross-validation: faces that a model was not learned from, as it gives them back (region
//! morphing, section 7, Table 2).

use std::collections::BTreeMap;

use faer::Mat;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use serde::Serialize;

use super::areas::{Areas, Errors};
use super::wide;
use crate::fit::FitResult;
use crate::fit::head::template::Template;
use crate::fit::learn::persons::Persons;
use crate::fit::learn::{Learner, Settings, spectrum};
use crate::fit::statistics::gram::{inner, sums};
use crate::fit::statistics::pca::Spectrum;
use crate::fit::statistics::subspace::Subspace;

/// A mean over people and its 95 % confidence interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Interval {
    /// The mean.
    pub mean: f64,
    /// The lower end of the interval.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
}

impl Interval {
    /// Of values of independent people, by Student's t.
    pub fn of(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
        // One value says nothing of how others differ from it.
        let half = match values.len() {
            0 | 1 => f64::INFINITY,
            count => student_t(count - 1) * (variance / n).sqrt(),
        };
        Self {
            mean,
            low: mean - half,
            high: mean + half,
        }
    }
}

/// The 97.5 % point of Student's t, by the expansion in 1 / degrees of freedom (Abramowitz and
/// Stegun 26.7.5), which is within 0.001 from 10 degrees on; below, the table.
fn student_t(degrees: usize) -> f64 {
    const FEW: [f64; 10] = [
        f64::INFINITY,
        12.706,
        4.303,
        3.182,
        2.776,
        2.571,
        2.447,
        2.365,
        2.306,
        2.262,
    ];
    if let Some(&t) = FEW.get(degrees) {
        return t;
    }
    let (x, n) = (1.959_964_f64, degrees as f64);
    let (x3, x5, x7) = (x.powi(3), x.powi(5), x.powi(7));
    x + (x3 + x) / (4.0 * n)
        + (5.0 * x5 + 16.0 * x3 + 3.0 * x) / (96.0 * n * n)
        + (3.0 * x7 + 19.0 * x5 + 17.0 * x3 - 15.0 * x) / (384.0 * n.powi(3))
}

/// How well one area of held-out faces comes back. Each number is the mean over the people of what was found on each:
/// of who has several scans, on average.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AreaErrors {
    /// The area.
    pub area: String,
    /// The largest distance, mm.
    pub max: Interval,
    /// The mean distance, mm.
    pub mean: Interval,
    /// The root mean square distance, mm.
    pub rms: Interval,
    /// The root mean square distance, in percent of the diameter of the head's bounding box.
    pub rms_percent: f64,
    /// The largest distance, in percent of that diameter.
    pub max_percent: f64,
    /// The mean distance, in percent of that diameter.
    pub mean_percent: f64,
}

/// What a model of one tau makes of held-out faces.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HeldOut {
    /// The part of the variance that each block keeps.
    pub tau: f64,
    /// Coefficients of the model, a mean over the folds.
    pub coefficients: f64,
    /// Region PCA with blending and the head block.
    pub regions: Vec<AreaErrors>,
    /// PCA of whole faces with as many coefficients.
    pub whole_face: Vec<AreaErrors>,
    /// Each feature by itself.
    pub shapes: Vec<ShapeErrors>,
    /// Each face that was held out and its root mean square distance over the features, mm.
    #[serde(skip)]
    pub faces: Vec<(usize, f64)>,
}

/// How well the shape of one feature comes back: aligned on itself, on a head of average
/// proportions, which is what its modes are learned from. Root mean square distance, mm.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ShapeErrors {
    /// The feature.
    pub feature: String,
    /// The feature's own modes.
    pub region: Interval,
    /// As many modes of whole faces.
    pub whole_face: Interval,
}

/// A held-out face as it was and as it came back.
#[derive(Debug, Clone)]
pub struct Pair {
    /// Which face of the population.
    pub face: usize,
    /// The face in the model's pose, mm.
    pub input: Vec<DVec3>,
    /// The model's nearest face, mm.
    pub output: Vec<DVec3>,
    /// Root mean square distance over the features, mm.
    pub rms: f64,
}

/// What was found on one face: errors an area, and the diameter of its head.
type OfFace = (Vec<Errors>, f64);

/// Learns from all faces but those of each test set, in which people are whole, and gives these back by least squares
/// over the skin. Calls `done` after each test set. Also returns the pairs of the first tau, one a person.
///
/// # Errors
/// As [`Learner::new`].
pub fn cross_validate(
    template: &Template,
    faces: &[Vec<Vec3>],
    persons: &Persons,
    tests: &[Vec<usize>],
    taus: &[f64],
    settings: &Settings,
    mut done: impl FnMut(),
) -> FitResult<(Vec<HeldOut>, Vec<Pair>)> {
    let areas = Areas::new(template)?;
    let mut found = vec![Found::default(); taus.len()];
    let mut pairs: Vec<Pair> = Vec::new();
    for test in tests {
        let others: Vec<usize> = (0..faces.len()).filter(|i| !test.contains(i)).collect();
        let learned = wide(others.iter().map(|&i| &faces[i]));
        let mut learner = Learner::new(template, learned, &persons.some(&others), settings)?;
        // Of all vertices; what is compared are displacements from the mean.
        let fields: Vec<Vec<DVec3>> = wide(test.iter().map(|&i| &faces[i]))
            .par_iter()
            .map(|face| less(&learner.align(face), &learner.mean))
            .collect();
        let features = learner.features().count();
        let shapes: Vec<Vec<Vec<f64>>> = (0..features)
            .map(|f| {
                let shape =
                    |field: &Vec<DVec3>| learner.feature_shape(f, &plus(&learner.mean, field));
                fields.par_iter().map(shape).collect()
            })
            .collect();
        let mut modes_of = Vec::new();
        for (t, &tau) in taus.iter().enumerate() {
            let bases = learner.bases(tau)?;
            found[t].coefficients += bases.modes.len() as f64 / tests.len() as f64;
            let subspace = Subspace::new(&bases.modes, &areas.skin)?;
            let back = subspace.fields(&subspace.coefficients(&fields));
            for ((input, output), &face) in fields.iter().zip(&back).zip(test) {
                let errors = areas.errors(input, output);
                let head = plus(&learner.mean, output);
                let rms = errors.last().map_or(0.0, |all| all.rms);
                found[t].faces.push((face, rms));
                let is_new = |pair: &Pair| persons.of(pair.face) != persons.of(face);
                if t == 0 && pairs.len() < PAIRS && pairs.iter().all(is_new) {
                    pairs.push(Pair {
                        face,
                        input: plus(&learner.mean, input),
                        output: head.clone(),
                        rms,
                    });
                }
                found[t].regions.push((errors, areas.diameter(&head)));
            }
            let mut first = 0;
            for (f, report) in bases.reports[..features].iter().enumerate() {
                let own = &bases.modes[first..first + report.modes];
                first += report.modes;
                let vertices = &areas.vertices[f];
                let subspace = Subspace::new(own, vertices)?;
                let shapes: Vec<_> = (shapes[f].par_iter())
                    .map(|shape| on_head(&learner, f, shape))
                    .collect();
                let back = subspace.fields(&subspace.coefficients(&shapes));
                for (shape, back) in shapes.iter().zip(&back) {
                    let rms = Errors::between(vertices, shape, back).rms;
                    found[t].shapes.entry(f).or_default().push(rms);
                }
            }
            modes_of.push(bases.reports.iter().map(|r| r.modes).collect::<Vec<_>>());
        }
        let aligned = std::mem::take(&mut learner.aligned);
        let mirror = settings.both_sides.then_some(template);
        let whole = whole_faces(aligned, &learner.mean, &areas.skin, mirror)?;
        let most = modes_of.iter().map(|modes| modes.iter().sum()).max();
        let whole = WholeFaces::new(&whole, most.unwrap_or_default(), &areas.skin, &fields);
        for (found, modes) in found.iter_mut().zip(modes_of) {
            let back = whole.nearest(modes.iter().sum());
            for (input, output) in fields.iter().zip(&back) {
                let diameter = areas.diameter(&plus(&learner.mean, output));
                found.whole.push((areas.errors(input, output), diameter));
            }
            for (f, &count) in modes[..features].iter().enumerate() {
                let back = whole.nearest(count);
                let shaped: Vec<f64> = back
                    .par_iter()
                    .zip(&shapes[f])
                    .map(|(back, input)| {
                        let output = learner.feature_shape(f, &plus(&learner.mean, back));
                        let input = on_head(&learner, f, input);
                        let output = on_head(&learner, f, &output);
                        Errors::between(&areas.vertices[f], &input, &output).rms
                    })
                    .collect();
                found.whole_shapes.entry(f).or_default().extend(shaped);
            }
        }
        done();
    }
    let tested = persons.some(&tests.concat());
    let interval = |values: &[f64]| Interval::of(&tested.means(values));
    let summary = (taus.iter().zip(&found))
        .map(|(&tau, found)| HeldOut {
            tau,
            coefficients: found.coefficients,
            regions: summarise(&areas, &found.regions, &tested),
            whole_face: summarise(&areas, &found.whole, &tested),
            faces: found.faces.clone(),
            shapes: (found.shapes.iter().zip(found.whole_shapes.values()))
                .map(|((&f, own), whole)| ShapeErrors {
                    feature: areas.names[f].clone(),
                    region: interval(own),
                    whole_face: interval(whole),
                })
                .collect(),
        })
        .collect();
    Ok((summary, pairs))
}

/// Faces that are kept to be shown.
const PAIRS: usize = 10;

/// What was found so far at one tau.
#[derive(Clone, Default)]
struct Found {
    coefficients: f64,
    faces: Vec<(usize, f64)>,
    regions: Vec<OfFace>,
    whole: Vec<OfFace>,
    /// By feature: the root mean square error of each face, mm.
    shapes: BTreeMap<usize, Vec<f64>>,
    whole_shapes: BTreeMap<usize, Vec<f64>>,
}

/// A feature's shape as a field of all vertices, none of the others of which moves.
fn on_head(learner: &Learner, feature: usize, shape: &[f64]) -> Vec<DVec3> {
    let mut whole = vec![DVec3::ZERO; learner.mean.len()];
    for (&v, d) in learner.support(feature).iter().zip(shape.chunks_exact(3)) {
        whole[v as usize] = DVec3::from_slice(d);
    }
    whole
}

/// How whole faces vary on their skin, with their mirror images by the template that is given for them: aligned ones,
/// about a mean, all vertices, mm. Of faces that are given away none is kept longer than needed.
pub fn whole_faces<F: AsRef<[DVec3]>>(
    aligned: impl IntoParallelIterator<Item = F, Iter: IndexedParallelIterator>,
    mean: &[DVec3],
    skin: &[u32],
    images: Option<&Template>,
) -> FitResult<Spectrum> {
    let rows = aligned.into_par_iter().map(|face| {
        let face = face.as_ref();
        skin.iter()
            .flat_map(|&v| (face[v as usize] - mean[v as usize]).to_array())
            .collect()
    });
    let mirror = images.map(|template| &template.topology.mirror[..]);
    spectrum(rows.collect(), skin, mirror)
}

/// Displacement fields in a PCA of whole faces.
struct WholeFaces<'a> {
    mean: &'a [f64],
    /// Unit modes of the skin.
    modes: Vec<Vec<f64>>,
    /// What each field has of each mode, mm: a row a mode, a column a field.
    amounts: Mat<f64>,
    skin: &'a [u32],
    fields: &'a [Vec<DVec3>],
}

impl<'a> WholeFaces<'a> {
    /// With the first `most` modes.
    fn new(spectrum: &'a Spectrum, most: usize, skin: &'a [u32], fields: &'a [Vec<DVec3>]) -> Self {
        let modes = spectrum.truncate(most).modes;
        let rows: Vec<Vec<f64>> = (fields.par_iter())
            .map(|field| {
                let x = skin.iter().flat_map(|&v| field[v as usize].to_array());
                x.zip(&spectrum.mean).map(|(x, m)| x - m).collect()
            })
            .collect();
        Self {
            amounts: inner(&modes, &rows),
            mean: &spectrum.mean,
            modes,
            skin,
            fields,
        }
    }

    /// What the first `modes` give back of each field: of its skin, the rest is left as it was.
    fn nearest(&self, modes: usize) -> Vec<Vec<DVec3>> {
        let kept = modes.min(self.modes.len());
        let back = sums(&self.modes[..kept], self.amounts.get(..kept, ..));
        (back.par_iter().zip(self.fields))
            .map(|(back, field)| {
                let mut whole = field.clone();
                let moved = back.chunks_exact(3).zip(self.mean.chunks_exact(3));
                for (&v, (d, mean)) in self.skin.iter().zip(moved) {
                    whole[v as usize] = DVec3::from_slice(mean) + DVec3::from_slice(d);
                }
                whole
            })
            .collect()
    }
}

/// A face's displacement from the mean.
pub fn less(face: &[DVec3], mean: &[DVec3]) -> Vec<DVec3> {
    face.iter().zip(mean).map(|(p, m)| *p - *m).collect()
}

/// The mean moved by a displacement.
pub fn plus(mean: &[DVec3], field: &[DVec3]) -> Vec<DVec3> {
    mean.iter().zip(field).map(|(m, d)| *m + *d).collect()
}

fn summarise(areas: &Areas, faces: &[OfFace], persons: &Persons) -> Vec<AreaErrors> {
    areas
        .names
        .iter()
        .enumerate()
        .map(|(a, name)| {
            let of = |value: &dyn Fn(&Errors) -> f64| -> Interval {
                let each = faces.iter().map(|(errors, _)| value(&errors[a]));
                Interval::of(&persons.means(&each.collect::<Vec<_>>()))
            };
            let percent = |value: &dyn Fn(&Errors) -> f64| -> f64 {
                let each = faces
                    .iter()
                    .map(|(errors, diameter)| 100.0 * value(&errors[a]) / diameter);
                let means = persons.means(&each.collect::<Vec<_>>());
                means.iter().sum::<f64>() / means.len() as f64
            };
            AreaErrors {
                area: name.clone(),
                max: of(&|e| e.max),
                mean: of(&|e| e.mean),
                rms: of(&|e| e.rms),
                rms_percent: percent(&|e| e.rms),
                max_percent: percent(&|e| e.max),
                mean_percent: percent(&|e| e.mean),
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_students() {
        // Tables of t at 97.5 %.
        for (degrees, t) in [
            (1, 12.706),
            (4, 2.776),
            (9, 2.262),
            (10, 2.228),
            (29, 2.045),
            (299, 1.968),
        ] {
            assert!((student_t(degrees) - t).abs() < 0.003, "{degrees}");
        }
        let one = Interval::of(&[1.0]);
        assert_eq!(
            (one.low, one.mean, one.high),
            (f64::NEG_INFINITY, 1.0, f64::INFINITY)
        );
        let interval = Interval::of(&[1.0, 2.0, 3.0, 4.0]);
        assert_eq!(interval.mean, 2.5);
        // 3.182 times the standard error, sqrt(5 / 3) / 2.
        assert!((interval.high - 2.5 - 3.182 * (5.0_f64 / 3.0).sqrt() / 2.0).abs() < 1e-9);
    }
}
