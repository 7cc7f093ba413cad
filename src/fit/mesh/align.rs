//! Rigid alignment (Procrustes): what is pose and what is shape.

use glam::{DMat3, DVec3};
use nalgebra::Matrix3;

use super::mirror::even;

/// A rotation followed by a translation.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Rigid {
    /// The rotation, a proper one.
    pub rotation: DMat3,
    /// The translation, mm.
    pub translation: DVec3,
}

impl Rigid {
    /// Where a point goes.
    pub fn apply(&self, point: DVec3) -> DVec3 {
        self.rotation * point + self.translation
    }

    /// The motion back.
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        Self {
            rotation,
            translation: -(rotation * self.translation),
        }
    }

    /// The rigid motion that brings `from` closest to `to`, in the least-squares sense over the
    /// given vertices, each with its weight (Kabsch 1976; Umeyama 1991 for the reflection case).
    /// Size is part of a face, so there is no scale.
    pub fn fit(from: &[DVec3], to: &[DVec3], vertices: &[u32], weights: &[f64]) -> Self {
        let total: f64 = vertices.iter().map(|&v| weights[v as usize]).sum();
        let centre = |points: &[DVec3]| -> DVec3 {
            let sum: DVec3 = vertices
                .iter()
                .map(|&v| points[v as usize] * weights[v as usize])
                .sum();
            sum / total
        };
        let (from_centre, to_centre) = (centre(from), centre(to));
        let mut covariance = Matrix3::zeros();
        for &v in vertices {
            let a = (from[v as usize] - from_centre) * weights[v as usize];
            let b = to[v as usize] - to_centre;
            covariance +=
                nalgebra::Vector3::new(b.x, b.y, b.z) * nalgebra::RowVector3::new(a.x, a.y, a.z);
        }
        let svd = covariance.svd(true, true);
        let rotation = match (svd.u, svd.v_t) {
            (Some(mut u), Some(v_t)) => {
                if (u * v_t).determinant() < 0.0 {
                    let least = svd.singular_values.imin();
                    u.column_mut(least).neg_mut();
                }
                u * v_t
            }
            _ => Matrix3::identity(),
        };
        let rotation = DMat3::from_cols_slice(rotation.as_slice());
        Self {
            rotation,
            translation: to_centre - rotation * from_centre,
        }
    }
}

/// The affine field `A p + b` closest to the displacements `face - mean` of some vertices `p` of
/// the mean, in the weighted least-squares sense, taken out of the whole face: what is left is the
/// face on a head of average size and proportions.
pub fn without_proportions(
    face: &[DVec3],
    mean: &[DVec3],
    vertices: &[u32],
    weights: &[f64],
) -> Vec<DVec3> {
    let row = |p: DVec3| nalgebra::Vector4::new(p.x / 100.0, p.y / 100.0, p.z / 100.0, 1.0);
    let mut normal = nalgebra::Matrix4::zeros();
    let mut right = nalgebra::Matrix4x3::zeros();
    for &v in vertices {
        let v = v as usize;
        let r = row(mean[v]);
        let d = face[v] - mean[v];
        normal += r * r.transpose() * weights[v];
        right += r * nalgebra::RowVector3::new(d.x, d.y, d.z) * weights[v];
    }
    // Four vertices in a plane leave a direction free; nothing is taken out then.
    let Some(factor) = normal.cholesky() else {
        return face.to_vec();
    };
    let affine = factor.solve(&right);
    face.iter()
        .zip(mean)
        .map(|(&p, &m)| {
            let d = row(m).transpose() * affine;
            p - DVec3::new(d[0], d[1], d[2])
        })
        .collect()
}

/// The area of each vertex: a third of the triangles around it, mm^2.
pub fn vertex_areas(positions: &[DVec3], triangles: &[[u32; 3]]) -> Vec<f64> {
    let mut areas = vec![0.0; positions.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|v| positions[v as usize]);
        let third = (b - a).cross(c - a).length() / 6.0;
        triangle.iter().for_each(|&v| areas[v as usize] += third);
    }
    areas
}

/// Generalised Procrustes alignment over some vertices: every face is moved rigidly onto the mean
/// of the moved faces, until the mean stands still. Returns the mean.
///
/// The first mean is `reference`, which therefore sets the pose of the result. With a `mirror` map the mirror
/// image of each face counts as one more, and the mean is its own.
pub fn procrustes(
    faces: &mut [Vec<DVec3>],
    reference: &[DVec3],
    vertices: &[u32],
    weights: &[f64],
    mirror: Option<&[u32]>,
) -> Vec<DVec3> {
    use rayon::prelude::*;
    let mut mean = reference.to_vec();
    // Converges by a factor of some hundred a round, since people differ little in pose; the
    // bound only guards against a pathological set.
    for _ in 0..20 {
        faces.par_iter_mut().for_each(|face| {
            let motion = Rigid::fit(face, &mean, vertices, weights);
            face.iter_mut().for_each(|p| *p = motion.apply(*p));
        });
        let next = mean_of(faces);
        // The mean of rotated faces shrinks slightly and may turn; hold its pose to the reference.
        let hold = Rigid::fit(&next, reference, vertices, weights);
        let next: Vec<DVec3> = next.iter().map(|&p| hold.apply(p)).collect();
        // The image of a face is moved onto such a mean by the image of the motion.
        let next = mirror.map(|mirror| even(&next, mirror)).unwrap_or(next);
        let moved = vertices
            .iter()
            .map(|&v| next[v as usize].distance(mean[v as usize]))
            .fold(0.0, f64::max);
        mean = next;
        // A tenth of a nanometre: nothing that follows can see it.
        if moved < 1e-7 {
            break;
        }
    }
    mean
}

