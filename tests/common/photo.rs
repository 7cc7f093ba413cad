//! A photo that no camera took.

use glam::{DVec2, DVec3, Vec3};
use phiz::Face;
use phiz::anatomy::Landmark;
use phiz::photo::{Camera, Edit, HARMONICS, Light};

/// Its size, px.
pub const SIZE: [u32; 2] = [480, 400];

pub fn camera(angles: [f64; 3]) -> Camera {
    Camera {
        rotation: Camera::turned(angles),
        translation: DVec3::new(0.0, 0.0, 800.0),
        focal: 1000.0,
        centre: DVec2::new(240.0, 200.0),
    }
}

pub fn edit(face: &Face, camera: &Camera, light: Option<Light>) -> Edit {
    Edit::new(
        face.model(),
        camera,
        SIZE,
        light,
        face.positions(),
        face.normals(),
    )
    .unwrap()
}

pub fn window() -> Light {
    // Bright from the subject's left and above, a little warm.
    let channel =
        |k: f64| -> [f64; HARMONICS] { [k, 0.5 * k, 0.2 * k, 0.3 * k, 0.0, 0.0, 0.1, 0.0, 0.0] };
    Light {
        coefficients: [channel(0.7), channel(0.6), channel(0.5)],
        rms: 0.0,
    }
}

/// A landmark on some positions.
pub fn stencil(landmark: &Landmark, of: &[Vec3]) -> Vec3 {
    landmark
        .stencil
        .iter()
        .map(|&(v, w)| of[v as usize] * w as f32)
        .sum()
}
