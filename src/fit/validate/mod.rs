//! The evidence: what a population is like, and how well a model learned from it describes faces
//! that it has not seen (region morphing, section 7; semantic reshaping, section 5.1).
//!
//! [`validate`] computes every number into a [`Report`], which is written as JSON; [`page`] draws
//! and writes it for people.

pub mod areas;
pub mod bases;
pub mod curves;
pub mod held_out;
pub mod normality;
pub mod page;
mod pictures;
mod plots;

use std::collections::BTreeMap;

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use serde::Serialize;

use crate::blob::pack;
use crate::fit::head::template::Template;
use crate::fit::learn::crease::{Seam, seams};
use crate::fit::learn::persons::Persons;
use crate::fit::learn::{
    BlockReport, FaceReport, Learned, Learner, Settings as Learning, far_beyond,
};
use crate::fit::statistics::pca::Spectrum;
use crate::fit::statistics::subspace::fields;
use crate::fit::truth::population::Labels;
use crate::fit::{FitError, FitResult};
use crate::model::About;
use crate::{FaceModel, Randomize};
use areas::Areas;
use curves::{Curves, curves};
use held_out::{HeldOut, Interval, Pair, cross_validate, whole_faces};
use normality::{Normality, normality};

/// The fewest people of whom a part can be held out and the rest learned from.
const FEWEST: usize = 4;
/// The parts of the variance whose numbers of modes are counted (Table 1).
const COUNTED: [f64; 4] = [0.9, 0.95, 0.98, 0.99];
/// The parts of the variance at which faces are held out.
const TRIED: [f64; 2] = [0.95, 0.99];
/// People whom the paper held out.
const PAPER: usize = 10;
/// Parts into which all faces are split, each of which is held out once.
const FOLDS: usize = 5;
/// Splits of the curves, `[training, test]`: the paper's, and the few scans that most have.
const SPLITS: [[usize; 2]; 2] = [[100, 100], [25, 100]];
/// Random faces whose distance to the population, and whose rounding, is measured.
const RANDOM_FACES: u64 = 100;

/// What to validate.
pub struct Population<'a> {
    /// What the faces are registered to.
    pub template: &'a Template,
    /// What each face is called, in the same order; empty where they have no names.
    pub names: Vec<String>,
    /// Whether the mirror image of each face that is learned from counts as one more.
    pub both_sides: bool,
    /// Registered faces, all vertices, mm, in any pose; in f32, as files of scans have them, since
    /// all of them are kept beside what is learned from most of them.
    pub faces: Vec<Vec<Vec3>>,
    /// Which of them are of one person.
    pub persons: Persons,
    /// What is known of those of whom anything is.
    pub labels: Vec<Labels>,
    /// What a model that is learned from them says of itself.
    pub about: About,
    /// From each vertex of the face to where it belongs, mm, on faces whose truth is known.
    pub drift: Option<Drift>,
}

/// How far registrations put vertices from where they belong.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Drift {
    /// Faces whose truth is known.
    pub faces: usize,
    /// Mean over the face area, mm; the interval is over faces.
    pub mean: Interval,
    /// The distance that 95 % of the vertices stay below, mm.
    pub percentile_95: f64,
}

/// All numbers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// What the population is.
    pub about: About,
    /// Registered faces.
    pub faces: usize,
    /// The number of each face's person, where some have several: these count as one in all means over people.
    #[serde(skip_serializing_if = "Persons::are_single")]
    pub persons: Persons,
    /// Vertices of each.
    pub vertices: usize,
    /// What is known of the faces.
    pub labels: Option<LabelCounts>,
    /// Whether models were learned without the mirror images of faces.
    pub one_sided: bool,
    /// Root mean square distance of each face's skin from the mean after alignment, mm.
    pub alignment: Vec<f64>,
    /// Each face by its name, in the same order.
    pub people: Vec<Person>,
    /// Each feature's region, then the whole head.
    pub modes: Vec<Modes>,
    /// Coefficients, variance and smoothing of each block of the model at tau = 95 %.
    pub blocks: Vec<BlockReport>,
    /// Ten people at random, as in the paper.
    pub ten_held_out: Vec<HeldOut>,
    /// All faces, each held out once.
    pub held_out: Vec<HeldOut>,
    /// How many parts they were split into.
    pub folds: usize,
    /// Error against the number of coefficients.
    pub curves: Vec<Curves>,
    /// The sparse basis beside others; empty unless it was asked for ([`bases::bases`]).
    pub bases: Vec<bases::Bases>,
    /// How near random faces are to people.
    pub specificity: Specificity,
    /// How clean the features' borders are.
    pub seams: Vec<Seam>,
    /// How far the model's file moves vertices.
    pub rounding: Rounding,
    /// Whether the coefficients are normally distributed.
    pub normality: Normality,
    /// How far registration put vertices from where they belong, where that is known.
    pub drift: Option<Drift>,
}

