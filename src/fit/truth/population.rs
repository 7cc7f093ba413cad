//! A synthetic population of registered adult faces, from the base mesh's CC0 targets.
//!
//! It is made of one artist's shapes, not of people: a stand-in until faces registered to real
//! scans take its place, and labelled with what was sampled.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use glam::DVec3;
use nalgebra::{Matrix4, Vector4};
use rayon::prelude::*;

use crate::Random;
use crate::fit::format::files::write_atomically;
use crate::fit::format::ply::{faces, write_mesh};
use crate::fit::format::text::json;
use crate::fit::head::base_mesh::{self, BaseMesh, Target};
use crate::fit::head::generic_head::ETHNICITIES;
use crate::fit::head::template::Template;
use crate::fit::{FitError, FitResult};
use crate::model::About;

/// What one face was sampled from.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Labels {
    /// 0 female to 1 male.
    pub sex: f64,
    /// Years.
    pub age: f64,
    /// Shares of african, asian and caucasian; they sum to 1.
    pub ethnicity: [f64; 3],
    /// 0 thin, 0.5 average, 1 heavy.
    pub weight: f64,
    /// 0 slight, 0.5 average, 1 muscular.
    pub muscle: f64,
    /// The value of each local control, in its target's full displacement; 0 is average.
    pub local: BTreeMap<String, f64>,
}

impl Labels {
    /// Reads `labels.json` as [`write()`] leaves it, of those of the named faces that are in it; nothing where it has other
    /// labels, of who made it.
    ///
    /// # Errors
    /// When the file cannot be read or is no JSON.
    pub fn read(path: &Path, names: &[&str]) -> FitResult<Option<Vec<Self>>> {
        let all: serde_json::Value = json(path)?;
        let Ok(mut all) = serde_json::from_value::<BTreeMap<String, Self>>(all) else {
            return Ok(None);
        };
        Ok(Some(
            names.iter().filter_map(|name| all.remove(*name)).collect(),
        ))
    }
}

/// What a model that is learned from such a population says of itself.
pub fn about() -> About {
    About {
        title: "phiz synthetic adults".into(),
        population: "Synthetic adult faces of both sexes, 18 to 80 years, sampled from the shapes \
                     of the MakeHuman base mesh."
            .into(),
        caveat: "No real person was measured. Percentiles say where a face stands among these \
                 synthetic ones, nothing about people of any origin, sex or age."
            .into(),
        licences: vec![base_mesh::licence()],
        ..About::default()
    }
}

/// Registered faces and what they were sampled from.
#[derive(Debug, Clone, PartialEq)]
pub struct Population {
    /// A face's vertices, in the template's order, in mm; origin between the eyes.
    pub faces: Vec<Vec<DVec3>>,
    /// One a face.
    pub labels: Vec<Labels>,
    /// How many candidates were rejected on the way, by reason.
    pub rejected: BTreeMap<String, usize>,
}

/// A local control: up to one target each way and side.
struct Control {
    name: String,
    spread: f64,
    /// Displacement of the template for a negative and a positive value; one pair, or left and
    /// right.
    sides: Vec<[Sparse; 2]>,
}

/// A displacement field that is zero almost everywhere: `(template vertex, mm)`.
type Sparse = Vec<(u32, DVec3)>;

/// Standard deviation of a control, in full targets, by the folder it comes from. The targets'
/// full displacement is an extreme that an artist still finds believable.
const SPREADS: [(&str, f64); 10] = [
    ("head", 0.10),
    ("eyes", 0.20),
    ("eyebrows", 0.30),
    ("nose", 0.21),
    ("mouth", 0.19),
    ("chin", 0.26),
    ("cheek", 0.28),
    ("forehead", 0.22),
    ("ears", 0.25),
    ("neck", 0.12),
];

/// Standard deviation of each asymmetry target: faces are only slightly crooked.
const ASYMMETRY: f64 = 0.08;

