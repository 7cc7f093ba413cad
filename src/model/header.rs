//! The header of a model.

use serde::{Deserialize, Serialize};

use crate::anatomy::{Landmark, Measure, Part};
use crate::blob::record::record;

/// What the people in a model are, and are not, and whose work it stands on.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct About {
    /// The model's name.
    pub title: String,
    /// Who was learned from, in a sentence or two.
    pub population: String,
    /// What must not be read into it.
    pub caveat: String,
    /// How many faces it was learned from.
    pub faces: u32,
    /// The program and version that made it.
    pub made_by: String,
    /// Every source with its licence.
    pub licences: Vec<Licence>,
}

/// A source that went into the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Licence {
    /// What it is.
    pub source: String,
    /// Who made it.
    pub by: String,
    /// The licence's SPDX name.
    pub licence: String,
}

/// A block as the header names it; its numbers are in sections.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct BlockHeader {
    pub name: String,
    pub regions: Vec<String>,
    pub modes: u32,
    pub step: f32,
    /// How many vertices the block moves by itself.
    pub support: u32,
    pub surround: Option<SurroundHeader>,
    /// The block whose region it edits, if it is a local one.
    pub local_to: Option<String>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SurroundHeader {
    pub targets: u32,
    /// How many parts follow as one.
    pub rigid: u32,
}

/// A control as the header names it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ControlHeader {
    pub name: String,
    pub group: String,
    pub description: String,
    pub direction: Vec<(u32, f32)>,
    pub reading: Vec<(u32, f32)>,
    /// The measure that a semantic control sets, an index into `measures`.
    pub measure: Option<u32>,
}

/// The fall-off distance of blending, in mm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Blending {
    /// What the model was trained with.
    pub alpha: f32,
    /// The least and the greatest that a face takes.
    pub limits: [f32; 2],
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Header {
    pub about: About,
    pub units: String,
    pub vertices: u32,
    pub corners: u32,
    pub triangles: u32,
    pub quantiles: u32,
    pub regions: Vec<String>,
    pub parts: Vec<Part>,
    pub landmarks: Vec<Landmark>,
    pub measures: Vec<Measure>,
    pub blocks: Vec<BlockHeader>,
    pub controls: Vec<ControlHeader>,
    pub blending: Blending,
}

record! {
    About { title, population, caveat, faces, made_by, licences }
    Licence { source, by, licence }
    BlockHeader { name, regions, modes, step, support, surround, local_to }
    SurroundHeader { targets, rigid }
    ControlHeader { name, group, description, direction, reading, measure }
    Blending { alpha, limits }
    Header {
        about, units, vertices, corners, triangles, quantiles, regions, parts, landmarks, measures,
        blocks, controls, blending,
    }
}