/// How one face stands to the others.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Person {
    /// What it is called, or its number where it has no name.
    pub name: String,
    /// What alignment left, and its size.
    #[serde(flatten)]
    pub face: FaceReport,
    /// Root mean square distance over the features between it and what a model at 95 % gives back that was learned from
    /// others, mm.
    pub held_out: f64,
    /// By how many robust standard deviations it is farther from the mean than others, or larger or smaller, where that is
    /// far beyond them ([`far_beyond`]).
    pub far: Option<f64>,
}

/// What the faces are labelled with.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LabelCounts {
    /// Faces that are more female than male, and the others.
    pub sex: [usize; 2],
    /// Faces a decade of age, from that of the first number on.
    pub decades: BTreeMap<u32, usize>,
    /// Faces by their greatest share of african, asian and caucasian.
    pub ethnicity: [usize; 3],
}

impl LabelCounts {
    fn of(labels: &[Labels]) -> Option<Self> {
        if labels.is_empty() {
            return None;
        }
        let mut counts = Self {
            sex: [0; 2],
            decades: BTreeMap::new(),
            ethnicity: [0; 3],
        };
        for label in labels {
            counts.sex[usize::from(label.sex >= 0.5)] += 1;
            *counts
                .decades
                .entry(label.age as u32 / 10 * 10)
                .or_default() += 1;
            let shares = label.ethnicity;
            let greatest = (0..3).max_by(|&a, &b| shares[a].total_cmp(&shares[b]));
            counts.ethnicity[greatest.unwrap_or_default()] += 1;
        }
        Some(counts)
    }
}

/// How a part of the head varies (Table 1, Fig. 6).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Modes {
    /// The part.
    pub name: String,
    /// The fewest modes that keep 90, 95, 98 and 99 % of its variance.
    pub counts: [usize; 4],
    /// The part of the variance that the first 1, 2, ... modes have: compactness.
    pub cumulative: Vec<f64>,
}

impl Modes {
    fn of(name: &str, spectrum: &Spectrum) -> FitResult<Self> {
        let mut counts = [0; 4];
        for (count, tau) in counts.iter_mut().zip(COUNTED) {
            *count = spectrum.modes_for(tau)?;
        }
        let all = spectrum.eigenvalues.len();
        Ok(Self {
            name: name.into(),
            counts,
            cumulative: (1..=all).map(|k| spectrum.explained(k)).collect(),
        })
    }
}

/// The mean distance of the skin of random faces to the nearest face of the population, mm, and the
/// same from each face of the population to the nearest one of another person.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Specificity {
    /// Random faces of the model.
    pub regions: Interval,
    /// Random faces of a PCA of whole faces with as many coefficients.
    pub whole_face: Interval,
    /// Between people.
    pub population: Interval,
}

/// What rounding costs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rounding {
    /// Bytes of the model's file.
    pub bytes: usize,
    /// Root mean square distance of the vertices of random faces of the file from those of the
    /// bases before they were rounded, mm.
    pub rms: f64,
}

/// A report, and what its pictures are drawn from.
pub struct Validated<'a> {
    /// The numbers.
    pub report: Report,
    template: &'a Template,
    model: FaceModel,
    pairs: Vec<Pair>,
}

/// How many times [`validate`] calls its `done`.
pub const STEPS: u64 = (3 + FOLDS + 1 + SPLITS.len()) as u64;

