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
//! | `seams` | planes | M - N | the vertex of each corner from N on; the first N belong to the vertices in order |
//! | `uvs` | planes | 2 M | texture coordinates in units of [`TEXTURE`](crate::quantise::TEXTURE): of the first N corners, predicted over the vertices, all u, all v; then of each further corner u and v as differences from those of its vertex |
//! | `mirror` | planes | N | how many vertices ahead the one on the other side is; 0 when it is the same or an earlier one |
//! | `regions` | u8 | N | index into the header's `regions` |
//! | `colours` | u8 | 3 N | sRGB |
//! | `sides` | planes | 4 + all modes | how the mean, then each mode looks in the mirror: 0 as it is, -1 its opposite, 1 neither; then three 0 |
//! | `mean` | planes | 3 N | mean face, predicted over the vertices: all x, all y, all z, in units of [`COORDINATES`]; where its side is 0, of one side |
//! | `correlation` | planes | C (C - 1) / 2 | their correlation in the population, in units of [`CORRELATIONS`]: row by row, up to the diagonal |
//! | `quantiles` | f32 | P (2 + Q) | a control after another: the percentiles at which its slider ends, then the read-out at equally spaced percentiles |
//! | `support.b` | planes | S | vertices, increasing, each as its difference from the one before; absent for a block without surround that is not local (all N) |
//! | `modes.b` | planes | 3 S K | displacement for one sigma in units of the header's `step`, predicted over the support: a mode after another, of each all x, all y, all z; where none of the block's `sides` is 1, of one side |
//! | `sigmas.b` | f32 | K | standard deviations, mm |
//! | `targets.b` | planes | R | surround vertices, as `support.b` |
//! | `distances.b` | planes | R | distance from the region, predicted over the targets, in units of [`DISTANCES`] |
//! | `attributes` | u8 | any | absent without attributes: as in the header, the fingerprint that codes of faces begin with (a u32: the two halves of the checksum in exclusive or, of the model without this section and the next as it was first written), and a list of strings: name, description and unit of each of A attributes |
//! | `read-outs` | f32 | A (4 + C) | of each attribute both limits, the mean, the explained part, and the read-out's change with each coefficient |
//! | `rigid.b` | planes | 17 G | for each of the header's `rigid` parts that follow as one: the part, an index into `parts`; 8 places in the support; their weights, which sum to 65535 |
//!
//! A model without blocks is a head: one face, which a page shows while the rest loads.
//!
//! Planes are described in [`crate::blob`]. The units are in [`crate::quantise`].
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
//! *Of one side* are all but the vertices whose mirror image (the vertex of the other side) is an earlier one of
//! them: in the length N or S is how many these are. The others have the numbers of their images, x with the other
//! sign; in a mode with the side -1, y and z.
//!
//! What other targets follow is not kept: [`Surround::new`] finds it again.
//!
//! Sections are written in the order in which they are read, so that a model can be read while it comes in
//! ([`IncomingModel`]); in another order it is read all the same, once all of it is there.

mod attribute;
mod block;
mod control;
mod header;
mod reach;
mod read;
mod surround;
mod surrounding;

use std::sync::{Arc, OnceLock};

use glam::Vec3;
use nalgebra::DMatrix;

pub use crate::kernel::Modes;
pub use attribute::Attribute;
pub(crate) use attribute::along;
pub use block::{Block, FALLOFF_REACH, falloff};
pub use control::Control;
pub use header::{About, Blending, Licence};
#[cfg(feature = "fit")]
pub(crate) use read::MAX_COEFFICIENTS;
#[cfg(feature = "fit")]
pub(crate) use surround::Nearest;
pub use surround::{Rigid, SOURCES, Surround};

use crate::anatomy::{Landmark, Measure};
use crate::blob::{Blob, BlobWriter, Kind};
use crate::error::range;
use crate::kernel::Patch;
use crate::mesh::Topology;
use crate::quantise::{COORDINATES, CORRELATIONS, DISTANCES};
use crate::{Error, Result};
use header::{BlockHeader, ControlHeader, Header, SurroundHeader};
pub(crate) use reach::Reach;
pub use read::IncomingModel;
pub(crate) use read::vertices;

