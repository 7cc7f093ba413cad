//! The statistical face, at the points that the fit goes by and at the landmarks.

use glam::DVec3;
use nalgebra::{DMatrix, DVector};

use crate::fit::head::template::Template;
use crate::fit::mesh::surface::Surface;
use crate::fit::{FitError, FitResult};

/// P points of the statistical face with K modes.
#[derive(Debug, Clone, Default)]
pub struct Shape {
    /// The mean face, mm.
    pub mean: Vec<DVec3>,
    /// Unit normals of the mean face.
    pub normals: Vec<DVec3>,
    /// Displacements at one standard deviation, mm: K a point, point by point.
    pub modes: Vec<DVec3>,
    /// K.
    pub count: usize,
    /// The modes that are strengths of expressions: no face shows less than none of one.
    pub shown: Vec<usize>,
}

impl Shape {
    /// Points of a template, each a weighted sum of vertices, with modes at its vertices (mm at one
    /// standard deviation).
    pub fn new(
        template: &Template,
        modes: &[Vec<DVec3>],
        normals: &[DVec3],
        points: &[&[(u32, f64)]],
    ) -> Self {
        let at = |field: &[DVec3], point: &[(u32, f64)]| -> DVec3 {
            point.iter().map(|&(v, w)| field[v as usize] * w).sum()
        };
        let across = points.iter().map(|p| modes.iter().map(|m| at(m, p)));
        Self {
            mean: points.iter().map(|p| at(&template.positions, p)).collect(),
            normals: points
                .iter()
                .map(|p| at(normals, p).normalize_or(DVec3::Z))
                .collect(),
            modes: across.flatten().collect(),
            count: modes.len(),
            shown: Vec::new(),
        }
    }

    /// A point of the face with these coefficients (K or fewer; the others are 0).
    pub fn point(&self, index: usize, coefficients: &[f64]) -> DVec3 {
        let moved: DVec3 = self
            .modes_of(index)
            .iter()
            .zip(coefficients)
            .map(|(mode, &c)| *mode * c)
            .sum();
        self.mean[index] + moved
    }

    /// A point's K displacements, mm.
    pub fn modes_of(&self, index: usize) -> &[DVec3] {
        &self.modes[index * self.count..(index + 1) * self.count]
    }

    /// Adds what the modes cannot do: smooth displacements of `sigma` mm an axis that are alike
    /// within about `length` mm, as modes of the Gaussian process with that covariance, conditioned
    /// on `centres` (Luethi et al. 2018, "Gaussian process morphable models").
    pub fn loosen(&mut self, centres: &[DVec3], sigma: f64, length: f64) {
        let n = centres.len();
        let covariance =
            |a: DVec3, b: DVec3| (-0.5 * a.distance_squared(b) / (length * length)).exp();
        // A millionth on the diagonal is below what anything here can tell, and keeps it regular.
        let among = DMatrix::from_fn(n, n, |i, j| {
            covariance(centres[i], centres[j]) + if i == j { 1e-6 } else { 0.0 }
        });
        let Some(factor) = among.cholesky() else {
            return;
        };
        let mut modes = Vec::with_capacity(self.mean.len() * (self.count + 3 * n));
        for (i, &p) in self.mean.iter().enumerate() {
            modes.extend_from_slice(self.modes_of(i));
            let mut field = DVector::from_fn(n, |c, _| covariance(p, centres[c]));
            factor.l_dirty().solve_lower_triangular_mut(&mut field);
            for value in field.iter() {
                modes.extend(DVec3::AXES.map(|axis| axis * (sigma * value)));
            }
        }
        self.modes = modes;
        self.count += 3 * n;
    }
}

/// Landmarks that hair hides, or that lie where scans of a face end.
const FAR: [&str; 6] = [
    "vertex",
    "trichion",
    "tragion right",
    "tragion left",
    "gonion right",
    "gonion left",
];

/// How far from its landmarks the face goes on, mm.
const FACE_REACH: f64 = 26.0;

