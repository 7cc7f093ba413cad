//! How far blocks reach at a fall-off distance.

use std::sync::OnceLock;

use super::surrounding::Surrounding;
use crate::kernel::{Modes, Patch};
use crate::model::{Block, ModelParts};

/// What an event of each block touches at one fall-off distance. Faces of the same distance share it.
#[derive(Debug)]
pub(crate) struct Reach {
    /// The fall-off distance, mm.
    pub alpha: f32,
    /// What follows each block.
    pub surroundings: Vec<Surrounding>,
    patches: Vec<OnceLock<Patch>>,
}

impl Reach {
    pub fn new(parts: &ModelParts, alpha: f32) -> Self {
        let surrounding = |b: &Block| Surrounding::new(&b.modes, b.surround.as_ref(), alpha);
        Self {
            alpha,
            surroundings: parts.blocks.iter().map(surrounding).collect(),
            patches: parts.blocks.iter().map(|_| OnceLock::new()).collect(),
        }
    }

    /// The modes of a block and the vertices that they move: its support, and what follows.
    pub fn movers<'a>(&'a self, b: usize, block: &'a Block) -> [(&'a Modes, &'a [u32]); 2] {
        let following = &self.surroundings[b];
        [
            (&block.modes, &block.support),
            (&following.modes, &following.targets),
        ]
    }

    /// What a move of a block touches: found when it is first asked for, as most blocks of a
    /// distance that someone passes through never are.
    pub fn patch(&self, block: usize, parts: &ModelParts, whole: &Patch) -> &Patch {
        self.patches[block].get_or_init(|| {
            let (support, targets) = (
                &parts.blocks[block].support,
                &self.surroundings[block].targets,
            );
            whole.part(&[support, targets])
        })
    }
}