/// The mean of faces, vertex by vertex.
pub fn mean_of(faces: &[Vec<DVec3>]) -> Vec<DVec3> {
    let mut mean = vec![DVec3::ZERO; faces[0].len()];
    for face in faces {
        mean.iter_mut().zip(face).for_each(|(m, p)| *m += *p);
    }
    mean.iter().map(|m| *m / faces.len() as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;

    fn cloud(random: &mut Random, n: usize) -> Vec<DVec3> {
        (0..n)
            .map(|_| DVec3::new(random.normal(), random.normal(), random.normal()) * 50.0)
            .collect()
    }

    #[test]
    fn a_rigid_motion_is_found_again() {
        let mut random = Random::new(3);
        let points = cloud(&mut random, 40);
        let vertices: Vec<u32> = (0..40).collect();
        for _ in 0..50 {
            let axis = DVec3::new(random.normal(), random.normal(), random.normal()).normalize();
            let truth = Rigid {
                rotation: DMat3::from_axis_angle(axis, random.uniform() * 6.0),
                translation: DVec3::new(random.normal(), random.normal(), 9.0) * 100.0,
            };
            let moved: Vec<DVec3> = points.iter().map(|&p| truth.apply(p)).collect();
            let weights: Vec<f64> = (0..40).map(|_| 0.1 + random.uniform()).collect();
            let found = Rigid::fit(&points, &moved, &vertices, &weights);
            for &p in &points {
                // Rounding of numbers near 1000.
                assert!(found.apply(p).distance(truth.apply(p)) < 1e-9);
            }
        }
    }

    #[test]
    fn proportions_are_taken_out_and_nothing_else() {
        let mut random = Random::new(8);
        let mean = cloud(&mut random, 50);
        let vertices: Vec<u32> = (0..50).collect();
        let weights = vec![1.0; 50];
        let tall = DMat3::from_diagonal(DVec3::new(1.02, 1.1, 0.97));
        let face: Vec<DVec3> = mean
            .iter()
            .map(|&p| tall * p + DVec3::new(1.0, -2.0, 0.5))
            .collect();
        let left = without_proportions(&face, &mean, &vertices, &weights);
        for (a, b) in left.iter().zip(&mean) {
            assert!(a.distance(*b) < 1e-9);
        }
        let bump: Vec<DVec3> = (0..50)
            .map(|i| {
                mean[i]
                    + if i == 7 {
                        DVec3::new(0.0, 0.0, 3.0)
                    } else {
                        DVec3::ZERO
                    }
            })
            .collect();
        let once = without_proportions(&bump, &mean, &vertices, &weights);
        let twice = without_proportions(&once, &mean, &vertices, &weights);
        // A projection: what is left has no affine part any more.
        for (a, b) in once.iter().zip(&twice) {
            assert!(a.distance(*b) < 1e-9);
        }
        assert!(once[7].distance(mean[7]) > 2.0);
    }

    #[test]
    fn a_mirror_image_is_not_called_a_rotation() {
        let mut random = Random::new(4);
        let points = cloud(&mut random, 40);
        let vertices: Vec<u32> = (0..40).collect();
        let mirrored: Vec<DVec3> = points.iter().map(|p| DVec3::new(-p.x, p.y, p.z)).collect();
        let found = Rigid::fit(&points, &mirrored, &vertices, &[1.0; 40]);
        assert!((found.rotation.determinant() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn alignment_does_not_depend_on_the_poses_of_the_faces() {
        let mut random = Random::new(5);
        let base = cloud(&mut random, 60);
        let vertices: Vec<u32> = (0..60).collect();
        let weights = vec![1.0; 60];
        let mut faces: Vec<Vec<DVec3>> = (0..6)
            .map(|_| {
                let noise = cloud(&mut random, 60);
                base.iter().zip(noise).map(|(p, n)| *p + n * 0.03).collect()
            })
            .collect();
        let mut posed: Vec<Vec<DVec3>> = faces.clone();
        for face in &mut posed {
            let motion = Rigid {
                rotation: DMat3::from_rotation_y(random.normal()),
                translation: DVec3::splat(random.normal() * 10.0),
            };
            face.iter_mut().for_each(|p| *p = motion.apply(*p));
        }
        let one = procrustes(&mut faces, &base, &vertices, &weights, None);
        let two = procrustes(&mut posed, &base, &vertices, &weights, None);
        for (a, b) in one.iter().zip(&two) {
            // Both stop within 1e-7 mm of the fixed point.
            assert!(a.distance(*b) < 1e-6, "{}", a.distance(*b));
        }
    }
}
