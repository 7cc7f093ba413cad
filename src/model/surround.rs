//! What follows a region, and how (region morphing, section 6.2, eqs. 11 and 12).

use std::sync::OnceLock;

use glam::Vec3;
use wide::f32x4;

use crate::mesh::Topology;
use crate::{Error, Result};

/// How many sources a target has. The sharpest crease at the border of nose and forehead, as a
/// multiple of a whole-face PCA's (`tests/offline/learning.rs`): 2.7 and 2.1 with the single nearest of
/// eq. 11, 1.9 and 1.9 with 4, 0.7 and 1.1 with 8, 0.7 and 0.6 with 12. They are searched for
/// once for each fall-off distance; an event costs the same with any number.
pub const SOURCES: usize = 8;

/// Weights are in units of 1 / 65535.
const WHOLE: u16 = u16::MAX;

/// Looking for the nearest sources compares every target with every vertex of the border; a head
/// has 3 million pairs in all, and so many take a second.
const MOST_PAIRS: usize = 1 << 28;

/// The vertices around a region and what they follow.
///
/// Target t moves by `falloff(distance_t / alpha)` times the weighted mean of its sources'
/// displacements. Eq. 11's single nearest vertex creases where neighbours have far-apart nearest
/// vertices, so there are several sources, with weights that sum to 1. How much a target follows
/// goes by its distance along the surface, so the upper lip does not pull the lower; whom it
/// follows is seen from the mesh, so a model file does not have to say it.
#[derive(Debug, Clone)]
pub struct Surround {
    /// The vertices that follow, increasing; none of the support.
    pub targets: Vec<u32>,
    /// Distance of each target from the region along the undeformed surface, mm, on
    /// [`DISTANCES`](crate::quantise::DISTANCES).
    pub distances: Vec<f32>,
    /// The parts that follow as one.
    pub rigid: Vec<Rigid>,
    /// Where each target is, and which of the parts it is of, if of any.
    points: Vec<(Vec3, Option<u32>)>,
    nearest: Nearest,
    kept: OnceLock<Vec<Row>>,
}

/// What a target follows: places in the support (not vertex numbers), and their weights in units of
/// 1/65535, which sum to 65535.
pub type Row = [(u32, u16); SOURCES];

/// What is followed is found from the rest.
impl PartialEq for Surround {
    fn eq(&self, other: &Self) -> bool {
        let all = |s: &Self| (s.targets.clone(), s.distances.clone(), s.rigid.clone());
        all(self) == all(other) && self.points == other.points
    }
}

/// A part whose vertices all follow the same sources, so that it keeps its shape: an eyeball.
#[derive(Debug, Clone, PartialEq)]
pub struct Rigid {
    /// The part, an index into the topology's parts.
    pub part: u32,
    /// Places in the support.
    pub sources: [u32; SOURCES],
    /// Their weights in units of 1/65535; they sum to 65535.
    pub weights: [u16; SOURCES],
}

