//! A face with an expression on it.

use glam::{Mat3, Vec3};

use super::{Expression, Expressions};
use crate::anatomy::Landmark;
use crate::{Error, Face, Result};

/// By how much at most closing lids are helped or held back.
const GAINS: [f32; 2] = [0.3, 2.0];
/// How far apart along y the landmarks of shut lids are, mm: the upper lid's edge lies a little over
/// the lower one's.
const SHUT: f32 = -0.3;

/// Expressions in use: weights, and the face that they were last put on.
#[derive(Debug, Clone)]
pub struct Performance {
    expressions: Expressions,
    weights: Vec<f32>,
    /// The face that is shown, with the weights.
    shown: Option<(String, Vec<f32>)>,
    /// One more than there are vertices, as of normals; see [`crate::kernel::Patch::normals`].
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
}

impl Performance {
    /// A face at rest.
    pub fn new(expressions: &Expressions) -> Self {
        Self {
            weights: vec![0.0; expressions.list.len()],
            expressions: expressions.clone(),
            shown: None,
            positions: Vec::new(),
            normals: Vec::new(),
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
        Ok(())
    }

    /// Back to rest.
    pub fn rest(&mut self) {
        self.weights.fill(0.0);
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
        let parts = face.model().parts();
        let most = self
            .expressions
            .list
            .iter()
            .filter_map(|e| e.support.last());
        if most.max().is_some_and(|&v| v as usize >= neutral.len()) {
            return Err(Error::Mismatch(
                "these expressions are for another head than the model's".into(),
            ));
        }
        let wanted = (face.code(), self.weights.clone());
        if self.shown.as_ref() == Some(&wanted) {
            return Ok(());
        }
        let weights = &self.weights;
        self.positions.clear();
        self.positions.extend_from_slice(neutral);
        self.positions.push(Vec3::ZERO);
        let landmarks = &parts.landmarks;
        (self.expressions).carry(weights, landmarks, neutral, &mut self.positions);
        let derived = &self.expressions.derived;
        let mut turns = [Vec3::ZERO; 2];
        for (expression, &weight) in self.expressions.list.iter().zip(weights) {
            turns[0] += expression.turns[0] * weight;
            turns[1] += expression.turns[1] * weight;
        }
        for eye in &derived.eyes {
            eye.settle(neutral, turns, &mut self.positions);
        }
        self.normals.resize(neutral.len() + 1, Vec3::ZERO);
        face.model()
            .derived
            .whole
            .normals(&self.positions, &mut self.normals);
        self.shown = Some(wanted);
        Ok(())
    }

    /// Vertex positions of the face that was last performed, mm.
    pub fn positions(&self) -> &[Vec3] {
        &self.positions[..self.positions.len().saturating_sub(1)]
    }

    /// Unit vertex normals of it.
    pub fn normals(&self) -> &[Vec3] {
        &self.normals[..self.normals.len().saturating_sub(1)]
    }
}

impl Expressions {
    /// Moves the skin of a face at rest (all vertices, mm, in the pose of the mean head) by expressions
    /// with weights, but for what eyeballs do to lids.
    pub(crate) fn carry(
        &self,
        weights: &[f32],
        landmarks: &[Landmark],
        neutral: &[Vec3],
        positions: &mut [Vec3],
    ) {
        let [small, large] = [0, 1].map(|scale| {
            let mut maps = vec![Mat3::ZERO; neutral.len()];
            self.derived.carriers[scale].maps(neutral, &mut maps);
            maps
        });
        let mut moved = neutral.to_vec();
        for (e, (expression, &weight)) in self.list.iter().zip(weights).enumerate() {
            if weight <= 0.0 {
                continue;
            }
            let part = self.derived.large[e];
            let each = || {
                let each = expression.support.iter().zip(&expression.displacements);
                each.map(|(&v, &d)| {
                    let v = v as usize;
                    (v, small[v] * (d * (1.0 - part)) + large[v] * (d * part))
                })
            };
            let mut gain = 1.0;
            if !expression.meets.is_empty() {
                for (v, d) in each() {
                    moved[v] += d;
                }
                let open = gap(expression, landmarks, neutral);
                let left = gap(expression, landmarks, &moved);
                // One that is hardly open has nothing to close.
                let needed = (open - SHUT) / (open - left).max(0.1);
                gain = needed.clamp(GAINS[0], GAINS[1]);
                for (v, _) in each() {
                    moved[v] = neutral[v];
                }
            }
            for (v, d) in each() {
                positions[v] += d * (weight * gain);
            }
        }
    }
}

/// How far the pairs of landmarks of an expression are apart along y, mm, on average; 0 without
/// pairs.
fn gap(expression: &Expression, landmarks: &[Landmark], positions: &[Vec3]) -> f32 {
    let apart = |&[a, b]: &[u32; 2]| {
        let at = |l: u32| landmarks[l as usize].position(positions).y;
        at(a) - at(b)
    };
    let pairs = expression.meets.len().max(1) as f32;
    expression.meets.iter().map(apart).sum::<f32>() / pairs
}
