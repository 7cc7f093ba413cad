//! What of a mesh is seen: a z-buffer.

use glam::{DVec2, DVec3};

use super::Camera;

/// No triangle is seen at a pixel.
pub const NOTHING: u32 = u32::MAX;

/// The nearest triangle at the middle of each pixel.
#[derive(Debug, Clone)]
pub struct Raster {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The triangle of each pixel, row by row; [`NOTHING`] where there is none.
    pub triangles: Vec<u32>,
    /// Its distance from the camera's plane there, mm; infinite where there is none.
    pub depths: Vec<f32>,
}

impl Raster {
    /// Of vertices in the head's frame (mm). Triangles that reach behind the camera are left out;
    /// both sides of the others are seen.
    pub fn new(
        camera: &Camera,
        [width, height]: [usize; 2],
        positions: &[DVec3],
        triangles: &[[u32; 3]],
    ) -> Self {
        // One over the depth is linear in the image.
        let seen: Vec<DVec3> = positions
            .iter()
            .map(|&p| {
                let q = camera.to_camera(p);
                (camera.centre + q.truncate() * (camera.focal / q.z)).extend(1.0 / q.z)
            })
            .collect();
        let corners = triangles.iter().map(|t| t.map(|v| seen[v as usize]));
        Self::of([width, height], corners)
    }

    /// Of triangles whose corners are in the image (px) and have the third number as one over their
    /// depths; what has none above 0 is left out.
    pub fn of(
        [width, height]: [usize; 2],
        triangles: impl IntoIterator<Item = [DVec3; 3]>,
    ) -> Self {
        let mut raster = Self {
            width,
            height,
            triangles: vec![NOTHING; width * height],
            depths: vec![f32::INFINITY; width * height],
        };
        for (corners, t) in triangles.into_iter().zip(0..) {
            raster.draw(t, corners);
        }
        raster
    }

    fn draw(&mut self, triangle: u32, corners: [DVec3; 3]) {
        if !corners.iter().all(|c| c.z > 0.0) {
            return;
        }
        let [a, b, c] = corners.map(|c| c.truncate());
        let double_area = (b - a).perp_dot(c - a);
        if double_area == 0.0 {
            return;
        }
        let low = a.min(b).min(c);
        let high = a.max(b).max(c);
        // Pixels whose middles may be inside.
        let first = |x: f64| (x - 0.5).ceil().max(0.0) as usize;
        let end = |x: f64, most: usize| ((x - 0.5).floor() + 1.0).clamp(0.0, most as f64) as usize;
        for y in first(low.y)..end(high.y, self.height) {
            for x in first(low.x)..end(high.x, self.width) {
                let p = DVec2::new(x as f64, y as f64) + 0.5;
                let [u, v, w] = barycentric(p, [a, b, c]);
                if u < 0.0 || v < 0.0 || w < 0.0 {
                    continue;
                }
                let inverse = u * corners[0].z + v * corners[1].z + w * corners[2].z;
                let depth = (1.0 / inverse) as f32;
                let at = y * self.width + x;
                if depth < self.depths[at] {
                    self.depths[at] = depth;
                    self.triangles[at] = triangle;
                }
            }
        }
    }

    /// The depth at the pixel that a point of the image (px) is in, mm; infinite where nothing is,
    /// and outside.
    pub fn depth(&self, p: DVec2) -> f64 {
        let inside = p.x >= 0.0 && p.y >= 0.0;
        let (x, y) = (p.x as usize, p.y as usize);
        match inside && x < self.width && y < self.height {
            true => f64::from(self.depths[y * self.width + x]),
            false => f64::INFINITY,
        }
    }
}

/// The shares of a triangle's corners in a point of its plane.
pub fn barycentric(p: DVec2, [a, b, c]: [DVec2; 3]) -> [f64; 3] {
    let double_area = (b - a).perp_dot(c - a);
    let u = (c - b).perp_dot(p - b) / double_area;
    let v = (a - c).perp_dot(p - c) / double_area;
    [u, v, 1.0 - u - v]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_of_two_triangles_is_seen_and_depths_are_exact() {
        let camera = Camera {
            rotation: Camera::turned([0.0; 3]),
            translation: DVec3::new(0.0, 0.0, 500.0),
            focal: 500.0,
            centre: DVec2::new(50.0, 50.0),
        };
        // A plane that leans, and half of it covered by one that does not.
        let plane = |x: f64, y: f64| DVec3::new(x, y, 0.2 * x);
        let positions = [
            plane(-200.0, -200.0),
            plane(200.0, -200.0),
            plane(0.0, 300.0),
            DVec3::new(0.0, -500.0, 100.0),
            DVec3::new(500.0, -500.0, 100.0),
            DVec3::new(0.0, 500.0, 100.0),
        ];
        let raster = Raster::new(&camera, [100, 100], &positions, &[[0, 1, 2], [3, 4, 5]]);
        assert_eq!(raster.triangles[50 * 100 + 20], 0);
        assert_eq!(raster.triangles[50 * 100 + 60], 1);
        assert!((raster.depth(DVec2::new(60.2, 50.7)) - 400.0).abs() < 1e-3);
        // At column 20.5 the ray is x = -0.059 z, and the plane z = 500 - 0.2 x.
        let slope = (20.5 - 50.0) / 500.0;
        let depth = 500.0 / (1.0 + 0.2 * slope);
        assert!((raster.depth(DVec2::new(20.5, 50.5)) - depth).abs() < 1e-3);
        assert_eq!(raster.depth(DVec2::new(-0.5, 3.0)), f64::INFINITY);
        // The second covers the right half of the picture alone.
        let half = Raster::new(&camera, [100, 100], &positions, &[[3, 4, 5]]);
        assert_eq!(half.depth(DVec2::new(2.0, 50.0)), f64::INFINITY);
        assert_eq!(half.triangles[50 * 100 + 2], NOTHING);
    }
}