impl Surround {
    /// Finds the sources of `targets` (increasing), which are `distances` mm away from the region
    /// of `support` (increasing vertex numbers) on the mean face.
    ///
    /// # Errors
    /// When a target is of the support or has no distance, a part is not there or its sources are
    /// not sound, or the region has no border.
    pub fn new(
        mean: &[Vec3],
        topology: &Topology,
        support: &[u32],
        targets: Vec<u32>,
        distances: Vec<f32>,
        rigid: Vec<Rigid>,
    ) -> Result<Self> {
        let bad = |why: String| Err(Error::Blob(why));
        let mut inside = vec![false; mean.len()];
        support.iter().for_each(|&v| inside[v as usize] = true);
        let increasing = targets.windows(2).all(|w| w[0] < w[1]);
        let outside = |t: &u32| inside.get(*t as usize) == Some(&false);
        if !increasing || !targets.iter().all(outside) || distances.len() != targets.len() {
            return bad("its surround is not in order".into());
        }
        if !distances.iter().all(|&d| d >= 0.0) {
            return bad("a negative distance".into());
        }
        let nearest = Nearest::new(mean, topology, support);
        if nearest.border.is_empty() && !targets.is_empty() {
            return bad("it has a surround but no border".into());
        }
        if nearest.border.len().saturating_mul(targets.len()) > MOST_PAIRS {
            return bad("its surround is too large".into());
        }
        let mut led = vec![None; mean.len()];
        for (row, r) in rigid.iter().zip(0..) {
            let sum: u32 = row.weights.iter().map(|&w| u32::from(w)).sum();
            let inside = row.sources.iter().all(|&s| (s as usize) < support.len());
            let part = topology.parts.get(row.part as usize);
            let Some(part) = part.filter(|_| inside && sum == u32::from(WHOLE)) else {
                return bad(format!("what part {} follows is not sound", row.part));
            };
            let own = topology.uv_triangles.iter().skip(part.first as usize);
            for corner in own.take(part.count as usize).flatten() {
                led[topology.uv_vertices[*corner as usize] as usize] = Some(r);
            }
        }
        let point = |&t: &u32| (mean[t as usize], led[t as usize]);
        Ok(Self {
            points: targets.iter().map(point).collect(),
            targets,
            distances,
            rigid,
            nearest,
            kept: OnceLock::new(),
        })
    }

    /// Finds what all targets follow, and keeps it: who changes the fall-off distance once does so again.
    pub(crate) fn keep(&self) {
        self.kept
            .get_or_init(|| self.rows(&Vec::from_iter(0..self.targets.len())));
    }

    /// What some targets follow, by their places among all.
    pub fn rows(&self, targets: &[usize]) -> Vec<Row> {
        if let Some(kept) = self.kept.get() {
            return targets.iter().map(|&t| kept[t]).collect();
        }
        let mut nearest = self.nearest.clone();
        let mut rows = vec![[(0, 0); SOURCES]; targets.len()];
        for (row, &t) in rows.iter_mut().zip(targets) {
            match self.points[t] {
                (p, None) => nearest.row(p, row),
                (_, Some(part)) => {
                    let Rigid {
                        sources, weights, ..
                    } = &self.rigid[part as usize];
                    *row = std::array::from_fn(|i| (sources[i], weights[i]));
                }
            }
        }
        rows
    }
}

/// Border vertices that are passed over at a time when they are too far away.
const GROUP: usize = 16;

/// The border of a region, to look for the nearest of its vertices.
#[derive(Debug, Clone)]
pub(crate) struct Nearest {
    /// The place in the support of each border vertex, and where it is.
    border: Vec<(u32, Vec3)>,
    /// Where they are, four side by side: x, y and z. What fills the last is infinitely far.
    fours: Vec<[f32x4; 3]>,
    /// The box around each [`GROUP`] of them: neighbours in number are neighbours on the head.
    boxes: Vec<[f32x4; 2]>,
    /// The nearest to the point that was last looked at, once there was one, and which vertices are
    /// among these.
    last: Vec<u64>,
    among: Vec<bool>,
}

/// A border vertex that is near: squared distances that are no less than 0 are in the order of their bits.
fn near(squared: f32, i: u32) -> u64 {
    u64::from(squared.to_bits()) << 32 | u64::from(i)
}

/// How far it is, squared.
fn squared(near: u64) -> f32 {
    f32::from_bits((near >> 32) as u32)
}

/// Which it is.
fn place(near: u64) -> usize {
    near as u32 as usize
}

/// Puts a vertex among the nearest, which are in order, in place of the last.
#[inline(always)]
fn insert(found: &mut [u64; SOURCES + 1], new: u64) {
    let mut at = SOURCES;
    while at > 0 && found[at - 1] > new {
        found[at] = found[at - 1];
        at -= 1;
    }
    found[at] = new;
}

