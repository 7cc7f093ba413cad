//! The face model: a mean, blocks, controls, and what is known of the population.
//!
//! # Sections of a model blob
//!
//! N vertices, M texture corners, T triangles, B blocks, C coefficients in all, P controls with Q
//! quantiles each; block `b` has S support vertices, K modes, R surround targets with J sources.
//!
//! | section | type | length | what |
//! |---|---|---|---|
//! | `mean` | f32 | 3 N | mean face, x y z a vertex, mm |
//! | `uvs` | f32 | 2 M | texture coordinates, u v a corner; the first N belong to the vertices in order |
//! | `seams` | index | M - N | the vertex of each further corner |
//! | `triangles` | index | 3 T | corners, counter-clockwise seen from outside, part by part |
//! | `mirror` | index | N | the vertex on the other side |
//! | `regions` | u8 | N | index into the header's `regions` |
//! | `colours` | u8 | 3 N | sRGB |
//! | `correlation` | f32 | C C | correlation of the coefficients in the population |
//! | `quantiles` | f32 | P Q | read-out at equally spaced percentiles, a control after another |
//! | `support.b` | index | S | vertices, increasing; absent for a block without surround (all N) |
//! | `modes.b` | i16 | 3 S K | displacement for one sigma in units of the header's `step` |
//! | `sigmas.b` | f32 | K | standard deviations, mm |
//! | `targets.b` | index | R | surround vertices, increasing |
//! | `distances.b` | f32 | R | distance from the region, mm |
//! | `sources.b` | index | R J | places in the support |
//! | `weights.b` | u16 | R J | weights; those of a target sum to 65535 |
//!
//! An index section is u16 or u32, as its row in the table says.

mod block;
mod control;
mod header;

use std::sync::Arc;

use glam::Vec3;
use nalgebra::DMatrix;

pub use block::{Block, FALLOFF_REACH, Surround, falloff};
pub use control::Control;
pub use header::{About, Blending, Licence};

use crate::anatomy::{Landmark, Measure};
use crate::blob::{Blob, BlobWriter, Kind};
use crate::mesh::Topology;
use crate::quantise::Quantised;
use crate::{Error, Face, Result};
use header::{BlockHeader, ControlHeader, Header, SurroundHeader};

/// Coordinates of a head in mm stay far below this.
const LARGEST_COORDINATE: f32 = 1e4;
const MAX_VERTICES: u32 = 1 << 20;
const MAX_COEFFICIENTS: usize = 1024;
/// Blending farther than a head is high means nothing, and up to here a whole micrometre survives
/// f32.
const FARTHEST_REACH: f32 = 1e3;
/// Limits of a control in sigmas (region morphing, section 5).
pub const LIMIT: f32 = 3.0;

/// Everything that a model is made of.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelParts {
    /// What it is and where it comes from.
    pub about: About,
    /// Mean face, mm.
    pub mean: Vec<Vec3>,
    /// Triangles, texture coordinates, regions, mirror images.
    pub topology: Topology,
    /// The bases, in the order of their coefficients.
    pub blocks: Vec<Block>,
    /// The controls; each has the same number of quantiles.
    pub controls: Vec<Control>,
    /// Correlation of the coefficients in the population, row by row.
    pub correlation: Vec<f32>,
    /// Named points.
    pub landmarks: Vec<Landmark>,
    /// Named lengths.
    pub measures: Vec<Measure>,
    /// The fall-off distance.
    pub blending: Blending,
}

/// What is computed once from the parts, for every face of the model.
#[derive(Debug)]
pub(crate) struct Derived {
    /// What an event of each block touches.
    pub touched: Vec<crate::mesh::Patch>,
    /// All triangles and vertices.
    pub whole: crate::mesh::Patch,
    /// The coefficients of the face on which every control reads 0.5.
    pub median: Vec<i32>,
    /// The correlation and its lower Cholesky factor.
    pub correlation: DMatrix<f64>,
    pub cholesky: DMatrix<f64>,
    pub fingerprint: u32,
}

/// A face model, read from a blob. Cheap to clone; faces share it.
#[derive(Debug, Clone)]
pub struct FaceModel {
    pub(crate) parts: Arc<ModelParts>,
    pub(crate) derived: Arc<Derived>,
}

impl FaceModel {
    /// Reads a model.
    ///
    /// # Errors
    /// [`Error::Blob`] or [`Error::Version`] with the reason, for any bytes that are not a whole
    /// and consistent model.
    pub fn parse(bytes: &[u8]) -> Result<Self> {
        let blob = Blob::parse(bytes, Kind::Model)?;
        let parts = ModelParts::read(&blob)?;
        Self::new(parts, blob.checksum())
    }

