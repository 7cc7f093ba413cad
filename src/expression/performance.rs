//! A face with an expression on it.

use std::ops::Range;

use glam::{Mat3A, Vec3, Vec3A};

use super::Expressions;
use crate::anatomy::Landmark;
use crate::{Error, Face, Result};

/// By how much at most closing lids are helped or held back.
const GAINS: [f32; 2] = [0.3, 2.0];
/// How far apart along y the landmarks of shut lids are, mm: the upper lid's edge lies a little over
/// the lower one's.
const SHUT: f32 = -0.3;

/// Expressions in use: weights, and the face that they were last put on.
#[derive(Debug)]
pub struct Performance {
    expressions: Expressions,
    weights: Vec<f32>,
    /// The revision of the face that is shown, with these weights.
    shown: Option<u64>,
    /// How the face of a revision carries displacements.
    maps: Option<(u64, Maps)>,
    moves: Moves,
    skin: Skin,
    /// What was shown before.
    before: Skin,
    changed: Range<u32>,
}

/// Positions and unit normals.
#[derive(Debug, Default)]
struct Skin {
    /// One more than there are vertices, as of normals; see [`crate::kernel::Patch::normals`].
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
}

/// The linear maps of displacements on a face, at the nodes of the small and the large scale.
#[derive(Debug)]
pub(crate) struct Maps([Vec<Mat3A>; 2]);

/// What expressions do to the mean head. They stay while a face changes under them, and so does this.
#[derive(Debug, Default)]
pub(crate) struct Moves {
    /// By how much each expression is shown.
    amounts: Vec<f32>,
    /// The vertices that move.
    list: Vec<Move>,
}

/// How far a vertex moves, at the small scale and at the large one.
#[derive(Debug)]
struct Move {
    vertex: u32,
    /// Its place among those that any expression moves.
    place: u32,
    by: [Vec3; 2],
}

/// A copy has the weights, and has not been put on a face yet.
impl Clone for Performance {
    fn clone(&self) -> Self {
        Self {
            weights: self.weights.clone(),
            ..Self::new(&self.expressions)
        }
    }
}

impl Performance {
    /// A face at rest.
    pub fn new(expressions: &Expressions) -> Self {
        Self {
            weights: vec![0.0; expressions.list.len()],
            expressions: expressions.clone(),
            shown: None,
            maps: None,
            moves: Moves::default(),
            skin: Skin::default(),
            before: Skin::default(),
            changed: 0..0,
        }
    }

    /// What it performs.
    pub fn expressions(&self) -> &Expressions {
        &self.expressions
    }

    /// How much of each expression is shown, 0..=1.
    pub fn weights(&self) -> &[f32] {
        &self.weights
    }

    /// Shows so much of an expression, 0..=1.
    ///
    /// # Errors
    /// When there is none of that name, or the weight is not in 0..=1.
    pub fn set(&mut self, name: &str, weight: f64) -> Result<()> {
        let at = self.expressions.find(name)?;
        if !(0.0..=1.0).contains(&weight) {
            return Err(Error::Value {
                what: "the weight of an expression",
                wanted: "from 0 to 1".into(),
                got: weight,
            });
        }
        self.weights[at] = weight as f32;
        self.shown = None;
        Ok(())
    }

    /// Back to rest.
    pub fn rest(&mut self) {
        self.weights.fill(0.0);
        self.shown = None;
    }

    /// Whether nothing is shown.
    pub fn is_at_rest(&self) -> bool {
        self.weights.iter().all(|&w| w == 0.0)
    }

    /// Puts the expressions on a face. Nothing is computed again when neither has changed.
    ///
    /// # Errors
    /// When the face is of another mesh.
    pub fn perform(&mut self, face: &Face) -> Result<()> {
        let neutral = face.positions();
        if self.expressions.derived.places.len() != neutral.len() {
            return Err(Error::Mismatch(
                "these expressions are for another head than the model's".into(),
            ));
        }
        // At rest there are as many normals as the face keeps, and it may keep others.
        let normals = self.skin.normals.len().saturating_sub(1);
        let is_kept = normals == face.normals().len() || !self.is_at_rest();
        if self.shown == Some(face.revision()) && is_kept {
            return Ok(());
        }
        std::mem::swap(&mut self.skin, &mut self.before);
        copy(neutral, &mut self.skin.positions);
        if self.is_at_rest() {
            copy(face.normals(), &mut self.skin.normals);
        } else {
            self.move_skin(face);
        }
        // What was shown before may have been another head.
        let before = self.before.positions.len();
        self.changed = match before == self.skin.positions.len() {
            true => self.skin.differs(&self.before),
            false => 0..neutral.len() as u32,
        };
        self.shown = Some(face.revision());
        Ok(())
    }

    /// Moves the skin of a face at rest.
    fn move_skin(&mut self, face: &Face) {
        let neutral = face.positions();
        let derived = &self.expressions.derived;
        let Skin { positions, normals } = &mut self.skin;
        if self
            .maps
            .as_ref()
            .is_none_or(|maps| maps.0 != face.revision())
        {
            self.maps = Some((face.revision(), self.expressions.maps(neutral)));
        }
        if let Some((_, maps)) = &self.maps {
            let (moves, landmarks) = (&mut self.moves, &derived.parts.landmarks);
            (self.expressions).carry(maps, moves, &self.weights, landmarks, neutral, positions);
        }
        let mut turns = [Vec3::ZERO; 2];
        for (expression, &weight) in self.expressions.list.iter().zip(&self.weights) {
            turns[0] += expression.turns[0] * weight;
            turns[1] += expression.turns[1] * weight;
        }
        for eye in &derived.eyes {
            eye.settle(neutral, turns, positions);
        }
        // All of them are computed.
        normals.resize(positions.len(), Vec3::ZERO);
        let whole = &face.model().derived.whole;
        whole.normals(positions, normals);
    }

