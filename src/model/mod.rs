//! The face model: a mean, blocks, controls, and what is known of the population.
//!
//! # Sections of a model blob
//!
//! N vertices, M texture corners, T triangles, B blocks, C coefficients of the population (those of
//! all blocks that are not local), P controls with Q quantiles each; block `b` has S support
//! vertices, K modes, R surround targets and G parts among these that follow as one.
//!
//! | section | type | length | what |
//! |---|---|---|---|
//! | `triangles` | planes | 3 T | corners, counter-clockwise seen from outside, part by part: all first ones, each as its difference from the one before; all second ones and all third ones, each as its difference from the triangle's first |
//! | `seams` | index | M - N | the vertex of each corner from N on; the first N belong to the vertices in order |
//! | `uvs` | planes | 2 M | texture coordinates in units of [`TEXTURE`](crate::quantise::TEXTURE): of the first N corners, predicted over the vertices, all u, all v; then of each further corner u and v as differences from those of its vertex |
//! | `mirror` | planes | N | how many vertices ahead the one on the other side is; 0 when it is the same or an earlier one |
//! | `regions` | u8 | N | index into the header's `regions` |
//! | `colours` | u8 | 3 N | sRGB |
//! | `mean` | planes | 3 N | mean face, predicted over the vertices: all x, all y, all z, in units of [`COORDINATES`] |
//! | `correlation` | planes | C (C - 1) / 2 | their correlation in the population, in units of [`CORRELATIONS`]: row by row, up to the diagonal |
//! | `quantiles` | f32 | P (2 + Q) | a control after another: the percentiles at which its slider ends, then the read-out at equally spaced percentiles |
//! | `support.b` | planes | S | vertices, increasing, each as its difference from the one before; absent for a block without surround that is not local (all N) |
//! | `modes.b` | planes | 3 S K | displacement for one sigma in units of the header's `step`, predicted over the support: a mode after another, of each all x, all y, all z |
//! | `sigmas.b` | f32 | K | standard deviations, mm |
//! | `targets.b` | planes | R | surround vertices, as `support.b` |
//! | `distances.b` | planes | R | distance from the region, predicted over the targets, in units of [`DISTANCES`] |
//! | `attributes` | u8 | any | absent without attributes: as in the header, the fingerprint (a u32, the two halves of the checksum in exclusive or) of the model without this section and the next, and a list of strings: name, description and unit of each of A attributes |
//! | `read-outs` | f32 | A (4 + C) | of each attribute both limits, the mean, the explained part, and the read-out's change with each coefficient |
//! | `rigid.b` | planes | 17 G | for each of the header's `rigid` parts that follow as one: the part, an index into `parts`; 8 places in the support; their weights, which sum to 65535 |
//!
//! A model without blocks is a head: one face, which a page shows while the rest loads.
//!
//! An index section is u16 or u32, as its row in the table says; planes are described in
//! [`crate::blob`]. The units are in [`crate::quantise`].
//!
//! *Predicted* numbers of vertices are what is left of them after a guess from their neighbours.
//! The vertices are walked breadth first: from the lowest that was not met, over the triangles
//! around each vertex in their order, over the two next corners of each. A vertex v is guessed from
//! parallelograms: for the triangles (v, a, b) around it and those around a that have the edge a b,
//! in their order, with a, b and the third corner c met earlier than v, the mean of a + b - c,
//! rounded to the nearest; where there is none, the mean of the earlier corners of its triangles;
//! where there is none either, the vertex met before; the first is guessed as 0. Of as many as there
//! are the first eight, four, two or one count; of the triangles around a vertex the first 32. On
//! the support or the targets of a block the walk passes over all others; parallelograms with a
//! corner among these do not count, and a vertex that loses all of them is guessed from the mean of
//! their other corners. All is modulo 2^32, and numbers are kept in the order of the walk.
//!
//! What other targets follow is not kept: [`Surround::new`] finds it again.

mod attribute;
mod block;
mod control;
mod header;
mod reach;
mod surround;

use std::sync::{Arc, OnceLock};

use glam::{Vec3, Vec4};
use nalgebra::DMatrix;
use wide::i32x4;

