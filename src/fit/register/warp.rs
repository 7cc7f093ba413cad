//! The global warp: what landmarks do, carried smoothly to everything between them (region
//! morphing, section 4.1).

use glam::{DMat3, DVec3};
use nalgebra::{DMatrix, Matrix3};
use rayon::prelude::*;

use crate::fit::{FitError, FitResult};

/// A radial basis function of the distance r, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kernel {
    /// sqrt(r^2 + radius^2), the paper's choice. The radius rounds the cone of
    /// [`Kernel::Biharmonic`] off; one well above the landmarks' spacing oscillates.
    MultiQuadric {
        /// mm; without one the mean distance of a landmark from its nearest neighbour.
        radius: Option<f64>,
    },
    /// r^2 log r.
    ThinPlate,
    /// exp(-r^2 / radius^2): each landmark acts near by, and far away only the affine part is left.
    Gaussian {
        /// mm; without one twice the mean distance of a landmark from its nearest neighbour.
        radius: Option<f64>,
    },
    /// r: in space the one of least bending (Carr et al. 2001).
    Biharmonic,
}

impl Default for Kernel {
    fn default() -> Self {
        Kernel::MultiQuadric { radius: None }
    }
}

impl Kernel {
    /// The kernel with its radius set, from the nearest-neighbour `spacing` where none was asked.
    fn with_radius(self, spacing: f64) -> FitResult<Self> {
        let (kernel, radius) = match self {
            Kernel::MultiQuadric { radius } => {
                let radius = radius.unwrap_or(spacing);
                let kernel = Kernel::MultiQuadric {
                    radius: Some(radius),
                };
                (kernel, radius)
            }
            Kernel::Gaussian { radius } => {
                let radius = radius.unwrap_or(2.0 * spacing);
                let kernel = Kernel::Gaussian {
                    radius: Some(radius),
                };
                (kernel, radius)
            }
            Kernel::ThinPlate | Kernel::Biharmonic => return Ok(self),
        };
        if !(radius > 0.0 && radius.is_finite()) {
            return Err(FitError::Input(format!(
                "a kernel's radius is a length over 0 mm, not {radius}"
            )));
        }
        Ok(kernel)
    }

    /// The function's value, with the sign that makes it conditionally *positive* definite: with
    /// it smoothing always adds to the diagonal, and the weights absorb it.
    fn value(self, squared: f64) -> f64 {
        match self {
            Kernel::MultiQuadric { radius } => {
                let radius = radius.unwrap_or(0.0);
                -(squared + radius * radius).sqrt()
            }
            // r^2 log r = r^2 log(r^2) / 2, and 0 at 0.
            Kernel::ThinPlate if squared > 0.0 => 0.5 * squared * squared.ln(),
            Kernel::ThinPlate => 0.0,
            Kernel::Gaussian { radius } => {
                let radius = radius.unwrap_or(1.0);
                (-squared / (radius * radius)).exp()
            }
            Kernel::Biharmonic => -squared.sqrt(),
        }
    }
}

/// A smooth map of space that takes landmarks to landmarks: a weighted sum of radial functions
/// about the source landmarks, and an affine map (eq. 2).
#[derive(Debug, Clone, PartialEq)]
pub struct Warp {
    kernel: Kernel,
    /// Source landmarks, mm.
    centres: Vec<DVec3>,
    /// One a landmark; with eq. 3 they sum to zero and have no moment.
    weights: Vec<DVec3>,
    /// The affine part about `origin`.
    linear: DMat3,
    origin: DVec3,
    translation: DVec3,
}