    fn new(parts: ModelParts, checksum: u64) -> Result<Self> {
        let count = parts.coefficients();
        let correlation = DMatrix::from_row_iterator(
            count,
            count,
            parts.correlation.iter().map(|&r| f64::from(r)),
        );
        let Some(cholesky) = correlation.clone().cholesky() else {
            return Err(Error::Blob(
                "its correlation matrix is not positive definite".into(),
            ));
        };
        let adjacency = parts.topology.vertex_triangles();
        let touched = parts
            .blocks
            .iter()
            .map(|block| {
                let surround = block.surround.as_ref().map_or(&[][..], |s| &s.targets);
                let moved = block.support.iter().chain(surround).copied();
                parts.topology.patch(moved, &adjacency)
            })
            .collect();
        let whole = parts.topology.patch(0..parts.mean.len() as u32, &adjacency);
        let mut median = vec![0.0_f32; count];
        for control in &parts.controls {
            let amount = (control.median() - control.read(&median)) / control.gain();
            for &(i, change) in &control.direction {
                median[i as usize] += amount * change;
            }
        }
        if let Some(i) = median.iter().position(|m| !(m.abs() <= LIMIT)) {
            return Err(Error::Blob(format!(
                "its median person has {} sigmas of coefficient {i}",
                median[i]
            )));
        }
        let median = median.into_iter().map(crate::face::grid).collect();
        Ok(Self {
            derived: Arc::new(Derived {
                touched,
                whole,
                median,
                correlation,
                cholesky: cholesky.l(),
                fingerprint: (checksum ^ (checksum >> 32)) as u32,
            }),
            parts: Arc::new(parts),
        })
    }

    /// A face: the median person of the population.
    pub fn face(&self) -> Face {
        Face::new(self)
    }

    /// The face of a code that [`Face::code`] made.
    ///
    /// # Errors
    /// [`Error::Code`] when the code is damaged or of another model.
    pub fn from_code(&self, code: &str) -> Result<Face> {
        let mut face = self.face();
        face.set_code(code)?;
        Ok(face)
    }

    /// What the model is made of.
    pub fn parts(&self) -> &ModelParts {
        &self.parts
    }

    pub(crate) fn control(&self, name: &str) -> Result<&Control> {
        let found = self.parts.controls.iter().find(|c| c.name == name);
        found.ok_or_else(|| Error::Unknown {
            kind: "control",
            name: name.to_owned(),
        })
    }

    pub(crate) fn block(&self, name: &str) -> Result<usize> {
        let found = self.parts.blocks.iter().position(|b| b.name == name);
        found.ok_or_else(|| Error::Unknown {
            kind: "region",
            name: name.to_owned(),
        })
    }
}

impl ModelParts {
    /// How many coefficients a face has.
    pub fn coefficients(&self) -> usize {
        self.blocks.iter().map(|b| b.sigmas.len()).sum()
    }

    /// The bytes of the model's blob.
    ///
    /// # Errors
    /// When the header cannot be written.
    pub fn write(&self) -> Result<Vec<u8>> {
        let topology = &self.topology;
        let header = Header {
            about: self.about.clone(),
            units: "mm".into(),
            vertices: self.mean.len() as u32,
            corners: topology.uvs.len() as u32,
            triangles: topology.uv_triangles.len() as u32,
            quantiles: self.controls.first().map_or(2, |c| c.quantiles.len()) as u32,
            regions: topology.region_names.clone(),
            parts: topology.parts.clone(),
            landmarks: self.landmarks.clone(),
            measures: self.measures.clone(),
            blocks: self
                .blocks
                .iter()
                .map(|b| block_header(b, topology))
                .collect(),
            controls: self
                .controls
                .iter()
                .map(|c| ControlHeader {
                    name: c.name.clone(),
                    group: c.group.clone(),
                    description: c.description.clone(),
                    direction: c.direction.clone(),
                    reading: c.reading.clone(),
                })
                .collect(),
            blending: self.blending,
        };
        let mut blob = BlobWriter::new(Kind::Model, &header)?;
        let flat: Vec<f32> = self.mean.iter().flat_map(|p| p.to_array()).collect();
        blob.section("mean", &flat);
        topology.write(&mut blob);
        blob.section("correlation", &self.correlation);
        let quantiles: Vec<f32> = self
            .controls
            .iter()
            .flat_map(|c| c.quantiles.iter().copied())
            .collect();
        blob.section("quantiles", &quantiles);
        for (b, block) in self.blocks.iter().enumerate() {
            blob.section(&format!("modes.{b}"), &block.modes.integers);
            blob.section(&format!("sigmas.{b}"), &block.sigmas);
            if let Some(surround) = &block.surround {
                blob.indices(&format!("support.{b}"), &block.support);
                blob.indices(&format!("targets.{b}"), &surround.targets);
                blob.section(&format!("distances.{b}"), &surround.distances);
                blob.indices(&format!("sources.{b}"), &surround.sources);
                blob.section(&format!("weights.{b}"), &surround.weights);
            }
        }
        Ok(blob.finish())
    }

