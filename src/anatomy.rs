//! Named places on a head: landmarks, parts and measures.

use glam::Vec3;
use serde::{Deserialize, Serialize};

/// A named triangle group (`skin`, `mouth cavity`, `left eyeball` ...).
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Part {
    /// The part's name.
    pub name: String,
    /// Its first triangle.
    pub first: u32,
    /// How many triangles it has.
    pub count: u32,
}

/// A named point of the surface, as weights on vertices that sum to 1.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Landmark {
    /// `ibug_00` to `ibug_67`, or an anatomical name.
    pub name: String,
    /// `(vertex, weight)` pairs; the weights sum to 1.
    pub stencil: Vec<(u32, f64)>,
}

impl Landmark {
    /// Where the point is on a face with these vertex positions (mm).
    pub fn position(&self, positions: &[Vec3]) -> Vec3 {
        self.stencil
            .iter()
            .map(|&(vertex, weight)| positions[vertex as usize] * weight as f32)
            .sum()
    }
}

/// A length on the face: the distance between two landmarks, in mm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Measure {
    /// What anthropometry calls it, such as `nose width`.
    pub name: String,
    /// Where it is measured, in words.
    pub description: String,
    /// Index of the one landmark.
    pub from: u32,
    /// Index of the other.
    pub to: u32,
}

impl Measure {
    /// The measure of a face with these vertex positions, in mm.
    pub fn of(&self, landmarks: &[Landmark], positions: &[Vec3]) -> f32 {
        let from = landmarks[self.from as usize].position(positions);
        let to = landmarks[self.to as usize].position(positions);
        from.distance(to)
    }
}
