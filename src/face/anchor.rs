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

use std::iter::successors;
use std::sync::Arc;

use glam::Vec3;

use super::Face;
use super::measured::Before;
use crate::Result;
use crate::model::{FaceModel, falloff};

/// Passes in which weights around regions become smooth: distances are measured along edges, which
/// zigzag.
const PASSES: usize = 12;
/// Sweeps over all edges, in which distances become shorter by an edge at least. A head needs a few; a mesh that is made to
/// need more than these would keep whoever locks something busy for hours.
const SWEEPS: usize = 256;
/// Of a part that hangs together with no region so many vertices are asked how far the skin beside
/// them follows.
const ASKED: usize = 16;
/// Each of them is compared with every vertex of the skin, and a head has 2 million pairs in all. Of what has more than
/// so many, which take a tenth of a second, fewer of the skin are asked, one in some.
const MOST_PAIRS: usize = 1 << 26;

/// The largest coefficient of an anchor, in units of 1/65536 sigma: 8,000 sigmas, which no hand
/// reaches, and which sums still take.
pub(super) const MOST: i32 = (1 << 29) - 1;

/// Regions, a bit each: the number of the block that is not local. A model has no more.
pub(super) type Regions = u64;

/// What changes of coefficients are taken back by in some regions.
#[derive(Debug, Clone)]
pub(super) struct Anchor {
    pub regions: Regions,
    /// Coefficients in units of 1/65536 sigma.
    pub state: Vec<i32>,
    /// Those that the face's positions are of.
    pub shown: Vec<i32>,
    /// How far each vertex follows, 0..=1.
    pub weights: Arc<[f32]>,
}

impl Face {
    /// The locked regions that stay where they are when a coefficient of a block changes.
    fn staying(&self, block: usize) -> Regions {
        let blocks = &self.model.parts().blocks;
        let region = blocks[block].region();
        let others = (0..blocks.len())
            .filter(|&b| blocks[b].local_to.is_none() && self.locked[b])
            .filter(|&b| blocks[b].region() != region);
        others.fold(0, |regions, b| regions | 1 << b)
    }

    /// How far each vertex stays when a coefficient of a block changes; `None` when all follow.
    pub(super) fn stays(&self, block: usize) -> Option<Arc<[f32]>> {
        self.known(self.staying(block))
    }

    /// Brings the weights that locks need up to date.
    pub(super) fn mask(&mut self) {
        let blocks = self.model.parts().blocks.len();
        let mut masks: Vec<(Regions, Arc<[f32]>)> = Vec::new();
        for block in 0..blocks {
            let regions = self.staying(block);
            if regions != 0 && masks.iter().all(|mask| mask.0 != regions) {
                masks.push((regions, self.weights(regions)));
            }
        }
        self.masks = masks;
    }

    fn known(&self, regions: Regions) -> Option<Arc<[f32]>> {
        let masks = self.masks.iter().map(|mask| (mask.0, &mask.1));
        let mut known = masks.chain(self.anchors.iter().map(|a| (a.regions, &a.weights)));
        known.find(|k| k.0 == regions).map(|k| k.1.clone())
    }

