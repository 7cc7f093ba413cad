//! The same surface with other vertices and other triangles: what two scans of one face have in
//! common, and what they have not.
//!
//! Each triangle is divided into four, the vertices wander over the surface, and some edges flip.
//! The result is a manifold whose vertices lie on the given surface, hardly any of them where a
//! vertex of it was (those of the border stay).

use std::collections::HashSet;

use glam::DVec3;

use crate::Random;

/// A point of a triangle mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// The triangle.
    pub triangle: u32,
    /// Barycentric weights on its corners; they sum to 1.
    pub weights: [f64; 3],
}

impl SurfacePoint {
    /// Where it is when the mesh has these vertices.
    pub fn on(&self, positions: &[DVec3], triangles: &[[u32; 3]]) -> DVec3 {
        let corners = triangles[self.triangle as usize];
        (0..3)
            .map(|i| positions[corners[i] as usize] * self.weights[i])
            .sum()
    }
}

/// How far a vertex wanders at most in each of two sweeps, in lengths of the edges around it.
const WANDER: f64 = 0.5;

/// The cosine of the greatest angle by which a move may turn a triangle.
const TURN: f64 = 0.8;

/// The cosine of the greatest angle between the triangles before and after a flip.
const FLAT: f64 = 0.95;

/// A triangle's least height must be this part of its longest edge, where it was before.
const SLIM: f64 = 0.12;

/// The share of edges that are tried to flip.
const FLIPS: f64 = 0.3;

/// No triangle.
const NONE: u32 = u32::MAX;

/// The connectivity of a surface that is to be resampled, made once for all its shapes.
#[derive(Debug)]
pub struct Resampler<'a> {
    triangles: &'a [[u32; 3]],
    /// The triangle across the edge opposite to each corner.
    across: Vec<[u32; 3]>,
    /// Each triangle divided into four.
    fine: Vec<[u32; 3]>,
    /// Where the vertices of `fine` are.
    starts: Vec<SurfacePoint>,
    /// The fine triangles around each fine vertex.
    fans: Vec<Vec<u32>>,
    /// The fine edges `(a, b)`, a < b, sorted, each with its triangles.
    edges: Vec<((u32, u32), [u32; 2])>,
    /// The fine vertices of the border, which stay.
    border: Vec<bool>,
}

