//! What faces measure: a table of them, for statistics of people, and the faces themselves, to be opened on the page.

use std::path::Path;

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use serde_json::json;

use crate::anatomy::Measure;
use crate::fit::format::files::write_atomically;
use crate::fit::likeness::Likenesses;
use crate::fit::mesh::align::vertex_areas;
use crate::fit::{FitError, FitResult};
use crate::{Face, FaceModel};

/// What is in the table, for `--help`.
pub const TABLE: &str = "\
The table is CSV with a row a face:
  name                  of its file, without the ending
  left (mm)             RMS distance of its skin from the model's face that it is likest
  code                  of that face: the page has it at #CODE, the package by model.fromCode(CODE)
  face width (mm) ...   the model's measures, of the face itself
  age (years) ...       what the model's attributes read of its likeness
  nose 1 (%) ...        the percentile at which each slider of the page then stands
  nose 1 (sigma) ...    the population's coefficients, block by block, in their order

The likeness is by penalised least squares with the model's own prior, each face by itself: the more the model leaves of
a face, the more it is drawn towards the mean. Percentiles are of the model's people, who may be none of yours.";

/// A registered face as a model has it.
#[derive(Debug, Clone)]
pub struct Measured {
    /// What it is called.
    pub name: String,
    /// RMS distance of its skin from the likeness, mm.
    pub left: f64,
    /// The face of the model that it is likest.
    pub likeness: Face,
    /// The model's measures of the face itself, mm.
    pub lengths: Vec<f64>,
}

/// Measures faces in the topology of a model (all vertices, mm, any pose); `done` is called after each.
///
/// # Errors
/// When the model does not vary, or a coefficient would be beyond 255 sigmas: with the face's name.
pub fn measure(
    model: &FaceModel,
    faces: &[(String, Vec<DVec3>)],
    done: impl Fn() + Sync,
) -> FitResult<Vec<Measured>> {
    let parts = model.parts();
    let mean: Vec<DVec3> = parts.mean.iter().map(|p| p.as_dvec3()).collect();
    let likenesses = Likenesses::new(model, vertex_areas(&mean, &parts.topology.triangles()))?;
    let one = |(name, face): &(String, Vec<DVec3>)| {
        // By itself: who else is there changes nothing of it.
        let (coefficients, left) = likenesses.of(std::slice::from_ref(face))?;
        let mut all: Vec<f32> = coefficients[0].iter().map(|&c| c as f32).collect();
        all.resize(parts.coefficients(), 0.0);
        let mut likeness = model.face();
        (likeness.set_coefficients(&all)).map_err(|e| FitError::Input(format!("{name}: {e}")))?;
        // Heights and depths are along the axes of the model's heads.
        let aligned: Vec<Vec3> = (likenesses.align(face).iter())
            .map(|p| p.as_vec3())
            .collect();
        let lengths = (parts.measures.iter()).map(|measure| measure.of(&parts.landmarks, &aligned));
        let measured = Measured {
            name: name.clone(),
            left,
            lengths: lengths.collect(),
            likeness,
        };
        done();
        Ok(measured)
    };
    faces.par_iter().map(one).collect()
}

/// Writes the table ([`TABLE`]), whole or not at all.
///
/// # Errors
/// When the file cannot be written.
pub fn write_table(model: &FaceModel, faces: &[Measured], path: &Path) -> FitResult<()> {
    let parts = model.parts();
    let mut head: Vec<String> = ["name", "left (mm)", "code"].map(Into::into).into();
    head.extend((parts.measures.iter()).map(|m| format!("{} ({})", m.name, Measure::UNIT)));
    head.extend((parts.attributes.iter()).map(|a| match a.unit.as_str() {
        "" => a.name.clone(),
        unit => format!("{} ({unit})", a.name),
    }));
    head.extend(parts.controls.iter().map(|c| format!("{} (%)", c.name)));
    let population = parts.blocks.iter().flat_map(|block| {
        let own = block.coefficients().take_while(|&i| i < parts.population());
        (1..=own.count()).map(|i| format!("{} {i} (sigma)", block.name))
    });
    head.extend(population);
    let fail = |e: csv::Error| FitError::file(path, e);
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(&head).map_err(fail)?;
    for face in faces {
        let (name, likeness) = (&face.name, &face.likeness);
        let mut row = vec![name.clone(), format!("{:.3}", face.left), likeness.code()];
        row.extend(face.lengths.iter().map(|mm| format!("{mm:.3}")));
        for attribute in &parts.attributes {
            row.push(format!("{:.4}", likeness.attribute(&attribute.name)?));
        }
        for control in &parts.controls {
            row.push(format!("{:.2}", 100.0 * likeness.get(&control.name)?));
        }
        let sigmas = likeness.coefficients();
        row.extend((sigmas[..parts.population()].iter()).map(|sigma| format!("{sigma:.4}")));
        table.write_record(&row).map_err(fail)?;
    }
    let bytes = table
        .into_inner()
        .map_err(|e| FitError::file(path, e.error()))?;
    write_atomically(path, &bytes)
}

/// Writes the likenesses as faces that the page opens ("Open a face's file"): `www/src/keep/facefile.js` says what is in
/// such a file.
///
/// # Errors
/// When the file cannot be written.
pub fn write_faces(model: &FaceModel, faces: &[Measured], path: &Path) -> FitResult<()> {
    let title = &model.parts().about.title;
    let one = |face: &Measured| {
        json!({
            "format": "phiz-face", "version": 2, "name": face.name, "model": title, "code": face.likeness.code(),
        })
    };
    let all: Vec<_> = faces.iter().map(one).collect();
    let text = serde_json::to_vec_pretty(&all).map_err(|e| FitError::file(path, e))?;
    write_atomically(path, &text)
}
