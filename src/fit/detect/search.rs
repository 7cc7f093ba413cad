//! Where on a scan a face may be: every place and direction is tried roughly.

use glam::{DMat3, DQuat, DVec3};

use super::fit::Fit;
use super::shape::Shape;
use super::surfels::Surfels;

/// A place from which the surface around it is looked at.
#[derive(Debug, Clone, Copy)]
pub struct Lookout {
    /// The place, mm.
    pub point: DVec3,
    /// The mean normal within [`AROUND`].
    axis: DVec3,
    /// The mean height of the surface within [`AROUND`] over the place, along the axis, mm:
    /// negative where it stands out, as the tip of a nose does.
    height: f64,
}

/// The radius of what a lookout sees, mm: from the tip of the nose to the eyes and the chin.
const AROUND: f64 = 45.0;

impl Lookout {
    /// The lookout at a point near a surface.
    pub fn new(surfels: &Surfels, point: DVec3) -> Self {
        let slack = AROUND + surfels.cell;
        // Surfels are numbered along the grid, with z slowest.
        let first = surfels.points.partition_point(|p| p.z < point.z - slack);
        let (mut axis, mut mean, mut area) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        for i in first..surfels.points.len() {
            let p = surfels.points[i];
            if p.z > point.z + slack {
                break;
            }
            if p.distance_squared(point) < AROUND * AROUND {
                axis += surfels.normals[i] * surfels.areas[i];
                mean += (p - point) * surfels.areas[i];
                area += surfels.areas[i];
            }
        }
        let axis = axis.normalize_or(DVec3::Z);
        Self {
            point,
            axis,
            height: if area > 0.0 {
                mean.dot(axis) / area
            } else {
                0.0
            },
        }
    }

    /// Columns: right, up and the axis, with up turned by `roll` from what is nearest to `up`.
    fn frame(&self, up: DVec3, roll: f64) -> DMat3 {
        let up = up.reject_from_normalized(self.axis);
        let up = up.normalize_or(self.axis.any_orthonormal_vector());
        let up = DQuat::from_axis_angle(self.axis, roll) * up;
        DMat3::from_cols(up.cross(self.axis), up, self.axis)
    }

    /// The frames of axes that lean away from its own by some degrees, each in all directions.
    fn frames(&self, leans: &[f64]) -> Vec<DMat3> {
        let mut frames = Vec::new();
        for &lean in leans {
            let leanings = if lean > 0.0 { LEANINGS } else { 1 };
            for leaning in 0..leanings {
                let around = self.frame(DVec3::Y, turn(leaning, leanings)).y_axis;
                let lean = DQuat::from_axis_angle(around, lean.to_radians());
                frames.extend(
                    (0..ROLLS).map(|roll| {
                        DMat3::from_quat(lean) * self.frame(DVec3::Y, turn(roll, ROLLS))
                    }),
                );
            }
        }
        frames
    }
}

/// How widely starts are looked for.
pub struct Breadth {
    /// How far a place must stand out, as a share of what the tip of the nose does. The surfel nearest
    /// to a tip is a little inside it, and noses differ.
    pub height: f64,
    /// Angles between the axis of a place and that of the face, degrees.
    pub leans: &'static [f64],
}

/// For scans of all of the face.
pub const WHOLE: Breadth = Breadth {
    height: 0.5,
    leans: &[0.0],
};

/// For profiles and other parts: what is missing on one side of a place leans its axis to the other.
pub const PART: Breadth = Breadth {
    height: 0.3,
    leans: &[0.0, 40.0],
};

/// Directions in which an axis leans.
const LEANINGS: usize = 8;

/// Directions tried around each axis.
const ROLLS: usize = 24;

/// How many points of the face the first look takes.
const FIRST_POINTS: usize = 100;

/// How far off a start may be and still count, mm: half the distance between two places, and what
/// noses differ by.
const FIRST_REACH: f64 = 16.0;

/// The angle of one of so many equal steps around, radians.
fn turn(step: usize, steps: usize) -> f64 {
    std::f64::consts::TAU * step as f64 / steps as f64
}

/// How well the face agrees with a surface, 0 to 1: a point counts by how near it is, up to `reach`
/// mm, and by how well normals agree.
pub fn agreement(shape: &Shape, fit: &Fit, points: usize, surfels: &Surfels, reach: f64) -> f64 {
    let points = points.min(shape.mean.len());
    let sum: f64 = (0..points)
        .map(|i| {
            let p = fit.point(shape, i);
            surfels.near(p).map_or(0.0, |j| {
                let away = surfels.points[j].distance_squared(p) / (reach * reach);
                let facing = surfels.normals[j].dot(fit.normal(shape, i));
                (1.0 - away).max(0.0) * ((facing - 0.3) / 0.7).max(0.0)
            })
        })
        .sum();
    sum / points as f64
}

/// At most so many starts for the fit with what each is worth, the best first: the mean face with
/// the tip of its nose (`tip`) on each place that stands out about as much as a nose does, in the
/// direction that agrees best. `rough` are the places, `fine` is what is compared with.
pub fn starts(
    shape: &Shape,
    tip: Lookout,
    rough: &Surfels,
    fine: &Surfels,
    breadth: &Breadth,
    most: usize,
) -> Vec<(f64, Fit)> {
    let own = tip.frame(DVec3::Y, 0.0).transpose();
    let mut starts: Vec<(f64, Fit)> = Vec::new();
    for &point in &rough.points {
        let lookout = Lookout::new(rough, point);
        if lookout.height > breadth.height * tip.height {
            continue;
        }
        let mut best: Option<(f64, Fit)> = None;
        for frame in lookout.frames(breadth.leans) {
            let rotation = frame * own;
            let fit = Fit {
                rotation,
                scale: 1.0,
                translation: point - rotation * tip.point,
                coefficients: Vec::new(),
            };
            let worth = agreement(shape, &fit, FIRST_POINTS, fine, FIRST_REACH);
            if best.as_ref().is_none_or(|(most, _)| worth > *most) {
                best = Some((worth, fit));
            }
        }
        starts.extend(best);
    }
    starts.sort_by(|a, b| b.0.total_cmp(&a.0));
    starts.truncate(most);
    starts
}