    fn weights(&self, regions: Regions) -> Arc<[f32]> {
        let known = self.known(regions);
        known.unwrap_or_else(|| weights(&self.model, regions))
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

    /// An anchor that positions are still to be brought up to.
    pub(super) fn new_anchor(&self, regions: Regions, state: Vec<i32>) -> Anchor {
        Anchor {
            weights: self.weights(regions),
            regions,
            shown: vec![0; state.len()],
            state,
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
            if regions == 0 {
                continue;
            }
            let mut change = vec![0; state.len()];
            for i in own {
                change[i] = self.state[i] - state[i];
            }
            self.add(regions, &change, 1);
        }
    }

    /// Adds `sign` times a change of coefficients to the anchor of some regions.
    fn add(&mut self, regions: Regions, change: &[i32], sign: i32) {
        let state = self.anchor(regions).state.iter_mut();
        (state.zip(change)).for_each(|(e, change)| *e = (*e + sign * change).clamp(-MOST, MOST));
    }

    /// Forgets anchors that hold nothing.
    pub(super) fn tidy(&mut self) {
        self.anchors.retain(|a| a.state.iter().any(|&e| e != 0));
    }

    /// Lets go of what former locks left in the named regions (all, when absent). Returns whether
    /// there was any.
    ///
    /// What is locked, S, stays, on its border as well, which an anchor of regions L beside it reaches.
    /// So that nothing is left of that deep in L, its e goes over to the anchor of S from that of both:
    /// with their weights, w(L) - w(L and S) + w(S), that is 0 in L and w(L) in S.
    ///
    /// # Errors
    /// When there is no such region.
    pub(super) fn let_go(&mut self, regions: Option<&[String]>) -> Result<bool> {
        let mut named = vec![regions.is_none(); self.locked.len()];
        for region in regions.unwrap_or_default() {
            let own = self.model.region(region)?;
            named.iter_mut().zip(own).for_each(|(n, own)| *n |= own);
        }
        let (mut stay, mut others): (Regions, Regions) = (0, 0);
        for (b, block) in self.model.parts().blocks.iter().enumerate() {
            match (&block.local_to, self.locked[b], named[b]) {
                (None, true, _) => stay |= 1 << b,
                (None, false, false) => others |= 1 << b,
                _ => {}
            }
        }
        let mut gone = false;
        for anchor in self.anchors.clone() {
            let going = anchor.regions & !stay;
            if going != 0 && going & others == 0 {
                if stay != 0 {
                    self.add(stay, &anchor.state, 1);
                }
                self.add(going | stay, &anchor.state, -1);
                gone = true;
            }
        }
        if gone {
            self.tidy();
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
            self.anchor(theirs.regions);
        }
        for ours in &mut self.anchors {
            let theirs = other.anchors.iter().find(|a| a.regions == ours.regions);
            for (i, e) in ours.state.iter_mut().enumerate() {
                let to = theirs.map_or(0.0, |a| f64::from(a.state[i]));
                let from = f64::from(*e);
                *e = (from + (to - from) * t).round() as i32;
            }
        }
        self.evaluate();
        self.tidy();
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
///
/// Sweeps over all edges do what queues would: they are a few passes, and only when something is
/// locked.
pub(super) fn weights(model: &FaceModel, regions: Regions) -> Arc<[f32]> {
    let parts = model.parts();
    let n = parts.mean.len();
    let covers = |region: u8| {
        let locked = |b: &usize| regions >> b & 1 == 1;
        let mut blocks = (0..parts.blocks.len()).filter(locked);
        // A block without regions covers all vertices.
        blocks.any(|b| {
            let own = &parts.blocks[b].regions;
            own.is_empty() || own.contains(&region)
        })
    };
    let covered: Vec<bool> = (0..=u8::MAX).map(covers).collect();
    let inside: Vec<bool> = (parts.topology.regions.iter())
        .map(|&r| covered[usize::from(r)])
        .collect();
    let triangles = parts.topology.triangles();
    let edges: Vec<[usize; 2]> = (triangles.iter())
        .flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]])
        .map(|edge| edge.map(|v| v as usize))
        .collect();

    let alpha = parts.blending.alpha;
    let distance = along_edges(&parts.mean, &edges, &inside);
    let mut weights: Vec<f32> = distance.iter().map(|d| falloff(d / alpha)).collect();
    for _ in 0..PASSES {
        let mut sums = vec![(0.0_f32, 0.0_f32); n];
        for &[a, b] in &edges {
            sums[a] = (sums[a].0 + weights[b], sums[a].1 + 1.0);
            sums[b] = (sums[b].0 + weights[a], sums[b].1 + 1.0);
        }
        for (v, (sum, count)) in sums.into_iter().enumerate() {
            if !inside[v] && count > 0.0 {
                weights[v] = 0.5 * (weights[v] + sum / count);
            }
        }
    }

