//! Expressions: smiles, blinks and glances, on any face of a model.
//!
//! They come in a file of their own, so that a page can show a face before it has them. In it an
//! expression is how far each vertex moves on the *mean* head. On another face each of these
//! displacements is turned and stretched as that face differs from the mean around the vertex
//! (`carry`), so that a broad mouth smiles more broadly; lids close as far as they are open, and
//! slide on the eyeball instead of through it (`eye`). Expressions with the names of ARKit's have
//! its meaning: weights from 0 to 1 that are summed, and left is the subject's left.
//!
//! # The file
//!
//! A blob (see [`crate::blob`]) of kind 4. Its header says of which mean head it is, and names the
//! expressions; the sections hold their displacements, those of an expression that is alike on both
//! sides only on one. `support.I` are the vertices (differences of increasing numbers) and `moves.I`
//! what prediction along the mesh misses of the displacements in steps, three a vertex.

mod carry;
mod eye;
mod performance;

use std::sync::Arc;

use glam::{Vec3, Vec4};

use crate::blob::record::record;
use crate::blob::{Blob, BlobWriter, Kind};
use crate::error::Number;
use crate::model::{FaceModel, ModelParts};
use crate::quantise::COORDINATES;
use crate::{Error, Result};
use carry::Carrier;
use eye::Eye;

pub use performance::Performance;

/// Displacements are stored in steps of this many mm: a vertex is off by at most 0.017 mm.
pub const STEP: f32 = 0.02;

/// An expression on the mean head.
#[derive(Debug, Clone, PartialEq)]
pub struct Expression {
    /// Its name, such as `jawOpen`.
    pub name: String,
    /// The vertices it moves, increasing.
    pub support: Vec<u32>,
    /// How far it moves each of them, mm.
    pub displacements: Vec<Vec3>,
    /// How it turns the subject's left and right eyeball: an axis times an angle in radians.
    pub turns: [Vec3; 2],
    /// Pairs of landmarks that it brings together: a lid that closes.
    pub meets: Vec<[u32; 2]>,
}

/// How an expression is stored: of one that is alike on both sides only the vertices that do not
/// come after their mirror image, of one that has a twin, its mirror image, all.
struct ExpressionHeader {
    name: String,
    /// The name of its mirror image, which follows it and is not stored.
    twin: Option<String>,
    support: u32,
    turns: [[f32; 3]; 2],
    meets: Vec<[u32; 2]>,
}

struct Header {
    /// [`shape`] of the model.
    shape: u32,
    step: f32,
    expressions: Vec<ExpressionHeader>,
}

record! {
    ExpressionHeader { name, twin, support, turns, meets }
    Header { shape, step, expressions }
}

/// Which mean head and which mesh: FNV-1a over the mean's coordinates on their grid and the
/// triangles. Models that were trained otherwise but have this head can share expressions.
fn shape(model: &FaceModel) -> u32 {
    let parts = model.parts();
    let mean = parts.mean.iter().flat_map(|p| p.to_array());
    let mean = mean.map(|x| COORDINATES.index(x.into()) as u32);
    let corners = parts.topology.uv_triangles.as_flattened().iter().copied();
    mean.chain(corners).fold(0x811c_9dc5, |hash: u32, word| {
        (hash ^ word).wrapping_mul(0x0100_0193)
    })
}

/// How some of `n` vertices move, by vertex; `None` when one is there twice.
#[inline(never)]
fn by_vertex(moved: &[(u32, Vec3)], n: usize) -> Option<(Vec<u32>, Vec<Vec3>)> {
    let mut places = vec![usize::MAX; n];
    for (i, &(v, _)) in moved.iter().enumerate() {
        if places[v as usize] != usize::MAX {
            return None;
        }
        places[v as usize] = i;
    }
    places.retain(|&i| i != usize::MAX);
    Some(places.into_iter().map(|i| moved[i]).unzip())
}

fn flip(v: Vec3) -> Vec3 {
    Vec3::new(-v.x, v.y, v.z)
}

/// The mirror image of a turn: the axis is a pseudo-vector.
fn flip_turn(v: Vec3) -> Vec3 {
    Vec3::new(v.x, -v.y, -v.z)
}

impl Expression {
    /// The same on the other side of the face, whose landmarks are `meets`.
    fn mirrored(&self, name: String, mirror: &[u32], meets: Vec<[u32; 2]>) -> Self {
        let moved: Vec<(u32, Vec3)> = (self.support.iter().zip(&self.displacements))
            .map(|(&v, &d)| (mirror[v as usize], flip(d)))
            .collect();
        // A vertex has one mirror image, and no other has that one.
        let (support, displacements) = by_vertex(&moved, mirror.len()).unwrap_or_default();
        Self {
            name,
            support,
            displacements,
            turns: [flip_turn(self.turns[1]), flip_turn(self.turns[0])],
            meets,
        }
    }
}