/// Controls left out: what the macro targets already do, and rigid motion, which alignment
/// removes again.
const LEFT_OUT: [&str; 4] = ["head-age", "head-trans", "measure-neck", "neck-trans"];

/// Lengths by which an implausible face is known: a name and two landmarks.
const MEASURES: [(&str, &str, &str); 17] = [
    ("face width", "tragion right", "tragion left"),
    ("jaw width", "gonion right", "gonion left"),
    ("cheek width", "cheek right", "cheek left"),
    ("face height", "glabella", "ibug_08"),
    ("forehead height", "glabella", "trichion"),
    ("skull height", "ibug_27", "vertex"),
    ("nose height", "ibug_27", "ibug_33"),
    ("nose width", "alare right", "alare left"),
    ("nose depth", "ibug_30", "ibug_33"),
    ("upper lip", "ibug_33", "ibug_51"),
    ("lips", "ibug_51", "ibug_57"),
    ("mouth width", "ibug_48", "ibug_54"),
    ("chin height", "ibug_57", "ibug_08"),
    ("right eye width", "ibug_36", "ibug_39"),
    ("left eye width", "ibug_42", "ibug_45"),
    ("eye distance", "ibug_39", "ibug_42"),
    ("brow height", "ibug_19", "ibug_37"),
];

/// Robust standard deviations from the median beyond which a measure is an outlier.
const OUTLIER: f64 = 3.0;

/// The measures' medians and spreads are those of this many candidates, whatever the count asked
/// for, so that a smaller population is the beginning of a larger one.
const PILOT: usize = 400;

/// More skin triangles than this turned by over 90 degrees from the rest pose is a fold.
const FOLDS: usize = 12;

/// How far a lid's rim may sink into the eyeball beyond what it does in the rest pose, in mm.
const LID_SINKS: f64 = 0.8;

/// How far the lower lip's inner edge may stand above the upper's beyond the rest pose, in mm.
const LIPS_CROSS: f64 = 1.2;