pub use crate::kernel::Modes;
pub use attribute::Attribute;
pub(crate) use attribute::along;
pub use block::{Block, FALLOFF_REACH, falloff};
pub use control::Control;
pub use header::{About, Blending, Licence};
#[cfg(feature = "fit")]
pub(crate) use surround::Nearest;
pub use surround::{Rigid, SOURCES, Surround};

use crate::anatomy::{Landmark, Measure};
use crate::blob::{Blob, BlobWriter, Kind};
use crate::error::{Number, range};
use crate::kernel::Patch;
use crate::mesh::Topology;
use crate::predict::Walk;
use crate::quantise::{COORDINATES, CORRELATIONS, DISTANCES, sound_step};
use crate::{Error, Face, Result};
use header::{BlockHeader, ControlHeader, Header, SurroundHeader};
pub(crate) use reach::Reach;

/// Coordinates of a head in mm stay far below this.
const LARGEST_COORDINATE: f32 = 1e4;
const MAX_VERTICES: u32 = 1 << 20;
const MAX_COEFFICIENTS: usize = 1024;
/// What is locked is told by a bit each.
const MAX_BLOCKS: usize = 63;
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
    /// Correlation of the population's coefficients ([`ModelParts::population`]), row by row.
    pub correlation: Vec<f32>,
    /// What labels tell of a face; none when nobody labelled one.
    pub attributes: Vec<Attribute>,
    /// Named points.
    pub landmarks: Vec<Landmark>,
    /// What can be measured.
    pub measures: Vec<Measure>,
    /// The fall-off distance.
    pub blending: Blending,
}

/// What is computed once from the parts, for every face of the model.
#[derive(Debug)]
pub(crate) struct Derived {
    /// All vertices, for normals.
    pub whole: Patch,
    /// What follows each block at the model's own fall-off distance.
    pub reach: Arc<Reach>,
    /// The coefficients of the face on which every control reads 0.5.
    pub median: Vec<i32>,
    /// Its positions and normals, once there is a face.
    pub start: OnceLock<[Vec<Vec3>; 2]>,
    /// The correlation and its lower Cholesky factor.
    pub correlation: DMatrix<f64>,
    pub cholesky: DMatrix<f64>,
    /// Of each attribute with the read-out w: R w and w . R w.
    pub along: Vec<(Vec<f64>, f64)>,
    pub fingerprint: u32,
}

/// A face model, read from a blob. Cheap to clone; faces share it.
#[derive(Debug, Clone)]
pub struct FaceModel {
    pub(crate) parts: Arc<ModelParts>,
    pub(crate) derived: Arc<Derived>,
}