/// Up to `count` vertices of the visible face, evenly spread, and the first n of them so for any n:
/// from the one at `first` on always the one that is farthest from all before.
///
/// The visible face is the skin around the landmarks of the face that is seen from in front or from a
/// side: no cavity, no inside of a nostril.
///
/// # Errors
/// When the template has hardly any of it.
pub fn visible_face(
    template: &Template,
    surface: &Surface<'_>,
    first: DVec3,
    count: usize,
) -> FitResult<Vec<u32>> {
    let landmarks: Vec<DVec3> = (0..template.landmarks.len())
        .filter(|&i| !FAR.contains(&template.landmarks[i].name.as_str()))
        .map(|i| template.landmark(i, &template.positions))
        .collect();
    let views = [0.0_f64, 60.0, -60.0].map(|yaw| {
        let (sin, cos) = yaw.to_radians().sin_cos();
        DVec3::new(sin, 0.0, cos)
    });
    let seen = |v: u32| {
        let (p, normal) = (template.positions[v as usize], surface.normals[v as usize]);
        let near = landmarks.iter().any(|l| l.distance(p) < FACE_REACH);
        near && views.iter().any(|&view| {
            // From a little above the skin, past all of the head.
            let from = p + (normal + view) * 0.2;
            normal.dot(view) > 0.2 && surface.cast(from, view, 500.0).is_none()
        })
    };
    let mut face = template.part_vertices("skin")?;
    face.retain(|&v| seen(v));
    if face.len() < 500 {
        let cause = format!("only {} vertices of the template are a face", face.len());
        return Err(FitError::Input(cause));
    }
    let at = |i: usize| template.positions[face[i] as usize];
    let farthest = |distances: &[f64]| {
        (0..distances.len())
            .max_by(|&a, &b| distances[a].total_cmp(&distances[b]))
            .unwrap_or(0)
    };
    let nearness: Vec<f64> = (0..face.len()).map(|i| -at(i).distance(first)).collect();
    let mut next = farthest(&nearness);
    let mut distances = vec![f64::INFINITY; face.len()];
    let mut chosen = Vec::new();
    while chosen.len() < count.min(face.len()) {
        chosen.push(face[next]);
        for (i, distance) in distances.iter_mut().enumerate() {
            *distance = distance.min(at(i).distance_squared(at(next)));
        }
        next = farthest(&distances);
    }
    Ok(chosen)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;
    use crate::fit::test_head;

    #[test]
    fn loosened_points_vary_alike_as_far_as_the_length_says() {
        let mut random = Random::new(1);
        let mut point = || DVec3::new(random.normal(), random.normal(), random.normal()) * 30.0;
        let centres: Vec<DVec3> = (0..20).map(|_| point()).collect();
        // At the centres the process is what it says, elsewhere it varies less.
        let mut mean = centres.clone();
        mean.extend((0..50).map(|_| point()));
        let mut shape = Shape {
            normals: vec![DVec3::Z; mean.len()],
            modes: vec![DVec3::X; mean.len()],
            mean,
            count: 1,
            shown: Vec::new(),
        };
        shape.loosen(&centres, 3.0, 25.0);
        assert_eq!(shape.count, 61);
        let along = |i: usize, j: usize, axis: usize| -> f64 {
            let (a, b) = (&shape.modes_of(i)[1..], &shape.modes_of(j)[1..]);
            a.iter().zip(b).map(|(a, b)| a[axis] * b[axis]).sum()
        };
        for i in 0..70 {
            assert_eq!(shape.modes_of(i)[0], DVec3::X);
            for axis in 0..3 {
                assert!(along(i, i, axis) < 9.0 + 1e-9);
            }
            for j in 0..20 {
                let apart = shape.mean[i].distance_squared(shape.mean[j]);
                let truth = 9.0 * (-0.5 * apart / 625.0).exp();
                // The millionth on the diagonal, times 9 mm^2 and the condition it leaves.
                assert!((along(i, j, 1) - truth).abs() < 1e-3, "{i} {j}");
            }
        }
    }

    #[test]
    fn the_visible_face_is_outside_and_evenly_spread() {
        let Some(head) = test_head() else { return };
        let triangles = head.triangles();
        let surface = Surface::new(&head.positions, &triangles);
        let tip = DVec3::new(0.0, -40.0, 60.0);
        let face = visible_face(head, &surface, tip, 400).expect("a face");
        let cavity = head.part_vertices("mouth cavity").expect("a mouth");
        assert!(face.iter().all(|v| cavity.binary_search(v).is_err()));
        // The face is about 250 cm^2: discs around 400 points of it, none of which has another's
        // middle in it, have radii of 4 mm and more.
        let at = |v: u32| head.positions[v as usize];
        for (i, &v) in face.iter().enumerate() {
            for &w in &face[..i] {
                assert!(at(v).distance(at(w)) > 4.0);
            }
        }
        // And the first ones are those of a smaller number.
        assert_eq!(
            visible_face(head, &surface, tip, 50).expect("a face"),
            face[..50]
        );
    }
}