/// Computes the report. Calls `done` with what comes next, [`STEPS`] times.
///
/// Whoever has several scans is held out with all of them, and counts once in what is found of the others and in what is
/// learned.
///
/// # Errors
/// With fewer than 4 people, of whom none can be held out, or persons of other faces; and as [`Learner::new`].
pub fn validate<'a>(
    population: Population<'a>,
    mut done: impl FnMut(&'static str),
) -> FitResult<Validated<'a>> {
    let Population {
        template,
        names,
        both_sides,
        faces,
        persons,
        labels,
        about,
        drift,
    } = population;
    persons.check(faces.len())?;
    let count_of_people = persons.count();
    if count_of_people < FEWEST {
        return Err(FitError::Input(format!(
            "{} too few to hold any out and learn from the others; {FEWEST} is the least",
            persons.said_to_be()
        )));
    }
    let settings = Learning {
        both_sides,
        ..Learning::default()
    };
    let areas = Areas::new(template)?;

    done("learning");
    let learner = Learner::new(template, wide(&faces), &persons, &settings)?;
    let mut modes = (learner.features())
        .map(|(name, spectrum)| Modes::of(name, spectrum))
        .collect::<FitResult<Vec<_>>>()?;
    let bases = learner.bases(settings.tau)?;
    let count = bases.modes.len();
    let mean = learner.mean.clone();
    let learned = learner.model(bases, about, settings.semantic)?;
    let file = pack(&learned.parts.write()?)?;
    let model = FaceModel::parse(&file)?;

    done("random faces");
    let whole = whole_faces(
        &learned.aligned,
        &mean,
        &areas.skin,
        both_sides.then_some(template),
    )?;
    modes.push(Modes::of("whole face", &whole)?);
    let whole_modes = on_all_vertices(&whole.truncate(count), &areas.skin, template);
    let controls: Vec<String> = model
        .parts()
        .controls
        .iter()
        .filter(|c| c.measure.is_none())
        .map(|c| c.name.clone())
        .collect();
    let normality = normality(&controls, &learned.coefficients);
    let rounding = Rounding {
        bytes: file.len(),
        rms: rounding(&learned, &model)?,
    };
    let specificity = specificity(&learned, &model, &whole_modes, &areas.skin)?;
    done("seams");
    let kept = whole.modes_for(settings.tau)?;
    let seams = seams(template, &model, &whole_modes[..kept], &|face| face)?;
    let Learned {
        parts,
        blocks,
        faces: each,
        aligned,
        ..
    } = learned;
    // From here on other models are learned; of this one the file is enough.
    drop((whole, whole_modes, aligned));

    done("holding out ten faces");
    // Of as few as may be, one is held out: the others are what is learned from.
    let held = PAPER
        .min(count_of_people / 2)
        .min(count_of_people + 1 - FEWEST);
    let hold_out = |tests: &[Vec<usize>], done: &mut dyn FnMut()| {
        cross_validate(template, &faces, &persons, tests, &TRIED, &settings, done)
    };
    let (ten_held_out, pairs) = hold_out(&[persons.draw(held, 10)], &mut || ())?;
    let parts_of = FOLDS.min(count_of_people);
    let (held_out, _) = hold_out(&persons.folds(parts_of, 5), &mut || {
        done("holding out every face");
    })?;
    let mut split = Vec::new();
    for [training, test] in SPLITS {
        done("error against the number of coefficients");
        if count_of_people >= training + FEWEST {
            let counts = [training, test];
            split.push(curves(template, &faces, &persons, counts, 100, &settings)?);
        }
    }
    Ok(Validated {
        report: Report {
            about: parts.about,
            faces: faces.len(),
            persons,
            vertices: template.positions.len(),
            labels: LabelCounts::of(&labels),
            one_sided: !both_sides,
            alignment: each.iter().map(|face| face.alignment).collect(),
            people: people(names, &each, &held_out[0]),
            modes,
            blocks,
            ten_held_out,
            held_out,
            folds: parts_of,
            curves: split,
            bases: Vec::new(),
            specificity,
            seams,
            rounding,
            normality,
            drift,
        },
        template,
        model,
        pairs,
    })
}

/// Each face with its name, and the error of the first time that it was held out.
fn people(names: Vec<String>, faces: &[FaceReport], held_out: &HeldOut) -> Vec<Person> {
    let number = |i: usize| format!("face {i}");
    let mut people: Vec<Person> = (faces.iter().enumerate())
        .map(|(i, &face)| Person {
            name: names.get(i).cloned().unwrap_or_else(|| number(i)),
            face,
            held_out: f64::NAN,
            far: None,
        })
        .collect();
    for &(face, rms) in &held_out.faces {
        people[face].held_out = rms;
    }
    for (face, far, _) in far_beyond(faces).into_iter().rev() {
        people[face].far = Some(far);
    }
    people
}