    fn read(blob: &Blob) -> Result<Self> {
        let header: Header = blob.header()?;
        let bad = |why: String| Err(Error::Blob(why));
        if header.units != "mm" {
            return bad(format!("its unit is {:?}, not mm", header.units));
        }
        if header.vertices == 0 || header.vertices > MAX_VERTICES {
            return bad(format!("{} vertices", header.vertices));
        }
        // Twice what Euler's formula allows for so many vertices. It keeps the products of these
        // numbers within 32 bits, which is what wasm counts in, and what is derived from each
        // block's part of the mesh a small multiple of the block's own bytes.
        let most = 4 * header.vertices;
        if header.corners > most || header.triangles > most {
            return bad(format!(
                "{} texture corners and {} triangles",
                header.corners, header.triangles
            ));
        }
        if header.regions.len() > usize::from(u8::MAX) {
            return bad(format!("{} regions", header.regions.len()));
        }
        let n = header.vertices as usize;
        let mean = blob
            .floats("mean", 3 * n, LARGEST_COORDINATE)?
            .chunks_exact(3)
            .map(Vec3::from_slice)
            .collect();
        let topology = Topology::read(
            blob,
            n,
            header.corners as usize,
            header.triangles as usize,
            header.regions,
            header.parts,
        )?;
        let total: u64 = header.blocks.iter().map(|b| u64::from(b.modes)).sum();
        let empty = header.blocks.iter().any(|b| b.modes == 0);
        if header.blocks.is_empty() || empty || total > MAX_COEFFICIENTS as u64 {
            return bad(format!(
                "{total} coefficients in {} blocks",
                header.blocks.len()
            ));
        }
        let total = total as usize;
        let mut blocks = Vec::with_capacity(header.blocks.len());
        let mut first_coefficient = 0;
        for (b, block) in header.blocks.into_iter().enumerate() {
            let block = read_block(blob, b, block, &topology, n, first_coefficient)?;
            first_coefficient += block.sigmas.len();
            if blocks.iter().any(|other: &Block| other.name == block.name) {
                return bad(format!("two blocks are called {:?}", block.name));
            }
            blocks.push(block);
        }
        let correlation = blob.floats("correlation", total * total, 1.000_001)?;
        for i in 0..total {
            let diagonal = correlation[i * total + i];
            let symmetric =
                (0..i).all(|j| correlation[i * total + j] == correlation[j * total + i]);
            if (diagonal - 1.0).abs() > 1e-5 || !symmetric {
                return bad(format!("row {i} of its correlation matrix is not one"));
            }
        }
        let controls = read_controls(blob, header.controls, header.quantiles, total)?;
        for landmark in &header.landmarks {
            let sum: f64 = landmark.stencil.iter().map(|s| s.1).sum();
            let sound = landmark
                .stencil
                .iter()
                .all(|s| (s.0 as usize) < n && s.1.abs() <= 2.0);
            if !sound || !((sum - 1.0).abs() < 1e-3) {
                return bad(format!("landmark {:?} is not on the head", landmark.name));
            }
        }
        let landmarks = header.landmarks.len();
        if let Some(m) = header
            .measures
            .iter()
            .find(|m| m.from as usize >= landmarks || m.to as usize >= landmarks)
        {
            return bad(format!("measure {:?} has no landmarks", m.name));
        }
        let Blending {
            alpha,
            limits: [least, most],
        } = header.blending;
        let whole = [least, alpha, most]
            .iter()
            .all(|&mm| crate::face::micrometres(mm) == mm);
        if !(whole && least > 0.0 && least <= alpha && alpha <= most && most <= FARTHEST_REACH) {
            return bad(format!(
                "a blending distance of {alpha} mm in {least} to {most}"
            ));
        }
        Ok(Self {
            about: header.about,
            mean,
            topology,
            blocks,
            controls,
            correlation,
            landmarks: header.landmarks,
            measures: header.measures,
            blending: header.blending,
        })
    }
}

fn block_header(block: &Block, topology: &Topology) -> BlockHeader {
    BlockHeader {
        name: block.name.clone(),
        regions: block
            .regions
            .iter()
            .map(|&r| topology.region_names[r as usize].clone())
            .collect(),
        modes: block.sigmas.len() as u32,
        step: block.modes.step,
        surround: block.surround.as_ref().map(|s| SurroundHeader {
            sources: s.sources_each as u32,
        }),
    }
}

