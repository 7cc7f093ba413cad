//! Brows are marked on their hair; the template's points are above it.

use glam::DVec3;

use super::{Placement, Scan};
use crate::anatomy::brow_hair;
use crate::fit::head::template::Template;
use crate::fit::mesh::surface::Surface;

/// The first of the ten points on brows, of iBUG's.
const FIRST: usize = 17;
/// People mark the upper half of the hair: so much of the way down to its middle is where marks are. The head that is registered to a
/// scan without these points has its own 4 mm above them in the mean, where the middle of its hair is 7 mm below.
const MARKED: f64 = 0.75;
/// A scan's surface is no farther from where a point is moved to, mm.
const REACH: f64 = 15.0;
/// Fewer points do not place a head.
const FEWEST: usize = 4;

/// Which of the ten points on brows a landmark of the template is.
fn of_brow(template: &Template, landmark: usize) -> Option<usize> {
    let number = template.landmarks[landmark].name.strip_prefix("ibug_")?;
    let number: usize = number.parse().ok()?;
    (FIRST..FIRST + 10)
        .contains(&number)
        .then(|| number - FIRST)
}

/// Moves points of a scan, `(index in the template's landmarks, point in mm)`, that are marked on the hair of brows to where the
/// template has them: by as much as these are above the upper half of the hair on the template, as large and turned as the other
/// points have it, and onto the surface.
pub(in crate::fit) fn off_hair(points: &mut [(usize, DVec3)], scan: &Scan, template: &Template) {
    let mut known = [None; 10];
    for landmark in 0..template.landmarks.len() {
        if let Some(i) = of_brow(template, landmark) {
            known[i] = Some(template.landmark(landmark, &template.positions));
        }
    }
    let others = points.iter().copied();
    let others: Vec<_> = others
        .filter(|&(l, _)| of_brow(template, l).is_none())
        .collect();
    let placed = match others.len() {
        FEWEST.. => Placement::of(&others, template, false),
        _ => Placement::of(points, template, false),
    };
    let known = known.into_iter().collect::<Option<Vec<DVec3>>>();
    let known = known.and_then(|known| <[DVec3; 10]>::try_from(known).ok());
    let (Some(placed), Some(own)) = (placed, known) else {
        return;
    };
    let positions: Vec<_> = template.positions.iter().map(|p| p.as_vec3()).collect();
    let hair = brow_hair(own.map(|p| p.as_vec3()), &positions).map(|p| p.as_dvec3());
    let surface = Surface::new(&scan.positions, &scan.triangles);
    for (landmark, point) in points {
        if let Some(i) = of_brow(template, *landmark) {
            let there = *point + placed.rotation * (own[i] - hair[i]) * (MARKED * placed.scale);
            let hit = surface.closest(there, REACH);
            *point = hit.map_or(there, |hit| hit.point);
        }
    }
}
