//! What the labels of a population tell of the faces of a model.
//!
//! The labelled people need not be those of the model: all faces of one template can be written in
//! its coefficients, by penalised least squares with the model's own prior. The mean change of these
//! coefficients with a label is the label's direction, and its read-out is the one whose most
//! probable change, given that it goes up by one, is that direction: with d the direction and R the
//! correlation of the coefficients, w = R^-1 d / (d . R^-1 d). People of a label then read it on
//! average, with nothing lost to regression towards the mean, and a face drawn from the model's
//! population given the read-out is on average the mean face of that label.
//!
//! Where the people of a model stand among labelled ones who are not the same is not known: what an
//! artist's heads and scans differ by would be taken for a label. So the read-out is counted from the
//! mean face, which stands for the mean of the labels.

use std::ops::Range;

use faer::linalg::solvers::{Llt, Solve};
use faer::{Mat, Side};
use glam::DVec3;
use rayon::prelude::*;

use super::labels::Labels;
use crate::FaceModel;
use crate::fit::head::generic_head::ETHNICITIES;
use crate::fit::head::template::Template;
use crate::fit::likeness::{Likenesses, correlation};
use crate::fit::mesh::align::vertex_areas;
use crate::fit::{FitError, FitResult};
use crate::model::Attribute;

/// The labelled people are held out in so many parts, each once.
const FOLDS: usize = 5;

/// Of the order in which they are, which is not that of their names.
const SEED: u64 = 5;

/// A label of which less is explained is none that the model's faces tell: read-outs and labels
/// are correlated by less than a half.
const LEAST_EXPLAINED: f32 = 0.25;

/// A model holds no greater numbers of a label.
const LARGEST: f32 = 1e6;

/// A label's name, and its value of each face of which it is known.
type Label = (String, Vec<Option<f64>>);

/// What is said of a label: unit and meaning.
fn meaning(name: &str) -> (&'static str, &'static str) {
    match name {
        "age" => ("years", "age"),
        "sex" => ("share", "sex, from 0 for female to 1 for male"),
        "weight" => ("amount", "weight, from 0 for thin to 1 for heavy"),
        "muscle" => ("amount", "muscle, from 0 for slight to 1 for muscular"),
        name if ETHNICITIES.contains(&name) => ("share", "share of that shape"),
        _ => ("", "label"),
    }
}

/// Attributes and how well they tell the labels.
#[derive(Debug, Clone, PartialEq)]
pub struct Learned {
    /// One a label that could be learned.
    pub told: Vec<Outcome>,
    /// The others.
    pub skipped: Vec<Skipped>,
    /// What the model leaves of the labelled faces' skin, mm RMS.
    pub left: f64,
}

/// Labels that are learned together, and why they are not.
pub type Skipped = (Vec<String>, String);

/// What came of a label.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// The attribute.
    pub attribute: Attribute,
    /// Of how many people the label is known.
    pub people: usize,
    /// The root mean square by which read-outs of held-out people, counted from the mean of all
    /// labelled people, miss their labels, in the label's unit. Of one person's faces it is the mean of the squares.
    pub error: f64,
    /// The length of its direction for a standard deviation of the label, sigmas.
    pub length: f64,
}

impl Learned {
    /// Those that the model's faces tell: a quarter of the label's variance at least.
    pub fn attributes(&self) -> impl Iterator<Item = &Attribute> {
        let all = self.told.iter().map(|told| &told.attribute);
        all.filter(|attribute| attribute.explained >= LEAST_EXPLAINED)
    }
}