    let hangs = together(n, &edges);
    let mut sizes = vec![0; n];
    let mut anchored = vec![false; n];
    // The next vertex of each one's part, from the part's first on; `n` after the last.
    let (mut next, mut first) = (vec![n; n], vec![n; n]);
    for v in (0..n).rev() {
        let part = hangs[v];
        sizes[part] += 1;
        anchored[part] |= inside[v];
        next[v] = std::mem::replace(&mut first[part], v);
    }
    let of = |part: usize| successors(Some(first[part]), |&v| Some(next[v]).filter(|&v| v < n));
    let skin = (0..n).max_by_key(|&v| sizes[v]).unwrap_or(0);
    let is_loose = |&v: &usize| v != skin && sizes[v] > 0 && !anchored[v];
    let loose = (0..n).filter(is_loose).count();
    let apart = 1 + loose * ASKED / (MOST_PAIRS / sizes[skin].max(1)).max(1);
    for part in (0..n).filter(is_loose) {
        let mut sum = 0.0;
        let mut asked = 0.0;
        for v in of(part).step_by(1 + sizes[part] / ASKED) {
            let mut nearest = (f32::INFINITY, 0.0);
            for u in of(skin).step_by(apart) {
                let far = parts.mean[u].distance_squared(parts.mean[v]);
                if far < nearest.0 {
                    nearest = (far, weights[u]);
                }
            }
            sum += nearest.1;
            asked += 1.0;
        }
        of(part).for_each(|v| weights[v] = sum / asked);
    }
    weights.into()
}

/// The length of the shortest path along edges from the inside, mm; infinite where none leads of [`SWEEPS`] edges.
fn along_edges(positions: &[Vec3], edges: &[[usize; 2]], inside: &[bool]) -> Vec<f32> {
    let mut distance: Vec<f32> = (inside.iter())
        .map(|&inside| if inside { 0.0 } else { f32::INFINITY })
        .collect();
    for _ in 0..SWEEPS {
        let mut shorter = false;
        for &[a, b] in edges {
            let length = positions[a].distance(positions[b]);
            for [from, to] in [[a, b], [b, a]] {
                if distance[from] + length < distance[to] {
                    distance[to] = distance[from] + length;
                    shorter = true;
                }
            }
        }
        if !shorter {
            break;
        }
    }
    distance
}

/// Of what each vertex hangs together with, one vertex.
fn together(count: usize, edges: &[[usize; 2]]) -> Vec<usize> {
    let mut towards: Vec<usize> = (0..count).collect();
    let root = |towards: &mut [usize], mut v: usize| {
        while towards[v] != v {
            towards[v] = towards[towards[v]];
            v = towards[v];
        }
        v
    };
    for &[a, b] in edges {
        let (a, b) = (root(&mut towards, a), root(&mut towards, b));
        towards[a.max(b)] = a.min(b);
    }
    (0..count).map(|v| root(&mut towards, v)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Edges in an order in which each sweep comes one edge farther: all of them would take minutes.
    #[test]
    fn a_long_way_is_measured_as_far_as_it_counts() {
        const COUNT: usize = 200_000;
        let positions: Vec<Vec3> = (0..COUNT).map(|i| Vec3::X * (0.25 * i as f32)).collect();
        let edges: Vec<[usize; 2]> = (1..COUNT).rev().map(|i| [i - 1, i]).collect();
        let inside: Vec<bool> = (0..COUNT).map(|i| i == 0).collect();
        let all = along_edges(&positions, &edges, &inside);
        for (i, &length) in all.iter().take(SWEEPS + 1).enumerate() {
            assert_eq!(length, 0.25 * i as f32);
        }
        assert!(all[SWEEPS + 1..].iter().all(|l| l.is_infinite()));
    }

    #[test]
    fn the_shorter_of_two_ways_counts() {
        let positions = [0.0, 1.0, 2.0, 3.0].map(|x| Vec3::new(x, 2.0 * (x - 1.0), 0.0));
        let edges = [[0, 3], [0, 1], [1, 2], [2, 3]];
        let all = along_edges(&positions, &edges, &[false, true, false, true]);
        let step = 5.0_f32.sqrt();
        assert_eq!(all, [step, 0.0, step, 0.0]);
    }
}
