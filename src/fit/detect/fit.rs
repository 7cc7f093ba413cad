//! Pose and shape of the statistical face, fitted to a surface by Gauss-Newton.

use glam::{DMat3, DQuat, DVec3};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::shape::Shape;

/// Where the face is and what it looks like.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// A proper rotation, from the template's axes to the scan's.
    pub rotation: DMat3,
    /// Size on top of what the modes do.
    pub scale: f64,
    /// Where the template's origin is on the scan, mm.
    pub translation: DVec3,
    /// In standard deviations; those that are left out are 0.
    pub coefficients: Vec<f64>,
}

impl Fit {
    /// Where a point of the face is on the scan, mm.
    pub fn point(&self, shape: &Shape, index: usize) -> DVec3 {
        self.place(shape.point(index, &self.coefficients))
    }

    /// Where a place in the template's frame is on the scan, mm.
    pub fn place(&self, p: DVec3) -> DVec3 {
        self.rotation * (self.scale * p) + self.translation
    }

    /// The normal of a point of the face, with what shape does to it left out.
    pub fn normal(&self, shape: &Shape, index: usize) -> DVec3 {
        self.rotation * shape.normals[index]
    }
}

/// What a point of the face is drawn to.
#[derive(Debug, Clone, Copy)]
pub struct Match {
    /// A point of the scan, mm.
    pub point: DVec3,
    /// The scan's unit normal there.
    pub normal: DVec3,
    /// 0 to 1.
    pub weight: f64,
}

/// How the face is drawn to the scan.
#[derive(Debug, Clone, Copy)]
pub struct Pull {
    /// How many of the shape's points take part, from the first.
    pub points: usize,
    /// How many modes may bend it.
    pub modes: usize,
    /// The standard deviation of the distance from the fitted face to the scan, mm.
    pub sigma: f64,
}

/// How many independent distances all points together are worth: neighbours err alike.
pub const WORTH: f64 = 200.0;

/// The standard deviation of log(size) beyond what the modes do: children, and scans whose unit
/// is a little off.
const SCALE_SIGMA: f64 = 0.07;

/// Unknowns of the pose: a small rotation, a translation, and the growth of log(size).
const POSE: usize = 7;

/// The normal equations of all unknowns about a fit.
struct Equations {
    matrix: DMatrix<f64>,
    right: DVector<f64>,
}

impl Equations {
    /// Sums the squared distances along the scan's normals, with the coefficients' and the size's
    /// own probability. Nothing when too few points have a match to fix a pose.
    fn new(
        shape: &Shape,
        fit: &Fit,
        pull: Pull,
        find: impl Fn(DVec3, DVec3) -> Option<Match>,
    ) -> Option<Self> {
        let points = pull.points.min(shape.mean.len());
        let modes = pull.modes.min(shape.count);
        let size = POSE + modes;
        let share = (WORTH / points as f64).sqrt() / pull.sigma;
        let mut rows: Vec<f64> = Vec::with_capacity(points * size);
        let mut residuals: Vec<f64> = Vec::with_capacity(points);
        for index in 0..points {
            let p = fit.point(shape, index);
            let Some(found) = find(p, fit.normal(shape, index)) else {
                continue;
            };
            let arm = p - fit.translation;
            let normal = found.normal * (share * found.weight.sqrt());
            rows.extend(arm.cross(normal).to_array());
            rows.extend(normal.to_array());
            rows.push(arm.dot(normal));
            let inward = fit.rotation.transpose() * normal * fit.scale;
            let own = &shape.modes_of(index)[..modes];
            rows.extend(own.iter().map(|mode| mode.dot(inward)));
            residuals.push((found.point - p).dot(normal));
        }
        // A pose has seven unknowns; on a few points more it would hang on their noise.
        if residuals.len() < 20.max(points / 20) {
            return None;
        }
        let jacobian = DMatrix::from_vec(size, residuals.len(), rows);
        let mut matrix = &jacobian * jacobian.transpose();
        let mut right = &jacobian * DVector::from_vec(residuals);
        // On a sphere or a plane nothing holds some motions: with this a step along them is small,
        // and others do not notice (a radian, and 30 mm).
        for i in 0..3 {
            matrix[(i, i)] += 1.0;
            matrix[(3 + i, 3 + i)] += 1e-3;
        }
        matrix[(6, 6)] += SCALE_SIGMA.powi(-2);
        right[6] -= SCALE_SIGMA.powi(-2) * fit.scale.ln();
        for k in 0..modes {
            matrix[(POSE + k, POSE + k)] += 1.0;
            right[POSE + k] -= fit.coefficients.get(k).copied().unwrap_or(0.0);
        }
        Some(Self { matrix, right })
    }
}