/// Learns the attributes of a model from labelled faces in the template's topology (mm, any pose),
/// who are called `source`. A label that cannot be learned, for too few have it or differ in it, is skipped.
///
/// A label is taken to be the same for a person and the mirror image: where each mode of the model is one or the
/// opposite of it ([`crate::model::ModelParts::odd`]), the part of the faces that is unlike on their two sides tells
/// nothing of it, and how some people happen to be crooked is not read as their age.
///
/// A person counts once, however many of the faces are theirs, and is held out with all of them.
///
/// # Errors
/// With fewer people than what else is known of each would need, without labels, when one of them is not finite or none
/// can be learned, or with a model that does not vary.
pub fn learn(
    template: &Template,
    model: &FaceModel,
    faces: &[Vec<DVec3>],
    labels: &Labels,
    source: &str,
) -> FitResult<Learned> {
    if model.parts().population() == 0 {
        let cause = "the model has one face, which tells no label";
        return Err(FitError::Input(cause.into()));
    }
    let persons = &labels.persons;
    if persons.faces() != faces.len() {
        let (told, there) = (persons.faces(), faces.len());
        let cause = format!("the labels are those of {told} faces, and not of these {there}");
        return Err(FitError::Input(cause));
    }
    let least = 2 * (FOLDS + labels.besides.len());
    if persons.count() < least {
        let (said, besides) = (persons.said_to_be(), labels.besides.len());
        let why = match besides {
            0 => String::new(),
            _ => format!(
                ": two for each of the {besides} numbers that are known of them besides, whose part is taken out first, \
                 and {} more",
                2 * FOLDS
            ),
        };
        let cause = format!("{said} too few to tell labels by; {least} people are the least{why}");
        return Err(FitError::Input(cause));
    }
    for (name, values) in &labels.told {
        let odd = |value: &Option<f64>| value.is_some_and(|value| !value.is_finite());
        if let Some(face) = values.iter().position(odd) {
            let cause = format!("label {name:?} of face {face} is not finite");
            return Err(FitError::Input(cause));
        }
    }
    if labels.together.is_empty() {
        let cause = "no label of these faces is known";
        return Err(FitError::Input(cause.into()));
    }
    if model.parts().mean.len() != template.positions.len()
        || model.parts().topology.uv_triangles != template.topology.uv_triangles
    {
        let cause = "the model is of another head than the template";
        return Err(FitError::Input(cause.into()));
    }
    let areas = vertex_areas(&template.positions, &template.triangles());
    let (coefficients, left) = Likenesses::new(model, areas)?.of(faces)?;
    let mut without = residual(&coefficients, &labels.besides)?;
    symmetrise(&mut without, &model.parts().odd());
    let correlation = correlation(model);
    let prior = correlation
        .llt(Side::Lower)
        .map_err(|_| FitError::Input("the model's correlation is not definite".into()))?;
    let one = |own: &Range<usize>| -> Result<(Vec<Outcome>, Option<Skipped>), Skipped> {
        let together: Vec<&Label> = labels.told[own.clone()].iter().collect();
        let has = |f: &usize| together.iter().all(|label| label.1[*f].is_some());
        let all: Vec<usize> = (0..faces.len()).filter(has).collect();
        let people = persons.some(&all);
        let count = people.count();
        // Of whom it is not known nothing is read.
        let read = |label: &&Label| label.1.iter().map(|x| x.unwrap_or(f64::NAN)).collect();
        let skipped = |labels: &[&Label], why: String| {
            (labels.iter().map(|label| label.0.clone()).collect(), why)
        };
        if count < 2 * FOLDS {
            let why = format!(
                "known of {count} people, where {} are the fewest",
                2 * FOLDS
            );
            return Err(skipped(&together, why));
        }
        // A share that nobody has, or all have as much of, leaves the others to be learned.
        let is_still = |label: &&Label| all.iter().all(|&f| label.1[f] == label.1[all[0]]);
        let (still, labels): (Vec<&Label>, Vec<&Label>) = together.into_iter().partition(is_still);
        let same = format!("the same for all {count} people of whom it is known");
        if labels.is_empty() {
            return Err(skipped(&still, same));
        }
        for label in &labels {
            let known: Vec<f64> = all.iter().filter_map(|&f| label.1[f]).collect();
            let [least, most] = round_limits(&known).map(|limit| limit as f32);
            if !(least < most && least.abs().max(most.abs()) <= LARGEST) {
                let why = format!(
                    "from {least} to {most}, where a model holds seven digits of numbers up to {LARGEST}: in another \
                     unit it can be learned"
                );
                return Err(skipped(&labels, why));
            }
        }
        let values: Vec<Vec<f64>> = labels.iter().map(read).collect();
        let values: Vec<&[f64]> = values.iter().map(|values| &values[..]).collect();
        let mut weights = vec![0.0; faces.len()];
        for (&f, weight) in all.iter().zip(people.weights()) {
            weights[f] = weight;
        }
        let data = Data {
            without: &without,
            coefficients: &coefficients,
            weights: &weights,
            prior: &prior,
        };
        let one_way = || {
            let why = match labels.len() {
                1 => "what it differs in is lost in the rounding of its numbers",
                _ => "one of its shares goes with another, and does not vary by itself",
            };
            skipped(&labels, why.into())
        };
        let readouts = data.learn(&values, &all).ok_or_else(one_way)?;
        let mut sums = vec![[0.0; 3]; labels.len()];
        for held in people.folds(FOLDS, SEED) {
            let mut is_held = vec![false; faces.len()];
            held.iter().for_each(|&i| is_held[all[i]] = true);
            let known = all.iter().copied().filter(|&f| !is_held[f]);
            let known: Vec<usize> = known.collect();
            let rare = || {
                let why = "so few people differ in it that, without a fifth of all, none do: it cannot be tried on \
                           others";
                skipped(&labels, why.into())
            };
            let learned = data.learn(&values, &known).ok_or_else(rare)?;
            for ((readout, values), sums) in learned.iter().zip(&values).zip(&mut sums) {
                for f in held.iter().map(|&i| all[i]) {
                    let reads = readout.read(&coefficients[f]);
                    let (centre, value) = (readout.centre, values[f]);
                    let guess = centre + readout.slope * (reads - centre);
                    for (sum, off) in sums.iter_mut().zip([reads, guess, centre]) {
                        *sum += weights[f] * (off - value).powi(2);
                    }
                }
            }
        }
        let told = readouts.into_iter().zip(&labels).zip(sums);
        let told = told.map(|((readout, (name, values)), [missed, guessed, total])| {
            let (unit, means) = meaning(name);
            let values: Vec<f64> = all.iter().filter_map(|&f| values[f]).collect();
            let limits = round_limits(&values);
            let attribute = Attribute {
                name: name.clone(),
                description: format!("{means}, as {source} have it"),
                unit: unit.into(),
                limits: limits.map(|limit| limit as f32),
                mean: readout.centre as f32,
                explained: (1.0 - guessed / total).clamp(0.0, 1.0) as f32,
                reading: readout.weights.iter().map(|&w| w as f32).collect(),
            };
            Outcome {
                attribute,
                people: count,
                error: (missed / count as f64).sqrt(),
                length: readout.length,
            }
        });
        let left_out = (!still.is_empty()).then(|| skipped(&still, same));
        Ok((told.collect(), left_out))
    };
    let each: Vec<_> = labels.together.par_iter().map(one).collect();
    let (mut told, mut skipped) = (Vec::new(), Vec::new());
    for outcome in each {
        match outcome {
            Ok((some, left_out)) => {
                told.extend(some);
                skipped.extend(left_out);
            }
            Err(why) => skipped.push(why),
        }
    }
    if told.is_empty() {
        let why = skipped
            .iter()
            .map(|(names, why)| format!("{}: {why}", names.join(", ")));
        let why: Vec<String> = why.collect();
        let cause = format!("no label can be learned; {}", why.join("; "));
        return Err(FitError::Input(cause));
    }
    Ok(Learned {
        told,
        skipped,
        left,
    })
}