/// Writes the file of a model's expressions.
///
/// Those whose names end in `Left` and `Right` follow each other and are mirror images; of such a
/// pair only the first is stored, and of all others only one side.
///
/// # Errors
/// When an expression moves a vertex that is not there, not as many as it has displacements, or some out of order, or
/// when [`Expressions::parse`] would refuse the file: two have one name, eyes turn too far, landmarks are not there, a
/// vertex moves by a metre, there are too many.
pub fn write(model: &FaceModel, expressions: &[Expression]) -> Result<Vec<u8>> {
    let topology = &model.parts().topology;
    let (n, mirror) = (topology.regions.len(), &topology.mirror);
    let walk = topology.walk();
    let mut headers = Vec::new();
    let mut stored = Vec::new();
    let mut skip = false;
    for (i, expression) in expressions.iter().enumerate() {
        if std::mem::take(&mut skip) {
            continue;
        }
        let support = &expression.support;
        let in_order = support.windows(2).all(|w| w[0] < w[1]);
        let there = support.last().is_none_or(|&v| (v as usize) < n);
        if !in_order || !there || support.len() != expression.displacements.len() {
            return Err(Error::Blob(format!(
                "expression \"{}\" moves vertices that are not there, or not in order",
                expression.name
            )));
        }
        let twin = expressions.get(i + 1).filter(|next| {
            let stem = expression.name.strip_suffix("Left");
            stem.is_some_and(|stem| next.name.strip_suffix("Right") == Some(stem))
        });
        skip = twin.is_some();
        let symmetric = twin.is_none();
        let kept: Vec<(u32, Vec3)> = (expression.support.iter().zip(&expression.displacements))
            .filter(|(v, _)| !symmetric || **v <= mirror[**v as usize])
            .map(|(&v, &d)| (v, d))
            .collect();
        let mut meets = expression.meets.clone();
        meets.extend(twin.iter().flat_map(|t| t.meets.iter().copied()));
        headers.push(ExpressionHeader {
            name: expression.name.clone(),
            twin: twin.map(|t| t.name.clone()),
            support: kept.len() as u32,
            turns: expression.turns.map(|t| t.to_array()),
            meets,
        });
        stored.push(kept);
    }
    let header = Header {
        shape: shape(model),
        step: STEP,
        expressions: headers,
    };
    let mut blob = BlobWriter::new(Kind::Expressions, &header);
    for (i, kept) in stored.iter().enumerate() {
        let support: Vec<u32> = kept.iter().map(|k| k.0).collect();
        let steps: Vec<i32> = kept
            .iter()
            .flat_map(|k| k.1.to_array())
            .map(|x| (f64::from(x) / f64::from(STEP)).round() as i32)
            .collect();
        blob.planes(
            &format!("support.{i}"),
            &crate::model::differences(&support),
        );
        blob.planes(
            &format!("moves.{i}"),
            &walk.on(&support, mirror, true).residuals(&steps, 3),
        );
    }
    let bytes = blob.finish()?;
    read(&Blob::parse(&bytes, Kind::Expressions)?, model)?;
    Ok(bytes)
}

/// The expressions of a model. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Expressions {
    list: Arc<Vec<Expression>>,
    derived: Arc<Derived>,
}

/// What is computed once from the expressions and the mean head.
#[derive(Debug)]
struct Derived {
    /// Of the model that they were read for: what they name by number is its.
    parts: Arc<ModelParts>,
    /// The vertices that any expression moves, increasing.
    moved: Vec<u32>,
    /// The place of a vertex among them; of one that none moves, anything.
    places: Vec<u32>,
    /// For small displacements and for large ones.
    carriers: [Carrier; 2],
    /// How much of each expression is carried as large.
    large: Vec<f32>,
    eyes: Vec<Eye>,
}

impl Derived {
    /// How much of an expression is carried as small (0) or large (1).
    fn part(&self, expression: usize, scale: usize) -> f32 {
        match scale {
            0 => 1.0 - self.large[expression],
            _ => self.large[expression],
        }
    }
}

impl Expressions {
    /// Reads the expressions of a model from the bytes of their file, packed or not; on wasm32,
    /// where the platform inflates, not packed.
    ///
    /// # Errors
    /// [`Error::Blob`] or [`Error::Version`] for bytes that are not such a file,
    /// [`Error::Mismatch`] when it is for another mean head.
    pub fn parse(bytes: &[u8], model: &FaceModel) -> Result<Self> {
        #[cfg(not(target_arch = "wasm32"))]
        let bytes = &crate::blob::unpack(bytes)?;
        let blob = Blob::parse(bytes, Kind::Expressions)?;
        let list = read(&blob, model)?;
        let mut moved = vec![false; model.parts().mean.len()];
        for &v in list.iter().flat_map(|expression| &expression.support) {
            moved[v as usize] = true;
        }
        let mut places = vec![0; moved.len()];
        let moved: Vec<u32> = (0..moved.len() as u32)
            .filter(|&v| moved[v as usize])
            .collect();
        for (&v, place) in moved.iter().zip(0..) {
            places[v as usize] = place;
        }
        let derived = Derived {
            carriers: carry::REACHES.map(|reach| Carrier::new(model, &moved, reach)),
            large: (list.iter())
                .map(|expression| {
                    let lengths = expression.displacements.iter().map(|d| d.length());
                    carry::large_part(lengths.fold(0.0, f32::max))
                })
                .collect(),
            eyes: Eye::both(model, &moved),
            parts: model.parts.clone(),
            moved,
            places,
        };
        Ok(Self {
            list: Arc::new(list),
            derived: Arc::new(derived),
        })
    }

