//! Pose and shape of the statistical face, fitted to a surface by Gauss-Newton.

use glam::{DMat3, DQuat, DVec3};
use nalgebra::{DMatrix, DVector};

/// Points of the statistical face, P of them with K modes.
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
}

impl Shape {
    /// A point of the face with these coefficients (K or fewer; the others are 0).
    pub fn point(&self, index: usize, coefficients: &[f64]) -> DVec3 {
        let modes = &self.modes[index * self.count..(index + 1) * self.count];
        let moved: DVec3 = modes.iter().zip(coefficients).map(|(m, &c)| *m * c).sum();
        self.mean[index] + moved
    }
}

/// Where the face is and what it looks like.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// A proper rotation, from the template's axes to the scan's.
    pub rotation: DMat3,
    /// Size on top of the modes' own.
    pub scale: f64,
    /// The scan's place of the template's origin, mm.
    pub translation: DVec3,
    /// In standard deviations.
    pub coefficients: Vec<f64>,
}

impl Fit {
    /// Where a point of the face is on the scan.
    pub fn point(&self, shape: &Shape, index: usize) -> DVec3 {
        self.rotation * (self.scale * shape.point(index, &self.coefficients)) + self.translation
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
    /// How many independent distances the points are worth: neighbours err alike.
    pub worth: f64,
}

/// The standard deviation of log(size) beyond what the modes do: children, and scans whose unit
/// is a little off.
const SCALE_SIGMA: f64 = 0.07;

/// One step of Gauss-Newton on the distances along the scan's normals, with the coefficients' and
/// the size's own probability. Returns how far the points moved at most, mm; nothing when too few
/// of them have a match to fix a pose.
pub fn step(
    shape: &Shape,
    fit: &mut Fit,
    pull: Pull,
    find: impl Fn(DVec3, DVec3) -> Option<Match>,
) -> Option<f64> {
    let points = pull.points.min(shape.mean.len());
    let modes = pull.modes.min(shape.count);
    fit.coefficients.resize(shape.count, 0.0);
    let size = 7 + modes;
    let mut rows: Vec<f64> = Vec::with_capacity(points * size);
    let mut residuals: Vec<f64> = Vec::with_capacity(points);
    let mut reach: f64 = 0.0;
    for index in 0..points {
        let p = fit.point(shape, index);
        let Some(found) = find(p, fit.rotation * shape.normals[index]) else {
            continue;
        };
        let weight = (found.weight * pull.worth / points as f64).sqrt() / pull.sigma;
        let arm = p - fit.translation;
        reach = reach.max(arm.length());
        let normal = found.normal * weight;
        rows.extend(arm.cross(normal).to_array());
        rows.extend(normal.to_array());
        rows.push(arm.dot(normal));
        let inward = fit.rotation.transpose() * normal * fit.scale;
        let own = &shape.modes[index * shape.count..index * shape.count + modes];
        rows.extend(own.iter().map(|mode| mode.dot(inward)));
        residuals.push((found.point - p).dot(normal));
    }
    // A pose has six unknowns; on a few points more it would hang on their noise.
    if residuals.len() < 20.max(points / 20) {
        return None;
    }
    let jacobian = DMatrix::from_vec(size, residuals.len(), rows);
    let mut normal = &jacobian * jacobian.transpose();
    let mut right = &jacobian * DVector::from_vec(residuals);
    let scale_precision = SCALE_SIGMA.powi(-2);
    normal[(6, 6)] += scale_precision;
    right[6] -= scale_precision * fit.scale.ln();
    for k in 0..modes {
        normal[(7 + k, 7 + k)] += 1.0;
        right[7 + k] -= fit.coefficients[k];
    }
    // On a sphere or a plane nothing holds some motions: a millimetre or a hundredth of a radian
    // a step is then the most that is believed.
    for i in 0..3 {
        normal[(i, i)] += 1.0;
        normal[(3 + i, 3 + i)] += 1e-3;
    }
    let change = normal.cholesky()?.solve(&right);
    let part = |i: usize| DVec3::new(change[i], change[i + 1], change[i + 2]);
    let (turn, shift) = (part(0), part(3));
    // Far from the solution a step may be wild; half a radian is beyond what it can know.
    let turn = turn.clamp_length_max(0.5);
    let growth = change[6].clamp(-0.2, 0.2);
    fit.rotation = DMat3::from_quat(
        (DQuat::from_scaled_axis(turn) * DQuat::from_mat3(&fit.rotation)).normalize(),
    );
    fit.translation += shift;
    fit.scale *= growth.exp();
    for k in 0..modes {
        fit.coefficients[k] += change[7 + k];
    }
    let bend = (0..modes)
        .map(|k| change[7 + k] * change[7 + k])
        .sum::<f64>()
        .sqrt();
    Some(shift.length() + (turn.length() + growth.abs()) * reach + bend)
}
