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

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use faer::linalg::solvers::{Llt, Solve};
use faer::{Mat, Side};
use glam::DVec3;
use rayon::prelude::*;
use serde_json::Value;

use crate::FaceModel;
use crate::fit::format::text::json;
use crate::fit::head::generic_head::ETHNICITIES;
use crate::fit::head::template::Template;
use crate::fit::mesh::align::{Rigid, vertex_areas};
use crate::fit::statistics::subspace::Subspace;
use crate::fit::{FitError, FitResult};
use crate::model::Attribute;

/// The labelled people are held out in so many parts, each once.
const FOLDS: usize = 5;

/// What a model leaves of a face of others is as smooth as faces are: it counts as so many
/// independent errors, and not as one a coordinate.
const INDEPENDENT: f64 = 300.0;

/// A label of which less is explained is none that the model's faces tell: read-outs and labels
/// are correlated by less than a half.
const LEAST_EXPLAINED: f32 = 0.25;

/// The labels of a population, one value a face.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Labels {
    /// What is learned, by name.
    pub told: Vec<(String, Vec<f64>)>,
    /// Which of these are learned together: shares, which sum to 1, as one, all else alone.
    pub together: Vec<Range<usize>>,
    /// What else is known of each face. Its part of the faces is taken out of them first, so that
    /// it is not taken for that of a label.
    pub besides: Vec<Vec<f64>>,
}

impl Labels {
    /// Reads `labels.json`: an object, which holds an object for each of the named faces. Its
    /// numbers are labels, and so are the three shares of `ethnicity`; the numbers of an object in
    /// it are what else is known.
    ///
    /// # Errors
    /// When the file cannot be read, a face is missing in it, or has other labels than the first.
    pub fn read(path: &Path, names: &[String]) -> FitResult<Self> {
        let all: BTreeMap<String, BTreeMap<String, Value>> = json(path)?;
        let mut labels = Labels::default();
        for (f, name) in names.iter().enumerate() {
            let bad = |why: &str| FitError::file(path, format!("{name}: {why}"));
            let face = all.get(name).ok_or_else(|| bad("it is not there"))?;
            let (mut told, mut together) = (Vec::new(), Vec::new());
            let mut besides = Vec::new();
            for (label, value) in face {
                match value {
                    Value::Number(number) => {
                        together.push(told.len()..told.len() + 1);
                        told.push((label.clone(), number.as_f64()));
                    }
                    Value::Array(shares) if label == "ethnicity" && shares.len() == 3 => {
                        together.push(told.len()..told.len() + 3);
                        let named = ETHNICITIES.map(str::to_owned).into_iter().zip(shares);
                        told.extend(named.map(|(name, share)| (name, share.as_f64())));
                    }
                    Value::Object(more) => besides.extend(more.values().map(Value::as_f64)),
                    _ => return Err(bad(&format!("its {label} is no number"))),
                }
            }
            if f == 0 {
                labels.told = told.iter().map(|t| (t.0.clone(), Vec::new())).collect();
                labels.besides = vec![Vec::new(); besides.len()];
                labels.together = together;
            }
            let same = told.len() == labels.told.len()
                && besides.len() == labels.besides.len()
                && told.iter().zip(&labels.told).all(|(a, b)| a.0 == b.0);
            let numbers = told.into_iter().map(|t| t.1).chain(besides);
            let numbers: Option<Vec<f64>> = numbers.collect();
            let Some(numbers) = numbers.filter(|_| same) else {
                return Err(bad("it has not the labels of the first face, as numbers"));
            };
            let columns = labels.told.iter_mut().map(|t| &mut t.1);
            let columns = columns.chain(&mut labels.besides);
            columns.zip(numbers).for_each(|(c, x)| c.push(x));
        }
        Ok(labels)
    }
}

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
    /// One a label.
    pub told: Vec<Told>,
    /// What the model leaves of the labelled faces' skin, mm RMS.
    pub left: f64,
}

