//! The generic head: one topology for every face.

use glam::DVec3;

pub use crate::anatomy::{Landmark, Part};

/// A linear map from the base mesh's vertices to the template's, one sparse row a vertex.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Stencils {
    /// Row `i` is `entries[starts[i]..starts[i + 1]]`; `starts.len()` is rows + 1.
    pub starts: Vec<u32>,
    /// `(base vertex, weight)`; base vertices are numbered as in the base mesh's own file.
    pub entries: Vec<(u32, f64)>,
}

impl Stencils {
    /// Applies the map to one vector a base vertex (positions, or displacements of a target).
    pub fn apply(&self, base: &[DVec3]) -> Vec<DVec3> {
        self.starts
            .windows(2)
            .map(|row| {
                self.entries[row[0] as usize..row[1] as usize]
                    .iter()
                    .map(|&(vertex, weight)| base[vertex as usize] * weight)
                    .sum()
            })
            .collect()
    }
}

/// The generic head (region morphing, section 3): about 13,000 vertices, 26,000 triangles.
///
/// Vertices are numbered region by region. Millimetres; y up, z out of the face, x to the
/// subject's left.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Template {
    /// Rest pose, N vertices.
    pub positions: Vec<DVec3>,
    /// Texture coordinates, M >= N. The first N belong to the vertices in order; the others are
    /// second coordinates of vertices on a seam.
    pub uvs: Vec<[f32; 2]>,
    /// The vertex of each texture coordinate: M entries, `uv_vertices[i] == i` for i < N.
    pub uv_vertices: Vec<u32>,
    /// Triangles as indices into `uvs`, counter-clockwise seen from outside, part by part.
    pub uv_triangles: Vec<[u32; 3]>,
    /// The triangle groups, in order, covering all triangles.
    pub parts: Vec<Part>,
    /// The mirror image of each vertex (left to right); an involution.
    pub mirror: Vec<u32>,
    /// The names of the regions.
    pub region_names: Vec<String>,
    /// The region of each vertex: an index into `region_names`.
    pub regions: Vec<u8>,
    /// Prescribed colour of each vertex, sRGB.
    pub colours: Vec<[u8; 3]>,
    /// The 81 feature points.
    pub landmarks: Vec<Landmark>,
    /// The subdivision as a linear operator on the base mesh's vertices, so that targets and
    /// expressions made for the base mesh carry over.
    pub stencils: Stencils,
}

impl Template {
    /// Triangles as vertex indices.
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        self.uv_triangles
            .iter()
            .map(|t| t.map(|corner| self.uv_vertices[corner as usize]))
            .collect()
    }

    /// A landmark's position on a face with this topology.
    pub fn landmark(&self, index: usize, positions: &[DVec3]) -> DVec3 {
        self.landmarks[index]
            .stencil
            .iter()
            .map(|&(vertex, weight)| positions[vertex as usize] * weight)
            .sum()
    }
}
