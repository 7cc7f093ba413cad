//! Folded triangles, squeezed ones, and triangles through each other.

use std::collections::BTreeSet;

use glam::{DMat2, DVec2, DVec3};
use parry3d::bounding_volume::Aabb;
use parry3d::math::Vector;
use parry3d::partitioning::{Bvh, BvhBuildStrategy};

use super::template::Template;
use crate::fit::{FitError, FitResult};

/// The cosine of 120 degrees, beyond which two neighbouring triangles are folded over.
const FOLDED: f64 = -0.5;

/// How far from the landmarks of lips and lids triangles are tested against each other, mm.
const AROUND: f64 = 25.0;

/// Rounds of evening out at most.
const EVENINGS: usize = 30;

/// Pairs of neighbouring triangles that should not fold.
#[derive(Debug, Clone)]
pub struct Folds {
    triangles: Vec<[u32; 3]>,
    /// The triangles at each edge, where they are not folded at rest.
    pairs: Vec<[u32; 2]>,
}

impl Folds {
    /// The pairs of `triangles` whose normals are at most 120 degrees apart at `rest`.
    pub fn new(rest: &[DVec3], triangles: Vec<[u32; 3]>) -> Self {
        let mut halves: Vec<((u32, u32), u32)> = (0_u32..)
            .zip(&triangles)
            .flat_map(|(t, &[a, b, c])| {
                [(a, b), (b, c), (c, a)].map(|(a, b)| ((a.min(b), a.max(b)), t))
            })
            .collect();
        halves.sort_unstable();
        let all = Self {
            pairs: halves
                .chunk_by(|a, b| a.0 == b.0)
                .filter(|run| run.len() == 2)
                .map(|run| [run[0].1, run[1].1])
                .collect(),
            triangles,
        };
        let folded = all.of(rest);
        let pairs = all.pairs.iter().filter(|pair| !folded.contains(pair));
        Self {
            pairs: pairs.copied().collect(),
            triangles: all.triangles,
        }
    }

    /// The pairs that are folded in a face: places in the list of triangles.
    pub fn of(&self, face: &[DVec3]) -> Vec<[u32; 2]> {
        let normals: Vec<DVec3> = self
            .triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|v| face[v as usize]);
                (b - a).cross(c - a).normalize_or_zero()
            })
            .collect();
        let folded =
            |pair: &&[u32; 2]| normals[pair[0] as usize].dot(normals[pair[1] as usize]) < FOLDED;
        self.pairs.iter().filter(folded).copied().collect()
    }

    /// The vertices of some pairs, each once, increasing.
    pub fn vertices(&self, pairs: &[[u32; 2]]) -> Vec<u32> {
        let corners = |&t: &u32| self.triangles[t as usize];
        let mut vertices: Vec<u32> = pairs.as_flattened().iter().flat_map(corners).collect();
        vertices.sort_unstable();
        vertices.dedup();
        vertices
    }

    /// Evens out a face where it is folded: vertices move towards the middle of their neighbours.
    /// Returns whether no fold is left.
    pub fn even_out(&self, face: &mut [DVec3], neighbours: &[Vec<u32>]) -> bool {
        let mut patch = BTreeSet::new();
        for _ in 0..EVENINGS {
            let folded = self.of(face);
            if folded.is_empty() {
                return true;
            }
            for vertex in self.vertices(&folded) {
                patch.insert(vertex);
                patch.extend(&neighbours[vertex as usize]);
            }
            let middles: Vec<DVec3> = patch
                .iter()
                .map(|&v| {
                    let around = &neighbours[v as usize];
                    around.iter().map(|&n| face[n as usize]).sum::<DVec3>() / around.len() as f64
                })
                .collect();
            for (&v, middle) in patch.iter().zip(middles) {
                face[v as usize] = (face[v as usize] + middle) / 2.0;
            }
        }
        false
    }
}

/// How the triangles of a mesh are stretched in a face, beside a face at rest.
#[derive(Debug, Clone)]
pub struct Stretches {
    charts: Vec<Chart>,
}

/// A triangle at rest, in its plane: its first edge along x, and the inverse of the matrix of both
/// edges from its first corner.
#[derive(Debug, Clone, Copy)]
struct Chart {
    corners: [u32; 3],
    inverse: DMat2,
}