impl Nearest {
    /// Of a region: the vertices of `support` with a neighbour outside of it.
    pub fn new(mean: &[Vec3], topology: &Topology, support: &[u32]) -> Self {
        let mut inside = vec![false; mean.len()];
        support.iter().for_each(|&v| inside[v as usize] = true);
        let mut on_border = vec![false; mean.len()];
        for corners in &topology.uv_triangles {
            let triangle = corners.map(|c| topology.uv_vertices[c as usize]);
            if triangle.iter().any(|&v| !inside[v as usize]) {
                triangle
                    .iter()
                    .for_each(|&v| on_border[v as usize] = inside[v as usize]);
            }
        }
        let border = support.iter().zip(0..);
        let border = border.filter(|(v, _)| on_border[**v as usize]);
        Self::of(
            border
                .map(|(&v, place)| (place, mean[v as usize]))
                .collect(),
        )
    }

    fn of(border: Vec<(u32, Vec3)>) -> Self {
        let around = |some: &[(u32, Vec3)]| {
            let start = (Vec3::INFINITY, Vec3::NEG_INFINITY);
            let (low, high) = some.iter().fold(start, |b, s| (b.0.min(s.1), b.1.max(s.1)));
            [low, high].map(|p| f32x4::new([p.x, p.y, p.z, 0.0]))
        };
        let four = |some: &[(u32, Vec3)]| {
            let of = |axis: usize, i: usize| some.get(i).map_or(f32::INFINITY, |s| s.1[axis]);
            [0, 1, 2].map(|axis| f32x4::new([0, 1, 2, 3].map(|i| of(axis, i))))
        };
        Self {
            boxes: border.chunks(GROUP).map(around).collect(),
            fours: border.chunks(4).map(four).collect(),
            last: Vec::new(),
            among: vec![false; border.len()],
            border,
        }
    }