/// Modes of the skin as displacements of all vertices, mm a sigma; what is not skin stays.
fn on_all_vertices(
    pca: &crate::fit::statistics::pca::Pca,
    skin: &[u32],
    template: &Template,
) -> Vec<Vec<DVec3>> {
    pca.modes
        .par_iter()
        .zip(&pca.sigmas)
        .map(|(mode, sigma)| {
            let mut field = vec![DVec3::ZERO; template.positions.len()];
            for (&v, d) in skin.iter().zip(mode.chunks_exact(3)) {
                field[v as usize] = DVec3::from_slice(d) * *sigma;
            }
            field
        })
        .collect()
}

/// Faces in the precision of learning.
fn wide<'a>(faces: impl IntoIterator<Item = &'a Vec<Vec3>>) -> Vec<Vec<DVec3>> {
    let one = |face: &Vec<Vec3>| face.iter().map(|p| p.as_dvec3()).collect();
    faces.into_iter().map(one).collect()
}

fn random_face(model: &FaceModel, seed: u64) -> FitResult<crate::Face> {
    let mut face = model.face();
    face.randomize(&Randomize {
        seed: Some(seed),
        ..Randomize::default()
    })?;
    Ok(face)
}

fn positions(face: &crate::Face) -> Vec<DVec3> {
    face.positions().iter().map(|p| p.as_dvec3()).collect()
}

/// How far the vertices of random faces of a file are from the same faces of the bases before they
/// were rounded, mm RMS.
///
/// # Errors
/// When the model has other coefficients than the bases.
pub fn rounding(learned: &Learned, model: &FaceModel) -> FitResult<f64> {
    let n = learned.parts.mean.len();
    let random = (0..RANDOM_FACES)
        .into_par_iter()
        .map(|seed| random_face(model, seed))
        .collect::<FitResult<Vec<_>>>()?;
    let wide = |face: &crate::Face| face.coefficients().iter().map(|&c| f64::from(c)).collect();
    let coefficients: Vec<Vec<f64>> = random.iter().map(wide).collect();
    let exact = fields(&learned.modes, &coefficients);
    let squares: Vec<f64> = (random.par_iter().zip(&exact))
        .map(|(face, exact)| {
            let off = face.positions().iter().zip(learned.mean.iter().zip(exact));
            off.map(|(p, (m, d))| p.as_dvec3().distance_squared(*m + *d))
                .sum()
        })
        .collect();
    Ok((squares.iter().sum::<f64>() / (RANDOM_FACES as f64 * n as f64)).sqrt())
}

fn specificity(
    learned: &Learned,
    model: &FaceModel,
    whole_modes: &[Vec<DVec3>],
    skin: &[u32],
) -> FitResult<Specificity> {
    let mean: Vec<DVec3> = model.parts().mean.iter().map(|p| p.as_dvec3()).collect();
    let people = &learned.aligned;
    // Mean distance to the nearest of people, but for one person; who is farther already is not followed further.
    let nearest = |face: &[DVec3], but: Option<usize>| {
        let is_other = |(i, _): &(usize, &Vec<DVec3>)| Some(*i) != but;
        let others = people.iter().enumerate().filter(is_other);
        let least = others.fold(f64::INFINITY, |least, (_, other)| {
            let mut sum = 0.0;
            for some in skin.chunks(512) {
                let apart = some
                    .iter()
                    .map(|&v| face[v as usize].distance(other[v as usize]));
                sum += apart.sum::<f64>();
                if sum >= least {
                    return least;
                }
            }
            sum
        });
        least / skin.len() as f64
    };
    let regions = (0..RANDOM_FACES)
        .into_par_iter()
        .map(|seed| Ok(nearest(&positions(&random_face(model, seed)?), None)))
        .collect::<FitResult<Vec<f64>>>()?;
    let coefficients: Vec<Vec<f64>> = (0..RANDOM_FACES)
        .map(|seed| {
            let mut random = crate::Random::new(seed);
            whole_modes.iter().map(|_| random.normal()).collect()
        })
        .collect();
    let whole: Vec<f64> = (fields(whole_modes, &coefficients).par_iter())
        .map(|field| nearest(&held_out::plus(&mean, field), None))
        .collect();
    let between: Vec<f64> = (people.par_iter().enumerate())
        .map(|(i, face)| nearest(face, Some(i)))
        .collect();
    Ok(Specificity {
        regions: Interval::of(&regions),
        whole_face: Interval::of(&whole),
        population: Interval::of(&between),
    })
}