impl Warp {
    /// The warp that takes each point of `from` to its counterpart in `to`, both in mm, 4 or more
    /// of them and not in one plane.
    ///
    /// With `smoothing` 0 it does so exactly (better than 1e-6 mm). A larger one is added to the
    /// kernel's diagonal in units of the kernel's mean eigenvalue over what no affine map does, so
    /// it has no unit and means the same for any number of points, size and pose: at 0.01 landmarks are
    /// still held closely, from about 1 the warp follows their common motion rather than each of
    /// them, and towards infinity it becomes the least-squares affine map.
    ///
    /// The system of eqs. 2 and 3 is solved by LU with pivoting. A map that is affine on the
    /// landmarks comes out affine everywhere.
    ///
    /// # Errors
    /// When the two differ in number, with fewer than 4 points, with a number that is none, when
    /// two of `from` lie on one spot or all of them in a plane, when smoothing is negative, and
    /// when the kernel is so wide that the system cannot be solved in double precision.
    pub fn fit(from: &[DVec3], to: &[DVec3], kernel: Kernel, smoothing: f64) -> FitResult<Self> {
        let n = from.len();
        check(from, to, smoothing)?;
        let origin = from.iter().sum::<DVec3>() / n as f64;
        let target = to.iter().sum::<DVec3>() / n as f64;
        let size = spread(from, origin)?;
        let kernel = kernel.with_radius(spacing(from)?)?;

        // Affine columns of the size of one, so that pivots compare like with like.
        let affine = DMatrix::from_fn(n, 4, |i, c| match c {
            0 => 1.0,
            _ => (from[i][c - 1] - origin[c - 1]) / size,
        });
        let mut kernels =
            DMatrix::from_fn(n, n, |i, j| kernel.value(from[i].distance_squared(from[j])));
        if smoothing > 0.0 && n > 4 {
            let q = affine.clone().qr().q();
            let explained = (q.transpose() * &kernels * &q).trace();
            let mean = (kernels.trace() - explained) / (n - 4) as f64;
            (0..n).for_each(|i| kernels[(i, i)] += smoothing * mean);
        }
        let scale = kernels.amax();
        let mut system = DMatrix::zeros(n + 4, n + 4);
        system
            .view_mut((0, 0), (n, n))
            .copy_from(&(&kernels / scale));
        system.view_mut((0, n), (n, 4)).copy_from(&affine);
        system
            .view_mut((n, 0), (4, n))
            .copy_from(&affine.transpose());
        let right = DMatrix::from_fn(n + 4, 3, |i, axis| {
            to.get(i).map_or(0.0, |t| t[axis] - target[axis])
        });
        let lu = system.clone().lu();
        let solved = lu.solve(&right).map(|mut x| {
            // One step of refinement wins back the digits that a wide kernel costs.
            if let Some(correction) = lu.solve(&(&right - &system * &x)) {
                x += correction;
            }
            x
        });
        let unsolved = |x: &DMatrix<f64>| !((&right - &system * x).amax() <= 1e-7);
        let solution = match solved {
            Some(x) if !unsolved(&x) => x,
            _ => {
                return Err(FitError::Input(
                    "the warp's equations are singular; a smaller radius of the kernel or some \
                     smoothing helps"
                        .into(),
                ));
            }
        };
        let row = |i: usize| DVec3::new(solution[(i, 0)], solution[(i, 1)], solution[(i, 2)]);
        Ok(Self {
            kernel,
            centres: from.to_vec(),
            weights: (0..n).map(|i| row(i) / scale).collect(),
            linear: DMat3::from_cols(row(n + 1) / size, row(n + 2) / size, row(n + 3) / size),
            origin,
            translation: target + row(n),
        })
    }

    /// The kernel, with the radius that was used, mm.
    pub fn kernel(&self) -> Kernel {
        self.kernel
    }

    /// Where a point goes, mm.
    pub fn apply(&self, p: DVec3) -> DVec3 {
        let bending: DVec3 = self
            .centres
            .iter()
            .zip(&self.weights)
            .map(|(centre, weight)| *weight * self.kernel.value(p.distance_squared(*centre)))
            .sum();
        self.linear * (p - self.origin) + self.translation + bending
    }

    /// Where points go, mm.
    pub fn apply_all(&self, points: &[DVec3]) -> Vec<DVec3> {
        points.par_iter().map(|&p| self.apply(p)).collect()
    }
}