/// What came of a label.
#[derive(Debug, Clone, PartialEq)]
pub struct Told {
    /// The attribute.
    pub attribute: Attribute,
    /// The root mean square by which read-outs of held-out people, counted from the mean of all
    /// labelled people, miss their labels, in the label's unit.
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
/// who are called `source`.
///
/// # Errors
/// With fewer faces than what else is known of each would need, or a label or a model that does not vary.
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
    let people = faces.len();
    if people < 2 * (FOLDS + labels.besides.len()) {
        return Err(FitError::Input(format!(
            "{people} faces are too few to tell labels by"
        )));
    }
    let (coefficients, left) = coefficients(template, model, faces)?;
    let without = residual(&coefficients, &labels.besides)?;
    let correlation = correlation(model);
    let prior = correlation
        .llt(Side::Lower)
        .map_err(|_| FitError::Input("the model's correlation is not definite".into()))?;
    let data = Data {
        without: &without,
        coefficients: &coefficients,
        prior: &prior,
    };
    let one = |own: &Range<usize>| {
        let labels = &labels.told[own.clone()];
        let values: Vec<&[f64]> = labels.iter().map(|label| &label.1[..]).collect();
        let still = || FitError::Input(format!("label {} hardly varies", labels[0].0));
        let all: Vec<usize> = (0..people).collect();
        let readouts = data.learn(&values, &all).ok_or_else(still)?;
        let mut sums = vec![[0.0; 3]; labels.len()];
        for part in 0..FOLDS {
            let (held, known): (Vec<usize>, Vec<usize>) =
                (0..people).partition(|f| f % FOLDS == part);
            let learned = data.learn(&values, &known).ok_or_else(still)?;
            for ((readout, values), sums) in learned.iter().zip(&values).zip(&mut sums) {
                for &f in &held {
                    let reads = readout.read(&coefficients[f]);
                    let (centre, value) = (readout.centre, values[f]);
                    let guess = centre + readout.slope * (reads - centre);
                    for (sum, off) in sums.iter_mut().zip([reads, guess, centre]) {
                        *sum += (off - value).powi(2);
                    }
                }
            }
        }
        let told = readouts.into_iter().zip(labels).zip(sums);
        let told = told.map(|((readout, (name, values)), [missed, guessed, total])| {
            let (unit, means) = meaning(name);
            let limits = round_limits(values);
            let attribute = Attribute {
                name: name.clone(),
                description: format!("{means}, as {source} have it"),
                unit: unit.into(),
                limits: limits.map(|limit| limit as f32),
                mean: readout.centre as f32,
                explained: (1.0 - guessed / total).clamp(0.0, 1.0) as f32,
                reading: readout.weights.iter().map(|&w| w as f32).collect(),
            };
            Told {
                attribute,
                error: (missed / people as f64).sqrt(),
                length: readout.length,
            }
        });
        Ok(told.collect::<Vec<_>>())
    };
    let told: Vec<Vec<Told>> = (labels.together.par_iter())
        .map(one)
        .collect::<FitResult<_>>()?;
    let told = told.concat();
    Ok(Learned { told, left })
}

