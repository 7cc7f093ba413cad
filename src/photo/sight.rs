//! What of a face the camera sees.

use glam::{DVec2, DVec3};

use super::Camera;
use super::raster::Raster;

/// A head is so many px high where it is found out what hides what.
const DRAWN: f64 = 256.0;
/// What lies so much farther than what is seen is hidden by it, mm.
pub(super) const BEHIND: f64 = 4.0;

/// Outlines are looked for in so many directions.
const DIRECTIONS: usize = 8;
/// Where what is seen is nearer by so much from one pixel to the next, mm, something hides what lies behind it: no skin
/// rises so steeply but beside an outline.
const HIDING: f64 = 12.0;

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

    /// How far what is seen at a point is beside the outline of something that is before it, mm in the image's plane; `most` when
    /// that is farther.
    pub fn beside(&self, p: DVec3, most: f64) -> f64 {
        let at = self.own.project(p);
        let mm = self.own.to_camera(p).z / self.own.focal;
        let steps = (most / mm).floor() as usize;
        let ends = |direction: DVec2| {
            let depth = |step: usize| self.raster.depth(at + direction * step as f64);
            (1..=steps).find(|&step| depth(step - 1) - depth(step) > HIDING)
        };
        let around = (0..DIRECTIONS).map(|k| {
            let angle = std::f64::consts::TAU * k as f64 / DIRECTIONS as f64;
            DVec2::from_angle(angle)
        });
        let nearest = around.filter_map(ends).min();
        nearest.map_or(most, |step| most.min(step as f64 * mm))
    }

    /// The cosine of the angle at which a point of the mesh with a unit normal is seen; `None` when
    /// something hides it.
    pub fn facing(&self, p: DVec3, normal: DVec3) -> Option<f64> {
        let depth = self.own.to_camera(p).z;
        let hidden = depth > self.raster.depth(self.own.project(p)) + BEHIND;
        (!hidden).then(|| normal.dot((self.eye - p).normalize_or_zero()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wall, and before it a board whose edge is seen at x = 0, or a step that is no board.
    #[test]
    fn a_place_is_so_far_beside_what_hides_a_part_of_it() {
        let camera = Camera {
            rotation: glam::DMat3::IDENTITY,
            translation: DVec3::ZERO,
            focal: 500.0,
            centre: DVec2::ZERO,
        };
        let quad = |first: u32| [[0, 1, 2], [0, 2, 3]].map(|t| t.map(|k: u32| first + k));
        let sheet = |x: [f64; 2], z: f64| {
            [[0, 0], [1, 0], [1, 1], [0, 1]]
                .map(|[i, j]: [usize; 2]| DVec3::new(x[i] * z / 1000.0, [-120.0, 120.0][j], z))
        };
        for (depth, hides) in [(970.0, true), (990.0, false)] {
            let positions = [sheet([-120.0, 120.0], 1000.0), sheet([-120.0, 0.0], depth)].concat();
            let triangles = [quad(0), quad(4)].concat();
            let sight = Sight::new(&camera, &positions, &triangles).unwrap();
            for beside in [1.0, 3.0, 4.5, 20.0] {
                let found = sight.beside(DVec3::new(beside, 7.0, 1000.0), 5.0);
                let expected = if hides { beside.min(5.0) } else { 5.0 };
                // A pixel is a mm wide, and directions are an eighth of a turn apart.
                assert!((found - expected).abs() < 1.2, "{depth}, {beside}: {found}");
            }
            // The board itself is not hidden by what is behind it.
            let own = sight.beside(DVec3::new(-3.0 * depth / 1000.0, 7.0, depth), 5.0);
            assert_eq!(own, 5.0);
        }
    }
}
