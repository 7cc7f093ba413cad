//! What keeps locked regions in place.
//!
//! Coefficients reach beyond their region: those of the head move every vertex, and features carry
//! their surround along. While regions are locked, whatever the coefficients of others change by is
//! therefore taken back where the locked regions are, and less and less around them:
//!
//! displacement(v) = M(v) c + sum over anchors of w(v) M(v) e
//!
//! where M are the modes of all blocks, c the coefficients, and an anchor is a set of regions with
//! coefficients e of its own and weights w that are 1 in its regions. A change dc of a coefficient
//! of some region is a change -dc of e in the anchor of the locked regions but for that one, so that
//! a locked region still follows its own sliders. All of it is linear, the state is e beside c, and
//! unlocking moves nothing: the anchor stays as it is.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::sync::Arc;

use glam::Vec3;

use super::measured::Before;
use super::{Face, GRID};
use crate::Result;
use crate::model::{FaceModel, falloff};

/// Passes in which weights around regions become smooth: distances are measured along edges, which
/// zigzag.
const PASSES: usize = 12;
/// Of a part that hangs together with no region so many vertices are asked how far the skin beside
/// them follows.
const ASKED: usize = 16;

/// Regions, by the number of the block that is not local: increasing.
pub(super) type Regions = Vec<usize>;

/// What changes of coefficients are taken back by in some regions.
#[derive(Debug, Clone)]
pub(super) struct Anchor {
    pub regions: Regions,
    /// Coefficients in units of 1/65536 sigma.
    pub state: Vec<i32>,
    /// How far each vertex follows, 0..=1.
    pub weights: Arc<[f32]>,
    /// Displacements by each block, as those of a face.
    pub displacements: Vec<Vec<Vec3>>,
}

impl Anchor {
    pub(super) fn coefficients(&self) -> Vec<f32> {
        let each = self.state.iter();
        each.map(|&c| (f64::from(c) / GRID) as f32).collect()
    }
}

impl Face {
    /// The locked regions that stay where they are when a coefficient of a block changes.
    fn staying(&self, block: usize) -> Regions {
        let blocks = &self.model.parts().blocks;
        let region = blocks[block].region();
        (0..blocks.len())
            .filter(|&b| blocks[b].local_to.is_none() && self.locked[b])
            .filter(|&b| blocks[b].region() != region)
            .collect()
    }

    /// How far each vertex stays when a coefficient of a block changes; `None` when all follow.
    pub(super) fn stays(&self, block: usize) -> Option<Arc<[f32]>> {
        self.masks.get(&self.staying(block)).cloned()
    }

    /// Brings the weights that locks need up to date.
    pub(super) fn mask(&mut self) {
        let blocks = self.model.parts().blocks.len();
        let mut masks = BTreeMap::new();
        for block in 0..blocks {
            let regions = self.staying(block);
            if !regions.is_empty() && !masks.contains_key(&regions) {
                let known = self.masks.get(&regions).cloned();
                let weights = known.unwrap_or_else(|| weights(&self.model, &regions));
                masks.insert(regions, weights);
            }
        }
        self.masks = masks;
    }

    /// The anchor of some regions, new if there is none.
    pub(super) fn anchor(&mut self, regions: Regions) -> &mut Anchor {
        let at = match self.anchors.binary_search_by(|a| a.regions.cmp(&regions)) {
            Ok(at) => at,
            Err(at) => {
                let anchor = self.new_anchor(regions, vec![0; self.state.len()]);
                self.anchors.insert(at, anchor);
                at
            }
        };
        &mut self.anchors[at]
    }

    /// An anchor whose displacements are still to be computed.
    pub(super) fn new_anchor(&self, regions: Regions, state: Vec<i32>) -> Anchor {
        let former = self.anchors.iter().find(|a| a.regions == regions);
        let former = former.map(|a| &a.weights).or(self.masks.get(&regions));
        let each = self.displacements.iter();
        Anchor {
            weights: former.map_or_else(|| weights(&self.model, &regions), Arc::clone),
            regions,
            state,
            displacements: each.map(|d| vec![Vec3::ZERO; d.len()]).collect(),
        }
    }

    /// Takes back in locked regions what a new state changes.
    pub(super) fn take_back(&mut self, state: &[i32]) {
        for b in 0..self.model.parts().blocks.len() {
            let own = self.model.parts().blocks[b].coefficients();
            if state[own.clone()] == self.state[own.clone()] {
                continue;
            }
            let regions = self.staying(b);
            if regions.is_empty() {
                continue;
            }
            let was = self.state[own.clone()].to_vec();
            let anchor = self.anchor(regions);
            for ((e, &new), old) in anchor.state[own.clone()]
                .iter_mut()
                .zip(&state[own])
                .zip(was)
            {
                *e = e.saturating_sub(new.saturating_sub(old));
            }
        }
    }

    /// Forgets anchors that hold nothing.
    pub(super) fn tidy(&mut self) {
        self.anchors.retain(|a| a.state.iter().any(|&e| e != 0));
    }

    /// Lets go of what former locks left in the named regions (all, when absent); what is locked
    /// still stays. Returns whether there was any.
    ///
    /// # Errors
    /// When there is no such region.
    pub(super) fn let_go(&mut self, regions: Option<&[String]>) -> Result<bool> {
        let mut named = vec![regions.is_none(); self.locked.len()];
        for region in regions.unwrap_or_default() {
            let own = self.model.region(region)?;
            named.iter_mut().zip(own).for_each(|(n, own)| *n |= own);
        }
        let count = self.anchors.len();
        let locked = &self.locked;
        self.anchors
            .retain(|a| a.regions.iter().any(|&b| locked[b] || !named[b]));
        let gone = self.anchors.len() < count;
        if gone {
            self.evaluate_all();
        }
        Ok(gone)
    }