impl<'a> Resampler<'a> {
    /// Prepares a manifold of `vertices` vertices.
    pub fn new(vertices: usize, triangles: &'a [[u32; 3]]) -> Self {
        let coarse = edges(triangles);
        let mut across = vec![[NONE; 3]; triangles.len()];
        for &((a, b), [t, u]) in &coarse {
            if u != NONE {
                across[t as usize][opposite(triangles[t as usize], a, b)] = u;
                across[u as usize][opposite(triangles[u as usize], a, b)] = t;
            }
        }
        let mut starts = vec![
            SurfacePoint {
                triangle: NONE,
                weights: [0.0; 3]
            };
            vertices + coarse.len()
        ];
        let mut fine = Vec::with_capacity(4 * triangles.len());
        for (t, &[a, b, c]) in triangles.iter().enumerate() {
            let triangle = t as u32;
            for (corner, vertex) in [a, b, c].into_iter().enumerate() {
                let mut weights = [0.0; 3];
                weights[corner] = 1.0;
                starts[vertex as usize] = SurfacePoint { triangle, weights };
            }
            let [ab, bc, ca] = [(a, b, 2), (b, c, 0), (c, a, 1)].map(|(from, to, corner)| {
                let key = (from.min(to), from.max(to));
                let edge = coarse.partition_point(|&(e, _)| e < key);
                let middle = vertices + edge;
                let mut weights = [0.5; 3];
                weights[corner] = 0.0;
                starts[middle] = SurfacePoint { triangle, weights };
                middle as u32
            });
            fine.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        let mut fans = vec![Vec::new(); starts.len()];
        for (t, corners) in fine.iter().enumerate() {
            for &vertex in corners {
                fans[vertex as usize].push(t as u32);
            }
        }
        let edges = edges(&fine);
        let mut border = vec![false; starts.len()];
        for &((a, b), [_, second]) in &edges {
            if second == NONE {
                border[a as usize] = true;
                border[b as usize] = true;
            }
        }
        Self {
            triangles,
            across,
            fine,
            starts,
            fans,
            edges,
            border,
        }
    }

    /// Resamples the surface in the shape of `positions`: where the new vertices are, and the new
    /// triangles, four times as many as the surface has.
    pub fn resample(
        &self,
        positions: &[DVec3],
        random: &mut Random,
    ) -> (Vec<SurfacePoint>, Vec<[u32; 3]>) {
        let mut points = self.starts.clone();
        let mut places: Vec<DVec3> = points
            .iter()
            .map(|p| p.on(positions, self.triangles))
            .collect();
        for _ in 0..2 {
            for vertex in 0..points.len() {
                if !self.border[vertex] {
                    self.wander(vertex, positions, &mut points, &mut places, random);
                }
            }
        }
        (points, self.flip(&places, random))
    }

    /// Moves a vertex over the surface, as far as its triangles allow.
    fn wander(
        &self,
        vertex: usize,
        positions: &[DVec3],
        points: &mut [SurfacePoint],
        places: &mut [DVec3],
        random: &mut Random,
    ) {
        let fan = &self.fans[vertex];
        let here = places[vertex];
        let mut length = 0.0;
        for &t in fan {
            for v in self.fine[t as usize] {
                length += places[v as usize].distance(here);
            }
        }
        // Each edge of the fan was met twice.
        length *= WANDER * random.uniform() / (2.0 * fan.len() as f64);
        let direction = self.direction(vertex, points[vertex], positions, random);
        for _ in 0..3 {
            let point = self.walk(points[vertex], direction * length, positions);
            let place = point.on(positions, self.triangles);
            let fits = fan.iter().all(|&t| {
                let corners = self.fine[t as usize];
                let old = corners.map(|v| places[v as usize]);
                let new = corners.map(|v| {
                    if v as usize == vertex {
                        place
                    } else {
                        places[v as usize]
                    }
                });
                sound(new, old, TURN)
            });
            if fits {
                points[vertex] = point;
                places[vertex] = place;
                return;
            }
            length /= 2.0;
        }
    }

    /// A random unit tangent at a point. At a corner of its triangle it points into the triangle:
    /// which side of another edge it would leave by is not known there.
    fn direction(
        &self,
        vertex: usize,
        point: SurfacePoint,
        positions: &[DVec3],
        random: &mut Random,
    ) -> DVec3 {
        let corners = self.triangles[point.triangle as usize].map(|v| positions[v as usize]);
        let angle = std::f64::consts::TAU * random.uniform();
        let share = random.uniform();
        if let Some(corner) = point.weights.iter().position(|&w| w == 1.0) {
            debug_assert!(!self.border[vertex]);
            let [from, to] = [1, 2].map(|i| corners[(corner + i) % 3]);
            return (from.lerp(to, share) - corners[corner]).normalize_or_zero();
        }
        let along = (corners[1] - corners[0]).normalize_or_zero();
        let beside = normal(corners).cross(along);
        along * angle.cos() + beside * angle.sin()
    }

    /// Where one comes from a point of the surface along a tangent, straight on over edges; at the
    /// border one stops.
    fn walk(&self, from: SurfacePoint, tangent: DVec3, positions: &[DVec3]) -> SurfacePoint {
        let (mut point, mut rest) = (from, tangent);
        // Triangles are not much smaller than a step; the bound is for slivers.
        for _ in 0..32 {
            let ids = self.triangles[point.triangle as usize];
            let corners = ids.map(|v| positions[v as usize]);
            let change = barycentric(corners, rest);
            // It is left over the edge whose opposite corner's weight is the first to vanish.
            let (mut step, mut exit) = (1.0, None);
            for (corner, (weight, change)) in point.weights.iter().zip(change).enumerate() {
                let vanishes = (weight / -change).max(0.0);
                if change < 0.0 && vanishes < step {
                    (step, exit) = (vanishes, Some(corner));
                }
            }
            point.weights = std::array::from_fn(|i| (point.weights[i] + step * change[i]).max(0.0));
            let sum: f64 = point.weights.iter().sum();
            point.weights = point.weights.map(|w| w / sum);
            let Some(corner) = exit else { return point };
            let next = self.across[point.triangle as usize][corner];
            if next == NONE {
                return point;
            }
            let (a, b) = (ids[(corner + 1) % 3], ids[(corner + 2) % 3]);
            let other = self.triangles[next as usize];
            // The edge runs the other way in the triangle across: inwards is to its left there.
            let edge = (positions[b as usize] - positions[a as usize]).normalize_or_zero();
            let inwards = normal(other.map(|v| positions[v as usize])).cross(-edge);
            let along = rest.dot(edge);
            let ahead = (rest.length_squared() - along * along).max(0.0).sqrt();
            rest = (edge * along + inwards * ahead) * (1.0 - step);
            let weight = |v: u32| {
                let on_edge = [a, b].iter().position(|&e| e == v);
                on_edge.map_or(0.0, |i| point.weights[(corner + 1 + i) % 3])
            };
            point = SurfacePoint {
                triangle: next,
                weights: other.map(weight),
            };
        }
        point
    }

    /// The fine triangles with some edges flipped where the surface is nearly flat. A triangle is
    /// in one flip at most.
    fn flip(&self, places: &[DVec3], random: &mut Random) -> Vec<[u32; 3]> {
        let mut triangles = self.fine.clone();
        let mut taken = vec![false; triangles.len()];
        let mut valence: Vec<usize> = self.fans.iter().map(Vec::len).collect();
        let mut added = HashSet::new();
        // Not in the order of the edges, or one end of the mesh would have all the flips.
        let mut order: Vec<u32> = (0..self.edges.len() as u32)
            .filter(|_| random.uniform() < FLIPS)
            .collect();
        for i in (1..order.len()).rev() {
            order.swap(i, (random.bits() % (i as u64 + 1)) as usize);
        }
        for edge in order {
            let ((a, b), [t, u]) = self.edges[edge as usize];
            if u == NONE || taken[t as usize] || taken[u as usize] {
                continue;
            }
            // Of t's corners, from the one off the edge: c, then the edge as t has it.
            let first = triangles[t as usize];
            let off = opposite(first, a, b);
            let [c, a, b] = [0, 1, 2].map(|i| first[(off + i) % 3]);
            let second = triangles[u as usize];
            let d = second[opposite(second, a, b)];
            let key = (c.min(d), c.max(d));
            let exists = self.edges.binary_search_by_key(&key, |&(e, _)| e).is_ok();
            let bare = [a, b]
                .iter()
                .any(|&v| valence[v as usize] <= 4 || self.border[v as usize]);
            if exists || bare || added.contains(&key) {
                continue;
            }
            let at = |corners: [u32; 3]| corners.map(|v| places[v as usize]);
            let (old, new) = ([first, second].map(at), [[c, a, d], [d, b, c]].map(at));
            let fits = new
                .iter()
                .all(|&new| old.iter().all(|&old| sound(new, old, FLAT)));
            if fits {
                triangles[t as usize] = [c, a, d];
                triangles[u as usize] = [d, b, c];
                taken[t as usize] = true;
                taken[u as usize] = true;
                added.insert(key);
                for v in [a, b] {
                    valence[v as usize] -= 1;
                }
                for v in [c, d] {
                    valence[v as usize] += 1;
                }
            }
        }
        triangles
    }
}

/// The edges `(a, b)`, a < b, of a manifold's triangles, sorted, with the one or two triangles
/// that have them; [`NONE`] for no second one.
fn edges(triangles: &[[u32; 3]]) -> Vec<((u32, u32), [u32; 2])> {
    let mut halves: Vec<((u32, u32), u32)> = triangles
        .iter()
        .enumerate()
        .flat_map(|(t, &[a, b, c])| {
            [(a, b), (b, c), (c, a)].map(|(a, b)| ((a.min(b), a.max(b)), t as u32))
        })
        .collect();
    halves.sort_unstable();
    halves
        .chunk_by(|a, b| a.0 == b.0)
        .map(|run| (run[0].0, [run[0].1, run.get(1).map_or(NONE, |half| half.1)]))
        .collect()
}

/// Which corner of a triangle is not on the edge `a b`.
fn opposite(corners: [u32; 3], a: u32, b: u32) -> usize {
    (0..3)
        .find(|&i| corners[i] != a && corners[i] != b)
        .unwrap_or(0)
}

/// The unit normal of a triangle.
fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize_or_zero()
}

/// Whether a triangle faces nearly where one before it did (the cosine of the angle between them is
/// at least `turn`), and is no sliver, or less of one.
fn sound(new: [DVec3; 3], before: [DVec3; 3], turn: f64) -> bool {
    normal(new).dot(normal(before)) >= turn && slimness(new) >= SLIM.min(slimness(before))
}

/// A triangle's least height in lengths of its longest edge.
fn slimness([a, b, c]: [DVec3; 3]) -> f64 {
    let longest = (b - a)
        .length_squared()
        .max((c - b).length_squared())
        .max((a - c).length_squared());
    if longest == 0.0 {
        return 0.0;
    }
    (b - a).cross(c - a).length() / longest
}

/// How the barycentric weights change along a vector in the plane of a triangle.
fn barycentric([a, b, c]: [DVec3; 3], along: DVec3) -> [f64; 3] {
    let (ab, ac) = (b - a, c - a);
    let cross = ab.cross(ac);
    let area = cross.length_squared();
    if area == 0.0 {
        return [0.0; 3];
    }
    let v = along.cross(ac).dot(cross) / area;
    let w = ab.cross(along).dot(cross) / area;
    [-v - w, v, w]
}
