//! The mesh that all faces of a model share.

use glam::Vec3;

use crate::anatomy::Part;
use crate::blob::{Blob, BlobWriter};
use crate::{Error, Result};

/// Triangles, texture coordinates, regions and mirror images of N vertices.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Topology {
    /// Texture coordinates of M >= N corners; the first N belong to the vertices in order, the
    /// others are second coordinates of vertices on a seam.
    pub uvs: Vec<[f32; 2]>,
    /// The vertex of each corner: M entries, `uv_vertices[i] == i` for i < N.
    pub uv_vertices: Vec<u32>,
    /// Triangles as corners, counter-clockwise seen from outside, part by part.
    pub uv_triangles: Vec<[u32; 3]>,
    /// The triangle groups, in order.
    pub parts: Vec<Part>,
    /// The vertex on the other side of the head; an involution.
    pub mirror: Vec<u32>,
    /// The names of the regions.
    pub region_names: Vec<String>,
    /// The region of each vertex.
    pub regions: Vec<u8>,
    /// The prescribed colour of each vertex, sRGB.
    pub colours: Vec<[u8; 3]>,
}

/// Rows of triangle numbers, one a vertex.
#[derive(Debug, Clone)]
pub struct VertexTriangles {
    starts: Vec<u32>,
    triangles: Vec<u32>,
}

impl VertexTriangles {
    /// The triangles around a vertex.
    pub fn of(&self, vertex: u32) -> &[u32] {
        let v = vertex as usize;
        &self.triangles[self.starts[v] as usize..self.starts[v + 1] as usize]
    }
}

/// The vertices that move together in an event, and what their move does to normals.
#[derive(Debug, Clone)]
pub struct Patch {
    /// The smallest range of vertices in which a position or a normal changes.
    pub range: std::ops::Range<u32>,
    /// The vertices whose normal changes.
    pub vertices: Vec<u32>,
    /// The triangles around those; a corner whose normal does not change is the vertex count.
    triangles: Vec<[[u32; 2]; 3]>,
}

impl Topology {
    /// Triangles as vertices.
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        let vertex = |corner: u32| self.uv_vertices[corner as usize];
        self.uv_triangles.iter().map(|t| t.map(vertex)).collect()
    }

    /// The triangles around each vertex.
    pub fn vertex_triangles(&self) -> VertexTriangles {
        let triangles = self.triangles();
        let mut starts = vec![0_u32; self.regions.len() + 1];
        for &vertex in triangles.iter().flatten() {
            starts[vertex as usize + 1] += 1;
        }
        for v in 1..starts.len() {
            starts[v] += starts[v - 1];
        }
        let mut next = starts.clone();
        let mut rows = vec![0; triangles.len() * 3];
        for (t, triangle) in triangles.iter().enumerate() {
            for &vertex in triangle {
                let at = &mut next[vertex as usize];
                rows[*at as usize] = t as u32;
                *at += 1;
            }
        }
        VertexTriangles {
            starts,
            triangles: rows,
        }
    }

    /// What a move of the vertices `moved` touches.
    pub(crate) fn patch(
        &self,
        moved: impl Iterator<Item = u32>,
        adjacency: &VertexTriangles,
    ) -> Patch {
        let n = self.regions.len();
        let all = self.triangles();
        let mut turned = vec![false; n];
        for vertex in moved {
            turned[vertex as usize] = true;
            for &t in adjacency.of(vertex) {
                all[t as usize]
                    .iter()
                    .for_each(|&v| turned[v as usize] = true);
            }
        }
        let vertices: Vec<u32> = (0..n as u32).filter(|&v| turned[v as usize]).collect();
        let triangles = all
            .iter()
            .filter(|t| t.iter().any(|&v| turned[v as usize]))
            .map(|t| t.map(|v| [v, if turned[v as usize] { v } else { n as u32 }]))
            .collect();
        Patch {
            range: vertices.first().map_or(0, |&v| v)..vertices.last().map_or(0, |&v| v + 1),
            vertices,
            triangles,
        }
    }

    pub(crate) fn write(&self, blob: &mut BlobWriter) {
        let n = self.regions.len();
        let uvs: Vec<f32> = self.uvs.iter().flatten().copied().collect();
        blob.section("uvs", &uvs);
        blob.indices("seams", &self.uv_vertices[n..]);
        let corners: Vec<u32> = self.uv_triangles.iter().flatten().copied().collect();
        blob.indices("triangles", &corners);
        blob.indices("mirror", &self.mirror);
        blob.section("regions", &self.regions);
        let colours: Vec<u8> = self.colours.iter().flatten().copied().collect();
        blob.section("colours", &colours);
    }

    pub(crate) fn read(
        blob: &Blob,
        n: usize,
        corners: usize,
        triangles: usize,
        region_names: Vec<String>,
        parts: Vec<Part>,
    ) -> Result<Self> {
        let bad = |why: &str| Err(Error::Blob(why.into()));
        if corners < n {
            return bad("fewer texture coordinates than vertices");
        }
        let uvs = blob.floats("uvs", 2 * corners, 1e4)?;
        let mut uv_vertices: Vec<u32> = (0..n as u32).collect();
        uv_vertices.extend(blob.indices("seams", n)?);
        let triples = blob.indices("triangles", corners)?;
        let mirror = blob.indices("mirror", n)?;
        let regions = blob.section::<u8>("regions", n)?;
        let colours = blob.section::<u8>("colours", 3 * n)?;
        if uv_vertices.len() != corners || triples.len() != 3 * triangles || mirror.len() != n {
            return bad("its topology has sections of wrong lengths");
        }
        if regions
            .iter()
            .any(|&r| usize::from(r) >= region_names.len())
        {
            return bad("a vertex lies in no region");
        }
        if (0..n).any(|v| mirror[mirror[v] as usize] as usize != v) {
            return bad("its mirror map is not an involution");
        }
        let mut next = 0_u32;
        for part in &parts {
            if part.first != next {
                return bad("its parts do not follow each other");
            }
            match next.checked_add(part.count) {
                Some(end) => next = end,
                None => return bad("its parts are larger than the mesh"),
            }
        }
        if next as usize != triangles {
            return bad("its parts do not cover the mesh");
        }
        Ok(Self {
            uvs: uvs.chunks_exact(2).map(|c| [c[0], c[1]]).collect(),
            uv_vertices,
            uv_triangles: triples
                .chunks_exact(3)
                .map(|t| [t[0], t[1], t[2]])
                .collect(),
            parts,
            mirror,
            region_names,
            regions,
            colours: colours
                .chunks_exact(3)
                .map(|c| [c[0], c[1], c[2]])
                .collect(),
        })
    }
}

impl Patch {
    /// Recomputes the unit normals of the patch: the sum of the cross products of the triangles
    /// around a vertex, so each counts by its area.
    ///
    /// `normals` has one entry more than there are vertices, which takes what falls on vertices
    /// outside. A vertex whose triangles have no area gets a zero normal.
    pub(crate) fn normals(&self, positions: &[Vec3], normals: &mut [Vec3]) {
        for &v in &self.vertices {
            normals[v as usize] = Vec3::ZERO;
        }
        for &[a, b, c] in &self.triangles {
            let corner = positions[a[0] as usize];
            let normal =
                (positions[b[0] as usize] - corner).cross(positions[c[0] as usize] - corner);
            normals[a[1] as usize] += normal;
            normals[b[1] as usize] += normal;
            normals[c[1] as usize] += normal;
        }
        for &v in &self.vertices {
            normals[v as usize] = normals[v as usize].normalize_or_zero();
        }
    }
}