/// A mode that is its own mirror image, in `sides`.
const EVEN: i32 = 0;
/// One that is the opposite of it.
const ODD: i32 = -1;
const NEITHER: i32 = 1;

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
        read::model(&Blob::parse(bytes, Kind::Model)?, None)
    }

    /// The bytes of this model's blob with other words on its controls, or other attributes: where there are
    /// attributes its faces keep their codes.
    ///
    /// # Errors
    /// When more than these is changed, and as [`ModelParts::write`].
    pub fn rewritten(&self, parts: &ModelParts) -> Result<Vec<u8>> {
        let mut same = parts.clone();
        same.attributes.clone_from(&self.parts.attributes);
        for (control, own) in same.controls.iter_mut().zip(&self.parts.controls) {
            control.description.clone_from(&own.description);
        }
        if same != *self.parts {
            return Err(Error::Blob("it is another model's".into()));
        }
        parts.write_as(Some(self.derived.fingerprint))
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
    /// When the mean has a coordinate that is no number, a vertex, corner or region is named that is not there, there
    /// are not as many numbers as there are vertices or coefficients, the topology is not what [`Topology`] says of it, or it
    /// is more than a reader takes.
    pub fn write(&self) -> Result<Vec<u8>> {
        self.write_as(None)
    }

    /// As [`ModelParts::write`], with the fingerprint that its faces' codes begin with, where there are attributes.
    fn write_as(&self, fingerprint: Option<u32>) -> Result<Vec<u8>> {
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
        let all: Vec<u32> = (0..self.mean.len() as u32).collect();
        let sides = self.sides(&mean);
        // Who reads takes them four at a time.
        blob.planes("sides", &[&sides[..], &[0; 3]].concat());
        let (of_mean, sides) = (sides[0], &sides[1..]);
        // What one side says of the other is written once.
        let mirror = &topology.mirror;
        let residuals = |vertices: &[u32], numbers: &[i32], whole: bool| {
            let width = numbers.len() / vertices.len().max(1);
            walk.on(vertices, mirror, whole).residuals(numbers, width)
        };
        blob.planes("mean", &residuals(&all, &mean, of_mean == NEITHER));
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
            // All numbers of a vertex together: its predictors are looked up once.
            let modes: Vec<i32> = (block.modes.by_vertex().into_iter())
                .map(i32::from)
                .collect();
            let whole = sides[block.coefficients()].contains(&NEITHER);
            let name = format!("modes.{b}");
            blob.planes(&name, &residuals(&block.support, &modes, whole));
            blob.section(&format!("sigmas.{b}"), &block.sigmas);
            if block.surround.is_some() || block.local_to.is_some() {
                blob.planes(&format!("support.{b}"), &differences(&block.support));
            }
            if let Some(surround) = &block.surround {
                blob.planes(&format!("targets.{b}"), &differences(&surround.targets));
                let distances = surround.distances.iter();
                let distances: Vec<i32> = distances.map(|&d| DISTANCES.index(d.into())).collect();
                let residuals = walk
                    .on(&surround.targets, mirror, true)
                    .residuals(&distances, 1);
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
            let plain = blob.finish()?;
            let fingerprint = match fingerprint {
                Some(kept) => kept,
                None => Blob::parse(&plain, Kind::Model)?.fingerprint(),
            };
            let words = (self.attributes.iter())
                .flat_map(|a| [&a.name, &a.description, &a.unit].map(String::clone));
            blob.record("attributes", &(fingerprint, words.collect::<Vec<_>>()));
            let numbers = self.attributes.iter().flat_map(Attribute::numbers);
            blob.section("read-outs", &numbers.collect::<Vec<_>>());
        }
        blob.finish()
    }

    /// Which modes are the opposite of their mirror image, one a coefficient: a nose to the left, whose opposite is
    /// as much to the right. All but the local ones are that or their own image where a model was learned from
    /// people and their mirror images.
    pub fn odd(&self) -> Vec<bool> {
        self.sides(&[])
            .iter()
            .skip(1)
            .map(|&side| side == ODD)
            .collect()
    }

    /// How the mean (in steps of its grid) and then each mode looks in the mirror: [`EVEN`], [`ODD`] or
    /// [`NEITHER`]. The mean is not odd.
    fn sides(&self, mean: &[i32]) -> Vec<i32> {
        let mirror = &self.topology.mirror;
        let side = |vertices: &[u32], number: &dyn Fn(usize, usize) -> i32| {
            let image = |v: u32| vertices.binary_search(&mirror[v as usize]).ok();
            let images: Option<Vec<usize>> = vertices.iter().map(|&v| image(v)).collect();
            let is = |odd: bool| {
                images.iter().flatten().enumerate().all(|(at, &image)| {
                    (0..3).all(|axis| match (axis == 0) != odd {
                        true => number(at, axis) == -number(image, axis),
                        false => number(at, axis) == number(image, axis),
                    })
                })
            };
            match (images.is_some(), is(false), is(true)) {
                (true, true, _) => EVEN,
                (true, _, true) => ODD,
                _ => NEITHER,
            }
        };
        // One a coefficient, also of a block that is none: its reader says so.
        let of_block = |block: &Block| {
            let Block { modes, support, .. } = block;
            let is_whole = modes.numbers() == 3 * support.len();
            let each = (0..block.sigmas.len()).map(|k| match is_whole && k < modes.count() {
                true => side(support, &|v, axis| modes.get(k, 3 * v + axis).into()),
                false => NEITHER,
            });
            each.collect::<Vec<_>>()
        };
        let all: Vec<u32> = (0..mean.len() as u32 / 3).collect();
        let of_mean = match side(&all, &|v, axis| mean[3 * v + axis]) {
            EVEN => EVEN,
            _ => NEITHER,
        };
        let of_modes = self.blocks.iter().flat_map(of_block);
        [of_mean].into_iter().chain(of_modes).collect()
    }

    fn can_be_written(&self) -> Result<()> {
        let bad = |why: String| Err(Error::Blob(why));
        let Topology {
            uvs,
            uv_vertices,
            uv_triangles,
            regions,
            mirror,
            region_names,
            colours,
            ..
        } = &self.topology;
        let (n, total) = (self.mean.len(), self.population());
        let below = |numbers: &[u32], end: usize| numbers.iter().all(|&i| (i as usize) < end);
        if [regions.len(), mirror.len(), colours.len()] != [n; 3]
            || uv_vertices.len() != uvs.len()
            || uvs.len() < n
        {
            return bad("its topology is of another number of vertices".into());
        }
        if !below(uv_vertices, n) || !below(uv_triangles.as_flattened(), uvs.len()) {
            return bad("a triangle has a corner that is not there".into());
        }
        if !(0..n).all(|v| uv_vertices[v] as usize == v) {
            return bad("the corners of vertices are not in their order".into());
        }
        if !below(mirror, n) || !(0..n).all(|v| mirror[mirror[v] as usize] as usize == v) {
            return bad("its mirror map is not an involution".into());
        }
        if let Some(v) = self.mean.iter().position(|p| !p.is_finite()) {
            return bad(format!("vertex {v} of its mean is no point"));
        }
        if self.correlation.len() != total * total {
            return bad(format!("{} correlations", self.correlation.len()));
        }
        for block in &self.blocks {
            let surround = block.surround.as_ref();
            let targets = surround.map_or(&[][..], |s| &s.targets);
            let distances = surround.map_or(0, |s| s.distances.len());
            let mut covered = block.regions.iter();
            if !covered.all(|&r| usize::from(r) < region_names.len()) {
                return bad(format!("block \"{}\" covers no region", block.name));
            }
            if distances != targets.len() {
                return bad(format!(
                    "block \"{}\" has {distances} distances",
                    block.name
                ));
            }
            if !below(&block.support, n) || !below(targets, n) {
                return bad(format!(
                    "block \"{}\" moves a vertex that is not there",
                    block.name
                ));
            }
        }
        Ok(())
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