fn check(from: &[DVec3], to: &[DVec3], smoothing: f64) -> FitResult<()> {
    let n = from.len();
    let cause = if n != to.len() {
        format!("{n} landmarks cannot go to {}", to.len())
    } else if n < 4 {
        format!("{n} landmarks are too few for a warp; 4 is the least")
    } else if let Some(i) = (0..n).find(|&i| !(from[i].is_finite() && to[i].is_finite())) {
        format!("landmark {} of {n} is no point: a number is missing", i + 1)
    } else if !(smoothing >= 0.0 && smoothing.is_finite()) {
        format!("smoothing must be 0 or more, not {smoothing}")
    } else {
        return Ok(());
    };
    Err(FitError::Input(cause))
}

/// The root mean square distance of points from their centre, mm.
fn spread(points: &[DVec3], centre: DVec3) -> FitResult<f64> {
    let n = points.len() as f64;
    let mut covariance = Matrix3::zeros();
    for &p in points {
        let d = nalgebra::Vector3::from((p - centre).to_array());
        covariance += d * d.transpose() / n;
    }
    let size = covariance.trace().sqrt();
    let least = covariance.symmetric_eigenvalues().min().max(0.0).sqrt();
    // Squared in the covariance, a ratio below 1e-8 is rounding; a thousand times that is still
    // 0.01 micrometres on a face.
    if !(least > 1e-6 * size) {
        return Err(FitError::Input(format!(
            "the {} landmarks lie in a plane or on a line; a warp needs depth",
            points.len()
        )));
    }
    Ok(size)
}