impl FaceModel {
    /// Reads a model from the bytes of a file, packed or not; on wasm32, where the platform
    /// inflates, not packed.
    ///
    /// # Errors
    /// [`Error::Blob`] or [`Error::Version`] with the reason, for any bytes that are not a whole
    /// and consistent model.
    pub fn parse(bytes: &[u8]) -> Result<Self> {
        #[cfg(not(target_arch = "wasm32"))]
        let bytes = &crate::blob::unpack(bytes)?;
        let blob = Blob::parse(bytes, Kind::Model)?;
        let (mut parts, whole) = ModelParts::read(&blob)?;
        let population = parts.population();
        let correlation = DMatrix::from_row_iterator(
            population,
            population,
            parts.correlation.iter().map(|&r| f64::from(r)),
        );
        let mut fingerprint = blob.fingerprint();
        if let Some(read) = read_attributes(&blob, population)? {
            (fingerprint, parts.attributes) = read;
        }
        let mut changes = Vec::new();
        for attribute in &parts.attributes {
            let (change, variance) = along(&correlation, &attribute.reading);
            if variance.is_nan() || variance < 1e-12 {
                return Err(unsound(attribute));
            }
            changes.push((change, variance));
        }
        let Some(cholesky) = correlation.clone().cholesky() else {
            return Err(Error::Blob(
                "its correlation matrix is not positive definite".into(),
            ));
        };
        let mut median = vec![0.0_f32; parts.coefficients()];
        for control in parts.controls.iter().filter(|c| c.measure.is_none()) {
            let amount = (control.median() - control.read(&median)) / control.gain();
            for &(i, change) in &control.direction {
                median[i as usize] += amount * change;
            }
        }
        if let Some(i) = median.iter().position(|m| !(m.abs() <= LIMIT)) {
            return Err(Error::Blob(format!(
                "its median person has {} sigmas of coefficient {i}",
                Number(median[i].into())
            )));
        }
        let median = median.into_iter().map(crate::face::grid).collect();
        Ok(Self {
            derived: Arc::new(Derived {
                reach: Arc::new(Reach::new(&parts, parts.blending.alpha)),
                whole,
                median,
                start: OnceLock::new(),
                correlation,
                cholesky: cholesky.l(),
                along: changes,
                fingerprint,
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

    /// Which of the attributes has a name.
    pub(crate) fn attribute(&self, name: &str) -> Result<usize> {
        let found = self.parts.attributes.iter().position(|a| a.name == name);
        found.ok_or_else(|| Error::Unknown {
            kind: "attribute",
            name: name.to_owned(),
        })
    }

    /// Which of the attributes it is of which a value may be asked for.
    pub(crate) fn asked(&self, name: &str, value: f64) -> Result<usize> {
        let attribute = self.attribute(name)?;
        let [least, most] = self.parts.attributes[attribute].limits.map(f64::from);
        match (least..=most).contains(&value) {
            true => Ok(attribute),
            false => Err(Error::Value {
                what: "an attribute",
                wanted: range([least, most], ""),
                got: value,
            }),
        }
    }

    /// Which blocks a region is made of: the one of that name and its local ones.
    pub(crate) fn region(&self, name: &str) -> Result<Vec<bool>> {
        let own: Vec<bool> = (self.parts.blocks.iter())
            .map(|block| block.region() == name)
            .collect();
        match own.contains(&true) {
            true => Ok(own),
            false => Err(Error::Unknown {
                kind: "region",
                name: name.to_owned(),
            }),
        }
    }
}

impl ModelParts {
    /// How many coefficients a face has.
    pub fn coefficients(&self) -> usize {
        self.blocks.iter().map(|b| b.sigmas.len()).sum()
    }

    /// How many of them describe people: those of all blocks that are not local, which come first.
    pub fn population(&self) -> usize {
        let people = self.blocks.iter().filter(|b| b.local_to.is_none());
        people.map(|b| b.sigmas.len()).sum()
    }

    /// The bytes of the model's blob; [`pack`](crate::blob::pack) makes a file of them.
    ///
    /// Mean, texture coordinates, correlations and distances are rounded to their grids
    /// ([`crate::quantise`]); what lies on them is read as it was.
    ///
    /// # Errors
    /// When the header cannot be written, the mean has a coordinate that is no number, or a vertex
    /// or corner is named that is not there.
    pub fn write(&self) -> Result<Vec<u8>> {
        let topology = &self.topology;
        self.can_be_written()?;
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
                    measure: c.measure,
                })
                .collect(),
            blending: self.blending,
        };
        let mut blob = BlobWriter::new(Kind::Model, &header);
        let walk = topology.walk();
        topology.write(&mut blob, &walk);
        let mean: Vec<i32> = (self.mean.iter().flat_map(|p| p.to_array()))
            .map(|x| COORDINATES.index(x.into()))
            .collect();
        blob.planes("mean", &walk.residuals(&mean, 3));
        let total = self.population();
        let below = (0..total).flat_map(|i| &self.correlation[i * total..i * total + i]);
        let below: Vec<i32> = below.map(|&r| CORRELATIONS.index(r.into())).collect();
        blob.planes("correlation", &below);
        let quantiles: Vec<f32> = self
            .controls
            .iter()
            .flat_map(|c| c.limits.iter().chain(&c.quantiles).copied())
            .collect();
        blob.section("quantiles", &quantiles);
        for (b, block) in self.blocks.iter().enumerate() {
            let own = walk.on(&block.support);
            // All numbers of a vertex together: its predictors are looked up once.
            let modes: Vec<i32> = (block.modes.by_vertex().into_iter())
                .map(i32::from)
                .collect();
            blob.planes(
                &format!("modes.{b}"),
                &own.residuals(&modes, 3 * block.sigmas.len()),
            );
            blob.section(&format!("sigmas.{b}"), &block.sigmas);
            if block.surround.is_some() || block.local_to.is_some() {
                blob.planes(&format!("support.{b}"), &differences(&block.support));
            }
            if let Some(surround) = &block.surround {
                blob.planes(&format!("targets.{b}"), &differences(&surround.targets));
                let distances = surround.distances.iter();
                let distances: Vec<i32> = distances.map(|&d| DISTANCES.index(d.into())).collect();
                let residuals = walk.on(&surround.targets).residuals(&distances, 1);
                blob.planes(&format!("distances.{b}"), &residuals);
                let rigid = surround.rigid.iter().flat_map(|r| {
                    let weights = r.weights.map(u32::from);
                    [r.part].into_iter().chain(r.sources).chain(weights)
                });
                let rigid: Vec<i32> = rigid.map(|number| number as i32).collect();
                blob.planes(&format!("rigid.{b}"), &rigid);
            }
        }
        if !self.attributes.is_empty() {
            let plain = blob.finish();
            let fingerprint = Blob::parse(&plain, Kind::Model)?.fingerprint();
            let words = (self.attributes.iter())
                .flat_map(|a| [&a.name, &a.description, &a.unit].map(String::clone));
            blob.record("attributes", &(fingerprint, words.collect::<Vec<_>>()));
            let numbers = self.attributes.iter().flat_map(Attribute::numbers);
            blob.section("read-outs", &numbers.collect::<Vec<_>>());
        }
        Ok(blob.finish())
    }

    fn can_be_written(&self) -> Result<()> {
        let bad = |why: String| Err(Error::Blob(why));
        let Topology {
            uvs,
            uv_vertices,
            uv_triangles,
            regions,
            ..
        } = &self.topology;
        let (n, total) = (self.mean.len(), self.population());
        let below = |numbers: &[u32], end: usize| numbers.iter().all(|&i| (i as usize) < end);
        if regions.len() != n || uv_vertices.len() != uvs.len() || uvs.len() < n {
            return bad("its topology is of another number of vertices".into());
        }
        if !below(uv_vertices, n) || !below(uv_triangles.as_flattened(), uvs.len()) {
            return bad("a triangle has a corner that is not there".into());
        }
        if let Some(v) = self.mean.iter().position(|p| !p.is_finite()) {
            return bad(format!("vertex {v} of its mean is no point"));
        }
        if self.correlation.len() != total * total {
            return bad(format!("{} correlations", self.correlation.len()));
        }
        for block in &self.blocks {
            let targets = block.surround.as_ref().map_or(&[][..], |s| &s.targets);
            if !below(&block.support, n) || !below(targets, n) {
                return bad(format!(
                    "block \"{}\" moves a vertex that is not there",
                    block.name
                ));
            }
        }
        Ok(())
    }

    /// And all vertices, for normals.
    fn read(blob: &Blob) -> Result<(Self, Patch)> {
        let header: Header = blob.header()?;
        let bad = |why: String| Err(Error::Blob(why));
        if header.units != "mm" {
            return bad(format!("its unit is \"{}\", not mm", header.units));
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
        let (topology, walk, around) = Topology::read(
            blob,
            n,
            header.corners as usize,
            header.triangles as usize,
            header.regions,
            header.parts,
        )?;
        let mean = read_mean(blob, &walk, n)?;
        let total: u64 = header.blocks.iter().map(|b| u64::from(b.modes)).sum();
        let empty = header.blocks.iter().any(|b| b.modes == 0);
        if empty || total > MAX_COEFFICIENTS as u64 || header.blocks.len() > MAX_BLOCKS {
            return bad(format!(
                "{total} coefficients in {} blocks",
                header.blocks.len()
            ));
        }
        let total = total as usize;
        let mut blocks = Vec::with_capacity(header.blocks.len());
        let mut first_coefficient = 0;
        for (b, block) in header.blocks.into_iter().enumerate() {
            let block = read_block(blob, b, block, (&topology, &walk, &mean), first_coefficient)?;
            first_coefficient += block.sigmas.len();
            if blocks.iter().any(|other: &Block| other.name == block.name) {
                return bad(format!("two blocks are called \"{}\"", block.name));
            }
            let local = |block: &Block| block.local_to.is_some();
            if !local(&block) && blocks.last().is_some_and(local) {
                return bad(format!("block \"{}\" follows a local one", block.name));
            }
            let edited = |region: &String| {
                let mut others = blocks.iter().filter(|other| !local(other));
                others.any(|other| other.name == *region)
            };
            if !block.local_to.as_ref().is_none_or(edited) {
                return bad(format!("block \"{}\" is local to none", block.name));
            }
            blocks.push(block);
        }
        let people = blocks.iter().filter(|b| b.local_to.is_none());
        let correlation = read_correlation(blob, people.map(|b| b.sigmas.len()).sum())?;
        let counts = Counts {
            coefficients: total,
            measures: header.measures.len(),
        };
        let controls = read_controls(blob, header.controls, header.quantiles, counts)?;
        for landmark in &header.landmarks {
            let sum: f64 = landmark.stencil.iter().map(|s| s.1).sum();
            let sound = landmark
                .stencil
                .iter()
                .all(|s| (s.0 as usize) < n && s.1.abs() <= 2.0);
            if !sound || !((sum - 1.0).abs() < 1e-3) {
                return bad(format!("landmark \"{}\" is not on the head", landmark.name));
            }
        }
        let landmarks = header.landmarks.len();
        let mut measures = header.measures.iter();
        if let Some(m) = measures.find(|m| !m.quantity.is_sound(landmarks)) {
            return bad(format!("measure \"{}\" has no landmarks", m.name));
        }
        let Blending {
            alpha,
            limits: [least, most],
        } = header.blending;
        let whole = [least, alpha, most]
            .iter()
            .all(|&mm| crate::face::micrometres(mm) == mm);
        if !(whole && least > 0.0 && least <= alpha && alpha <= most && most <= FARTHEST_REACH) {
            let [least, alpha, most] = [least, alpha, most].map(|mm| Number(mm.into()));
            return bad(format!(
                "a blending distance of {alpha} mm in {least} to {most}"
            ));
        }
        let parts = Self {
            about: header.about,
            mean,
            topology,
            blocks,
            controls,
            correlation,
            attributes: Vec::new(),
            landmarks: header.landmarks,
            measures: header.measures,
            blending: header.blending,
        };
        Ok((parts, Patch::new(&around)))
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
        step: block.modes.step(),
        support: block.support.len() as u32,
        surround: block.surround.as_ref().map(|s| SurroundHeader {
            targets: s.targets.len() as u32,
            rigid: s.rigid.len() as u32,
        }),
        local_to: block.local_to.clone(),
    }
}

/// Each number as its difference from the one before.
pub(crate) fn differences(numbers: &[u32]) -> Vec<i32> {
    let before = [0].iter().chain(numbers);
    let pairs = numbers.iter().zip(before);
    pairs.map(|(b, a)| b.wrapping_sub(*a) as i32).collect()
}

/// The inverse of [`differences`] for vertices in order: increasing and below `n`.
pub(crate) fn vertices(blob: &Blob, name: &str, length: u32, n: usize) -> Result<Vec<u32>> {
    let mut next = 0_u32;
    let numbers: Vec<u32> = (blob.planes(name, length as usize)?.into_iter())
        .map(|step| {
            next = next.wrapping_add(step as u32);
            next
        })
        .collect();
    let increasing = numbers.windows(2).all(|w| w[0] < w[1]);
    match increasing && numbers.last().is_none_or(|&v| (v as usize) < n) {
        true => Ok(numbers),
        false => Err(Error::Blob(format!("section \"{name}\" is not in order"))),
    }
}

fn read_mean(blob: &Blob, walk: &Walk, n: usize) -> Result<Vec<Vec3>> {
    let mean = walk.restore(blob.in_planes("mean", 3 * n)?, 3, 1);
    let most = COORDINATES.index(LARGEST_COORDINATE.into()).unsigned_abs();
    let numbers = mean
        .iter()
        .flat_map(|four| four.to_array().into_iter().take(3));
    if let Some((at, x)) = numbers.enumerate().find(|(_, x)| x.unsigned_abs() > most) {
        return Err(Error::Blob(format!(
            "number {at} of section \"mean\" is {}, outside +-{}",
            Number(COORDINATES.point(x)),
            Number(LARGEST_COORDINATE.into())
        )));
    }
    let point =
        |p: &i32x4| Vec4::from(p.to_array().map(|i| COORDINATES.point(i) as f32)).truncate();
    Ok(mean.iter().map(point).collect())
}

fn read_correlation(blob: &Blob, total: usize) -> Result<Vec<f32>> {
    let below = blob.planes("correlation", total * total.saturating_sub(1) / 2)?;
    let mut correlation = vec![1.0; total * total];
    let pairs = (0..total).flat_map(|i| (0..i).map(move |j| (i, j)));
    for ((i, j), index) in pairs.zip(below) {
        let r = CORRELATIONS.point(index) as f32;
        if !(r.abs() <= 1.0) {
            return Err(Error::Blob(format!(
                "row {i} of its correlation matrix has a correlation of {}",
                Number(r.into())
            )));
        }
        correlation[i * total + j] = r;
        correlation[j * total + i] = r;
    }
    Ok(correlation)
}

fn read_block(
    blob: &Blob,
    b: usize,
    header: BlockHeader,
    (topology, walk, mean): (&Topology, &Walk, &[Vec3]),
    first_coefficient: usize,
) -> Result<Block> {
    let bad = |why: String| Err(Error::Blob(format!("block \"{}\": {why}", header.name)));
    let n = mean.len();
    let mut regions = Vec::new();
    for name in &header.regions {
        match topology.region_names.iter().position(|r| r == name) {
            Some(region) => regions.push(region as u8),
            None => return bad(format!("no region is called \"{name}\"")),
        }
    }
    if header.local_to.is_some() && header.surround.is_some() {
        return bad("it is local and has a surround".into());
    }
    let support: Vec<u32> = match header.surround.is_some() || header.local_to.is_some() {
        true => vertices(blob, &format!("support.{b}"), header.support, n)?,
        false => (0..n as u32).collect(),
    };
    if support.is_empty() || support.len() != header.support as usize {
        return bad(format!("a support of {} vertices", header.support));
    }
    let modes = header.modes as usize;
    let residuals = blob.in_planes(&format!("modes.{b}"), 3 * support.len() * modes)?;
    let rows = match support.len() == n {
        true => walk.restore(residuals, modes, 3),
        false => walk.on(&support).restore(residuals, modes, 3),
    };
    let (modes, fit) = Modes::of_rows(sound_step(header.step)?, modes, &rows);
    if !fit {
        return bad("a mode of more steps than 16 bits hold".into());
    }
    // Many more bytes than all that is left.
    drop(rows);
    let sigmas = blob.floats(&format!("sigmas.{b}"), modes.count(), 1e9)?;
    let surround = match header.surround {
        None => None,
        Some(SurroundHeader { targets, rigid }) => {
            let targets = vertices(blob, &format!("targets.{b}"), targets, n)?;
            let distances = blob.in_planes(&format!("distances.{b}"), targets.len())?;
            let distances: Vec<f32> = (walk.on(&targets).restore(distances, 1, 1).iter())
                .map(|d| DISTANCES.point(d.to_array()[0]) as f32)
                .collect();
            if distances.iter().any(|&d| d > LARGEST_COORDINATE) {
                return bad("a distance beyond all heads".into());
            }
            let rigid = read_rigid(blob, &format!("rigid.{b}"), rigid)?;
            match Surround::new(mean, topology, &support, targets, distances, rigid) {
                Ok(surround) => Some(surround),
                Err(why) => return bad(why.to_string()),
            }
        }
    };
    Ok(Block {
        modes,
        name: header.name,
        regions,
        support,
        sigmas,
        first_coefficient,
        surround,
        local_to: header.local_to,
    })
}

fn read_rigid(blob: &Blob, name: &str, count: u32) -> Result<Vec<Rigid>> {
    let numbers = blob.planes(name, (1 + 2 * SOURCES).saturating_mul(count as usize))?;
    let rigid = numbers.chunks_exact(1 + 2 * SOURCES).map(|row| Rigid {
        part: row[0] as u32,
        sources: std::array::from_fn(|i| row[1 + i] as u32),
        weights: std::array::from_fn(|i| row[1 + SOURCES + i] as u16),
    });
    Ok(rigid.collect())
}

/// The attributes, if there are any, and the fingerprint of the model without them: they name its
/// faces and change none, so that a face's code stays good when they are learned anew.
fn read_attributes(blob: &Blob, population: usize) -> Result<Option<(u32, Vec<Attribute>)>> {
    let Some((fingerprint, words)) = blob.record::<(u32, Vec<String>)>("attributes")? else {
        return Ok(None);
    };
    let each = 4 + population;
    let numbers = blob.floats("read-outs", words.len() / 3 * each, 1e6)?;
    let mut attributes: Vec<Attribute> = Vec::new();
    for (words, numbers) in words.chunks_exact(3).zip(numbers.chunks_exact(each)) {
        let attribute = Attribute {
            name: words[0].clone(),
            description: words[1].clone(),
            unit: words[2].clone(),
            limits: [numbers[0], numbers[1]],
            mean: numbers[2],
            explained: numbers[3],
            reading: numbers[4..].to_vec(),
        };
        let twice = attributes.iter().any(|a| a.name == attribute.name);
        let is_part = (0.0..=1.0).contains(&attribute.explained);
        if twice || !is_part || numbers[0] >= numbers[1] {
            return Err(unsound(&attribute));
        }
        attributes.push(attribute);
    }
    Ok(Some((fingerprint, attributes)))
}

fn unsound(attribute: &Attribute) -> Error {
    let name = &attribute.name;
    Error::Blob(format!("attribute \"{name}\" is not sound"))
}

/// How many there are of what controls name by number.
struct Counts {
    coefficients: usize,
    measures: usize,
}

fn read_controls(
    blob: &Blob,
    headers: Vec<ControlHeader>,
    quantiles: u32,
    counts: Counts,
) -> Result<Vec<Control>> {
    let q = quantiles as usize;
    if !(2..=4096).contains(&q) || headers.len() > 4096 {
        return Err(Error::Blob(format!(
            "{} controls of {q} quantiles",
            headers.len()
        )));
    }
    let table = blob.floats("quantiles", headers.len() * (2 + q), 1e6)?;
    let mut controls: Vec<Control> = Vec::with_capacity(headers.len());
    for (header, row) in headers.into_iter().zip(table.chunks_exact(2 + q)) {
        let (limits, quantiles) = row.split_first_chunk().unwrap_or((&[0.0; 2], row));
        let control = Control {
            name: header.name,
            group: header.group,
            description: header.description,
            direction: header.direction,
            reading: header.reading,
            measure: header.measure,
            quantiles: quantiles.to_vec(),
            limits: *limits,
        };
        let bad = |why: &str| Err(Error::Blob(format!("control \"{}\": {why}", control.name)));
        let terms = || control.direction.iter().chain(&control.reading);
        let in_order = |terms: &[(u32, f32)]| terms.windows(2).all(|w| w[0].0 < w[1].0);
        if terms().any(|t| t.0 as usize >= counts.coefficients || !(t.1.abs() <= 1e6))
            || !in_order(&control.direction)
            || !in_order(&control.reading)
        {
            return bad("its coefficients are unknown, or not in order");
        }
        let [least, most] = control.limits;
        let limited = 0.0 <= least && least < most && most <= 1.0;
        if !limited || quantiles.windows(2).any(|w| w[0] >= w[1]) {
            return bad("its quantiles or limits do not increase");
        }
        if controls.iter().any(|c| c.name == control.name) {
            return bad("there are two of that name");
        }
        match control.measure {
            None if !(control.gain().abs() >= 1e-6) => {
                return bad("it does not move its own read-out");
            }
            Some(m) if m as usize >= counts.measures => return bad("its measure is not there"),
            Some(_) if !control.reading.is_empty() || control.direction.is_empty() => {
                return bad("it measures and reads coefficients, or moves none");
            }
            _ => {}
        }
        controls.push(control);
    }
    Ok(controls)
}
