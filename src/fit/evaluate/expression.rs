//! Expressions of the base mesh on fitted heads.

use std::path::Path;

use glam::{DMat3, DVec3};

use crate::fit::FitResult;
use crate::fit::align::Rigid;
use crate::fit::base_mesh::read_target;
use crate::fit::template::Template;

/// An expression as the displacement of each of the template's vertices.
#[derive(Debug, Clone)]
pub struct Expression {
    /// Its ARKit name; of a pair without the side.
    pub name: String,
    /// Displacements in the rest pose, mm.
    pub displacements: Vec<DVec3>,
}

/// The expressions that are tried on fitted heads, with the targets that each is the sum of.
const TRIED: [(&str, &[&str]); 2] = [
    ("jawOpen", &["jawOpen"]),
    ("eyeBlink", &["eyeBlinkLeft", "eyeBlinkRight"]),
];

impl Expression {
    /// Reads jawOpen and eyeBlink (both eyes) from `faceunits01` in `data_dir`, the base mesh's
    /// data folder, and carries them to the template by its stencils.
    ///
    /// # Errors
    /// When a target is missing or unreadable.
    pub fn read(template: &Template, data_dir: &Path) -> FitResult<Vec<Self>> {
        let folder = data_dir.join("faceunits01/targets/faceunits");
        let entries = &template.stencils.entries;
        let bases = entries.iter().map(|e| e.0 as usize + 1).max().unwrap_or(0);
        TRIED
            .iter()
            .map(|(name, targets)| {
                let mut moved = vec![DVec3::ZERO; bases];
                for target in *targets {
                    let path = folder.join(format!("{target}.target"));
                    // The body below the neck has no part in the template.
                    for (vertex, displacement) in read_target(&path, usize::MAX)?.entries {
                        if let Some(sum) = moved.get_mut(vertex as usize) {
                            *sum += displacement;
                        }
                    }
                }
                Ok(Self {
                    name: (*name).into(),
                    displacements: template.stencils.apply(&moved),
                })
            })
            .collect()
    }

    /// The expression on a face of the template's topology, in any pose: the displacements turned
    /// and scaled as the head is.
    pub fn on(&self, face: &[DVec3], turn: DMat3) -> Vec<DVec3> {
        let moved = self.displacements.iter().zip(face);
        moved.map(|(d, p)| *p + turn * *d).collect()
    }
}

/// The rotation and scale from the rest pose to a face over some vertices (Umeyama 1991).
pub fn similarity(rest: &[DVec3], face: &[DVec3], vertices: &[u32]) -> DMat3 {
    let even = vec![1.0; rest.len()];
    let pose = Rigid::fit(rest, face, vertices, &even);
    let centre = |points: &[DVec3]| {
        vertices.iter().map(|&v| points[v as usize]).sum::<DVec3>() / vertices.len().max(1) as f64
    };
    let (from, to) = (centre(rest), centre(face));
    let (mut along, mut square) = (0.0, 0.0);
    for &v in vertices {
        let p = rest[v as usize] - from;
        along += (pose.rotation * p).dot(face[v as usize] - to);
        square += p.length_squared();
    }
    if square > 0.0 {
        pose.rotation * (along / square)
    } else {
        pose.rotation
    }
}