/// Samples a population: `count` faces, the same for the same seed on any number of threads.
///
/// Candidates are drawn one after the other. One is rejected when any of 17 lengths between landmarks lies more
/// than three robust standard deviations (1.4826 times the median absolute deviation) from the
/// median, when its skin folds, its lips cross, or its lids sink into its eyeballs.
pub fn sample(
    template: &Template,
    data_dir: &Path,
    count: usize,
    seed: u64,
) -> FitResult<Population> {
    let base = BaseMesh::read(data_dir)?;
    let sampler = Sampler::new(template, &base)?;
    let candidate = |index: usize| {
        let labels = sampler.draw(&mut Random::stream(seed, index as u64));
        let (face, sinks) = sampler.face(&labels);
        (labels, face, sinks)
    };
    let pilot: Vec<Vec<f64>> = (0..PILOT)
        .into_par_iter()
        .map(|index| sampler.measure(&candidate(index).1))
        .collect();
    let usual: Vec<(f64, f64)> = (0..MEASURES.len())
        .map(|m| {
            let centre = median(pilot.iter().map(|p| p[m]).collect());
            let spread = median(pilot.iter().map(|p| (p[m] - centre).abs()).collect());
            (centre, 1.4826 * spread)
        })
        .collect();

    let mut population = Population {
        faces: Vec::new(),
        labels: Vec::new(),
        rejected: BTreeMap::new(),
    };
    let mut first = 0;
    while population.faces.len() < count {
        if first > 20 * count + PILOT {
            let cause = "hardly any candidate is a plausible face: is this the right base mesh?";
            return Err(FitError::Input(cause.into()));
        }
        let batch = (count - population.faces.len()).clamp(8, 256);
        let drawn: Vec<_> = (first..first + batch)
            .into_par_iter()
            .map(|index| {
                let (labels, face, sinks) = candidate(index);
                let fault = sampler.fault(&face, sinks, &usual);
                (labels, face, fault)
            })
            .collect();
        for (labels, face, fault) in drawn {
            if population.faces.len() == count {
                break;
            }
            match fault {
                Some(reason) => *population.rejected.entry(reason).or_default() += 1,
                None => {
                    population.faces.push(face);
                    population.labels.push(labels);
                }
            }
        }
        first += batch;
    }
    Ok(population)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// What the file of a face is called, but for its ending.
fn name(index: usize) -> String {
    format!("face_{index:04}")
}

/// Refuses a folder with other faces than those that `count` of a population take the place of: labels would be missing
/// of them, and who learns from the folder would learn from both.
///
/// # Errors
/// When there is one, or the folder cannot be read.
pub fn check_folder(dir: &Path, count: usize) -> FitResult<()> {
    let own: BTreeSet<_> = (0..count)
        .map(|index| dir.join(name(index) + ".ply"))
        .collect();
    match faces(dir)?
        .into_iter()
        .filter(|face| !own.contains(face))
        .min()
    {
        Some(other) => {
            let cause =
                format!("a face that is none of these {count}: they go to a folder of their own");
            Err(FitError::file(&other, cause))
        }
        None => Ok(()),
    }
}

/// Writes `face_0000.ply` ..., `labels.json` and `about.json`, which `train` puts into the model.
///
/// # Errors
/// Those of [`check_folder`], and when the folder cannot be written to.
pub fn write(population: &Population, template: &Template, dir: &Path) -> FitResult<()> {
    std::fs::create_dir_all(dir).map_err(|e| FitError::file(dir, e))?;
    check_folder(dir, population.faces.len())?;
    // Labels of before would be those of other faces, if this ended before its own are there.
    let path = dir.join("labels.json");
    if path.exists() {
        std::fs::remove_file(&path).map_err(|e| FitError::file(&path, e))?;
    }
    let triangles = template.triangles();
    let mut labels = BTreeMap::new();
    for (index, (face, label)) in population.faces.iter().zip(&population.labels).enumerate() {
        let name = name(index);
        write_mesh(&dir.join(format!("{name}.ply")), face, &triangles)?;
        labels.insert(name, label);
    }
    let json = serde_json::to_vec_pretty(&labels).map_err(|e| FitError::file(&path, e))?;
    write_atomically(&path, &json)?;
    let path = dir.join("about.json");
    let json = serde_json::to_vec_pretty(&about()).map_err(|e| FitError::file(&path, e))?;
    write_atomically(&path, &json)
}

struct Sampler<'a> {
    template: &'a Template,
    /// Macro displacement fields by name, over all template vertices.
    macros: BTreeMap<String, Vec<DVec3>>,
    controls: Vec<Control>,
    eyes: [Eye; 2],
    triangles: Vec<[u32; 3]>,
    skin_normals: Vec<DVec3>,
    landmarks: BTreeMap<String, usize>,
}

/// An eyeball and the rim of its lids.
struct Eye {
    ball: Vec<u32>,
    rim: Vec<u32>,
    /// Distance of each rim vertex to the eyeball's centre less its radius in the rest pose.
    gaps: Vec<f64>,
}

impl Eye {
    fn new(template: &Template, name: &str) -> FitResult<Eye> {
        let ball = template.part_vertices(name)?;
        let skin = template.part_vertices("skin")?;
        let cavities = template.part_vertices("eye cavities")?;
        let (centre, radius) = sphere(&ball, &template.positions);
        let rim: Vec<u32> = cavities
            .into_iter()
            .filter(|v| skin.binary_search(v).is_ok())
            .filter(|&v| template.positions[v as usize].x * centre.x > 0.0)
            .collect();
        let gaps = rim
            .iter()
            .map(|&v| template.positions[v as usize].distance(centre) - radius)
            .collect();
        Ok(Eye { ball, rim, gaps })
    }

