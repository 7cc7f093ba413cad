//! Eyeballs that turn, and lids that slide on them.

use glam::{Quat, Vec3};
use nalgebra::{Matrix4, Vector4};

use super::Expression;
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
    /// The eyes of a model that has them.
    pub fn both(model: &FaceModel, expressions: &[Expression]) -> Vec<Self> {
        let mean = &model.parts().mean;
        let mut moved = vec![false; mean.len()];
        for expression in expressions {
            for &v in &expression.support {
                moved[v as usize] = true;
            }
        }
        let skin = model.parts().topology.part_vertices("skin");
        let eye = |(side, part)| {
            let ball = model.parts().topology.part_vertices(part);
            let sphere = sphere(mean, &ball)?;
            let near = |v: &u32| {
                let p = mean[*v as usize];
                moved[*v as usize] && p.distance(sphere.centre) < sphere.radius + NEAR
            };
            let lids = skin.iter().copied().filter(near).collect();
            Some(Self { side, ball, lids })
        };
        [(0, "left eyeball"), (1, "right eyeball")]
            .into_iter()
            .filter_map(eye)
            .collect()
    }

    /// Turns the ball by the sum of turns, and moves lids out of it. `neutral` is the face
    /// without expression.
    pub fn settle(&self, neutral: &[Vec3], turns: [Vec3; 2], positions: &mut [Vec3]) {
        let Some(sphere) = sphere(neutral, &self.ball) else {
            return;
        };
        let turn = turns[self.side];
        if turn != Vec3::ZERO {
            let turn = Quat::from_scaled_axis(turn);
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

/// The sphere through some vertices by linear least squares: |p|^2 = 2 p c + (r^2 - |c|^2).
fn sphere(positions: &[Vec3], vertices: &[u32]) -> Option<Sphere> {
    if vertices.len() < 4 {
        return None;
    }
    let origin = positions[vertices[0] as usize].as_dvec3();
    let mut square = Matrix4::zeros();
    let mut right = Vector4::zeros();
    for &v in vertices {
        let p = positions[v as usize].as_dvec3() - origin;
        let row = Vector4::new(2.0 * p.x, 2.0 * p.y, 2.0 * p.z, 1.0);
        square += row * row.transpose();
        right += row * p.length_squared();
    }
    let x = square.cholesky()?.solve(&right);
    let centre = glam::DVec3::new(x[0], x[1], x[2]);
    let radius = (x[3] + centre.length_squared()).max(0.0).sqrt();
    (radius.is_finite() && radius > 0.0).then(|| Sphere {
        centre: (origin + centre).as_vec3(),
        radius: radius as f32,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

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
