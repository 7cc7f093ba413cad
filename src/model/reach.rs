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
    /// What follows each block, and what of the head a move of both touches.
    blocks: Vec<(Surrounding, OnceLock<Patch>)>,
}

impl Reach {
    pub fn new(parts: &ModelParts, alpha: f32) -> Self {
        let mut reach = Self::of_none(alpha);
        parts.blocks.iter().for_each(|block| reach.add(block));
        reach
    }

    /// Before a model's first block.
    pub fn of_none(alpha: f32) -> Self {
        Self {
            alpha,
            blocks: Vec::new(),
        }
    }

    /// Adds a model's next block.
    #[inline(never)]
    pub fn add(&mut self, block: &Block) {
        let surrounding = Surrounding::new(block, self.alpha);
        self.blocks.push((surrounding, OnceLock::new()));
    }

    /// The modes of a block and the vertices that they move: its support, and what follows.
    pub fn movers<'a>(&'a self, b: usize, block: &'a Block) -> [(&'a Modes, &'a [u32]); 2] {
        let (following, _) = &self.blocks[b];
        [
            (&block.modes, &block.support),
            (&following.modes, &following.targets),
        ]
    }

    /// What a move of a block touches: found when it is first asked for, as most blocks of a
    /// distance that someone passes through never are.
    pub fn patch(&self, block: usize, parts: &ModelParts, whole: &Patch) -> &Patch {
        let (following, patch) = &self.blocks[block];
        patch.get_or_init(|| whole.part(&[&parts.blocks[block].support, &following.targets]))
    }
}
