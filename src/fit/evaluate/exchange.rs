//! Files by which other programs' registrations are measured like ours (`tests/peers`).
//!
//! They are given the template's skin alone: eyeballs and cavities have nothing to match on a
//! scan.

use std::collections::BTreeMap;
use std::path::Path;

use glam::DVec3;

use crate::fit::format::files::write_atomically;
use crate::fit::format::ply::{read_positions, write_mesh};
use crate::fit::head::expression::similarity;
use crate::fit::head::region::point;
use crate::fit::head::template::Template;
use crate::fit::truth::ict::Ict;
use crate::fit::{FitError, FitResult};

/// Writes what is registered, and the scan of ICT's mean head that gives the reference:
/// `skin.ply`, the template's skin at rest with its vertices in increasing order, `mean.ply`, and
/// for both the 68 landmarks in `skin.json` and `mean.json`.
///
/// # Errors
/// When the folder cannot be written to, or the template lacks its skin or a landmark.
pub fn write(template: &Template, ict: &Ict, dir: &Path) -> FitResult<()> {
    std::fs::create_dir_all(dir).map_err(|e| FitError::file(dir, e))?;
    let vertices = template.part_vertices("skin")?;
    let mut triangles = template.part_triangles("skin")?;
    let mut slot = vec![0; template.positions.len()];
    (0..)
        .zip(&vertices)
        .for_each(|(i, &v)| slot[v as usize] = i);
    for vertex in triangles.as_flattened_mut() {
        *vertex = slot[*vertex as usize];
    }
    let rest = &template.positions;
    let skin: Vec<DVec3> = vertices.iter().map(|&v| rest[v as usize]).collect();
    write_mesh(&dir.join("skin.ply"), &skin, &triangles)?;
    write_mesh(&dir.join("mean.ply"), &ict.neutral, &ict.triangles)?;
    let mut skin_points = BTreeMap::new();
    let mut mean_points = BTreeMap::new();
    for (i, &vertex) in ict.landmarks.iter().enumerate() {
        let name = format!("ibug_{i:02}");
        skin_points.insert(name.clone(), point(template, &name)?.to_array());
        mean_points.insert(name, ict.neutral[vertex as usize].to_array());
    }
    for (name, points) in [("skin.json", skin_points), ("mean.json", mean_points)] {
        let path = dir.join(name);
        let json = serde_json::to_vec_pretty(&points).map_err(|e| FitError::file(&path, e))?;
        write_atomically(&path, &json)?;
    }
    Ok(())
}

/// Reads a registered skin, whose vertices are in the order of `skin.ply`, as a face of the
/// template; what is not skin is moved and scaled with it.
///
/// # Errors
/// When the file cannot be read or has another number of vertices.
pub fn read(path: &Path, template: &Template) -> FitResult<Vec<DVec3>> {
    let vertices = template.part_vertices("skin")?;
    let skin = read_positions(path)?;
    if skin.len() != vertices.len() {
        let (found, meant) = (skin.len(), vertices.len());
        let cause = format!("{found} vertices where the template's skin has {meant}");
        return Err(FitError::file(path, cause));
    }
    let rest = &template.positions;
    let mut face = rest.clone();
    for (&v, &p) in vertices.iter().zip(&skin) {
        face[v as usize] = p;
    }
    let turn = similarity(rest, &face, &vertices);
    let count = vertices.len() as f64;
    let from = vertices.iter().map(|&v| rest[v as usize]).sum::<DVec3>() / count;
    let to = skin.iter().sum::<DVec3>() / count;
    for (v, p) in face.iter_mut().enumerate() {
        if vertices.binary_search(&(v as u32)).is_err() {
            *p = to + turn * (rest[v] - from);
        }
    }
    Ok(face)
}
