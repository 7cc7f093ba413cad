//! The generic head: one topology for every face.

use glam::DVec3;

use super::FitResult;
use crate::Error;
pub use crate::anatomy::{Landmark, Part};
use crate::blob::{Blob, BlobWriter, Kind};
use crate::mesh::Topology;

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

/// The JSON header of a template blob.
#[derive(serde::Serialize, serde::Deserialize)]
struct Header {
    units: String,
    vertices: u32,
    corners: u32,
    triangles: u32,
    regions: Vec<String>,
    parts: Vec<Part>,
    landmarks: Vec<Landmark>,
}

/// # Sections of a template blob
///
/// Those of [`crate::model`] from `uvs` to `colours`, and: `positions` f64 3 N, rest pose in mm;
/// `stencil_starts` index N + 1; `stencil_bases` index and `stencil_weights` f64, both E, the
/// entries of the subdivision's rows.
impl Template {
    /// Everything but positions, points and stencils, as the model keeps it.
    pub fn topology(&self) -> Topology {
        Topology {
            uvs: self.uvs.clone(),
            uv_vertices: self.uv_vertices.clone(),
            uv_triangles: self.uv_triangles.clone(),
            parts: self.parts.clone(),
            mirror: self.mirror.clone(),
            region_names: self.region_names.clone(),
            regions: self.regions.clone(),
            colours: self.colours.clone(),
        }
    }

    /// The bytes of the template's blob.
    ///
    /// # Errors
    /// When the header cannot be written.
    pub fn to_bytes(&self) -> FitResult<Vec<u8>> {
        let header = Header {
            units: "mm".into(),
            vertices: self.positions.len() as u32,
            corners: self.uvs.len() as u32,
            triangles: self.uv_triangles.len() as u32,
            regions: self.region_names.clone(),
            parts: self.parts.clone(),
            landmarks: self.landmarks.clone(),
        };
        let mut blob = BlobWriter::new(Kind::Template, &header)?;
        let flat: Vec<f64> = self.positions.iter().flat_map(|p| p.to_array()).collect();
        blob.section("positions", &flat);
        self.topology().write(&mut blob);
        blob.indices("stencil_starts", &self.stencils.starts);
        let (bases, weights): (Vec<u32>, Vec<f64>) = self.stencils.entries.iter().copied().unzip();
        blob.indices("stencil_bases", &bases);
        blob.section("stencil_weights", &weights);
        Ok(blob.finish())
    }

    /// Reads a template's blob.
    ///
    /// # Errors
    /// When the bytes are not a whole and consistent template.
    pub fn from_bytes(bytes: &[u8]) -> FitResult<Self> {
        let blob = Blob::parse(bytes, Kind::Template)?;
        let header: Header = blob.header()?;
        let n = header.vertices as usize;
        let (corners, triangles) = (header.corners as usize, header.triangles as usize);
        let topology = Topology::read(&blob, n, corners, triangles, header.regions, header.parts)?;
        let positions = blob.section::<f64>("positions", 3 * n)?;
        let weights = blob.sized::<f64>("stencil_weights")?;
        let starts = blob.indices("stencil_starts", weights.len() + 1)?;
        // Base meshes have some 20,000 vertices; the operator itself says how many it needs.
        let bases = blob.indices("stencil_bases", 1 << 20)?;
        let rows = starts.len() == n + 1 && starts.windows(2).all(|w| w[0] <= w[1]);
        let ends = starts
            .last()
            .is_some_and(|&end| end as usize == weights.len());
        let points = header
            .landmarks
            .iter()
            .flat_map(|l| &l.stencil)
            .all(|s| (s.0 as usize) < n);
        let finite = positions.iter().chain(&weights).all(|x| x.abs() < 1e6);
        if !(rows && ends && points && finite && bases.len() == weights.len()) {
            return Err(Error::Blob("its stencils, points or numbers are not sound".into()).into());
        }
        Ok(Self {
            positions: positions.chunks_exact(3).map(DVec3::from_slice).collect(),
            uvs: topology.uvs,
            uv_vertices: topology.uv_vertices,
            uv_triangles: topology.uv_triangles,
            parts: topology.parts,
            mirror: topology.mirror,
            region_names: topology.region_names,
            regions: topology.regions,
            colours: topology.colours,
            landmarks: header.landmarks,
            stencils: Stencils {
                starts,
                entries: bases.into_iter().zip(weights).collect(),
            },
        })
    }
}
