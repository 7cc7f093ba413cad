//! Hair on scans: a surface that is not the head's.
//!
//! A scanner sees hair as a solid, up to centimetres above the skin and over half of a head. A
//! closest point does not know. So the face is found by the skin that everybody shows, and elsewhere
//! what lies too far above the head that goes with such a face is left out; there the head is carried
//! along. Hair of less than that is followed, as is a skull that is larger than faces tell, if it
//! rises gradually.

use glam::DVec3;

use crate::fit::head::region::point;
use crate::fit::head::template::Template;

/// How far bare skin goes on around a point, mm.
const REACH: f64 = 20.0;

/// What lies so far above the prior's face is the less skin, mm. While that is still fitted, more is
/// let pass (the rounds of [`statistical`](super::statistical)).
const ABOVE: [f64; 2] = [4.0, 8.0];

/// Which vertices of a template are skin on everybody: around brows, nose and eyes (iBUG 17 to 47),
/// where neither hair nor beards grow higher than brows. All of a template without these points.
pub fn bare(template: &Template) -> Vec<bool> {
    let middle: Vec<DVec3> = (17..48)
        .filter_map(|i| point(template, &format!("ibug_{i:02}")).ok())
        .collect();
    (template.positions.iter())
        .map(|p| middle.is_empty() || middle.iter().any(|m| m.distance(*p) < REACH))
        .collect()
}

/// How likely a point of a scan that is so high above the prior's face (mm) is skin, 0 to 1, where
/// hair grows.
pub fn skin(above: f64) -> f64 {
    ((ABOVE[1] - above) / (ABOVE[1] - ABOVE[0])).clamp(0.0, 1.0)
}