    /// Moves and scales the eyeball so that the rim of the lids lies on it as in the rest pose,
    /// by Gauss-Newton on centre and radius; returns by how much the worst rim vertex sinks
    /// deeper than in the rest pose.
    ///
    /// The targets move lids and helper eyeballs each on their own; added up they gape or poke
    /// through. The eyeball stays a sphere. A pull towards where the targets put it keeps the
    /// depth, which the rim alone hardly fixes.
    fn seat(&self, face: &mut [DVec3]) -> f64 {
        let (given, given_radius) = sphere(&self.ball, face);
        let (mut centre, mut radius) = (given, given_radius);
        for _ in 0..8 {
            let mut normal = Matrix4::identity() * 0.02 * self.rim.len() as f64;
            let pull = (given - centre).extend(given_radius - radius).to_array();
            let mut right = Vector4::from(pull) * 0.02 * self.rim.len() as f64;
            for (&vertex, gap) in self.rim.iter().zip(&self.gaps) {
                let out = face[vertex as usize] - centre;
                let distance = out.length().max(1e-9);
                let residual = distance - radius - gap;
                let d = out / distance;
                let row = Vector4::new(d.x, d.y, d.z, 1.0);
                normal += row * row.transpose();
                right += row * residual;
            }
            let Some(step) = normal.cholesky().map(|c| c.solve(&right)) else {
                break;
            };
            centre += DVec3::new(step.x, step.y, step.z);
            radius += step.w;
        }
        let scale = radius / given_radius;
        for &vertex in &self.ball {
            let p = &mut face[vertex as usize];
            *p = centre + (*p - given).normalize_or_zero() * given_radius * scale;
        }
        let sinks = self
            .rim
            .iter()
            .zip(&self.gaps)
            .map(|(&v, gap)| gap - (face[v as usize].distance(centre) - radius));
        sinks.fold(0.0, f64::max)
    }
}

/// Centre and radius of an eyeball: its vertices come in opposite pairs ring by ring, so the
/// least-squares sphere is well determined.
fn sphere(ball: &[u32], face: &[DVec3]) -> (DVec3, f64) {
    let mut normal = Matrix4::zeros();
    let mut right = Vector4::zeros();
    let count = ball.len().max(1) as f64;
    let mean: DVec3 = ball.iter().map(|&v| face[v as usize]).sum::<DVec3>() / count;
    for &vertex in ball {
        let p = face[vertex as usize] - mean;
        let row = Vector4::new(2.0 * p.x, 2.0 * p.y, 2.0 * p.z, 1.0);
        normal += row * row.transpose();
        right += row * p.length_squared();
    }
    match normal.cholesky().map(|c| c.solve(&right)) {
        Some(s) => {
            let centre = DVec3::new(s.x, s.y, s.z);
            (
                mean + centre,
                (s.w + centre.length_squared()).max(0.0).sqrt(),
            )
        }
        None => (mean, 0.0),
    }
}