    /// Moves all anchors towards those of another face.
    pub(super) fn blend_anchors(&mut self, other: &Face, t: f64) {
        if self.anchors.is_empty() && other.anchors.is_empty() {
            return;
        }
        for theirs in &other.anchors {
            self.anchor(theirs.regions.clone());
        }
        for ours in &mut self.anchors {
            let theirs = other.anchors.iter().find(|a| a.regions == ours.regions);
            for (i, e) in ours.state.iter_mut().enumerate() {
                let to = theirs.map_or(0.0, |a| f64::from(a.state[i]));
                let from = f64::from(*e);
                *e = (from + (to - from) * t).round() as i32;
            }
        }
        self.tidy();
        self.evaluate_all();
    }

    /// What a failing call puts back.
    pub(super) fn before(&self) -> Before {
        Before {
            state: self.state.clone(),
            held: self.held.clone(),
            anchors: self.anchors.clone(),
        }
    }

    /// Puts back what was before a call.
    pub(super) fn put_back(&mut self, before: Before) {
        self.state = before.state;
        self.held = before.held;
        self.anchors = before.anchors;
        self.evaluate_all();
        self.changed = 0..0;
    }
}

/// How far each vertex stays with some regions: 1 in them, and falling off along the surface as
/// features' surrounds do. What hangs together with none of them, such as an eyeball, stays as a
/// whole, as far as the skin beside it.
pub(super) fn weights(model: &FaceModel, regions: &[usize]) -> Arc<[f32]> {
    let parts = model.parts();
    let n = parts.mean.len();
    let mut covered = vec![false; parts.topology.region_names.len()];
    let mut every = false;
    for &b in regions {
        let own = &parts.blocks[b].regions;
        every |= own.is_empty();
        own.iter().for_each(|&r| covered[usize::from(r)] = true);
    }
    let inside: Vec<bool> = (parts.topology.regions.iter())
        .map(|&r| every || covered[usize::from(r)])
        .collect();
    let triangles = parts.topology.triangles();
    let mut beside: Vec<Vec<u32>> = vec![Vec::new(); n];
    for t in &triangles {
        for i in 0..3 {
            beside[t[i] as usize].extend([t[(i + 1) % 3], t[(i + 2) % 3]]);
        }
    }
    for list in &mut beside {
        list.sort_unstable();
        list.dedup();
    }

    let distance = along_edges(&parts.mean, &beside, &inside);
    let alpha = parts.blending.alpha;
    let mut weights: Vec<f32> = distance.iter().map(|d| falloff(d / alpha)).collect();
    for _ in 0..PASSES {
        weights = (0..n)
            .map(|v| {
                if inside[v] || beside[v].is_empty() {
                    return weights[v];
                }
                let sum: f32 = beside[v].iter().map(|&u| weights[u as usize]).sum();
                0.5 * (weights[v] + sum / beside[v].len() as f32)
            })
            .collect();
    }

    let hangs = together(&beside);
    let mut sizes: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    (0..n).for_each(|v| sizes.entry(hangs[v]).or_default().push(v));
    let skin = sizes.values().max_by_key(|own| own.len());
    let skin = skin.cloned().unwrap_or_default();
    for own in sizes.values() {
        if own.len() == skin.len() || own.iter().any(|&v| inside[v]) {
            continue;
        }
        let asked: Vec<usize> = own
            .iter()
            .step_by(own.len().div_ceil(ASKED))
            .copied()
            .collect();
        let sum: f32 = (asked.iter())
            .map(|&v| {
                let far = |u: &&usize| parts.mean[**u].distance_squared(parts.mean[v]);
                let nearest = skin.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
                nearest.map_or(0.0, |&u| weights[u])
            })
            .sum();
        own.iter()
            .for_each(|&v| weights[v] = sum / asked.len() as f32);
    }
    weights.into()
}

/// The length of the shortest path along edges from the inside, mm.
fn along_edges(positions: &[Vec3], beside: &[Vec<u32>], inside: &[bool]) -> Vec<f32> {
    let mut distance: Vec<f32> = (inside.iter())
        .map(|&inside| if inside { 0.0 } else { f32::INFINITY })
        .collect();
    // Lengths are not negative: their bits are in the same order as they are.
    let sources = (0..inside.len() as u32).filter(|&v| inside[v as usize]);
    let mut next: BinaryHeap<Reverse<(u32, u32)>> = sources.map(|v| Reverse((0, v))).collect();
    while let Some(Reverse((bits, v))) = next.pop() {
        let there = f32::from_bits(bits);
        if there > distance[v as usize] {
            continue;
        }
        for &u in &beside[v as usize] {
            let d = there + positions[v as usize].distance(positions[u as usize]);
            if d < distance[u as usize] {
                distance[u as usize] = d;
                next.push(Reverse((d.to_bits(), u)));
            }
        }
    }
    distance
}

/// The least vertex of what each hangs together with.
fn together(beside: &[Vec<u32>]) -> Vec<u32> {
    let mut least: Vec<u32> = vec![u32::MAX; beside.len()];
    for v in 0..beside.len() as u32 {
        let mut open = vec![v];
        while let Some(u) = open.pop() {
            if least[u as usize] == u32::MAX {
                least[u as usize] = v;
                open.extend(&beside[u as usize]);
            }
        }
    }
    least
}
