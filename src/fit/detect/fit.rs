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
const WORTH: f64 = 200.0;

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
    let Some(factor) = matrix.cholesky() else {
        return;
    };
    let change = factor.solve(&right);
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
