//! A triangle mesh that can be asked for its closest point.

use glam::DVec3;
use parry3d::bounding_volume::Aabb;
use parry3d::math::Vector;
use parry3d::partitioning::{Bvh, BvhBuildStrategy, BvhNode};

/// A triangle mesh with a bounding volume hierarchy.
///
/// The hierarchy is single precision and only finds the triangle; points and weights are double.
pub struct Surface<'a> {
    /// Vertices, mm.
    pub positions: &'a [DVec3],
    /// Triangles, counter-clockwise from outside.
    pub triangles: &'a [[u32; 3]],
    /// Unit normals of the vertices, weighted by area.
    pub normals: Vec<DVec3>,
    /// The unit normal of each triangle; zero where it has no area.
    pub facets: Vec<DVec3>,
    /// Whether each vertex is on the border of the mesh (an edge with one triangle).
    pub border: Vec<bool>,
    bvh: Bvh,
}

/// A point of a [`Surface`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// The triangle.
    pub triangle: u32,
    /// Barycentric weights on its corners.
    pub weights: [f64; 3],
    /// The point, mm.
    pub point: DVec3,
    /// Its distance from what was asked for, mm.
    pub distance: f64,
}

impl<'a> Surface<'a> {
    /// The surface of a mesh.
    pub fn new(positions: &'a [DVec3], triangles: &'a [[u32; 3]]) -> Self {
        let leaves: Vec<Aabb> = triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|v| positions[v as usize]);
                let (low, high) = (a.min(b).min(c), a.max(b).max(c));
                // Rounded to single precision a box may lose up to this much of its triangle.
                let slack = 1e-6 * (1.0 + low.abs().max_element().max(high.abs().max_element()));
                Aabb::new(single(low - slack), single(high + slack))
            })
            .collect();
        let facets = triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|v| positions[v as usize]);
                (b - a).cross(c - a).normalize_or_zero()
            })
            .collect();
        Self {
            positions,
            triangles,
            normals: normals(positions, triangles),
            facets,
            border: border(positions.len(), triangles),
            bvh: Bvh::from_leaves(BvhBuildStrategy::Binned, &leaves),
        }
    }

    /// The closest point within `reach` of `p`.
    pub fn closest(&self, p: DVec3, reach: f64) -> Option<Hit> {
        self.closest_where(p, reach, |_| true)
    }

    /// The closest point within `reach` of `p` on the triangles that `admitted` lets through.
    pub fn closest_where(
        &self,
        p: DVec3,
        reach: f64,
        admitted: impl Fn(u32) -> bool,
    ) -> Option<Hit> {
        let query = single(p);
        // Costs are squared distances; the slack of the boxes is far below what rounding adds.
        let found = self.bvh.find_best(
            (reach * reach) as f32 * (1.0 + 1e-6) + f32::MIN_POSITIVE,
            |node: &BvhNode, _| {
                let outside = (node.mins() - query).max(query - node.maxs());
                outside.max(Vector::ZERO).length_squared()
            },
            |triangle, _| {
                if !admitted(triangle) {
                    return None;
                }
                let corners = self.triangles[triangle as usize].map(|v| self.positions[v as usize]);
                let weights = closest_on_triangle(corners, p);
                let q: DVec3 = (0..3).map(|i| corners[i] * weights[i]).sum();
                Some((q.distance_squared(p) as f32, (weights, q)))
            },
        );
        found
            .map(|(triangle, (_, (weights, point)))| Hit {
                triangle,
                weights,
                point,
                distance: point.distance(p),
            })
            .filter(|hit| hit.distance <= reach)
    }

    /// The interpolated unit normal at a hit.
    pub fn normal(&self, hit: &Hit) -> DVec3 {
        let corners = self.triangles[hit.triangle as usize];
        (0..3)
            .map(|i| self.normals[corners[i] as usize] * hit.weights[i])
            .sum::<DVec3>()
            .normalize_or(self.facets[hit.triangle as usize])
    }

    /// Whether a hit lies on the mesh's border: on an edge or corner that only one triangle has.
    pub fn on_border(&self, hit: &Hit) -> bool {
        let corners = self.triangles[hit.triangle as usize];
        let inside =
            hit.weights.iter().any(|&w| w >= 1.0 - 1e-9) || hit.weights.iter().any(|&w| w <= 1e-9);
        inside && (0..3).all(|i| hit.weights[i] <= 1e-9 || self.border[corners[i] as usize])
    }

    /// The first point of the surface along a ray, with its distance in lengths of `direction`.
    pub fn cast(&self, origin: DVec3, direction: DVec3, reach: f64) -> Option<Hit> {
        let ray = parry3d::query::Ray::new(single(origin), single(direction));
        let found = self.bvh.cast_ray(&ray, reach as f32, |triangle, _| {
            let [a, b, c] = self.triangles[triangle as usize].map(|v| self.positions[v as usize]);
            crossing([a, b, c], origin, direction).map(|(t, _)| t as f32)
        });
        let (triangle, _) = found?;
        let corners = self.triangles[triangle as usize].map(|v| self.positions[v as usize]);
        let (distance, weights) = crossing(corners, origin, direction)?;
        (distance <= reach).then(|| Hit {
            triangle,
            weights,
            point: origin + direction * distance,
            distance,
        })
    }
}

