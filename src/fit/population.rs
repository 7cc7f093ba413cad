//! A synthetic population of registered adult faces, from the base mesh's CC0 targets.
//!
//! It is made of one artist's shapes, not of people: a stand-in until faces registered to real
//! scans take its place, and labelled with what was sampled.

use std::collections::BTreeMap;
use std::path::Path;

use glam::DVec3;
use rayon::prelude::*;

use super::base_mesh::{BaseMesh, Target};
use super::generic_head::ETHNICITIES;
use super::ply::{write_mesh, write_whole};
use super::template::Template;
use super::{FitError, FitResult};
use crate::Random;
use crate::model::{About, Licence};

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
        licences: vec![Licence {
            source: "MakeHuman base mesh and targets (MPFB 2)".into(),
            by: "the MakeHuman community".into(),
            licence: "CC0-1.0".into(),
        }],
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
    ("head", 0.20),
    ("eyes", 0.22),
    ("eyebrows", 0.30),
    ("nose", 0.24),
    ("mouth", 0.22),
    ("chin", 0.26),
    ("cheek", 0.28),
    ("forehead", 0.30),
    ("ears", 0.25),
    ("neck", 0.12),
];

/// Controls left out: what the macro targets already do, and rigid motion, which alignment
/// removes again.
const LEFT_OUT: [&str; 4] = ["head-age", "head-trans", "measure-neck", "neck-trans"];

/// Samples a population: `count` faces, the same for the same seed on any number of threads.
pub fn sample(
    template: &Template,
    data_dir: &Path,
    count: usize,
    seed: u64,
) -> FitResult<Population> {
    let base = BaseMesh::read(data_dir)?;
    let sampler = Sampler::new(template, &base)?;
    let drawn: Vec<(Labels, Vec<DVec3>)> = (0..count)
        .into_par_iter()
        .map(|index| {
            let labels = sampler.draw(&mut Random::stream(seed, index as u64));
            let face = sampler.face(&labels);
            (labels, face)
        })
        .collect();
    let (labels, faces) = drawn.into_iter().unzip();
    Ok(Population {
        faces,
        labels,
        rejected: BTreeMap::new(),
    })
}

/// Writes `face_0000.ply` ..., `labels.json` and `about.json`, which `train` puts into the model.
pub fn write(population: &Population, template: &Template, dir: &Path) -> FitResult<()> {
    std::fs::create_dir_all(dir).map_err(|e| FitError::file(dir, e))?;
    let triangles = template.triangles();
    let mut labels = BTreeMap::new();
    for (index, (face, label)) in population.faces.iter().zip(&population.labels).enumerate() {
        let name = format!("face_{index:04}");
        write_mesh(&dir.join(format!("{name}.ply")), face, &triangles)?;
        labels.insert(name, label);
    }
    let path = dir.join("labels.json");
    let json = serde_json::to_vec_pretty(&labels).map_err(|e| FitError::file(&path, e))?;
    write_whole(&path, &json)?;
    let path = dir.join("about.json");
    let json = serde_json::to_vec_pretty(&about()).map_err(|e| FitError::file(&path, e))?;
    write_whole(&path, &json)
}

struct Sampler<'a> {
    template: &'a Template,
    /// Macro displacement fields by name, over all template vertices.
    macros: BTreeMap<String, Vec<DVec3>>,
    controls: Vec<Control>,
    left_eye: Vec<u32>,
    right_eye: Vec<u32>,
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
        Ok(Sampler {
            template,
            macros,
            controls,
            left_eye: part_vertices(template, "left eyeball"),
            right_eye: part_vertices(template, "right eyeball"),
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

    fn face(&self, labels: &Labels) -> Vec<DVec3> {
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
        let mean = |vertices: &[u32]| {
            let sum: DVec3 = vertices.iter().map(|&v| face[v as usize]).sum();
            sum / vertices.len().max(1) as f64
        };
        let origin = (mean(&self.left_eye) + mean(&self.right_eye)) / 2.0;
        for p in &mut face {
            *p -= origin;
        }
        face
    }
}

/// The vertices of a part.
pub fn part_vertices(template: &Template, name: &str) -> Vec<u32> {
    let triangles = template.triangles();
    let mut vertices: Vec<u32> = template
        .parts
        .iter()
        .filter(|part| part.name == name)
        .flat_map(|part| &triangles[part.first as usize..(part.first + part.count) as usize])
        .flatten()
        .copied()
        .collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
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
