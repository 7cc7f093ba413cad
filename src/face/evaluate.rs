//! From coefficients to positions and normals.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::Vec3;
use wide::i32x4;

use super::Face;
use crate::kernel::{CHUNK, Modes, Patch, add_to, round_to};
use crate::quantise::PER_SIGMA;

/// What anchors take back is rounded to whole multiples of this, mm, 8 nanometres: sums of it are
/// exact, as all others are.
const ANCHORED: f64 = 1.0 / 131_072.0;

impl Face {
    pub(super) fn all(&self) -> Range<u32> {
        0..self.positions().len() as u32
    }

    /// Brings positions and normals up to date with coefficients and anchors: adds what those
    /// changed by, or, where that is more work, sums everything again, which gives the same bits.
    pub(super) fn evaluate(&mut self) {
        let model = self.model.clone();
        let blocks = &model.parts().blocks;
        let mut touched = vec![false; blocks.len()];
        let (mut changes, mut everything) = (0, 0);
        for (b, block) in blocks.iter().enumerate() {
            let own = block.coefficients();
            let changed = self.state[own.clone()].iter().zip(&self.shown[own.clone()]);
            let changed = changed.filter(|(new, old)| new != old).count();
            let anchors = self.anchors.iter();
            let anchors = anchors
                .filter(|a| a.state[own.clone()] != a.shown[own.clone()])
                .count();
            touched[b] = changed + anchors > 0;
            // What anchors took back before is summed again.
            changes += block.modes.numbers() * (changed + 2 * anchors * own.len());
            everything += block.modes.numbers() * own.len() * (1 + self.anchors.len());
        }
        if 2 * changes > everything {
            return self.evaluate_all();
        }
        if self.sums.is_empty() {
            self.sum(true);
        }
        let mut out = Sums {
            sums: &mut self.sums,
            positions: &mut self.positions,
        };
        for (b, block) in blocks.iter().enumerate().filter(|(b, _)| touched[*b]) {
            let own = block.coefficients();
            for (modes, vertices) in self.reach.movers(b, block) {
                let change: Vec<i32> = (self.state[own.clone()].iter())
                    .zip(&self.shown[own.clone()])
                    .map(|(new, old)| new - old)
                    .collect();
                out.add(modes, vertices, &change);
                for anchor in &self.anchors {
                    let states = [&anchor.shown[own.clone()], &anchor.state[own.clone()]];
                    out.add_shares(modes, vertices, states, &anchor.weights);
                }
            }
        }
        self.is_shown();
        let patches: Vec<&Patch> = (0..blocks.len())
            .filter(|&b| touched[b])
            .map(|b| self.reach.patch(b, model.parts(), &model.derived.whole))
            .collect();
        self.changed = (patches.iter().map(|p| p.range.clone()))
            .reduce(|a, b| a.start.min(b.start)..a.end.max(b.end))
            .unwrap_or(0..0);
        let whole = &model.derived.whole;
        match patches.iter().map(|p| p.size()).sum::<usize>() < whole.size() {
            true => (patches.iter()).for_each(|p| p.normals(&self.positions, &mut self.normals)),
            false => whole.normals(&self.positions, &mut self.normals),
        }
    }

    /// Computes positions and normals from the mean on.
    pub(super) fn evaluate_all(&mut self) {
        let kept = !self.sums.is_empty();
        self.sum(false);
        if !kept {
            self.sums = Vec::new();
        }
        self.is_shown();
        self.changed = self.all();
        let whole = &self.model.derived.whole;
        whole.normals(&self.positions, &mut self.normals);
    }

    /// Sums all positions, of what is shown or of what shall be.
    pub(crate) fn sum(&mut self, shown: bool) {
        let model = self.model.clone();
        self.sums.resize(model.parts().mean.len(), [0.0; 3]);
        for (sum, mean) in self.sums.iter_mut().zip(&model.parts().mean) {
            *sum = mean.as_dvec3().to_array();
        }
        let mut out = Sums {
            sums: &mut self.sums,
            positions: &mut [],
        };
        for (b, block) in model.parts().blocks.iter().enumerate() {
            let own = block.coefficients();
            for (modes, vertices) in self.reach.movers(b, block) {
                let state = if shown { &self.shown } else { &self.state };
                out.add(modes, vertices, &state[own.clone()]);
                for anchor in &self.anchors {
                    let state = if shown { &anchor.shown } else { &anchor.state };
                    let state = &state[own.clone()];
                    let nothing = vec![0; state.len()];
                    out.add_shares(modes, vertices, [&nothing, state], &anchor.weights);
                }
            }
        }
        // There is one position more.
        let positions = &mut self.positions[..self.sums.len()];
        round_to(
            self.sums.as_flattened(),
            bytemuck::cast_slice_mut(positions),
        );
    }