impl<'a> Sampler<'a> {
    fn new(template: &'a Template, base: &BaseMesh) -> FitResult<Self> {
        let dense = |target: &Target| {
            let mut field = vec![DVec3::ZERO; base.positions.len()];
            for &(vertex, displacement) in &target.entries {
                field[vertex as usize] += displacement;
            }
            template.stencils.apply(&field)
        };
        let mut macros = BTreeMap::new();
        for name in macro_names() {
            macros.insert(name.clone(), dense(&base.target("macrodetails", &name)?));
        }
        let sparse = |folder: &str, name: &str| -> FitResult<Sparse> {
            let field = dense(&base.target(folder, name)?);
            Ok((0..)
                .zip(field)
                .filter(|(_, d)| d.length() > 1e-6)
                .collect())
        };
        let mut controls = Vec::new();
        for (folder, spread) in SPREADS {
            for (name, sides) in base.controls(folder)? {
                if LEFT_OUT.iter().any(|prefix| name.starts_with(prefix)) {
                    continue;
                }
                let mut fields = Vec::new();
                for [negative, positive] in &sides {
                    let field = |name: &Option<String>| match name {
                        Some(name) => sparse(folder, name),
                        None => Ok(Sparse::new()),
                    };
                    fields.push([field(negative)?, field(positive)?]);
                }
                controls.push(Control {
                    name,
                    spread,
                    sides: fields,
                });
            }
        }
        // Asymmetries are not in the list of controls: a target each way, `-l` and `-r`. The
        // trunk's, which have nothing to do with faces, are spelled `asymm`.
        for name in base.target_names("asym")? {
            if let Some(stem) = name
                .strip_suffix("-l")
                .filter(|stem| stem.starts_with("asym-"))
            {
                let sides = vec![[
                    sparse("asym", &name)?,
                    sparse("asym", &format!("{stem}-r"))?,
                ]];
                controls.push(Control {
                    name: stem.to_owned(),
                    spread: ASYMMETRY,
                    sides,
                });
            }
        }
        let triangles = template.part_triangles("skin")?;
        for (_, a, b) in MEASURES {
            for name in [a, b] {
                if !template.landmarks.iter().any(|l| l.name == name) {
                    return Err(FitError::Input(format!(
                        "the template has no landmark {name}"
                    )));
                }
            }
        }
        Ok(Sampler {
            template,
            macros,
            controls,
            eyes: [
                Eye::new(template, "left eyeball")?,
                Eye::new(template, "right eyeball")?,
            ],
            skin_normals: triangle_normals(&template.positions, &triangles),
            triangles,
            landmarks: (0..)
                .zip(&template.landmarks)
                .map(|(index, landmark)| (landmark.name.clone(), index))
                .collect(),
        })
    }

    fn draw(&self, random: &mut Random) -> Labels {
        // Exponential shares to a power: mostly one ethnicity, often a mix.
        let mut ethnicity = [0.0; 3];
        for share in &mut ethnicity {
            *share = (-(1.0 - random.uniform()).ln()).powf(1.8) + 1e-3;
        }
        let sum: f64 = ethnicity.iter().sum();
        let pole = f64::from(u8::from(random.uniform() < 0.5));
        // Towards the middle by half a normal deviate.
        let sex = (pole - 0.5) * (1.0 - 0.3 * random.normal().abs()).max(0.0) + 0.5;
        let age = 18.0 + 62.0 * random.uniform();
        let bounded = |random: &mut Random, spread: f64, limit: f64| {
            (spread * random.normal()).clamp(-limit, limit)
        };
        let weight = 0.5 + bounded(random, 0.17, 0.42);
        let muscle = 0.5 + bounded(random, 0.15, 0.4);
        let mut local = BTreeMap::new();
        for control in &self.controls {
            let common = control.spread * random.normal();
            for side in 0..control.sides.len() {
                let name = match (control.sides.len(), side) {
                    (1, _) => control.name.clone(),
                    (_, 0) => format!("l-{}", control.name),
                    _ => format!("r-{}", control.name),
                };
                let own = if control.sides.len() == 1 {
                    0.0
                } else {
                    0.15 * control.spread * random.normal()
                };
                local.insert(name, (common + own).clamp(-0.8, 0.8));
            }
        }
        Labels {
            sex,
            age,
            ethnicity: ethnicity.map(|share| share / sum),
            weight,
            muscle,
            local,
        }
    }