/// The mean distance of a point from its nearest neighbour, mm.
fn spacing(points: &[DVec3]) -> FitResult<f64> {
    let mut total = 0.0;
    for (i, p) in points.iter().enumerate() {
        let mut nearest = f64::INFINITY;
        for (j, q) in points.iter().enumerate() {
            if i == j {
                continue;
            }
            let distance = p.distance(*q);
            // A micrometre: below it two landmarks are one that was given twice.
            if distance < 1e-3 {
                return Err(FitError::Input(format!(
                    "landmarks {} and {} lie on one spot",
                    i.min(j) + 1,
                    i.max(j) + 1
                )));
            }
            nearest = nearest.min(distance);
        }
        total += nearest;
    }
    Ok(total / points.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;
    use crate::fit::test_head;

    const KERNELS: [Kernel; 4] = [
        Kernel::MultiQuadric { radius: None },
        Kernel::ThinPlate,
        Kernel::Gaussian { radius: None },
        Kernel::Biharmonic,
    ];

    fn cloud(random: &mut Random, n: usize, size: f64) -> Vec<DVec3> {
        (0..n)
            .map(|_| DVec3::new(random.normal(), random.normal(), random.normal()) * size)
            .collect()
    }

    /// Any rotation, and a translation of metres.
    fn pose(random: &mut Random) -> impl Fn(DVec3) -> DVec3 + use<> {
        let axis = cloud(random, 1, 1.0)[0].normalize();
        let rotation = DMat3::from_axis_angle(axis, 6.3 * random.uniform());
        let translation = cloud(random, 1, 1000.0)[0];
        move |p| rotation * p + translation
    }

    fn farthest(a: &[DVec3], b: &[DVec3]) -> f64 {
        a.iter()
            .zip(b)
            .map(|(a, b)| a.distance(*b))
            .fold(0.0, f64::max)
    }

    #[test]
    fn landmarks_are_met_exactly() {
        let mut random = Random::new(1);
        for kernel in KERNELS {
            for n in [4, 5, 9, 30, 81, 150] {
                let from = cloud(&mut random, n, 60.0);
                let to: Vec<DVec3> = from
                    .iter()
                    .zip(cloud(&mut random, n, 5.0))
                    .map(|(p, d)| *p * 1.1 + d)
                    .collect();
                let warp = Warp::fit(&from, &to, kernel, 0.0).expect("it can be solved");
                // Issue 3's bar.
                assert!(
                    farthest(&warp.apply_all(&from), &to) < 1e-6,
                    "{kernel:?} {n}"
                );
            }
        }
    }

    #[test]
    fn landmarks_of_a_head_are_met_exactly_even_where_lips_touch() {
        let Some(head) = test_head() else { return };
        let mut from: Vec<DVec3> = (0..head.landmarks.len())
            .map(|i| head.landmark(i, &head.positions))
            .collect();
        let index = |name: &str| {
            head.landmarks
                .iter()
                .position(|l| l.name == name)
                .expect("an iBUG point")
        };
        // The inner lips of a closed mouth, as far apart as on a scan.
        let (upper, lower) = (index("ibug_62"), index("ibug_66"));
        from[lower] = from[upper] - DVec3::new(0.0, 0.8, 0.0);
        let mut random = Random::new(2);
        for kernel in KERNELS {
            // Each goes its own way by some millimetres, and the whole head is turned.
            let moved = pose(&mut random);
            let to: Vec<DVec3> = from
                .iter()
                .zip(cloud(&mut random, from.len(), 2.0))
                .map(|(p, d)| moved(*p + d))
                .collect();
            let warp = Warp::fit(&from, &to, kernel, 0.0).expect("it can be solved");
            assert!(farthest(&warp.apply_all(&from), &to) < 1e-6, "{kernel:?}");
        }
    }

    #[test]
    fn an_affine_map_comes_out_affine_everywhere() {
        let mut random = Random::new(3);
        for kernel in KERNELS {
            for smoothing in [0.0, 0.1, 10.0] {
                let columns = cloud(&mut random, 3, 0.3);
                let linear = DMat3::IDENTITY + DMat3::from_cols(columns[0], columns[1], columns[2]);
                let affine = |p: DVec3| linear * p + DVec3::new(300.0, -20.0, 1000.0);
                let from = cloud(&mut random, 40, 60.0);
                let to: Vec<DVec3> = from.iter().map(|&p| affine(p)).collect();
                let warp = Warp::fit(&from, &to, kernel, smoothing).expect("it can be solved");
                // Also well outside, where radial functions grow. Rounding of numbers near 1000
                // times the condition of the system.
                let beyond = cloud(&mut random, 100, 150.0);
                let truth: Vec<DVec3> = beyond.iter().map(|&p| affine(p)).collect();
                assert!(
                    farthest(&warp.apply_all(&beyond), &truth) < 1e-6,
                    "{kernel:?}"
                );
            }
        }
    }

    #[test]
    fn the_warp_turns_with_source_and_target() {
        let mut random = Random::new(4);
        for kernel in KERNELS {
            for smoothing in [0.0, 0.5] {
                let from = cloud(&mut random, 30, 60.0);
                let to: Vec<DVec3> = from
                    .iter()
                    .zip(cloud(&mut random, 30, 4.0))
                    .map(|(p, d)| *p + d)
                    .collect();
                let (source, target) = (pose(&mut random), pose(&mut random));
                let turned = |points: &[DVec3], by: &dyn Fn(DVec3) -> DVec3| -> Vec<DVec3> {
                    points.iter().map(|&p| by(p)).collect()
                };
                let there = Warp::fit(&from, &to, kernel, smoothing).expect("it can be solved");
                let posed = Warp::fit(
                    &turned(&from, &source),
                    &turned(&to, &target),
                    kernel,
                    smoothing,
                )
                .expect("it can be solved");
                let points = cloud(&mut random, 50, 80.0);
                let a = turned(&there.apply_all(&points), &target);
                let b = posed.apply_all(&turned(&points, &source));
                // Coordinates of metres lose three digits of the distances of a face.
                assert!(farthest(&a, &b) < 1e-6, "{kernel:?} {}", farthest(&a, &b));
            }
        }
    }

    #[test]
    fn smoothing_relaxes_up_to_the_affine_map() {
        let mut random = Random::new(5);
        for kernel in KERNELS {
            let from = cloud(&mut random, 60, 60.0);
            let to: Vec<DVec3> = from
                .iter()
                .zip(cloud(&mut random, 60, 3.0))
                .map(|(p, d)| *p + d)
                .collect();
            let errors: Vec<f64> = [0.0, 0.01, 0.1, 1.0, 10.0, 1e6]
                .iter()
                .map(|&smoothing| {
                    let warp = Warp::fit(&from, &to, kernel, smoothing).expect("it can be solved");
                    let squares: f64 = warp
                        .apply_all(&from)
                        .iter()
                        .zip(&to)
                        .map(|(a, b)| a.distance_squared(*b))
                        .sum();
                    squares.sqrt()
                })
                .collect();
            assert!(
                errors.windows(2).all(|e| e[0] < e[1]),
                "{kernel:?} {errors:?}"
            );
            let affine = {
                let rows = DMatrix::from_fn(60, 4, |i, c| if c == 3 { 1.0 } else { from[i][c] });
                let right = DMatrix::from_fn(60, 3, |i, c| to[i][c]);
                let solution = rows
                    .clone()
                    .svd(true, true)
                    .solve(&right, 1e-12)
                    .expect("full rank");
                (rows * solution - right).norm()
            };
            // A millionth of the kernel's share is left.
            assert!((errors[5] - affine).abs() < 1e-4 * affine, "{kernel:?}");
        }
    }

    #[test]
    fn the_radius_that_was_used_is_stated() {
        // A regular grid 10 mm apart: the spacing is 10.
        let from: Vec<DVec3> = (0..27)
            .map(|i| DVec3::new(f64::from(i % 3), f64::from(i / 3 % 3), f64::from(i / 9)) * 10.0)
            .collect();
        let of = |kernel| {
            Warp::fit(&from, &from, kernel, 0.0)
                .expect("solves")
                .kernel()
        };
        let Kernel::MultiQuadric { radius: Some(r) } = of(Kernel::default()) else {
            panic!("no radius")
        };
        assert!((r - 10.0).abs() < 1e-9);
        let Kernel::Gaussian { radius: Some(r) } = of(Kernel::Gaussian { radius: None }) else {
            panic!("no radius")
        };
        assert!((r - 20.0).abs() < 1e-9);
        let asked = Kernel::Gaussian { radius: Some(7.0) };
        assert_eq!(of(asked), asked);
    }

    #[test]
    fn what_cannot_be_warped_is_said() {
        let mut random = Random::new(6);
        let good = cloud(&mut random, 10, 50.0);
        let message = |from: &[DVec3], to: &[DVec3], kernel, smoothing| {
            Warp::fit(from, to, kernel, smoothing)
                .expect_err("it is bad")
                .to_string()
        };
        let default = Kernel::default();
        assert!(message(&good, &good[..9], default, 0.0).contains("10 landmarks cannot go to 9"));
        assert!(message(&good[..3], &good[..3], default, 0.0).contains("4 is the least"));
        let mut bad = good.clone();
        bad[6].y = f64::NAN;
        assert!(message(&bad, &good, default, 0.0).contains("landmark 7 of 10"));
        assert!(message(&good, &bad, default, 0.0).contains("landmark 7 of 10"));
        bad[6] = good[2];
        assert!(message(&bad, &good, default, 0.0).contains("landmarks 3 and 7 lie on one spot"));
        let turn = pose(&mut random);
        let plane: Vec<DVec3> = good
            .iter()
            .map(|p| turn(DVec3::new(p.x, p.y, 0.0)))
            .collect();
        let line: Vec<DVec3> = good.iter().map(|p| turn(DVec3::X * p.x)).collect();
        for flat in [plane, line] {
            assert!(message(&flat, &good, default, 0.0).contains("in a plane or on a line"));
        }
        let spot = vec![DVec3::ONE; 10];
        assert!(message(&spot, &good, default, 0.0).contains("plane"));
        for smoothing in [-1.0, f64::NAN] {
            assert!(message(&good, &good, default, smoothing).contains("smoothing must be"));
        }
        for radius in [0.0, -3.0, f64::INFINITY] {
            let kernel = Kernel::MultiQuadric {
                radius: Some(radius),
            };
            assert!(message(&good, &good, kernel, 0.0).contains("length over 0 mm"));
        }
        // So wide that all its values are one to the last digit.
        let flat = Kernel::Gaussian { radius: Some(1e10) };
        let to = cloud(&mut random, 10, 50.0);
        assert!(message(&good, &to, flat, 0.0).contains("singular"));
    }
}
