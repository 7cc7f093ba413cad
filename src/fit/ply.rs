//! Registered faces as PLY files: the template's vertices in their order, in mm.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use glam::DVec3;
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};

use super::files::write_atomically;
use super::template::Template;
use super::{FitError, FitResult};

/// Writes a mesh as binary little-endian PLY: f32 positions and triangles. The file appears
/// whole or not at all.
pub fn write_mesh(path: &Path, positions: &[DVec3], triangles: &[[u32; 3]]) -> FitResult<()> {
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\n\
         property float y\nproperty float z\nelement face {}\n\
         property list uchar int vertex_indices\nend_header\n",
        positions.len(),
        triangles.len()
    )
    .into_bytes();
    bytes.reserve(12 * positions.len() + 13 * triangles.len());
    for p in positions {
        for value in p.as_vec3().to_array() {
            bytes.extend(value.to_le_bytes());
        }
    }
    for triangle in triangles {
        bytes.push(3);
        for vertex in triangle {
            bytes.extend(vertex.to_le_bytes());
        }
    }
    write_atomically(path, &bytes)
}

/// Reads the vertex positions of a PLY file, ascii or binary of either endianness.
pub fn read_positions(path: &Path) -> FitResult<Vec<DVec3>> {
    let file = File::open(path).map_err(|e| FitError::file(path, e))?;
    let size = file.metadata().map_err(|e| FitError::file(path, e))?.len();
    let mut reader = Reader::new(BufReader::new(file));
    let parser = Parser::<Vertex>::new();
    let one_line = |e: &dyn std::fmt::Display| {
        let text = e.to_string();
        // What follows is the parser's state, not the file's fault.
        let text = text.split("String:").next().unwrap_or_default();
        FitError::file(path, text.split_whitespace().collect::<Vec<_>>().join(" "))
    };
    let header = parser.read_header(&mut reader).map_err(|e| one_line(&e))?;
    for (name, element) in &header.elements {
        // A vertex takes three bytes at the very least: no file can hold more of them.
        if element.count as u64 > size {
            return Err(FitError::file(
                path,
                format!("claims {} of `{name}`", element.count),
            ));
        }
        let vertices = parser
            .read_payload_for_element(&mut reader, element, &header)
            .map_err(|e| one_line(&e))?;
        if name == "vertex" {
            for axis in ["x", "y", "z"] {
                if !element.properties.iter().any(|(name, _)| name == axis) {
                    return Err(FitError::file(path, format!("vertices without {axis}")));
                }
            }
            if let Some(bad) = vertices.iter().position(|v| !v.0.is_finite()) {
                return Err(FitError::file(path, format!("vertex {bad} is not finite")));
            }
            return Ok(vertices.into_iter().map(|v| v.0).collect());
        }
    }
    Err(FitError::file(path, "no element `vertex`"))
}

/// Reads every `.ply` of a folder as a face registered to the template, sorted by name.
///
/// The name is the file's without its ending. A file with another number of vertices is an error,
/// and so is a folder without faces.
pub fn read_faces(dir: &Path, template: &Template) -> FitResult<Vec<(String, Vec<DVec3>)>> {
    let entries = std::fs::read_dir(dir).map_err(|e| FitError::file(dir, e))?;
    let mut paths = Vec::new();
    for entry in entries {
        let path = entry.map_err(|e| FitError::file(dir, e))?.path();
        if path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("ply"))
        {
            paths.push(path);
        }
    }
    if paths.is_empty() {
        return Err(FitError::file(dir, "no .ply files"));
    }
    paths.sort();
    paths
        .iter()
        .map(|path| {
            let positions = read_positions(path)?;
            if positions.len() != template.positions.len() {
                let cause = format!(
                    "{} vertices where the template has {}: not registered to this template",
                    positions.len(),
                    template.positions.len()
                );
                return Err(FitError::file(path, cause));
            }
            let name = path.file_stem().unwrap_or_default().to_string_lossy();
            Ok((name.into_owned(), positions))
        })
        .collect()
}

/// Keeps a vertex's position and passes over everything else.
struct Vertex(DVec3);

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Vertex(DVec3::NAN)
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let value = match property {
            Property::Float(value) => value.into(),
            Property::Double(value) => value,
            Property::Char(value) => value.into(),
            Property::UChar(value) => value.into(),
            Property::Short(value) => value.into(),
            Property::UShort(value) => value.into(),
            Property::Int(value) => value.into(),
            Property::UInt(value) => value.into(),
            _ => return PropertyAccessResult::Ignored,
        };
        match name {
            "x" => self.0.x = value,
            "y" => self.0.y = value,
            "z" => self.0.z = value,
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}
