//! What of a face the camera sees.

use glam::{DVec2, DVec3};

use super::Camera;
use super::raster::Raster;

/// A head is so many px high where it is found out what hides what.
const DRAWN: f64 = 256.0;
/// What lies so much farther than what is seen is hidden by it, mm.
pub(super) const BEHIND: f64 = 4.0;

/// Skin is asked where the cosine of the angle at which it is seen is above this.
const FACING: f64 = 0.3;

/// A mesh as a camera sees it.
#[derive(Debug, Clone)]
pub(super) struct Sight {
    eye: DVec3,
    own: Camera,
    raster: Raster,
    /// The corners of the part of the image that the mesh is in, px.
    pub corners: [DVec2; 2],
}

impl Sight {
    /// Of a mesh, mm; `None` when it is not before the camera.
    pub fn new(camera: &Camera, positions: &[DVec3], triangles: &[[u32; 3]]) -> Option<Self> {
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for &p in positions {
            let q = camera.project(p);
            (low, high) = (low.min(q), high.max(q));
        }
        let extent = (high - low).max_element();
        if !(extent > 0.0 && extent.is_finite()) {
            return None;
        }
        // The head fills an image of its own.
        let scale = DRAWN / extent;
        let own = Camera {
            focal: camera.focal * scale,
            centre: (camera.centre - low) * scale,
            ..*camera
        };
        let size = ((high - low) * scale).ceil().as_usizevec2();
        Some(Self {
            eye: camera.position(),
            raster: Raster::new(&own, [size.x.max(1), size.y.max(1)], positions, triangles),
            own,
            corners: [low, high],
        })
    }

    /// Whether a point of the mesh with a unit normal is seen, and not from too far aside.
    pub fn sees(&self, p: DVec3, normal: DVec3) -> bool {
        self.facing(p, normal)
            .is_some_and(|cosine| cosine >= FACING)
    }

    /// The cosine of the angle at which a point of the mesh with a unit normal is seen; `None` when
    /// something hides it.
    pub fn facing(&self, p: DVec3, normal: DVec3) -> Option<f64> {
        let depth = self.own.to_camera(p).z;
        let hidden = depth > self.raster.depth(self.own.project(p)) + BEHIND;
        (!hidden).then(|| normal.dot((self.eye - p).normalize_or_zero()))
    }
}