    /// Vertex positions of the face that was last performed, mm.
    pub fn positions(&self) -> &[Vec3] {
        &self.skin.positions[..self.skin.positions.len().saturating_sub(1)]
    }

    /// Unit vertex normals of it; at rest those that the face keeps ([`Face::keep_normals`]).
    pub fn normals(&self) -> &[Vec3] {
        &self.skin.normals[..self.skin.normals.len().saturating_sub(1)]
    }

    /// The smallest range of vertices outside of which it has the positions and normals of what was
    /// performed before that.
    pub fn changed(&self) -> Range<u32> {
        self.changed.clone()
    }
}

/// Makes a copy of numbers of all vertices, with a zero after them.
#[inline(never)]
fn copy(from: &[Vec3], to: &mut Vec<Vec3>) {
    to.clear();
    to.extend_from_slice(from);
    to.push(Vec3::ZERO);
}

impl Skin {
    /// The range of vertices in which two of one mesh differ; empty at 0 when they do not.
    fn differs(&self, other: &Self) -> Range<u32> {
        let same = |v: usize| {
            // A face at rest may keep no normals.
            self.positions[v] == other.positions[v] && self.normals.get(v) == other.normals.get(v)
        };
        let Some(first) = (0..self.positions.len()).find(|&v| !same(v)) else {
            return 0..0;
        };
        let last = (first..self.positions.len()).rfind(|&v| !same(v));
        first as u32..last.unwrap_or(first) as u32 + 1
    }
}

impl Expressions {
    /// How a face at rest (all vertices, mm, in the pose of the mean head) carries displacements.
    pub(crate) fn maps(&self, neutral: &[Vec3]) -> Maps {
        Maps((self.derived.carriers.each_ref()).map(|carrier| carrier.at_nodes(neutral)))
    }

    /// Moves the skin of a face at rest (all vertices, mm) and its maps by expressions with weights, but
    /// for what eyeballs do to lids. What moves is kept for the next face that shows the same.
    pub(crate) fn carry(
        &self,
        maps: &Maps,
        moves: &mut Moves,
        weights: &[f32],
        landmarks: &[Landmark],
        neutral: &[Vec3],
        positions: &mut [Vec3],
    ) {
        let mut amounts = weights.to_vec();
        for (e, amount) in amounts.iter_mut().enumerate() {
            if *amount > 0.0 {
                *amount *= self.gain(e, maps, landmarks, neutral);
            }
        }
        if moves.amounts != amounts {
            moves.list = self.moves(&amounts);
            moves.amounts = amounts;
        }
        for one in &moves.list {
            for ((carrier, maps), by) in self.derived.carriers.iter().zip(&maps.0).zip(one.by) {
                if by != Vec3::ZERO {
                    let carried = carrier.carry(maps, one.place as usize, by.into());
                    positions[one.vertex as usize] += Vec3::from(carried);
                }
            }
        }
    }

    /// The vertices of the mean head that move when each expression is shown by an amount.
    fn moves(&self, amounts: &[f32]) -> Vec<Move> {
        let derived = &self.derived;
        let still = |(&vertex, place)| Move {
            vertex,
            place,
            by: [Vec3::ZERO; 2],
        };
        let mut moves: Vec<Move> = derived.moved.iter().zip(0..).map(still).collect();
        for (e, (expression, &amount)) in self.list.iter().zip(amounts).enumerate() {
            if amount <= 0.0 {
                continue;
            }
            let [small, large] = [0, 1].map(|scale| amount * derived.part(e, scale));
            for (&v, &d) in expression.support.iter().zip(&expression.displacements) {
                let [less, more] = &mut moves[derived.places[v as usize] as usize].by;
                *less += d * small;
                *more += d * large;
            }
        }
        moves.retain(|one| one.by != [Vec3::ZERO; 2]);
        moves
    }

    /// By how much an expression is helped or held back on a face: lids close as far as they are open.
    fn gain(&self, e: usize, maps: &Maps, landmarks: &[Landmark], neutral: &[Vec3]) -> f32 {
        let (expression, derived) = (&self.list[e], &self.derived);
        if expression.meets.is_empty() {
            return 1.0;
        }
        let [mut open, mut left] = [0.0; 2];
        for meet in &expression.meets {
            for (&landmark, sign) in meet.iter().zip([1.0, -1.0]) {
                for &(v, weight) in &landmarks[landmark as usize].stencil {
                    let mut y = neutral[v as usize].y;
                    let weight = sign * weight as f32 / expression.meets.len() as f32;
                    open += weight * y;
                    if let Ok(at) = expression.support.binary_search(&v) {
                        let d = Vec3A::from(expression.displacements[at]);
                        let place = derived.places[v as usize] as usize;
                        for (scale, carrier) in derived.carriers.iter().enumerate() {
                            let part = derived.part(e, scale);
                            y += carrier.carry(&maps.0[scale], place, d * part).y;
                        }
                    }
                    left += weight * y;
                }
            }
        }
        // One that is hardly open has nothing to close.
        ((open - SHUT) / (open - left).max(0.1)).clamp(GAINS[0], GAINS[1])
    }
}