    /// The nearest border vertices to `p` with weights that sink to zero where one drops out of
    /// the set, so that neighbours with other sets agree (the modified Shepard weights of Renka
    /// 1988).
    // Not inlined: engines run the fast code of a function from its next call on.
    #[inline(never)]
    pub fn row(&mut self, p: Vec3, row: &mut Row) {
        // The nearest first; one more than there are sources.
        let mut found = [near(f32::INFINITY, u32::MAX); SOURCES + 1];
        // Those of the point before are a good guess. Points come along the mesh, so that this leaves
        // few to compare; what comes out does not depend on it.
        for i in self.last.iter().map(|&last| place(last)) {
            let squared = p.distance_squared(self.border[i].1);
            insert(&mut found, near(squared, i as u32));
        }
        let bound = squared(found[SOURCES]);
        let [x, y, z] = p.to_array().map(f32x4::splat);
        let at = f32x4::new([p.x, p.y, p.z, 0.0]);
        for (group, [low, high]) in self.boxes.iter().enumerate() {
            let [dx, dy, dz, _] = (*low - at)
                .fast_max(at - *high)
                .fast_max(f32x4::ZERO)
                .to_array();
            // A thousandth is far more than what rounding makes of a distance.
            if dx * dx + dy * dy + dz * dz > 1.001 * bound {
                continue;
            }
            let first = group * GROUP;
            let fours = self.fours[first / 4..].iter().take(GROUP / 4);
            for (q, first) in fours.zip((first as u32..).step_by(4)) {
                let (dx, dy, dz) = (x - q[0], y - q[1], z - q[2]);
                let squares = dx * dx + dy * dy + dz * dz;
                if squares.simd_le(f32x4::splat(bound)).none() {
                    continue;
                }
                for (squared, i) in squares.to_array().into_iter().zip(first..) {
                    let new = near(squared, i);
                    if new < found[SOURCES] && self.among.get(i as usize) == Some(&false) {
                        insert(&mut found, new);
                    }
                }
            }
        }
        if self.border.len() > SOURCES {
            if self.last.is_empty() {
                self.last = found.to_vec();
            }
            for (last, found) in self.last.iter_mut().zip(found) {
                self.among[place(*last)] = false;
                *last = found;
            }
            self.last.iter().for_each(|&n| self.among[place(n)] = true);
        }
        let found = match self.last.is_empty() {
            true => &found[..self.border.len()],
            false => &self.last,
        };
        let mut nearness = [0.0; SOURCES + 1];
        for (nearness, near) in nearness.iter_mut().zip(found) {
            *nearness = 1.0 / squared(*near).max(1e-12).sqrt();
        }
        let few = found.len().min(SOURCES);
        let horizon = match found.len() > SOURCES {
            true => nearness[SOURCES],
            false => nearness[..few].last().map_or(1.0, |n| n / 1.2),
        };
        let mut total = 0.0;
        for n in &mut nearness[..few] {
            *n = (*n - horizon) * (*n - horizon) + 1e-12;
            total += *n;
        }
        // Half a unit less, so that rounding cannot make more than all of them.
        let scale = (f32::from(WHOLE) - 0.5) / total;
        row.fill((self.border[0].0, 0));
        let mut left = WHOLE;
        for ((row, weight), near) in row.iter_mut().zip(&nearness[..few]).zip(found) {
            *row = (self.border[place(*near)].0, (weight * scale) as u16);
            left -= row.1;
        }
        // The nearest has the most; what rounding left is its too.
        row[0].1 += left;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Nearest {
        fn of_point(&mut self, p: Vec3) -> Row {
            let mut row = [(0, 0); SOURCES];
            self.row(p, &mut row);
            row
        }
    }

    #[test]
    fn weights_sum_to_one_and_the_nearest_has_the_most() {
        for count in [1, 2, 8, 9, 40] {
            let border = (0..count).map(|i| (i, Vec3::new(i as f32, 0.0, 0.0)));
            let mut nearest = Nearest::of(border.collect());
            for x in [-3.0, 0.0, 0.4, 5.2, 100.0] {
                let row = nearest.of_point(Vec3::new(x, 1.0, 0.0));
                assert_eq!(row.iter().map(|s| u32::from(s.1)).sum::<u32>(), 65_535);
                assert!(row.iter().all(|s| s.1 <= row[0].1 && s.0 < count));
                let closest = x.round().max(0.0).min(count as f32 - 1.0) as u32;
                assert_eq!(row[0].0, closest);
            }
        }
    }

    #[test]
    fn the_nearest_do_not_depend_on_where_was_looked_before() {
        let mut random = crate::Random::new(3);
        let mut point = || Vec3::from_array([0; 3].map(|_| random.normal() as f32));
        let border: Vec<(u32, Vec3)> = (0..60).map(|i| (i, point())).collect();
        let mut walked = Nearest::of(border.clone());
        for _ in 0..500 {
            let p = point();
            let row = walked.of_point(p);
            assert_eq!(row, Nearest::of(border.clone()).of_point(p));
            let mut nearest = border.clone();
            nearest.sort_by(|a, b| p.distance(a.1).total_cmp(&p.distance(b.1)));
            assert_eq!(
                row.map(|s| s.0)[..],
                nearest[..SOURCES].iter().map(|b| b.0).collect::<Vec<_>>()
            );
        }
    }

    #[test]
    fn weights_do_not_jump_where_the_set_changes() {
        let border = (0..40).map(|i| (i, Vec3::new(i as f32, (i as f32).sin(), 0.0)));
        let mut nearest = Nearest::of(border.collect());
        let mut at = |x: f32| {
            let mut dense = [0_i32; 40];
            for (place, weight) in nearest.of_point(Vec3::new(x, 4.0, 1.0)) {
                dense[place as usize] += i32::from(weight);
            }
            dense
        };
        // A thousandth of the spacing moves a weight by a few thousandths, wherever it happens.
        for i in 0..20_000 {
            let (a, b) = (at(10.0 + i as f32 * 0.001), at(10.001 + i as f32 * 0.001));
            let most = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).max();
            assert!(most < Some(300), "{most:?} at {i}");
        }
    }
}
