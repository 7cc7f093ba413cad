//! Colours of vertices as programs write them in numbers.

use glam::DVec3;

/// A number above this is no part of 1: light may be a little brighter than white, while of 0 to 255 a face
/// has hardly any that is not far above.
const BRIGHTEST: f64 = 2.0;

/// Takes colours that were written as 0 to 255 where 0 to 1 is usual for what they are: all of a file's or
/// none, since a dark one alone does not tell. The note that says so.
pub fn to_unit(colours: &mut [DVec3]) -> Option<String> {
    let most = colours
        .iter()
        .map(|c| c.max_element())
        .filter(|c| c.is_finite());
    if !(most.fold(0.0, f64::max) > BRIGHTEST) {
        return None;
    }
    colours.iter_mut().for_each(|c| *c /= 255.0);
    Some("colours: from 0 to 255, because some are above 1".into())
}

/// A colour from 0 to 1 in bytes.
pub fn bytes(colour: DVec3) -> [u8; 3] {
    (colour * 255.0)
        .to_array()
        .map(|c| c.clamp(0.0, 255.0).round() as u8)
}

/// The note of vertices that are white because others have colours.
pub fn white(count: usize) -> String {
    format!("colours: {count} vertices without one are white")
}
