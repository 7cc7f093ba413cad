//! Eyeballs that turn, and lids that slide on them.

use glam::{DMat3, DVec3, Quat, Vec3};

use crate::model::FaceModel;

/// Vertices of the skin that are nearer than this to an eyeball, mm, are kept outside of it: as far
/// as a lid moves.
const NEAR: f32 = 15.0;
/// Skin that moves stays this far outside of an eyeball, mm, or as near as it was.
const CLEAR: f32 = 0.25;

/// An eyeball and the lids around it.
#[derive(Debug)]
pub struct Eye {
    /// 0 the subject's left, 1 the right.
    side: usize,
    ball: Vec<u32>,
    lids: Vec<u32>,
}

struct Sphere {
    centre: Vec3,
    radius: f32,
}

impl Eye {
    /// The eyes of a model that has them; `moved` are the vertices that expressions move, increasing.
    pub fn both(model: &FaceModel, moved: &[u32]) -> Vec<Self> {
        let mean = &model.parts().mean;
        let skin = model.parts().topology.part_vertices("skin");
        let eye = |(side, part)| {
            let ball = model.parts().topology.part_vertices(part);
            let sphere = sphere(mean, &ball)?;
            let near = |v: &u32| {
                let p = mean[*v as usize];
                moved.binary_search(v).is_ok() && p.distance(sphere.centre) < sphere.radius + NEAR
            };
            let lids = skin.iter().copied().filter(near).collect();
            Some(Self { side, ball, lids })
        };
        [(0, "left eyeball"), (1, "right eyeball")]
            .into_iter()
            .filter_map(eye)
            .collect()
    }

    /// 0 the subject's left, 1 the right.
    #[cfg(feature = "photo")]
    pub fn side(&self) -> usize {
        self.side
    }

    /// The middle and the radius of the ball on a face, mm.
    #[cfg(feature = "photo")]
    pub fn ball(&self, neutral: &[Vec3]) -> Option<(Vec3, f32)> {
        sphere(neutral, &self.ball).map(|sphere| (sphere.centre, sphere.radius))
    }

    /// Turns the ball by the sum of turns, and moves lids out of it. `neutral` is the face
    /// without expression.
    #[inline(never)]
    pub fn settle(&self, neutral: &[Vec3], turns: [Vec3; 2], positions: &mut [Vec3]) {
        let Some(sphere) = sphere(neutral, &self.ball) else {
            return;
        };
        let turn = turns[self.side];
        if turn != Vec3::ZERO {
            let turn = rotation(turn);
            for &v in &self.ball {
                let v = v as usize;
                positions[v] = sphere.centre + turn * (neutral[v] - sphere.centre);
            }
        }
        for &v in &self.lids {
            let v = v as usize;
            let least = (sphere.radius + CLEAR).min(neutral[v].distance(sphere.centre));
            let out = positions[v] - sphere.centre;
            let distance = out.length();
            if distance < least && distance > 1e-3 {
                positions[v] = sphere.centre + out * (least / distance);
            }
        }
    }
}

/// The rotation about an axis by an angle (radians, at most two turns), which is the vector's length.
/// It is a thirty-second of it, five times doubled: the sine and cosine of the library, which also
/// know angles of a million turns, are larger than all that is here.
fn rotation(turn: Vec3) -> Quat {
    let half = turn / 64.0;
    // The tangent of half a thirty-second.
    let tangent = half * (1.0 + half.length_squared() / 3.0);
    let mut rotation = Quat::from_xyzw(tangent.x, tangent.y, tangent.z, 1.0).normalize();
    for _ in 0..5 {
        rotation = (rotation * rotation).normalize();
    }
    rotation
}

/// The sphere through some vertices by linear least squares: about their middle,
/// |p|^2 = 2 p c + constant.
fn sphere(positions: &[Vec3], vertices: &[u32]) -> Option<Sphere> {
    let points = || vertices.iter().map(|&v| positions[v as usize].as_dvec3());
    let count = vertices.len().max(1) as f64;
    let middle = points().sum::<DVec3>() / count;
    let squares = points().map(|p| p.distance_squared(middle)).sum::<f64>() / count;
    let (mut square, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for p in points().map(|p| p - middle) {
        square += DMat3::from_cols(p * p.x, p * p.y, p * p.z);
        right += p * (p.length_squared() - squares);
    }
    // Points in a plane are of no sphere.
    if square.determinant() < 1e-9 * squares.powi(3) * count.powi(3) {
        return None;
    }
    let centre = square.inverse() * right / 2.0;
    let radius = (squares + centre.length_squared()).sqrt();
    (radius.is_finite() && radius > 0.0).then(|| Sphere {
        centre: (middle + centre).as_vec3(),
        radius: radius as f32,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rotation_is_that_of_the_library() {
        for turn in [
            Vec3::ZERO,
            Vec3::new(0.3, -0.2, 0.1),
            Vec3::new(-1.0, 2.0, 2.0),
        ] {
            let (own, theirs) = (rotation(turn), Quat::from_scaled_axis(turn));
            // The next term of the tangent is 2/15 x^5 with x = 3 / 64: 3e-8; doubled five times.
            assert!(own.dot(theirs).abs() > 1.0 - 1e-6, "{turn}");
            let v = Vec3::new(0.1, 0.7, -0.7);
            assert!((own * v).distance(theirs * v) < 5e-6, "{turn}");
        }
    }

    #[test]
    fn a_part_of_a_sphere_tells_all_of_it() {
        let centre = Vec3::new(31.0, 2.0, 8.0);
        let points: Vec<Vec3> = (0..60)
            .map(|i| {
                let (a, b) = (i as f32 * 0.37, 0.2 + 0.015 * i as f32);
                centre + 12.0 * Vec3::new(a.cos() * b.sin(), a.sin() * b.sin(), b.cos())
            })
            .collect();
        let all: Vec<u32> = (0..60).collect();
        let sphere = sphere(&points, &all).unwrap();
        // The points are f32 at 30 mm: 2e-6 mm, times the lever of a cap of a radian.
        assert!(sphere.centre.distance(centre) < 1e-3);
        assert!((sphere.radius - 12.0).abs() < 1e-3);
        assert!(super::sphere(&points, &all[..3]).is_none());
        assert!(super::sphere(&[Vec3::ZERO; 60], &all).is_none());
    }
}
