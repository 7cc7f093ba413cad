//! The layout of textures: where each part of the surface lies in the image of its colours.
//!
//! The base mesh has a layout of its whole body, in which a face is a fifth as wide as the image and lies on
//! its side. The generic head has the same charts, but upright, the face half as wide as the image: an image of
//! the same size shows it six times as finely.

use glam::DVec2;

use super::template::Template;
use crate::fit::{FitError, FitResult};
use crate::quantise::TEXTURE;

/// How much finer the middle of the face is than what is far from it: at a distance of 1 / BULGE from there, in
/// the base mesh's coordinates, a length is half as long. Half a face is 0.1.
const BULGE: f64 = 14.0;
/// Charts are so far from each other and from the image's border: colours are continued into it, and images are
/// drawn smaller.
const GAP: f64 = 1.0 / 64.0;
/// Coordinates are rounded to so many steps of the blob's grid, for its bytes: an eighth of a texel of 2048.
const ROUND: i32 = 2;

/// A piece of the surface that is in one piece in the image, too.
struct Chart {
    corners: Vec<usize>,
    low: DVec2,
    high: DVec2,
}

impl Chart {
    fn new(corners: Vec<usize>, uvs: &[DVec2]) -> Self {
        let each = || corners.iter().map(|&c| uvs[c]);
        Self {
            low: each().fold(DVec2::INFINITY, DVec2::min),
            high: each().fold(DVec2::NEG_INFINITY, DVec2::max),
            corners,
        }
    }

    fn size(&self) -> DVec2 {
        self.high - self.low
    }
}

/// Lays a template's charts out anew: that of the face across the top, all others in a row beneath it.
///
/// # Errors
/// When the template lacks the landmarks of the nose's ridge or the lower lip, or its face has no chart with others
/// beside it.
pub fn lay_out(template: &mut Template) -> FitResult<()> {
    let bad = |why: &str| FitError::Input(format!("the head has no layout: {why}"));
    let topology = &template.topology;
    let mut uvs: Vec<DVec2> = topology
        .uvs
        .iter()
        .map(|uv| DVec2::new(uv[0].into(), uv[1].into()))
        .collect();
    // Landmarks lie inside of the chart, where each vertex has one corner.
    let stencil = |name: &str| -> FitResult<_> {
        let found = template.landmarks.iter().find(|l| l.name == name);
        let found = found.ok_or_else(|| bad("a landmark is missing"))?;
        Ok(&found.stencil)
    };
    let middle = |stencil: &[(u32, f64)]| -> DVec2 {
        stencil.iter().map(|&(v, w)| uvs[v as usize] * w).sum()
    };
    let [ridge, lip] = [stencil("ibug_27")?, stencil("ibug_57")?];
    let [top, bottom] = [middle(ridge), middle(lip)];
    let face = ridge[0].0 as usize;
    let mut charts = charts(&topology.uv_triangles, &uvs);
    let found = charts.iter().position(|c| c.corners.contains(&face));
    let mut face = charts.swap_remove(found.ok_or_else(|| bad("its face is in no chart"))?);
    if charts.is_empty() {
        return Err(bad("its face is the only chart"));
    }

    // Upright, around the middle of the face.
    let up = (top - bottom).normalize_or(DVec2::Y);
    let centre = (top + bottom) / 2.0;
    for &c in &face.corners {
        let from = uvs[c] - centre;
        let turned = DVec2::new(from.dot(-up.perp()), from.dot(up));
        let far = turned.length();
        uvs[c] = turned.normalize_or_zero() * ((BULGE * far).ln_1p() / BULGE);
    }
    face = Chart::new(face.corners, &uvs);
    let scale = (1.0 - 2.0 * GAP) / face.size().x;
    for &c in &face.corners {
        let high = DVec2::new(face.low.x, face.high.y);
        uvs[c] = DVec2::new(GAP, 1.0 - GAP) + scale * (uvs[c] - high);
    }

    // All others as large as they may be.
    charts.sort_by(|a, b| b.size().x.total_cmp(&a.size().x));
    let left = 1.0 - GAP - scale * face.size().y;
    let room = DVec2::new(1.0 - GAP * (charts.len() + 1) as f64, left - 2.0 * GAP);
    let wide: f64 = charts.iter().map(|c| c.size().x).sum();
    let tall = charts.iter().map(|c| c.size().y).fold(0.0, f64::max);
    let scale = (room / DVec2::new(wide, tall)).min_element();
    if !(scale > 0.0 && scale.is_finite()) {
        return Err(bad("its charts have no room"));
    }
    let mut at = DVec2::splat(GAP);
    for chart in &charts {
        for &c in &chart.corners {
            uvs[c] = at + scale * (uvs[c] - chart.low);
        }
        at.x += scale * chart.size().x + GAP;
    }
    let coarse = |x: f64| TEXTURE.point(ROUND * TEXTURE.index(x / f64::from(ROUND))) as f32;
    template.topology.uvs = uvs.iter().map(|uv| uv.to_array().map(coarse)).collect();
    Ok(())
}