/// One step of Gauss-Newton. A fit that has too few matches stays as it is.
pub fn step(
    shape: &Shape,
    fit: &mut Fit,
    pull: Pull,
    find: impl Fn(DVec3, DVec3) -> Option<Match>,
) {
    let Some(Equations { matrix, right }) = Equations::new(shape, fit, pull, find) else {
        return;
    };
    let Some(change) = solved(matrix, &right, shape, fit) else {
        return;
    };
    // Far from the solution a step may be wild; these are beyond what one can know.
    let turn = DVec3::new(change[0], change[1], change[2]).clamp_length_max(0.5);
    let growth = change[6].clamp(-0.2, 0.2);
    let turned = DQuat::from_scaled_axis(turn) * DQuat::from_mat3(&fit.rotation);
    fit.rotation = DMat3::from_quat(turned.normalize());
    fit.translation += DVec3::new(change[3], change[4], change[5]);
    fit.scale *= growth.exp();
    let modes = change.len() - POSE;
    fit.coefficients
        .resize(fit.coefficients.len().max(modes), 0.0);
    for (c, d) in fit.coefficients.iter_mut().zip(change.iter().skip(POSE)) {
        *c += d;
    }
}

/// The least squares, with no expression shown less than not at all: those that would be are held there, and the others
/// solved for again (an active set that only grows, as a step is one of many).
fn solved(
    mut matrix: DMatrix<f64>,
    right: &DVector<f64>,
    shape: &Shape,
    fit: &Fit,
) -> Option<DVector<f64>> {
    let modes = matrix.nrows() - POSE;
    let mut right = right.clone();
    let mut held = vec![false; modes];
    loop {
        let change = matrix.clone().cholesky()?.solve(&right);
        let own = |k: usize| fit.coefficients.get(k).copied().unwrap_or(0.0);
        let below = |k: &usize| *k < modes && !held[*k] && own(*k) + change[POSE + k] < 0.0;
        let out: Vec<usize> = shape.shown.iter().copied().filter(below).collect();
        if out.is_empty() {
            return Some(change);
        }
        for k in out {
            held[k] = true;
            matrix[(POSE + k, POSE + k)] += HELD;
            right[POSE + k] -= HELD * own(k);
        }
    }
}

/// The weight by which a coefficient is held: distances weigh some thousands at most.
const HELD: f64 = 1e8;

/// How sure a fit is of where points are.
pub struct Uncertainty {
    factor: Cholesky<f64, Dyn>,
    modes: usize,
}

impl Uncertainty {
    /// The posterior of a fit, as Gauss-Newton has it: the inverse of the normal equations' matrix.
    pub fn new(
        shape: &Shape,
        fit: &Fit,
        pull: Pull,
        find: impl Fn(DVec3, DVec3) -> Option<Match>,
    ) -> Option<Self> {
        let Equations { matrix, .. } = Equations::new(shape, fit, pull, find)?;
        let modes = matrix.nrows() - POSE;
        let factor = matrix.cholesky()?;
        Some(Self { factor, modes })
    }

