//! A first pose.

use glam::{DMat3, DVec2, DVec3};
use nalgebra::{Matrix2x3, Matrix3};

/// Points are on a line when their spread across it is less than this part of that along it. A face
/// seen 80 degrees from the side is still a fifth as wide as high.
const FLAT: f64 = 0.05;

/// The scaled orthographic pose that brings points of a head (mm) closest to points of an image
/// (px), in the least-squares sense: the first step of POSIT (DeMenthon & Davis 1995). The rotation
/// is that to the camera's frame, the scale in px a mm. `None` when either lie on a line or in a
/// point.
pub(super) fn orthographic(head: &[DVec3], image: &[DVec2]) -> Option<(DMat3, f64)> {
    let count = head.len().min(image.len()) as f64;
    let (middle, centre) = (
        head.iter().sum::<DVec3>() / count,
        image.iter().sum::<DVec2>() / count,
    );
    let mut spread = nalgebra::Matrix2::zeros();
    let mut square = Matrix3::zeros();
    let mut across = Matrix2x3::zeros();
    for (&p, &q) in head.iter().zip(image) {
        let (p, q) = (p - middle, q - centre);
        let p = nalgebra::Vector3::new(p.x, p.y, p.z);
        let q = nalgebra::Vector2::new(q.x, q.y);
        spread += q * q.transpose();
        square += p * p.transpose();
        across += q * p.transpose();
    }
    let widths = spread.symmetric_eigenvalues().map(|v| v.max(0.0).sqrt());
    if !(widths.min() > FLAT * widths.max()) {
        return None;
    }
    let affine = across * square.try_inverse()?;
    let svd = affine.svd(true, true);
    let (u, v_t) = (svd.u?, svd.v_t?);
    let scale = svd.singular_values.sum() / 2.0;
    let rows = u * v_t;
    let row = |i: usize| DVec3::new(rows[(i, 0)], rows[(i, 1)], rows[(i, 2)]);
    let (right, down) = (row(0), row(1));
    let rotation = DMat3::from_cols(right, down, right.cross(down)).transpose();
    (scale > 0.0 && scale.is_finite()).then_some((rotation, scale))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photo::Camera;

    #[test]
    fn a_far_camera_is_found_and_lines_are_refused() {
        let head: Vec<DVec3> = (0..20)
            .map(|i| {
                let t = f64::from(i);
                DVec3::new(
                    50.0 * t.sin(),
                    60.0 * (1.3 * t).cos(),
                    20.0 * (0.7 * t).sin(),
                )
            })
            .collect();
        let rotation = Camera::turned([0.6, 0.2, -0.3]);
        let image = |p: &DVec3| (rotation * *p).truncate() * 2.5 + DVec2::new(300.0, 200.0);
        let seen: Vec<DVec2> = head.iter().map(image).collect();
        let (found, scale) = orthographic(&head, &seen).expect("is a face");
        assert!((scale - 2.5).abs() < 1e-9);
        assert!(
            (found - rotation)
                .to_cols_array()
                .iter()
                .all(|x| x.abs() < 1e-9)
        );
        let line: Vec<DVec2> = seen.iter().map(|q| DVec2::new(q.x, 2.0 * q.x)).collect();
        assert!(orthographic(&head, &line).is_none());
        assert!(orthographic(&head, &[DVec2::ONE; 20]).is_none());
    }
}