/// What a person and the mirror image have in common: with each label once of both, sums over all of them have nothing
/// of `odd` modes.
fn symmetrise(coefficients: &mut [Vec<f64>], odd: &[bool]) {
    for row in coefficients {
        let own = row.iter_mut().zip(odd);
        own.filter(|(_, odd)| **odd).for_each(|(c, _)| *c = 0.0);
    }
}

/// What read-outs are learned from.
struct Data<'a> {
    coefficients: &'a [Vec<f64>],
    /// Those less what else is known of the people.
    without: &'a [Vec<f64>],
    /// How much each face counts.
    weights: &'a [f64],
    /// The factor of the model's correlation.
    prior: &'a Llt<f64>,
}

/// A label as a linear function of coefficients.
struct Readout {
    weights: Vec<f64>,
    /// Of the coefficients 0, where people of all labels read their mean.
    origin: f64,
    /// The mean of the labels.
    centre: f64,
    /// Of the best guess of a label by its read-out.
    slope: f64,
    /// Of the direction, sigmas for a standard deviation of the label.
    length: f64,
}

impl Data<'_> {
    /// The read-outs of labels that are learned together, from some faces: with D their directions
    /// R^-1 D (D' R^-1 D)^-1. `None` when one of them does not vary, or not by itself.
    fn learn(&self, labels: &[&[f64]], some: &[usize]) -> Option<Vec<Readout>> {
        let weight = |f: usize| self.weights[some[f]];
        let count: f64 = (0..some.len()).map(weight).sum();
        let (g, k) = (labels.len(), self.coefficients[0].len());
        let mean = |values: &[f64]| {
            let each = some.iter().map(|&f| self.weights[f] * values[f]);
            each.sum::<f64>() / count
        };
        let centres: Vec<f64> = labels.iter().map(|values| mean(values)).collect();
        let y = Mat::from_fn(some.len(), g, |f, l| labels[l][some[f]] - centres[l]);
        // What is left of equal numbers about their mean is rounding.
        let largest = |l: usize| some.iter().map(|&f| labels[l][f].abs()).fold(0.0, f64::max);
        let varies = |l: usize| (0..some.len()).any(|f| y[(f, l)].abs() > 1e-12 * largest(l));
        if !(0..g).all(varies) {
            return None;
        }
        let c = Mat::from_fn(some.len(), k, |f, i| self.without[some[f]][i]);
        let weighted = Mat::from_fn(some.len(), g, |f, l| weight(f) * y[(f, l)]);
        let directions = c.transpose() * &weighted * inverse(y.transpose() * &weighted)?;
        let pulled = self.prior.solve(&directions);
        let squares = directions.transpose() * &pulled;
        let weights = pulled * inverse(squares.clone())?;
        let readouts = (0..g).map(|l| {
            let weights: Vec<f64> = (0..k).map(|i| weights[(i, l)]).collect();
            let reads = some.iter().map(|&f| dot(&weights, &self.coefficients[f]));
            let reads: Vec<f64> = reads.collect();
            let each = reads.iter().enumerate();
            let middle = each.clone().map(|(f, r)| weight(f) * r).sum::<f64>() / count;
            let (mut both, mut own, mut variance) = (0.0, 0.0, 0.0);
            for (f, r) in each {
                both += weight(f) * (r - middle) * y[(f, l)];
                own += weight(f) * (r - middle).powi(2);
                variance += weight(f) * y[(f, l)].powi(2) / count;
            }
            Readout {
                weights,
                origin: centres[l] - middle,
                centre: centres[l],
                slope: both / own,
                length: (squares[(l, l)] * variance).sqrt(),
            }
        });
        Some(readouts.collect())
    }
}