    /// The expressions, in the order of their weights.
    pub fn list(&self) -> &[Expression] {
        &self.list
    }

    /// The middle and the radius of the subject's left (0) or right (1) eyeball on a face without expression, mm; `None` of a
    /// model without eyes.
    #[cfg(feature = "photo")]
    pub(crate) fn eyeball(&self, side: usize, neutral: &[Vec3]) -> Option<(Vec3, f32)> {
        let mut eyes = self.derived.eyes.iter();
        eyes.find(|eye| eye.side() == side)?.ball(neutral)
    }

    /// The place of an expression.
    ///
    /// # Errors
    /// When none has that name.
    pub fn find(&self, name: &str) -> Result<usize> {
        let found = self.list.iter().position(|e| e.name == name);
        found.ok_or_else(|| Error::Unknown {
            kind: "expression",
            name: name.to_owned(),
        })
    }
}

#[inline(never)]
fn read(blob: &Blob, model: &FaceModel) -> Result<Vec<Expression>> {
    let header: Header = blob.header()?;
    let bad = |why: String| Err(Error::Blob(why));
    if header.shape != shape(model) {
        return Err(Error::Mismatch(
            "these expressions are for another head than the model's".into(),
        ));
    }
    if !(header.step > 0.0 && header.step <= 1.0) {
        return bad(format!("a step of {} mm", Number(header.step.into())));
    }
    let parts = model.parts();
    let (n, mirror) = (parts.topology.regions.len(), &parts.topology.mirror);
    let walk = parts.topology.walk();
    let mut list: Vec<Expression> = Vec::new();
    for (i, own) in header.expressions.into_iter().enumerate() {
        if own.support as usize > n {
            return bad(format!("expression \"{}\" moves too much", own.name));
        }
        let numbers = own.turns.as_flattened();
        // Half a turn is more than any eye does.
        if !numbers.iter().all(|x| x.abs() <= std::f32::consts::PI) {
            return bad(format!("expression \"{}\" turns eyes too far", own.name));
        }
        let named = |m: &[u32; 2]| m.iter().all(|&l| (l as usize) < parts.landmarks.len());
        if !own.meets.iter().all(named) {
            return bad(format!("expression \"{}\" has no landmarks", own.name));
        }
        let support = crate::model::vertices(blob, &format!("support.{i}"), own.support, n)?;
        let residuals = blob.in_planes(&format!("moves.{i}"), 3 * support.len())?;
        let steps = walk
            .on(&support, mirror, true)
            .restore(residuals, 3, 1, &[]);
        let displacements = (steps.iter())
            .map(|d| Vec4::from(d.to_array().map(|x| x as f32)).truncate() * header.step);
        let mut moved: Vec<(u32, Vec3)> = support.into_iter().zip(displacements).collect();
        // A metre is more than any face moves.
        if moved.iter().any(|m| !(m.1.abs().max_element() < 1000.0)) {
            return bad(format!("expression \"{}\" moves a vertex away", own.name));
        }
        if own.twin.is_none() {
            let images: Vec<(u32, Vec3)> = moved
                .iter()
                .filter(|m| mirror[m.0 as usize] != m.0)
                .map(|m| (mirror[m.0 as usize], flip(m.1)))
                .collect();
            moved.extend(images);
        }
        let Some((support, displacements)) = by_vertex(&moved, n) else {
            return bad(format!("expression \"{}\" has a vertex twice", own.name));
        };
        let [left, right] = own.turns.map(Vec3::from_array);
        // The first half of a pair's landmarks is of the one, the second of the other.
        let half = own.meets.len() / if own.twin.is_some() { 2 } else { 1 };
        let expression = Expression {
            name: own.name,
            support,
            displacements,
            turns: [left, right],
            meets: own.meets[..half].to_vec(),
        };
        let twin =
            (own.twin).map(|name| expression.mirrored(name, mirror, own.meets[half..].to_vec()));
        list.push(expression);
        list.extend(twin);
    }
    for (i, expression) in list.iter().enumerate() {
        if list[..i].iter().any(|other| other.name == expression.name) {
            return bad(format!(
                "two expressions are called \"{}\"",
                expression.name
            ));
        }
    }
    Ok(list)
}
