//! Where somebody looks: irises on eyeballs.
//!
//! The middle of an iris lies on a sphere around the middle of the eyeball, and the ray through where it is seen meets
//! that sphere where the eye looks. Both eyes look the same way, so that the mean of what they say counts; where
//! they disagree, or lids are all but shut, nothing is told.
//!
//! Only to the side: lids go up and down with an eye, cover its iris above and below, and a fit follows them. Of 60 heads that
//! the page drew what MediaPipe's irises told was off by 2 to 4 degrees to the side, and next to nothing was told of up and down.

use glam::{DVec2, DVec3};

use super::Camera;
use crate::expression::Expression;
use crate::{Expressions, Face};

/// The middle of an iris is this part of the eyeball's radius from its middle: where the border of the iris meets the
/// ball, 28 degrees from its axis.
const IRIS_FROM_MIDDLE: f64 = 0.88;
/// Lids that are nearer than this show too little of an iris, mm: those of who laughs are 5 mm apart and more.
const SHUT: f64 = 3.0;
/// Eyes that look farther apart than this were not found, radians: they would meet 18 cm before the face.
const APART: f64 = 0.35;
/// The first points of the subject's right and left eye in the scheme of iBUG, and how many an eye has.
const EYES: [usize; 2] = [36, 42];
const LIDS: usize = 6;
/// The upper lid's points and the lower ones under them, among those of an eye.
const OVER: [[usize; 2]; 2] = [[1, 5], [2, 4]];

/// What a fit has that eyes are told by.
pub(super) struct Eyes<'a> {
    pub face: &'a Face,
    pub expressions: &'a Expressions,
    pub camera: &'a Camera,
    /// The 68 points as given, px, and from each to where it is fitted.
    pub seen: &'a [DVec2],
    pub residuals: &'a [DVec2],
    /// px at the face a mm.
    pub scale: f64,
}

impl Eyes<'_> {
    /// The weight of each expression that turns eyes to a side, as its place in the list, for where the irises of the subject's right and left
    /// eye are (px); `None` when they do not tell.
    pub fn looking(&self, irises: [DVec2; 2]) -> Option<Vec<(usize, f64)>> {
        let [right, left] = [0, 1].map(|i| self.angle(i, irises[i]));
        let (right, left) = (right?, left?);
        if !((right - left).abs() <= APART) {
            return None;
        }
        let list = self.expressions.list();
        let turning = list.iter().enumerate().filter_map(|(i, expression)| {
            let full = turn(expression)?;
            // One of two opposite ones is shown, the other is behind 0.
            Some((i, ((right + left) / 2.0 / full).clamp(0.0, 1.0)))
        });
        let turning: Vec<_> = turning.collect();
        (!turning.is_empty()).then_some(turning)
    }

    /// How far an eye has turned to the subject's left, radians; the first is the right one.
    fn angle(&self, eye: usize, iris: DVec2) -> Option<f64> {
        let lids = EYES[eye]..EYES[eye] + LIDS;
        let lid = |k: usize| self.seen[EYES[eye] + k];
        let open = OVER.map(|[over, under]| lid(over).distance(lid(under)));
        if !((open[0] + open[1]) / 2.0 >= SHUT * self.scale) {
            return None;
        }
        // As far as the eye itself is fitted elsewhere its iris is, too.
        let off = self.residuals[lids].iter().sum::<DVec2>() / LIDS as f64;
        let (middle, radius) = self.expressions.eyeball(1 - eye, self.face.positions())?;
        let radius = IRIS_FROM_MIDDLE * f64::from(radius);
        let from = self.camera.position();
        let ray = (iris + off - self.camera.centre) / self.camera.focal;
        let ray = (self.camera.rotation.transpose() * ray.extend(1.0)).normalize();
        let way = middle.as_dvec3() - from;
        let nearest = way.dot(ray);
        let aside = (way - ray * nearest).length();
        // What is seen beside the sphere looks as far aside as can be seen.
        let before = (radius * radius - aside * aside).max(0.0).sqrt();
        let axis = (from + ray * (nearest - before) - middle.as_dvec3()).try_normalize()?;
        (axis.z > 0.0).then(|| axis.x.atan2(axis.z))
    }
}

/// How far an expression turns the eye that it is of to the subject's left, radians; `None` of one that does something else.
fn turn(expression: &Expression) -> Option<f64> {
    let turn: DVec3 = expression.turns.iter().map(|t| t.as_dvec3()).sum();
    (turn.y.abs() > turn.x.abs()).then_some(turn.y)
}