    /// A face, and by how much its lids sink into its eyeballs (mm).
    fn face(&self, labels: &Labels) -> (Vec<DVec3>, f64) {
        let mut face = self.template.positions.clone();
        for (name, weight) in macro_weights(labels) {
            // The rest pose already holds an average share of some of them.
            let weight = weight - rest_weight(&name);
            if weight != 0.0 {
                for (p, d) in face.iter_mut().zip(&self.macros[&name]) {
                    *p += *d * weight;
                }
            }
        }
        for control in &self.controls {
            for (side, fields) in control.sides.iter().enumerate() {
                let value = match (control.sides.len(), side) {
                    (1, _) => labels.local[&control.name],
                    (_, 0) => labels.local[&format!("l-{}", control.name)],
                    _ => labels.local[&format!("r-{}", control.name)],
                };
                for &(vertex, d) in &fields[usize::from(value > 0.0)] {
                    face[vertex as usize] += d * value.abs();
                }
            }
        }
        let sinks = self.eyes.iter().map(|eye| eye.seat(&mut face));
        let sinks = sinks.fold(0.0, f64::max);
        let [left, right] = self.eyes.each_ref().map(|eye| sphere(&eye.ball, &face).0);
        let origin = (left + right) / 2.0;
        for p in &mut face {
            *p -= origin;
        }
        (face, sinks)
    }

    fn point(&self, face: &[DVec3], name: &str) -> DVec3 {
        self.landmarks
            .get(name)
            .map_or(DVec3::NAN, |&index| self.template.landmark(index, face))
    }

    fn measure(&self, face: &[DVec3]) -> Vec<f64> {
        MEASURES
            .iter()
            .map(|(_, a, b)| self.point(face, a).distance(self.point(face, b)))
            .collect()
    }

    /// Why a face is not plausible, if it is not.
    fn fault(&self, face: &[DVec3], sinks: f64, usual: &[(f64, f64)]) -> Option<String> {
        for ((value, (centre, spread)), (name, _, _)) in
            self.measure(face).into_iter().zip(usual).zip(MEASURES)
        {
            if (value - centre).abs() > OUTLIER * spread {
                return Some(name.into());
            }
        }
        let turned = triangle_normals(face, &self.triangles)
            .iter()
            .zip(&self.skin_normals)
            .filter(|(now, rest)| now.dot(**rest) < 0.0)
            .count();
        if turned > FOLDS {
            return Some("folded skin".into());
        }
        if sinks > LID_SINKS {
            return Some("lids in eyeballs".into());
        }
        let gap = |positions: &[DVec3], upper: &str, lower: &str| {
            self.point(positions, upper).y - self.point(positions, lower).y
        };
        for (upper, lower) in [
            ("ibug_61", "ibug_67"),
            ("ibug_62", "ibug_66"),
            ("ibug_63", "ibug_65"),
        ] {
            let rest = gap(&self.template.positions, upper, lower).min(0.0);
            if gap(face, upper, lower) < rest - LIPS_CROSS {
                return Some("crossing lips".into());
            }
        }
        None
    }
}

fn triangle_normals(positions: &[DVec3], triangles: &[[u32; 3]]) -> Vec<DVec3> {
    triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            (b - a).cross(c - a)
        })
        .collect()
}

const LEVELS: [&str; 3] = ["min", "average", "max"];

fn macro_names() -> Vec<String> {
    let mut names = Vec::new();
    for sex in ["female", "male"] {
        for age in ["young", "old"] {
            for ethnicity in ETHNICITIES {
                names.push(format!("{ethnicity}-{sex}-{age}"));
            }
            for muscle in LEVELS {
                for weight in LEVELS {
                    names.push(format!(
                        "universal-{sex}-{age}-{muscle}muscle-{weight}weight"
                    ));
                }
            }
        }
    }
    names
}

/// The weight of a macro target in the rest pose.
fn rest_weight(name: &str) -> f64 {
    if name.starts_with("universal") {
        // Average muscle and weight, whose targets are empty.
        if name.contains("young-averagemuscle-averageweight") {
            0.5
        } else {
            0.0
        }
    } else if name.ends_with("-young") {
        1.0 / 6.0
    } else {
        0.0
    }
}