/// Where a ray crosses a triangle: distance in lengths of the direction, and barycentric weights
/// (Moller and Trumbore 1997).
fn crossing([a, b, c]: [DVec3; 3], origin: DVec3, direction: DVec3) -> Option<(f64, [f64; 3])> {
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(ac);
    let determinant = ab.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let from = origin - a;
    let u = from.dot(p) / determinant;
    let q = from.cross(ab);
    let v = direction.dot(q) / determinant;
    let t = ac.dot(q) / determinant;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= 0.0).then_some((t, [1.0 - u - v, u, v]))
}

/// Whether each vertex is on an edge that only one triangle has.
pub fn border(vertices: usize, triangles: &[[u32; 3]]) -> Vec<bool> {
    let mut edges: Vec<(u32, u32)> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
        .map(|(a, b)| (a.min(b), a.max(b)))
        .collect();
    edges.sort_unstable();
    let mut on_border = vec![false; vertices];
    for run in edges.chunk_by(|a, b| a == b) {
        if run.len() == 1 {
            on_border[run[0].0 as usize] = true;
            on_border[run[0].1 as usize] = true;
        }
    }
    on_border
}

fn single(p: DVec3) -> Vector {
    let p = p.as_vec3();
    Vector::new(p.x, p.y, p.z)
}

/// Area-weighted vertex normals, of unit length.
pub fn normals(positions: &[DVec3], triangles: &[[u32; 3]]) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; positions.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|v| positions[v as usize]);
        let normal = (b - a).cross(c - a);
        for &vertex in triangle {
            normals[vertex as usize] += normal;
        }
    }
    normals.iter().map(|n| n.normalize_or_zero()).collect()
}

/// Barycentric weights of the point of a triangle closest to `p` (Ericson, "Real-time collision
/// detection", 2005, section 5.1.5).
pub fn closest_on_triangle([a, b, c]: [DVec3; 3], p: DVec3) -> [f64; 3] {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let v = d1 / (d1 - d3);
        return [1.0 - v, v, 0.0];
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let w = d2 / (d2 - d6);
        return [1.0 - w, 0.0, w];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - w, w];
    }
    let scale = 1.0 / (va + vb + vc);
    [1.0 - (vb + vc) * scale, vb * scale, vc * scale]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;

    /// A bumpy open sheet.
    fn sheet(random: &mut Random, n: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let positions = (0..n * n)
            .map(|i| DVec3::new(f64::from(i % n), f64::from(i / n), random.uniform()) * 10.0)
            .collect();
        let triangles = (0..(n - 1) * (n - 1))
            .flat_map(|i| {
                let v = i / (n - 1) * n + i % (n - 1);
                [[v, v + 1, v + n], [v + 1, v + n + 1, v + n]]
            })
            .collect();
        (positions, triangles)
    }

    #[test]
    fn the_closest_point_is_the_closest_of_all_triangles() {
        let mut random = Random::new(2);
        let (positions, triangles) = sheet(&mut random, 12);
        let surface = Surface::new(&positions, &triangles);
        for _ in 0..500 {
            let p = DVec3::new(random.uniform(), random.uniform(), random.uniform() - 0.3) * 110.0;
            let truth = triangles
                .iter()
                .map(|t| {
                    let corners = t.map(|v| positions[v as usize]);
                    let w = closest_on_triangle(corners, p);
                    (0..3).map(|i| corners[i] * w[i]).sum::<DVec3>().distance(p)
                })
                .fold(f64::INFINITY, f64::min);
            let hit = surface.closest(p, 1e3).expect("reaches");
            // Two triangles may be equally near to single precision.
            assert!((hit.distance - truth).abs() < 1e-4 * (1.0 + truth));
            assert!(surface.closest(p, 0.99 * truth).is_none());
            let admitted = surface
                .closest_where(p, 1e3, |t| t != hit.triangle)
                .expect("another");
            assert!(admitted.triangle != hit.triangle && admitted.distance >= hit.distance - 1e-4);
        }
    }

    #[test]
    fn a_border_is_where_one_triangle_ends() {
        let mut random = Random::new(3);
        let (positions, triangles) = sheet(&mut random, 6);
        let surface = Surface::new(&positions, &triangles);
        let beyond = surface
            .closest(DVec3::new(-20.0, 25.0, 5.0), 1e3)
            .expect("hit");
        assert!(surface.on_border(&beyond));
        let above = surface
            .closest(DVec3::new(23.0, 22.0, 30.0), 1e3)
            .expect("hit");
        assert!(!surface.on_border(&above));
    }

    #[test]
    fn a_ray_meets_the_surface_first_where_it_is_nearest() {
        let mut random = Random::new(4);
        let (positions, triangles) = sheet(&mut random, 9);
        let surface = Surface::new(&positions, &triangles);
        for _ in 0..200 {
            let p = DVec3::new(random.uniform() * 79.0, random.uniform() * 79.0, 50.0);
            let hit = surface.cast(p, DVec3::NEG_Z, 100.0).expect("below");
            assert!((hit.point - p).truncate().length() < 1e-9);
            let q: DVec3 = (0..3)
                .map(|i| positions[triangles[hit.triangle as usize][i] as usize] * hit.weights[i])
                .sum();
            assert!(q.distance(hit.point) < 1e-9);
        }
    }
}