fn read_block(
    blob: &Blob,
    b: usize,
    header: BlockHeader,
    topology: &Topology,
    n: usize,
    first_coefficient: usize,
) -> Result<Block> {
    let bad = |why: String| Err(Error::Blob(format!("block {:?}: {why}", header.name)));
    let mut regions = Vec::new();
    for name in &header.regions {
        match topology.region_names.iter().position(|r| r == name) {
            Some(region) => regions.push(region as u8),
            None => return bad(format!("no region is called {name:?}")),
        }
    }
    let increasing = |indices: &[u32]| indices.windows(2).all(|w| w[0] < w[1]);
    let support: Vec<u32> = match header.surround {
        Some(_) => blob.indices(&format!("support.{b}"), n)?,
        None => (0..n as u32).collect(),
    };
    if support.is_empty() || !increasing(&support) {
        return bad("its support is not in order".into());
    }
    let modes = header.modes as usize;
    let integers = blob.section::<i16>(&format!("modes.{b}"), 3 * support.len() * modes)?;
    let sigmas = blob.floats(&format!("sigmas.{b}"), modes, 1e9)?;
    let surround = match header.surround {
        None => None,
        Some(SurroundHeader { sources }) => {
            let targets = blob.indices(&format!("targets.{b}"), n)?;
            if !increasing(&targets) || targets.iter().any(|t| support.binary_search(t).is_ok()) {
                return bad("its surround is not in order".into());
            }
            let sources_each = sources as usize;
            if sources_each == 0 || sources_each > 64 {
                return bad(format!("{sources_each} sources a vertex"));
            }
            let distances =
                blob.floats(&format!("distances.{b}"), targets.len(), LARGEST_COORDINATE)?;
            if distances.iter().any(|&d| d < 0.0) {
                return bad("a negative distance".into());
            }
            let pairs = targets.len() * sources_each;
            let sources = blob.indices(&format!("sources.{b}"), support.len())?;
            let weights = blob.section::<u16>(&format!("weights.{b}"), pairs)?;
            if sources.len() != pairs {
                return bad(format!("{} sources, not {pairs}", sources.len()));
            }
            let whole = |row: &[u16]| row.iter().map(|&w| u32::from(w)).sum::<u32>() == 65_535;
            if !weights.chunks_exact(sources_each).all(whole) {
                return bad("the weights of a vertex do not sum to 1".into());
            }
            Some(Surround {
                targets,
                distances,
                sources_each,
                sources,
                weights,
            })
        }
    };
    Ok(Block {
        modes: Quantised::from_parts(header.step, integers)?,
        name: header.name,
        regions,
        support,
        sigmas,
        first_coefficient,
        surround,
    })
}

fn read_controls(
    blob: &Blob,
    headers: Vec<ControlHeader>,
    quantiles: u32,
    coefficients: usize,
) -> Result<Vec<Control>> {
    let q = quantiles as usize;
    if !(2..=4096).contains(&q) || headers.len() > 4096 {
        return Err(Error::Blob(format!(
            "{} controls of {q} quantiles",
            headers.len()
        )));
    }
    let table = blob.floats("quantiles", headers.len() * q, 1e6)?;
    let mut controls: Vec<Control> = Vec::with_capacity(headers.len());
    for (header, quantiles) in headers.into_iter().zip(table.chunks_exact(q)) {
        let bad = |why: &str| Err(Error::Blob(format!("control {:?}: {why}", header.name)));
        let terms = || header.direction.iter().chain(&header.reading);
        if terms().any(|t| t.0 as usize >= coefficients || !(t.1.abs() <= 1e6)) {
            return bad("its coefficients are not the model's");
        }
        let in_order = |terms: &[(u32, f32)]| terms.windows(2).all(|w| w[0].0 < w[1].0);
        if !in_order(&header.direction) || !in_order(&header.reading) {
            return bad("its coefficients are not in order");
        }
        if quantiles.windows(2).any(|w| w[0] >= w[1]) {
            return bad("its quantiles do not increase");
        }
        if controls.iter().any(|c| c.name == header.name) {
            return bad("there are two of that name");
        }
        let control = Control {
            quantiles: quantiles.to_vec(),
            name: header.name.clone(),
            group: header.group.clone(),
            description: header.description.clone(),
            direction: header.direction.clone(),
            reading: header.reading.clone(),
        };
        if !(control.gain().abs() >= 1e-6) {
            return bad("it does not move its own read-out");
        }
        controls.push(control);
    }
    Ok(controls)
}