impl Readout {
    fn read(&self, coefficients: &[f64]) -> f64 {
        self.origin + dot(&self.weights, coefficients)
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The inverse of a positive definite matrix, or of one of shares: these sum to 1, so that the rows
/// sum to nothing. To add a constant to all of its elements makes that one definite, and changes
/// nothing in what it is multiplied with here, whose rows sum to nothing too.
fn inverse(mut matrix: Mat<f64>) -> Option<Mat<f64>> {
    let g = matrix.nrows();
    let trace: f64 = (0..g).map(|i| matrix[(i, i)]).sum();
    if g > 1 {
        let constant = Mat::from_fn(g, g, |_, _| trace / (g * g) as f64);
        matrix += constant;
    }
    let factor = matrix.llt(Side::Lower).ok()?;
    // Of one that is not definite rounding may leave a pivot of some 1e-16 of it.
    let definite = (0..g).all(|i| factor.L()[(i, i)].powi(2) > 1e-12 * trace);
    definite.then(|| factor.solve(Mat::<f64>::identity(g, g)))
}

/// Coefficients, each less its linear least squares by what else is known of the people.
fn residual(coefficients: &[Vec<f64>], besides: &[Vec<f64>]) -> FitResult<Vec<Vec<f64>>> {
    let (people, k) = (coefficients.len(), coefficients[0].len());
    let mean = |column: &dyn Fn(usize) -> f64| (0..people).map(column).sum::<f64>() / people as f64;
    let middles: Vec<f64> = (0..k).map(|i| mean(&|f| coefficients[f][i])).collect();
    let known: Vec<Vec<f64>> = (besides.iter())
        .map(|column| {
            let middle = mean(&|f| column[f]);
            column.iter().map(|x| x - middle).collect()
        })
        .collect();
    let a = Mat::from_fn(people, known.len(), |f, i| known[i][f]);
    let b = Mat::from_fn(people, k, |f, i| coefficients[f][i] - middles[i]);
    let mut normal = a.transpose() * &a;
    (0..known.len()).for_each(|i| normal[(i, i)] = normal[(i, i)] * (1.0 + 1e-9) + 1e-12);
    let factor = normal.llt(Side::Lower);
    let factor = factor.map_err(|_| FitError::Input("labels that are sums of others".into()))?;
    let told = &a * factor.solve(a.transpose() * &b);
    Ok((0..people)
        .map(|f| (0..k).map(|i| b[(f, i)] - told[(f, i)]).collect())
        .collect())
}

/// The least and the greatest of some labels, outwards to a tenth of their range's power of ten: a sex
/// of 1 and an age of 18 may be asked for where labels reach 0.9999 and 18.03.
fn round_limits(values: &[f64]) -> [f64; 2] {
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    // Of equal labels nothing is learned.
    let tens = (most - least).max(f64::MIN_POSITIVE).log10().floor();
    let parts = 10_f64.powi(1 - tens as i32);
    [
        (least * parts).floor() / parts,
        (most * parts).ceil() / parts,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;

    #[test]
    fn limits_are_round_and_hold_all_labels() {
        assert_eq!(round_limits(&[0.00008, 0.3, 0.99991]), [0.0, 1.0]);
        assert_eq!(round_limits(&[18.03, 52.0, 89.9]), [18.0, 90.0]);
        assert_eq!(round_limits(&[-0.52, 0.5]), [-0.6, 0.5]);
    }

    #[test]
    fn people_of_a_label_read_it_and_a_change_of_one_share_is_one_of_the_others() {
        let mut random = Random::new(4);
        let (people, k) = (3000, 8);
        let directions: Vec<[f64; 4]> = (0..k)
            .map(|_| [0; 4].map(|_| 1.5 * random.normal()))
            .collect();
        let (mut labels, mut coefficients) = (vec![Vec::new(); 4], Vec::new());
        for _ in 0..people {
            let drawn = [0; 3].map(|_| random.uniform());
            let sum: f64 = drawn.iter().sum();
            let told = [
                drawn[0] / sum,
                drawn[1] / sum,
                drawn[2] / sum,
                random.uniform(),
            ];
            labels.iter_mut().zip(told).for_each(|(l, x)| l.push(x));
            let of = |d: &[f64; 4]| dot(d, &told) + 0.3 * random.normal();
            coefficients.push(directions.iter().map(of).collect::<Vec<f64>>());
        }
        let prior = Mat::<f64>::identity(k, k).llt(Side::Lower).unwrap();
        let data = Data {
            coefficients: &coefficients,
            without: &coefficients,
            weights: &vec![1.0; people],
            prior: &prior,
        };
        let all: Vec<usize> = (0..people).collect();
        let values: Vec<&[f64]> = labels.iter().map(|l| &l[..]).collect();
        let shares = data.learn(&values[..3], &all).unwrap();
        for (l, readout) in shares.iter().enumerate() {
            for other in 0..3 {
                let along: Vec<f64> = directions.iter().map(|d| d[other]).collect();
                let mean: Vec<f64> = directions
                    .iter()
                    .map(|d| (d[0] + d[1] + d[2]) / 3.0)
                    .collect();
                let moved = dot(&readout.weights, &along) - dot(&readout.weights, &mean);
                let wanted = f64::from(u8::from(l == other)) - 1.0 / 3.0;
                // A slope by 3,000 people whose shares vary by 0.15 with noise 0.3 is off by 0.04
                // a standard error.
                assert!((moved - wanted).abs() < 0.2, "{l}, {other}: {moved}");
            }
        }
        for one in &coefficients {
            let sum: f64 = shares.iter().map(|r| r.read(one)).sum();
            // Exact but for the rounding of solves.
            assert!((sum - 1.0).abs() < 1e-6, "shares sum to {sum}");
        }
        let still = vec![0.5; people];
        assert!(data.learn(&[&still], &all).is_none());
        // Nor are shares of which one is nobody's, or of which two go together; without the one, the others are.
        let some: Vec<f64> = values[3].to_vec();
        let rest: Vec<f64> = some.iter().map(|x| 1.0 - x).collect();
        let halves: Vec<f64> = some.iter().map(|x| 0.5 * x).collect();
        let none = vec![0.0; people];
        assert!(data.learn(&[&none, &some, &rest], &all).is_none());
        assert!(data.learn(&[&halves, &halves, &rest], &all).is_none());
        let [one, other] = &data.learn(&[&some, &rest], &all).unwrap()[..] else {
            panic!("two")
        };
        for coefficients in &coefficients[..10] {
            // Exact but for the rounding of solves.
            let sum = one.read(coefficients) + other.read(coefficients);
            assert!((sum - 1.0).abs() < 1e-9, "{sum}");
        }
    }

    #[test]
    fn a_person_with_more_scans_counts_as_much_as_others() {
        let mut random = Random::new(6);
        let labels: Vec<f64> = (0..12).map(|_| random.normal()).collect();
        let rows = labels
            .iter()
            .map(|y| vec![y + random.normal(), random.normal()]);
        let coefficients: Vec<Vec<f64>> = rows.collect();
        let prior = Mat::<f64>::identity(2, 2).llt(Side::Lower).unwrap();
        let read = |some: &[usize], weights: &[f64]| {
            let data = Data {
                coefficients: &coefficients,
                without: &coefficients,
                weights,
                prior: &prior,
            };
            let readout = data.learn(&[&labels], some).unwrap().remove(0);
            let own = [
                readout.origin,
                readout.centre,
                readout.slope,
                readout.length,
            ];
            [&own[..], &readout.weights].concat()
        };
        let once: Vec<usize> = (0..12).collect();
        // The third person has three scans.
        let thrice: Vec<usize> = once.iter().copied().chain([2, 2]).collect();
        let mut weights = vec![1.0; 12];
        let plain = read(&once, &weights);
        weights[2] = 1.0 / 3.0;
        let weighted = read(&thrice, &weights);
        // The same sums in another order.
        let apart = |a: &[f64], b: &[f64]| a.iter().zip(b).any(|(a, b)| (a - b).abs() > 1e-9);
        assert!(!apart(&plain, &weighted), "{plain:?} {weighted:?}");
        assert!(apart(&plain, &read(&thrice, &[1.0; 12])));
    }

    #[test]
    fn what_is_unlike_on_two_sides_tells_no_label() {
        let mut random = Random::new(9);
        let labels: Vec<f64> = (0..40).map(|_| random.normal()).collect();
        // The second mode is odd, and by chance these people lean to one side with the label.
        let rows = labels
            .iter()
            .map(|y| vec![y + 0.1 * random.normal(), 0.5 * y]);
        let coefficients: Vec<Vec<f64>> = rows.collect();
        let images = coefficients.iter().map(|row| vec![row[0], -row[1]]);
        let both: Vec<Vec<f64>> = coefficients.iter().cloned().chain(images).collect();
        let prior = Mat::<f64>::identity(2, 2).llt(Side::Lower).unwrap();
        let weights = |coefficients: &[Vec<f64>], without: &[Vec<f64>], labels: &[f64]| {
            let data = Data {
                coefficients,
                without,
                weights: &vec![1.0; labels.len()],
                prior: &prior,
            };
            let all: Vec<usize> = (0..labels.len()).collect();
            data.learn(&[labels], &all).unwrap()[0].weights.clone()
        };
        let mut without = coefficients.clone();
        symmetrise(&mut without, &[false, true]);
        let own = weights(&coefficients, &without, &labels);
        assert_eq!(own[1], 0.0);
        // As if mirror images were people with the same labels.
        let all = weights(&both, &both, &[&labels[..], &labels].concat());
        assert!(
            all.iter().zip(&own).all(|(a, b)| (a - b).abs() < 1e-9),
            "{all:?} {own:?}"
        );
        assert!(weights(&coefficients, &coefficients, &labels)[1].abs() > 0.1);
    }
}