/// The macro targets and their weights: the product of a share for each part of the name, as
/// `macrodetails/macro.json` has it.
///
/// Age runs from `young` at 25 years to `old` at 90; younger adults are 25. Muscle and weight run
/// from `min` at 0 through `average` at 0.5 to `max` at 1.
fn macro_weights(labels: &Labels) -> Vec<(String, f64)> {
    let old = ((labels.age - 25.0) / 65.0).clamp(0.0, 1.0);
    let level = |value: f64| {
        let x = 2.0 * value - 1.0;
        [(-x).max(0.0), 1.0 - x.abs(), x.max(0.0)]
    };
    let mut weights = Vec::new();
    for (sex, sex_share) in [("female", 1.0 - labels.sex), ("male", labels.sex)] {
        for (age, age_share) in [("young", 1.0 - old), ("old", old)] {
            let share = sex_share * age_share;
            for (ethnicity, part) in ETHNICITIES.iter().zip(labels.ethnicity) {
                weights.push((format!("{ethnicity}-{sex}-{age}"), share * part));
            }
            for (muscle, m) in LEVELS.iter().zip(level(labels.muscle)) {
                for (weight, w) in LEVELS.iter().zip(level(labels.weight)) {
                    let name = format!("universal-{sex}-{age}-{muscle}muscle-{weight}weight");
                    weights.push((name, share * m * w));
                }
            }
        }
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::format::ply::read_faces;
    use crate::fit::{base_mesh_dir, test_head};

    #[test]
    fn the_average_labels_give_the_rest_pose() {
        let Some(head) = test_head() else { return };
        let base = BaseMesh::read(&base_mesh_dir().unwrap()).unwrap();
        let sampler = Sampler::new(head, &base).unwrap();
        let mut labels = sampler.draw(&mut Random::new(1));
        labels.local.values_mut().for_each(|v| *v = 0.0);
        labels = Labels {
            sex: 0.5,
            age: 25.0,
            ethnicity: [1.0 / 3.0; 3],
            weight: 0.5,
            muscle: 0.5,
            ..labels
        };
        let (face, sinks) = sampler.face(&labels);
        for (a, b) in face.iter().zip(&head.positions) {
            // Seating the eyeball is an iteration.
            assert!(a.distance(*b) < 1e-6);
        }
        assert!(sinks < 1e-6);
    }

    #[test]
    fn the_same_seed_gives_the_same_faces_on_any_threads() {
        let Some(head) = test_head() else { return };
        let dir = base_mesh_dir().unwrap();
        let many = sample(head, &dir, 6, 5).unwrap();
        let single = rayon::ThreadPoolBuilder::new()
            .num_threads(1)
            .build()
            .unwrap();
        let one = single.install(|| sample(head, &dir, 3, 5).unwrap());
        assert_eq!(one.faces[..], many.faces[..3]);
        assert_eq!(one.labels[..], many.labels[..3]);
        assert_ne!(sample(head, &dir, 1, 6).unwrap().faces[0], one.faces[0]);
    }

    #[test]
    fn adults_behind_whose_lids_sit_eyes() {
        let Some(head) = test_head() else { return };
        let population = sample(head, &base_mesh_dir().unwrap(), 40, 9).unwrap();
        let eye = Eye::new(head, "left eyeball").unwrap();
        for (face, labels) in population.faces.iter().zip(&population.labels) {
            assert!((18.0..=80.0).contains(&labels.age));
            assert!((labels.ethnicity.iter().sum::<f64>() - 1.0).abs() < 1e-9);
            let (centre, radius) = sphere(&eye.ball, face);
            for (&v, gap) in eye.rim.iter().zip(&eye.gaps) {
                let now = face[v as usize].distance(centre) - radius;
                assert!(now > gap - LID_SINKS - 1e-9, "{now} {gap}");
            }
        }
    }

    #[test]
    fn a_grotesque_is_rejected() {
        let Some(head) = test_head() else { return };
        let base = BaseMesh::read(&base_mesh_dir().unwrap()).unwrap();
        let sampler = Sampler::new(head, &base).unwrap();
        let usual: Vec<_> = sampler
            .measure(&head.positions)
            .iter()
            .map(|&m| (m, 0.05 * m))
            .collect();
        assert_eq!(sampler.fault(&head.positions, 0.0, &usual), None);
        let wide: Vec<DVec3> = head
            .positions
            .iter()
            .map(|p| *p * DVec3::new(1.5, 1.0, 1.0))
            .collect();
        assert_eq!(
            sampler.fault(&wide, 0.0, &usual).as_deref(),
            Some("face width")
        );
        assert_eq!(
            sampler.fault(&head.positions, 1.0, &usual).as_deref(),
            Some("lids in eyeballs")
        );
        let inverted: Vec<DVec3> = head.positions.iter().map(|p| flip_x(*p)).collect();
        assert_eq!(
            sampler.fault(&inverted, 0.0, &usual).as_deref(),
            Some("folded skin")
        );
    }

    fn flip_x(p: DVec3) -> DVec3 {
        p * DVec3::new(-1.0, 1.0, 1.0)
    }

    #[test]
    fn written_faces_are_read_again() {
        let Some(head) = test_head() else { return };
        let population = sample(head, &base_mesh_dir().unwrap(), 2, 3).unwrap();
        let dir = tempfile::tempdir().unwrap();
        write(&population, head, dir.path()).unwrap();
        let triangles = head.triangles();
        let faces = read_faces(dir.path(), &head.positions, &triangles).unwrap();
        assert_eq!(faces[1].0, "face_0001");
        for (a, b) in faces[1].1.iter().zip(&population.faces[1]) {
            // f32 at 200 mm.
            assert!(a.distance(*b) < 3e-5);
        }
        // The same again, of no more, takes its place; fewer would leave some, which are named.
        let labels = dir.path().join("labels.json");
        write(&population, head, dir.path()).unwrap();
        let names = ["face_0000", "face_0001"];
        let read = Labels::read(&labels, &names).unwrap().unwrap();
        assert_eq!(read.len(), 2);
        let nobody = Labels::read(&labels, &["anna"]).unwrap().unwrap();
        assert!(nobody.is_empty());
        for (read, written) in read.iter().zip(&population.labels) {
            // JSON's numbers are read to the last place but one.
            assert!((read.age - written.age).abs() < 1e-9);
            assert_eq!(read.local.len(), written.local.len());
        }
        let first = Population {
            faces: population.faces[..1].to_vec(),
            labels: population.labels[..1].to_vec(),
            ..population.clone()
        };
        let error = write(&first, head, dir.path()).unwrap_err().to_string();
        assert!(
            error.contains("face_0001.ply: a face that is none of these 1"),
            "{error}"
        );
        assert!(labels.exists());
        // One that ends early leaves no labels of before.
        std::fs::remove_file(dir.path().join("face_0000.ply")).unwrap();
        std::fs::create_dir(dir.path().join("face_0000.ply")).unwrap();
        write(&population, head, dir.path()).unwrap_err();
        assert!(!labels.exists());
        std::fs::remove_dir(dir.path().join("face_0000.ply")).unwrap();
        // Labels of others are none of these, and none that are broken.
        std::fs::write(
            &labels,
            "\u{feff}{\"face_0001\": {\"age\": 30, \"sex\": 1}}",
        )
        .unwrap();
        assert_eq!(Labels::read(&labels, &["face_0001"]).unwrap(), None);
        std::fs::write(&labels, "{").unwrap();
        Labels::read(&labels, &["face_0001"]).unwrap_err();
        std::fs::write(
            dir.path().join("odd.ply"),
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty double x\nproperty float y\nproperty int z\nend_header\n1 2 3\n",
        )
        .unwrap();
        let error = read_faces(dir.path(), &head.positions, &triangles)
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("odd.ply") && error.contains("1 vertices"),
            "{error}"
        );
    }
}
