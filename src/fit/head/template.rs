//! The generic head: one topology for every face.

use glam::DVec3;

use super::expression::Expression;
use crate::Error;
pub use crate::anatomy::{Landmark, Part};
use crate::blob::record::record;
use crate::blob::{Blob, BlobWriter, Kind};
use crate::fit::head::prior::ShapePrior;
use crate::fit::{FitError, FitResult};
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
    /// Triangles, texture coordinates, regions, mirror images and colours.
    pub topology: Topology,
    /// The 95 feature points: the 68 iBUG points, 13 more of the skull, 14 of the ears.
    pub landmarks: Vec<Landmark>,
    /// The subdivision as a linear operator on the base mesh's vertices, so that targets and
    /// expressions made for the base mesh carry over.
    pub stencils: Stencils,
    /// How faces vary around the rest pose, once that has been learned.
    pub prior: Option<ShapePrior>,
    /// What the rest pose can show: displacements of all vertices at full strength.
    pub expressions: Vec<Expression>,
}

impl Template {
    fn part(&self, name: &str) -> FitResult<&Part> {
        let found = self.topology.parts.iter().find(|p| p.name == name);
        found.ok_or_else(|| FitError::Input(format!("the template has no part called {name:?}")))
    }

    /// The triangles of a part, as vertices.
    ///
    /// # Errors
    /// When there is no part of that name.
    pub fn part_triangles(&self, name: &str) -> FitResult<Vec<[u32; 3]>> {
        let part = self.part(name)?;
        Ok(self.triangles()[part.first as usize..(part.first + part.count) as usize].to_vec())
    }

    /// The vertices of a part, increasing.
    ///
    /// # Errors
    /// When there is no part of that name.
    pub fn part_vertices(&self, name: &str) -> FitResult<Vec<u32>> {
        self.part(name)?;
        Ok(self.topology.part_vertices(name))
    }

    /// Triangles as vertex indices.
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        self.topology.triangles()
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

/// The header of a template blob.
struct Header {
    units: String,
    vertices: u32,
    corners: u32,
    triangles: u32,
    regions: Vec<String>,
    parts: Vec<Part>,
    landmarks: Vec<Landmark>,
    prior_modes: u32,
}

record! {
    Header { units, vertices, corners, triangles, regions, parts, landmarks, prior_modes }
}

/// # Sections of a template blob
///
/// Those of [`crate::model`] from `uvs` to `colours`, and: `positions` f64 3 N, rest pose in mm;
/// `stencil_starts` index N + 1; `stencil_bases` index and `stencil_weights` f64, both E, the
/// entries of the subdivision's rows; `prior` f32 3 N a mode in mm, where there is one;
/// `expressions` a list of names and `expression_moves` f32 3 N for each of them in mm, both absent
/// without any.
impl Template {
    /// The bytes of the template's blob.
    ///
    /// # Errors
    /// When the header cannot be written.
    pub fn to_bytes(&self) -> FitResult<Vec<u8>> {
        let header = Header {
            units: "mm".into(),
            vertices: self.positions.len() as u32,
            corners: self.topology.uvs.len() as u32,
            triangles: self.topology.uv_triangles.len() as u32,
            regions: self.topology.region_names.clone(),
            parts: self.topology.parts.clone(),
            landmarks: self.landmarks.clone(),
            prior_modes: self.prior.as_ref().map_or(0, |p| p.modes.len() as u32),
        };
        let mut blob = BlobWriter::new(Kind::Template, &header);
        let positions: Vec<f64> = self.positions.iter().flat_map(|p| p.to_array()).collect();
        blob.section("positions", &positions);
        self.topology.write(&mut blob, &self.topology.walk());
        blob.indices("stencil_starts", &self.stencils.starts);
        let (bases, weights): (Vec<u32>, Vec<f64>) = self.stencils.entries.iter().copied().unzip();
        blob.indices("stencil_bases", &bases);
        blob.section("stencil_weights", &weights);
        if let Some(prior) = &self.prior {
            blob.section("prior", &flat(prior.modes.iter().flatten()));
        }
        if !self.expressions.is_empty() {
            let names: Vec<String> = self.expressions.iter().map(|e| e.name.clone()).collect();
            blob.record("expressions", &names);
            let moves = self.expressions.iter().flat_map(|e| &e.displacements);
            blob.section("expression_moves", &flat(moves));
        }
        Ok(blob.finish()?)
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
        let (topology, ..) =
            Topology::read(&blob, n, corners, triangles, header.regions, header.parts)?;
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
        let modes = header.prior_modes as usize;
        let prior = match modes {
            0 => Vec::new(),
            // A template says how many vertices it has, and no prior has that many modes.
            1..=1000 => blob.section::<f32>("prior", 3 * n * modes)?,
            _ => return Err(Error::Blob(format!("a prior of {modes} modes")).into()),
        };
        let names: Vec<String> = blob.record("expressions")?.unwrap_or_default();
        let moves = match names.len() {
            0 => Vec::new(),
            1..=1000 => blob.section::<f32>("expression_moves", 3 * n * names.len())?,
            _ => return Err(Error::Blob(format!("{} expressions", names.len())).into()),
        };
        let finite = prior.iter().chain(&moves).all(|x| x.abs() < 1e6)
            && positions.iter().chain(&weights).all(|x| x.abs() < 1e6);
        if !(rows && ends && points && finite && bases.len() == weights.len()) {
            return Err(Error::Blob("its stencils, points or numbers are not sound".into()).into());
        }
        Ok(Self {
            positions: positions.chunks_exact(3).map(DVec3::from_slice).collect(),
            topology,
            landmarks: header.landmarks,
            stencils: Stencils {
                starts,
                entries: bases.into_iter().zip(weights).collect(),
            },
            prior: (modes > 0).then(|| ShapePrior {
                modes: fields(&prior, n).collect(),
            }),
            expressions: (names.into_iter().zip(fields(&moves, n)))
                .map(|(name, displacements)| Expression {
                    name,
                    displacements,
                })
                .collect(),
        })
    }
}

/// Vectors as numbers.
fn flat<'a>(vectors: impl Iterator<Item = &'a DVec3>) -> Vec<f32> {
    vectors.flat_map(|d| d.as_vec3().to_array()).collect()
}

/// Fields of `n` vectors, one after the other, from [`flat`] numbers.
fn fields(numbers: &[f32], n: usize) -> impl Iterator<Item = Vec<DVec3>> {
    // A blob may say that it has no vertices.
    numbers.chunks_exact((3 * n).max(1)).map(|field| {
        let vectors = field.chunks_exact(3);
        vectors
            .map(|d| glam::Vec3::from_slice(d).as_dvec3())
            .collect()
    })
}