impl Stretches {
    /// Of the triangles that are larger than `least` (mm^2) at `rest`.
    pub fn new(rest: &[DVec3], triangles: &[[u32; 3]], least: f64) -> Self {
        let chart = |&corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|v| rest[v as usize]);
            let (along, other) = (b - a, c - a);
            let (length, twice) = (along.length(), along.cross(other).length());
            (twice > 2.0 * least).then(|| {
                let x = other.dot(along) / length;
                let edges = DMat2::from_cols(DVec2::X * length, DVec2::new(x, twice / length));
                let inverse = edges.inverse();
                Chart { corners, inverse }
            })
        };
        Self {
            charts: triangles.iter().filter_map(chart).collect(),
        }
    }

    /// What is left of the length of a line on the face where and along which it is squeezed most:
    /// the least singular value of any triangle's map from rest. 1 at rest, 0 for a triangle without
    /// area.
    pub fn least(&self, face: &[DVec3]) -> f64 {
        let each = self.charts.iter().map(|chart| {
            let [a, b, c] = chart.corners.map(|v| face[v as usize]);
            let (along, other, turn) = (b - a, c - a, chart.inverse);
            let [x, y] = [turn.x_axis, turn.y_axis].map(|t| along * t.x + other * t.y);
            let (xx, xy, yy) = (x.dot(x), x.dot(y), y.dot(y));
            let half = (xx + yy) / 2.0;
            let apart = ((xx - yy) / 2.0).hypot(xy);
            (half - apart).max(0.0).sqrt()
        });
        each.fold(f64::INFINITY, f64::min)
    }
}

/// The neighbours of each of a mesh's vertices along its edges, increasing.
pub fn edge_neighbours(vertices: usize, triangles: &[[u32; 3]]) -> Vec<Vec<u32>> {
    let mut neighbours = vec![Vec::new(); vertices];
    for &[a, b, c] in triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            neighbours[from as usize].push(to);
            neighbours[to as usize].push(from);
        }
    }
    for row in &mut neighbours {
        row.sort_unstable();
        row.dedup();
    }
    neighbours
}

/// Triangles at lips and lids that should not go through each other.
#[derive(Debug, Clone)]
pub struct Crossings {
    triangles: Vec<[u32; 3]>,
    /// Those that do so at rest, sorted.
    at_rest: Vec<[u32; 2]>,
}

impl Crossings {
    /// Skin and cavities within 25 mm of the landmarks of eyes and mouth (`ibug_36` to
    /// `ibug_67`).
    ///
    /// # Errors
    /// When the template lacks those parts or landmarks.
    pub fn new(template: &Template) -> FitResult<Self> {
        let rest = &template.positions;
        let points = (36..68)
            .map(|i| super::region::point(template, &format!("ibug_{i:02}")))
            .collect::<FitResult<Vec<DVec3>>>()?;
        let mut triangles = template.part_triangles("skin")?;
        triangles.extend(template.part_triangles("mouth cavity")?);
        triangles.extend(template.part_triangles("eye cavities")?);
        triangles.retain(|t| {
            let at = rest[t[0] as usize];
            points.iter().any(|p| p.distance(at) < AROUND)
        });
        if triangles.is_empty() {
            let cause = "the template has no triangles around eyes and mouth";
            return Err(FitError::Input(cause.into()));
        }
        let mut all = Self {
            triangles,
            at_rest: Vec::new(),
        };
        all.at_rest = all.of(rest);
        Ok(all)
    }

    /// The triangles that are tested.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The pairs of triangles without a common vertex that go through each other in a face and
    /// did not do so at rest: places in the list of triangles, sorted.
    pub fn of(&self, face: &[DVec3]) -> Vec<[u32; 2]> {
        let corners = |t: u32| self.triangles[t as usize].map(|v| face[v as usize]);
        let boxes: Vec<Aabb> = (0..self.triangles.len() as u32)
            .map(|t| {
                let [a, b, c] = corners(t);
                // What rounding to single precision may take away from a box.
                let slack = 1e-3;
                let low = (a.min(b).min(c) - slack).as_vec3();
                let high = (a.max(b).max(c) + slack).as_vec3();
                Aabb::new(
                    Vector::new(low.x, low.y, low.z),
                    Vector::new(high.x, high.y, high.z),
                )
            })
            .collect();
        let tree = Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes);
        let mut found = Vec::new();
        for t in 0..self.triangles.len() as u32 {
            let ids = self.triangles[t as usize];
            for u in tree.intersect_aabb(&boxes[t as usize]) {
                let apart = || self.triangles[u as usize].iter().all(|v| !ids.contains(v));
                if t < u && apart() && cross(corners(t), corners(u)) {
                    found.push([t, u]);
                }
            }
        }
        found.sort_unstable();
        found.retain(|pair| self.at_rest.binary_search(pair).is_err());
        found
    }
}

/// Whether two triangles go through each other: an edge of one meets the inside of the other.
/// Triangles in one plane do not.
fn cross(one: [DVec3; 3], other: [DVec3; 3]) -> bool {
    let pierces = |edges: [DVec3; 3], face: [DVec3; 3]| {
        (0..3).any(|i| pierce(edges[i], edges[(i + 1) % 3], face))
    };
    pierces(one, other) || pierces(other, one)
}