    /// How a vertex moves with each coefficient: mm a sigma.
    pub(crate) fn jacobian(&self, vertex: u32) -> Vec<Vec3> {
        let mut rows = vec![Vec3::ZERO; self.state.len()];
        for (b, block) in self.model.parts().blocks.iter().enumerate() {
            let follows = self.stays(b).map_or(1.0, |w| 1.0 - w[vertex as usize]);
            // A vertex follows a region or is of it.
            for (modes, vertices) in self.reach.movers(b, block) {
                if let Ok(place) = vertices.binary_search(&vertex) {
                    for (row, k) in rows[block.coefficients()].iter_mut().zip(0..) {
                        *row = follows * modes.displacement(k, place);
                    }
                }
            }
        }
        rows
    }

    /// Notes that what there is is what is shown.
    pub(super) fn is_shown(&mut self) {
        static REVISIONS: AtomicU64 = AtomicU64::new(1);
        self.revision = REVISIONS.fetch_add(1, Ordering::Relaxed);
        self.shown.clone_from(&self.state);
        for anchor in &mut self.anchors {
            anchor.shown.clone_from(&anchor.state);
        }
    }
}

/// Where positions are summed.
struct Sums<'a> {
    sums: &'a mut [[f64; 3]],
    /// As the sums; none while more is added.
    positions: &'a mut [Vec3],
}

impl Sums<'_> {
    /// Adds what modes with a change of their coefficients move vertices by.
    fn add(&mut self, modes: &Modes, vertices: &[u32], change: &[i32]) {
        let scale = f64::from(modes.step()) / PER_SIGMA;
        let mut by = [i32x4::ZERO; CHUNK / 4];
        for part in modes.weights(change) {
            for (chunk, vertices) in vertices.chunks(CHUNK / 3).enumerate() {
                modes.sum(&part, CHUNK * chunk, &mut by);
                self.shift(vertices, bytemuck::cast_slice(&by), scale * part.unit);
            }
        }
    }

    /// Adds each vertex's share of what modes move it by in the second of two states more than in
    /// the first.
    fn add_shares(&mut self, modes: &Modes, vertices: &[u32], states: [&[i32]; 2], shares: &[f32]) {
        if states[0] == states[1] {
            return;
        }
        let parts = states.map(|state| modes.weights(state));
        let scale = f64::from(modes.step()) / (PER_SIGMA * ANCHORED);
        let mut by = [i32x4::ZERO; CHUNK / 4];
        for (chunk, vertices) in vertices.chunks(CHUNK / 3).enumerate() {
            let mut totals = [[0.0; CHUNK]; 2];
            for (totals, parts) in totals.iter_mut().zip(&parts) {
                for part in parts {
                    modes.sum(part, CHUNK * chunk, &mut by);
                    add_to(totals, bytemuck::cast_slice(&by), scale * part.unit);
                }
            }
            let by: &mut [i32] = bytemuck::cast_slice_mut(&mut by);
            let each = vertices.iter().flat_map(|v| [v; 3]);
            let [old, new] = &totals;
            for (by, ((new, old), v)) in by.iter_mut().zip(new.iter().zip(old).zip(each)) {
                let share = f64::from(shares[*v as usize]);
                // Whatever is farther than 16 m is no face.
                *by = ((new * share).round_ties_even() - (old * share).round_ties_even()) as i32;
            }
            self.shift(vertices, by, ANCHORED);
        }
    }

    /// Moves vertices (increasing) by three whole numbers each, times `unit` mm.
    fn shift(&mut self, vertices: &[u32], mut by: &[i32], unit: f64) {
        let mut rest = vertices;
        while let [first, ..] = *rest {
            let last = first + rest.len() as u32 - 1;
            let run = match rest.ends_with(&[last]) {
                true => rest.len(),
                false => (rest.iter().zip(first..))
                    .take_while(|(v, next)| **v == *next)
                    .count(),
            };
            rest = &rest[run..];
            let all = first as usize..first as usize + run;
            let (own, others) = by.split_at(3 * run);
            by = others;
            let sums = self.sums[all.clone()].as_flattened_mut();
            add_to(sums, own, unit);
            if let Some(positions) = self.positions.get_mut(all) {
                round_to(sums, bytemuck::cast_slice_mut(positions));
            }
        }
    }
}