    /// The standard deviation of a point's place in space, mm.
    pub fn of(&self, shape: &Shape, fit: &Fit, index: usize) -> f64 {
        let arm = fit.point(shape, index) - fit.translation;
        let mut rows = DMatrix::zeros(POSE + self.modes, 3);
        for (axis, unit) in DVec3::AXES.into_iter().enumerate() {
            let turn = arm.cross(unit);
            let own = fit.rotation.transpose() * unit * fit.scale;
            for i in 0..3 {
                rows[(i, axis)] = turn[i];
                rows[(3 + i, axis)] = unit[i];
            }
            rows[(6, axis)] = arm.dot(unit);
            for (k, mode) in shape.modes_of(index)[..self.modes].iter().enumerate() {
                rows[(POSE + k, axis)] = mode.dot(own);
            }
        }
        self.factor.l_dirty().solve_lower_triangular_mut(&mut rows);
        rows.norm()
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;
    use crate::Random;

    fn vector(random: &mut Random) -> DVec3 {
        DVec3::new(random.normal(), random.normal(), random.normal())
    }

    /// 300 points with 6 modes, facing anywhere.
    fn shape(random: &mut Random) -> Shape {
        Shape {
            mean: (0..300).map(|_| vector(random) * 40.0).collect(),
            normals: (0..300).map(|_| vector(random).normalize()).collect(),
            modes: (0..300 * 6).map(|_| vector(random) * 2.0).collect(),
            count: 6,
            shown: Vec::new(),
        }
    }

    /// Draws each point to its own place on `truth`, in the order in which they ask.
    fn to(shape: &Shape, truth: &Fit) -> impl Fn(DVec3, DVec3) -> Option<Match> {
        let asked = Cell::new(0);
        move |_, _| {
            let index = asked.replace((asked.get() + 1) % shape.mean.len());
            Some(Match {
                point: truth.point(shape, index),
                normal: truth.normal(shape, index),
                weight: 1.0,
            })
        }
    }

    #[test]
    fn pose_and_shape_are_found_again() {
        let mut random = Random::new(1);
        for _ in 0..10 {
            let shape = shape(&mut random);
            let truth = Fit {
                rotation: DMat3::from_axis_angle(vector(&mut random).normalize(), 0.6),
                scale: 1.0 + 0.1 * random.uniform(),
                translation: vector(&mut random) * 20.0,
                coefficients: (0..6).map(|_| random.normal()).collect(),
            };
            let mut fit = Fit {
                rotation: DMat3::IDENTITY,
                scale: 1.0,
                translation: DVec3::ZERO,
                coefficients: Vec::new(),
            };
            // So narrow a scatter that what is probable hardly matters.
            let pull = Pull {
                points: 300,
                modes: 6,
                sigma: 1e-3,
            };
            for _ in 0..12 {
                let found = to(&shape, &truth);
                step(&shape, &mut fit, pull, found);
            }
            for i in 0..300 {
                let apart = fit.point(&shape, i).distance(truth.point(&shape, i));
                // A coefficient of one sigma pulls with 1 against 200 / 1e-6.
                assert!(apart < 1e-5, "{apart}");
            }
        }
    }

    #[test]
    fn what_nothing_draws_stays() {
        let mut random = Random::new(2);
        let shape = shape(&mut random);
        let start = Fit {
            rotation: DMat3::IDENTITY,
            scale: 1.0,
            translation: DVec3::ONE,
            coefficients: vec![0.5; 6],
        };
        let pull = Pull {
            points: 300,
            modes: 6,
            sigma: 1.0,
        };
        let mut fit = start.clone();
        step(&shape, &mut fit, pull, |_, _| None);
        assert_eq!(fit, start);
        assert!(Uncertainty::new(&shape, &fit, pull, |_, _| None).is_none());
    }

    #[test]
    fn a_fit_is_surer_of_what_the_scan_shows() {
        let mut random = Random::new(3);
        let mut shape = shape(&mut random);
        shape.loosen(&[DVec3::ZERO, DVec3::X * 60.0], 3.0, 20.0);
        let fit = Fit {
            rotation: DMat3::IDENTITY,
            scale: 1.0,
            translation: DVec3::ZERO,
            coefficients: vec![0.0; shape.count],
        };
        let pull = Pull {
            points: 300,
            modes: shape.count,
            sigma: 1.0,
        };
        let spread = |reach: f64| {
            let seen = |p: DVec3, normal: DVec3| {
                (p.x < reach).then_some(Match {
                    point: p,
                    normal,
                    weight: 1.0,
                })
            };
            let own = Uncertainty::new(&shape, &fit, pull, seen).expect("enough is seen");
            (0..300)
                .map(|i| own.of(&shape, &fit, i))
                .collect::<Vec<_>>()
        };
        let (all, half) = (spread(f64::INFINITY), spread(0.0));
        for i in 0..300 {
            assert!(all[i] < half[i], "{i}: {} {}", all[i], half[i]);
        }
    }
}