/// Whether the segment `p q` goes through the triangle: both ends on different sides of its plane,
/// and the line inside of all three edges (signed volumes).
fn pierce(p: DVec3, q: DVec3, [a, b, c]: [DVec3; 3]) -> bool {
    let volume = |a: DVec3, b: DVec3, c: DVec3, d: DVec3| (b - a).cross(c - a).dot(d - a);
    if volume(a, b, c, p) * volume(a, b, c, q) >= 0.0 {
        return false;
    }
    let sides = [volume(p, q, a, b), volume(p, q, b, c), volume(p, q, c, a)];
    sides.iter().all(|&s| s > 0.0) || sides.iter().all(|&s| s < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;

    #[test]
    fn triangles_cross_when_a_point_of_one_is_on_both_sides_of_the_other() {
        let mut random = Random::new(5);
        let mut point = || DVec3::from_array(std::array::from_fn(|_| random.normal()));
        let mut crossing = 0;
        for _ in 0..2000 {
            let (one, other) = ([point(), point(), point()], [point(), point(), point()]);
            assert_eq!(cross(one, other), cross(other, one));
            // Many points of an edge against the other triangle: a coarse twin of the test.
            let found = [(one, other), (other, one)].iter().any(|(edges, face)| {
                let n = (face[1] - face[0]).cross(face[2] - face[0]);
                (0..3).any(|i| {
                    let (p, q) = (edges[i], edges[(i + 1) % 3]);
                    let (d, e) = (n.dot(p - face[0]), n.dot(q - face[0]));
                    let at = p.lerp(q, d / (d - e));
                    let on = crate::fit::mesh::surface::closest_on_triangle(*face, at);
                    let foot: DVec3 = (0..3).map(|i| face[i] * on[i]).sum();
                    d * e < 0.0 && foot.distance(at) < 1e-9
                })
            });
            assert_eq!(cross(one, other), found);
            crossing += usize::from(found);
            // Far apart nothing crosses.
            let far = other.map(|p| p + DVec3::X * 50.0);
            assert!(!cross(one, far));
        }
        assert!(crossing > 200);
    }

    #[test]
    fn a_squeezed_face_has_the_length_that_is_left() {
        let mut random = Random::new(3);
        let mut point = || DVec3::from_array(std::array::from_fn(|_| random.normal()));
        for _ in 0..100 {
            let rest = [point(), point(), point(), point()];
            // The last triangle is too small to count.
            let triangles = [[0, 1, 2], [1, 3, 2], [0, 0, 3]];
            let stretches = Stretches::new(&rest, &triangles, 1e-6);
            let (turn, shift) = (
                glam::DQuat::from_rotation_arc(point().normalize(), DVec3::X),
                point(),
            );
            let turned = rest.map(|p| turn * p + shift);
            assert!((stretches.least(&turned) - 1.0).abs() < 1e-9);
            assert!((stretches.least(&turned.map(|p| p * 0.3)) - 0.3).abs() < 1e-9);
        }
        // Along one direction alone, in its plane and askew to the edges.
        let flat = [
            DVec3::ZERO,
            DVec3::new(2.0, 1.0, 0.0),
            DVec3::new(-1.0, 3.0, 0.0),
        ];
        let stretches = Stretches::new(&flat, &[[0, 1, 2]], 0.1);
        let squeezed = flat.map(|p| p * DVec3::new(1.7, 0.45, 1.0));
        assert!((stretches.least(&squeezed) - 0.45).abs() < 1e-12);
        assert!(stretches.least(&[DVec3::ZERO; 3]).abs() < 1e-12);
    }

    #[test]
    fn a_fold_is_counted_unless_it_is_there_at_rest() {
        // A strip of two triangles, hinged at the y axis.
        let strip = |angle: f64| {
            let (sine, cosine) = angle.to_radians().sin_cos();
            vec![
                DVec3::ZERO,
                DVec3::Y,
                DVec3::X,
                DVec3::new(-cosine, 0.0, sine),
            ]
        };
        let triangles = vec![[0, 2, 1], [0, 1, 3]];
        let open = Folds::new(&strip(0.0), triangles.clone());
        for (angle, folded) in [(0.0, 0), (119.0, 0), (-119.0, 0), (121.0, 1), (-150.0, 1)] {
            assert_eq!(open.of(&strip(angle)).len(), folded, "{angle} degrees");
        }
        let shut = Folds::new(&strip(150.0), triangles);
        assert_eq!(shut.of(&strip(150.0)).len(), 0);
    }
}