/// The charts of some triangles, in the order of their first corners.
fn charts(triangles: &[[u32; 3]], uvs: &[DVec2]) -> Vec<Chart> {
    let mut leader: Vec<usize> = (0..uvs.len()).collect();
    fn find(leader: &mut [usize], mut i: usize) -> usize {
        while leader[i] != i {
            leader[i] = leader[leader[i]];
            i = leader[i];
        }
        i
    }
    for t in triangles {
        let [a, b, c] = t.map(|c| find(&mut leader, c as usize));
        let least = a.min(b).min(c);
        for i in [a, b, c] {
            leader[i] = least;
        }
    }
    let mut all = std::collections::BTreeMap::<usize, Vec<usize>>::new();
    for c in 0..uvs.len() {
        all.entry(find(&mut leader, c)).or_default().push(c);
    }
    let each = all.into_values();
    each.map(|corners| Chart::new(corners, uvs)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::base_mesh_dir;
    use crate::fit::head::generic_head;

    #[test]
    fn the_face_is_half_of_the_image_and_no_two_places_share_a_texel() {
        const SIDE: usize = 512;
        let Some(dir) = base_mesh_dir() else { return };
        let head = generic_head::build(&dir).unwrap();
        let topology = &head.topology;
        let uv = |corner: u32| {
            let [u, v] = topology.uvs[corner as usize].map(f64::from);
            DVec2::new(u, v)
        };
        let mut count = vec![0_u8; SIDE * SIDE];
        // The base mesh's right eye is the left one's mirror image in its image, too.
        let skin_and_cavities: u32 = topology.parts[..3].iter().map(|p| p.count).sum();
        for (i, t) in topology.uv_triangles.iter().enumerate() {
            let [a, b, c] = t.map(uv);
            let twice = (b - a).perp_dot(c - a);
            let is_eye = i >= skin_and_cavities as usize;
            assert!(is_eye || twice > 0.0, "{t:?} is turned over");
            let low = (a.min(b).min(c) * SIDE as f64).floor().as_usizevec2();
            let high = (a.max(b).max(c) * SIDE as f64).ceil().as_usizevec2();
            for y in low.y..high.y {
                for x in low.x..high.x {
                    let p = (DVec2::new(x as f64, y as f64) + 0.5) / SIDE as f64;
                    let sides = [(a, b), (b, c), (c, a)].map(|(p0, p1)| (p1 - p0).perp_dot(p - p0));
                    count[SIDE * y + x] += u8::from(sides.iter().all(|s| *s > 0.0));
                }
            }
        }
        assert!(count.iter().all(|&c| c < 2), "two places share a texel");
        let used = count.iter().filter(|&&c| c > 0).count() as f64 / (SIDE * SIDE) as f64;
        assert!(used > 0.4, "{used} of the image is used");
        let place = |name: &str| -> DVec2 {
            let landmark = head.landmarks.iter().find(|l| l.name == name).unwrap();
            landmark.stencil.iter().map(|&(v, w)| uv(v) * w).sum()
        };
        let across = place("ibug_16") - place("ibug_00");
        assert!(across.x > 0.42 && across.y.abs() < 0.01, "{across}");
        let down = place("ibug_27") - place("ibug_08");
        assert!(down.y > 0.25 && down.x.abs() < 0.02, "{down}");
    }
}