/// What read-outs are learned from.
struct Data<'a> {
    coefficients: &'a [Vec<f64>],
    /// Those less what else is known of the people.
    without: &'a [Vec<f64>],
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
    /// The read-outs of labels that are learned together, from some people: with D their directions
    /// R^-1 D (D' R^-1 D)^-1. `None` when they do not vary.
    fn learn(&self, labels: &[&[f64]], some: &[usize]) -> Option<Vec<Readout>> {
        let (count, g) = (some.len() as f64, labels.len());
        let k = self.coefficients[0].len();
        let mean = |values: &[f64]| some.iter().map(|&f| values[f]).sum::<f64>() / count;
        let centres: Vec<f64> = labels.iter().map(|values| mean(values)).collect();
        let y = Mat::from_fn(some.len(), g, |f, l| labels[l][some[f]] - centres[l]);
        let c = Mat::from_fn(some.len(), k, |f, i| self.without[some[f]][i]);
        let directions = c.transpose() * &y * inverse(y.transpose() * &y)?;
        let pulled = self.prior.solve(&directions);
        let squares = directions.transpose() * &pulled;
        let weights = pulled * inverse(squares.clone())?;
        let readouts = (0..g).map(|l| {
            let weights: Vec<f64> = (0..k).map(|i| weights[(i, l)]).collect();
            let reads = some.iter().map(|&f| dot(&weights, &self.coefficients[f]));
            let reads: Vec<f64> = reads.collect();
            let middle = reads.iter().sum::<f64>() / count;
            let (mut both, mut own, mut variance) = (0.0, 0.0, 0.0);
            for (f, r) in reads.iter().enumerate() {
                both += (r - middle) * y[(f, l)];
                own += (r - middle).powi(2);
                variance += y[(f, l)].powi(2) / count;
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
    (trace > 0.0).then(|| factor.solve(Mat::<f64>::identity(g, g)))
}

/// The coefficients of faces that are not the model's own, sigmas, and what those leave of their
/// skin, mm RMS.
fn coefficients(
    template: &Template,
    model: &FaceModel,
    faces: &[Vec<DVec3>],
) -> FitResult<(Vec<Vec<f64>>, f64)> {
    let parts = model.parts();
    let mean: Vec<DVec3> = parts.mean.iter().map(|p| p.as_dvec3()).collect();
    if mean.len() != template.positions.len()
        || parts.topology.uv_triangles != template.topology.uv_triangles
    {
        return Err(FitError::Input(
            "the model is of another head than the template".into(),
        ));
    }
    let areas = vertex_areas(&template.positions, &template.triangles());
    let skin = template.part_vertices("skin")?;
    let fields: Vec<Vec<DVec3>> = (faces.par_iter())
        .map(|face| {
            let motion = Rigid::fit(face, &mean, &skin, &areas);
            let moved = face.iter().zip(&mean);
            moved.map(|(&p, m)| motion.apply(p) - *m).collect()
        })
        .collect();
    let shown = model.face();
    let rows: Vec<_> = (0..mean.len() as u32)
        .into_par_iter()
        .map(|v| shown.jacobian(v))
        .collect();
    let modes: Vec<Vec<DVec3>> = (0..parts.population())
        .map(|i| rows.iter().map(|row| row[i].as_dvec3()).collect())
        .collect();
    let off = |found: &[Vec<f64>], subspace: &Subspace| {
        let nearest = subspace.fields(found);
        let pairs = nearest.par_iter().zip(&fields);
        // Summed face by face: threads share the work and not the order.
        let squares: Vec<f64> = pairs
            .map(|(a, b)| {
                let each = skin.iter().map(|&v| v as usize);
                each.map(|v| a[v].distance_squared(b[v])).sum()
            })
            .collect();
        squares.iter().sum::<f64>() / (fields.len() * skin.len()) as f64
    };
    let plain = Subspace::new(&modes, &skin)?;
    let left = off(&plain.coefficients(&fields), &plain);
    let inverse = correlation(model)
        .llt(Side::Lower)
        .map_err(|_| FitError::Input("the model's correlation is not definite".into()))?
        .solve(Mat::<f64>::identity(modes.len(), modes.len()));
    let weight = left * skin.len() as f64 / INDEPENDENT;
    let penalised = Subspace::penalised(&modes, &skin, inverse * faer::Scale(weight))?;
    let found = penalised.coefficients(&fields);
    let left = off(&found, &penalised).sqrt();
    Ok((found, left))
}

fn correlation(model: &FaceModel) -> Mat<f64> {
    let parts = model.parts();
    let k = parts.population();
    Mat::from_fn(k, k, |i, j| f64::from(parts.correlation[i * k + j]))
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
    }

    #[test]
    fn labels_are_read_or_refused_with_the_face_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("labels.json");
        let names = ["a", "b"].map(str::to_owned);
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            Labels::read(&path, &names)
        };
        let labels = read(
            r#"{"a": {"age": 20, "ethnicity": [0.2, 0.3, 0.5], "local": {"nose": 1}},
                "b": {"age": 30, "ethnicity": [1, 0, 0], "local": {"nose": -1}}}"#,
        )
        .unwrap();
        let told: Vec<&str> = labels.told.iter().map(|t| t.0.as_str()).collect();
        assert_eq!(told, ["age", "african", "asian", "caucasian"]);
        assert_eq!(labels.told[0].1, [20.0, 30.0]);
        assert_eq!(labels.told[3].1, [0.5, 0.0]);
        assert_eq!(labels.together, [0..1, 1..4]);
        assert_eq!(labels.besides, [[1.0, -1.0]]);
        // As Windows writes text.
        let text = "\u{feff}{\"a\": {\"age\": 20}, \"b\": {\"age\": 30}}";
        assert_eq!(read(text).unwrap().told[0].1, [20.0, 30.0]);
        for (text, why) in [
            (r#"{"a": {"age": 20}}"#, "b: it is not there"),
            (r#"{"a": {"age": 20}, "b": {"age": "x"}}"#, "b: its age"),
            (r#"{"a": {"age": 20}, "b": {"sex": 1}}"#, "b: it has not"),
            ("[]", "labels.json"),
        ] {
            let error = read(text).unwrap_err().to_string();
            assert!(
                error.contains(why) && error.contains("labels.json"),
                "{error}"
            );
        }
    }
}
