//! The colours of the skin that a photo shows, without the light on it, and how far they are believed.

use glam::{DVec2, DVec3, Vec3};

use super::cover::Cover;
use super::curtains::{self, Curtains};
use super::light::{CHIN, bare, features, points};
use super::sight::Sight;
use super::{Camera, Detail, Image, Light};
use super::{median, middle};
use crate::anatomy::{Landmark, brow_hair};
use crate::srgb::{BRIGHTNESS, linear};
use crate::{Error, FaceModel, Result};

/// What is seen at a cosine of the first is not believed, of the second wholly.
const FACING: [f64; 2] = [0.25, 0.6];
/// Nor so near beside what hides a part of the face, mm, wholly from the second on: fits are off by as much, and there is its edge.
const BESIDE: [f64; 2] = [2.0, 5.0];
/// Towards the outline, at a cosine below this, what has another tone than the skin is hair or what is
/// behind the head, not skin.
const INNER: f64 = 0.85;
/// From fewer vertices nobody knows a tone.
pub(super) const FEWEST: usize = 30;
/// Hair falls into foreheads: from so many mm above the brows on other tones are doubted, too, wholly
/// from the second on.
const FOREHEAD: [f32; 2] = [2.0, 9.0];
/// So it does into temples, which face the camera when a head is turned: from so far behind the outer
/// corners of the eyes on, mm, wholly from the second on; and from so far above the nose's base, below
/// which it is a beard, that is worn.
const TEMPLE: [[f32; 2]; 2] = [[4.0, 16.0], [0.0, 12.0]];
/// Around what is doubted there so many edges of the mesh are doubted as well, and belief grows again over so many more.
const EDGE: usize = 2;
const SOFT: usize = 4;
/// What is higher than the points on the brows by this, mm, in a column where hair hangs down so far, is hair and no brow.
const ARCH: f32 = 2.0;
/// Near hair the fill's brightness is believed rather than the photo's where they are apart by the first of these
/// logarithms, wholly by the second: single strands are thinner than the mesh.
const STRAND: [f64; 2] = [0.1, 0.28];
/// So is it where skin turns from the camera and is brighter than the fill.
const RIM: [f64; 2] = [0.05, 0.2];
/// Of what is brighter than the skin this part counts.
const SHINE: f64 = 0.4;
/// A beard's tone is that of the chin, if it is darker than the skin by this logarithm.
const BEARDED: f64 = 0.2;
/// The logarithms of tones that are another: none of the first is, all of the second are.
const OTHER: [f64; 2] = [0.2, 0.42];
/// The photo is worn within this distance of the face's features, mm, wholly within the second.
const AROUND: [f32; 2] = [35.0, 24.0];
/// In a photo that is exposed as usual this part of the pixels is brighter than the second: of nine portraits the
/// first hundredth is above 0.75, of one above 0.6. No photo is taken for darker by more than the third.
const BRIGHTEST: f64 = 0.01;
const BRIGHT: f64 = 0.7;
const MOST_EXPOSED: f64 = 30.0;
/// Pixels farther from the head than this part of its size are not asked.
const NEAR: f64 = 1.0;
/// A bridge of glasses differs by this logarithm from what is so far above and below its middle, mm, all across the nose: so far to both sides, in such
/// steps, mm, of somewhere near its root, before which it is. Of heads that the page drew 41 without glasses have at most 0.16, and two portraits 0.06; of
/// 49 with some 47 have more than 0.2.
const BRIDGE_DEPTH: f64 = 0.2;
const BRIDGE_HALVES: [f64; 3] = [2.2, 3.0, 3.7];
const BRIDGE_HALF: f64 = 4.0;
const BRIDGE_STEP: f64 = 1.0;
const BRIDGE_ASIDE: [f64; 5] = [-5.0, -2.5, 0.0, 2.5, 5.0];
/// No place tells more than this.
const BRIDGE_MOST: f64 = 0.8;
/// It is looked for so far above the eyes, mm, which is below brows that meet.
const BRIDGE_HEIGHTS: [f64; 2] = [-6.0, 7.0];
/// From one eye to the other, mm.
const PUPILS: f64 = 62.0;
/// Glasses reach from so far above the brows to so far below the tip of the nose, mm, and not onto the nose's
/// wings, which are so far from its middle.
const LENS: [f32; 2] = [4.0, 4.0];
const NOSE: f32 = 20.0;
/// What is darker than the skin by the first of these logarithms, or brighter by the second, is a frame.
const FRAME: [f64; 2] = [0.3, 0.45];
/// Lids and the hair of brows are dark anyway, so near to the points on them, mm.
const LID: f32 = 5.0;
const BROW: f32 = 6.0;
/// The eye's surroundings that a lens covers, mm from the points on the lids.
const SOCKET: f32 = 14.0;
/// What has another tone than skin at forehead and temples is hair when it has more contrast than this, in the median. Of 50 people of ICT, who are
/// bald, none has as much there, a few have 0.07.
const STRANDS: f64 = 0.1;
/// Contrast is told over so many mm, and not so near to brows, mm; nor at a smaller cosine of the angle at which it is seen.
const ACROSS_STRANDS: f64 = 2.0;
const BESIDE_BROW: f32 = 12.0;
const STRANDS_FACING: f64 = 0.2;
/// Fewer places do not tell it.
const FEWEST_STRANDS: usize = 12;
/// No tone is farther than this factor from the model's colours: the darkest skin has a thirtieth of its blue.
const LARGEST_TONE: f64 = 40.0;
/// Below this light colours are the camera's noise.
pub(super) const BLACK: f64 = 0.01;
/// Light below this part of the usual is shadow, whose albedo nobody knows.
const DARKEST: f64 = 0.15;
/// A face with what is known of its colours.
pub(super) struct Skin<'a> {
    pub model: &'a FaceModel,
    pub light: &'a Light,
    pub image: &'a Image<'a>,
    pub normals: &'a [Vec3],
    /// Where vertices are in the photo, px.
    pub seen: Vec<DVec2>,
    pub trust: Vec<f64>,
    /// Whether a mask, glasses or hair are before each vertex, for all that is known.
    pub hidden: Vec<bool>,
    pub camera: &'a Camera,
    /// Where vertices are, mm.
    pub places: &'a [DVec3],
    /// Below this height on the mean head a beard may be, which is no skin.
    beard_below: f32,
    /// How near hair is, 0..=1, where single strands are looked for.
    strands: Vec<f64>,
    /// The model's own colours, linear.
    pub painted: Vec<DVec3>,
    /// The cosine of the angle at which each vertex is seen, 0 when it is not.
    pub facings: Vec<f64>,
    /// The usual shading.
    pub usual: DVec3,
    /// What the photo's light is multiplied by, for photos that are too dark.
    pub exposure: f64,
    /// Whether an eye is behind a lens that is not clear.
    pub dark_lenses: bool,
}

impl<'a> Skin<'a> {
    /// Of a face (positions in mm, unit normals) that a camera sees in an image.
    ///
    /// # Errors
    /// When the mesh is not the model's, or the face is not in the photo.
    pub fn new(
        model: &'a FaceModel,
        camera: &'a Camera,
        light: &'a Light,
        (places, normals): (&'a [DVec3], &'a [Vec3]),
        image: &'a Image<'a>,
    ) -> Result<Self> {
        let topology = &model.parts().topology;
        super::check_mesh(places.len(), normals.len(), topology.regions.len())?;
        let [mut trust, facings] = trust(model, camera, places, normals)?;
        let cover = Cover::of(model, &points(model, (places, normals), camera, image));
        let mean = model.parts().mean.iter();
        let is_covered = |&at: &Vec3| cover.as_ref().is_some_and(|cover| cover.hides(at));
        let covered: Vec<bool> = mean.map(is_covered).collect();
        for (trust, _) in trust.iter_mut().zip(&covered).filter(|t| *t.1) {
            *trust = 0.0;
        }
        let lit = (0..facings.len()).filter(|&v| facings[v] > INNER);
        let shading = lit.map(|v| light.shade(normals[v].as_dvec3()));
        let usual = median(shading).max(DVec3::splat(1e-6));
        let mut skin = Self {
            model,
            light,
            image,
            normals,
            seen: places.iter().map(|&p| camera.project(p)).collect(),
            beard_below: f32::NEG_INFINITY,
            strands: vec![0.0; trust.len()],
            hidden: covered.clone(),
            camera,
            places,
            trust,
            facings,
            painted: topology.colours.iter().map(|&c| linear(c)).collect(),
            usual,
            exposure: exposure(image, places.iter().map(|&p| camera.project(p))),
            dark_lenses: false,
        };
        skin.doubt(&covered);
        skin.doubt_glasses();
        Ok(skin)
    }

    /// The albedo at a mix of three vertices, of finer pixels where there are some, and how much it is believed.
    pub fn albedo(
        &self,
        corners: [usize; 3],
        share: [f64; 3],
        detail: Option<&Detail>,
    ) -> (DVec3, f64) {
        let trust: f64 = (0..3).map(|i| share[i] * self.trust[corners[i]]).sum();
        let albedo = (trust > 0.0).then(|| self.unlit(corners, share, detail));
        albedo.flatten().map_or((DVec3::ZERO, 0.0), |a| (a, trust))
    }

    /// The same of whatever tone it is, brows and hair among it, and how well it is seen.
    pub fn shown(&self, corners: [usize; 3], share: [f64; 3]) -> (DVec3, f64) {
        let facing: f64 = (0..3).map(|i| share[i] * self.facings[corners[i]]).sum();
        let sight = ((facing - FACING[0]) / (FACING[1] - FACING[0])).clamp(0.0, 1.0);
        let is_hidden = corners.iter().any(|&v| self.hidden[v]);
        let albedo = (sight > 0.0 && !is_hidden).then(|| self.unlit(corners, share, None));
        albedo.flatten().map_or((DVec3::ZERO, 0.0), |a| (a, sight))
    }

    /// The photo's colour at a mix of three vertices without the light.
    fn unlit(
        &self,
        corners: [usize; 3],
        share: [f64; 3],
        detail: Option<&Detail>,
    ) -> Option<DVec3> {
        let place: DVec2 = (0..3).map(|i| self.seen[corners[i]] * share[i]).sum();
        let normal: DVec3 = (0..3)
            .map(|i| self.normals[corners[i]].as_dvec3() * share[i])
            .sum();
        let seen = self.image.at(place)?;
        let seen = detail.and_then(|d| d.at(place)).unwrap_or(seen);
        let shading = self.light.shade(normal.normalize_or_zero()) / self.usual;
        Some(seen * self.exposure / shading.max(DVec3::splat(DARKEST)))
    }

    /// The albedo of a vertex that is seen.
    pub fn vertex(&self, v: usize) -> Option<DVec3> {
        let (albedo, trust) = self.albedo([v; 3], [1.0, 0.0, 0.0], None);
        (trust > 0.0).then_some(albedo)
    }

    /// The usual albedo of what is seen and believed.
    pub fn own(&self) -> DVec3 {
        let seen = (0..self.trust.len()).filter(|&v| self.trust[v] > 0.8 && self.beardless(v));
        median(seen.filter_map(|v| self.vertex(v)))
    }

    /// Whether no beard is at a vertex.
    pub fn beardless(&self, v: usize) -> bool {
        self.model.parts().mean[v].y > self.beard_below
    }

    /// The logarithms of (albedo / model's colour) of the vertices that are seen.
    pub fn seen_tones(&self) -> Vec<(usize, DVec3)> {
        let limit = DVec3::splat(LARGEST_TONE.ln());
        let each = (0..self.trust.len()).filter_map(|v| {
            let albedo = self.vertex(v)?;
            let tone = (albedo.max(DVec3::splat(1e-3)) / self.painted[v]).map(f64::ln);
            Some((v, tone.clamp(-limit, limit)))
        });
        each.collect()
    }

    /// Believes less of what is near the outline or the hairline and has another tone than the skin, and of what is
    /// beside something that covers the skin.
    fn doubt(&mut self, covered: &[bool]) {
        let tones = self.seen_tones();
        let parts = self.model.parts();
        let places = |names: std::ops::RangeInclusive<&'static str>| {
            let named = move |l: &&Landmark| names.contains(&l.name.as_str());
            let found = parts.landmarks.iter().filter(named);
            found.map(|l| l.position(&parts.mean))
        };
        let brows = places("ibug_17"..="ibug_26").map(|p| p.y);
        let brows = brows.fold(f32::NEG_INFINITY, f32::max);
        let corners = places("ibug_36"..="ibug_36").chain(places("ibug_45"..="ibug_45"));
        let corners = corners.map(|p| p.z).fold(f32::INFINITY, f32::min);
        let nose = places("ibug_33"..="ibug_33").map(|p| p.y);
        let nose = nose.fold(f32::NEG_INFINITY, f32::max);
        let within = |[from, to]: [f32; 2], x: f32| ((x - from) / (to - from)).clamp(0.0, 1.0);
        let away = |a: DVec3, b: DVec3| {
            (((a - b).length() - OTHER[0]) / (OTHER[1] - OTHER[0])).clamp(0.0, 1.0)
        };
        // Jaws have the beard that the chin has, and no skin has its tone.
        let facings = &self.facings;
        let of = |is_one: &dyn Fn(f32) -> bool| {
            let facing = |least: f64| -> Vec<DVec3> {
                let all = tones.iter().filter(|t| facings[t.0] > least);
                let all = all.filter(|t| is_one(parts.mean[t.0].y));
                all.map(|t| t.1).collect()
            };
            // The chin of a head that is turned has little that faces the camera.
            let mut all = facing(INNER);
            if all.len() < FEWEST {
                all = facing(FACING[1]);
            }
            (!all.is_empty()).then(|| median(all.into_iter()))
        };
        // Of nothing that is seen nothing is another tone.
        let Some(all) = of(&|_| true) else {
            return;
        };
        // Who wears a mask shows no chin.
        let beard = of(&|y| y < nose - CHIN).unwrap_or(all);
        let cheeks = of(&|y| y > nose).unwrap_or(all);
        let bearded = BRIGHTNESS.dot(cheeks - beard) > BEARDED;
        let usual = if bearded { cheeks } else { all };
        if bearded {
            self.beard_below = nose;
        }
        // Foreheads shine: what is brighter there is hair only when it is by much.
        let hair = |tone: DVec3| {
            let shine = BRIGHTNESS.dot(tone - usual) > 0.0;
            away(
                if shine {
                    usual + SHINE * (tone - usual)
                } else {
                    tone
                },
                usual,
            )
        };
        let arches: Vec<Vec3> = places("ibug_17"..="ibug_26").collect();
        let curtains = |is_one: &dyn Fn(Vec3) -> bool| {
            Curtains::new(tones.iter().filter_map(|&(v, tone)| {
                let at = parts.mean[v];
                let darker = BRIGHTNESS.dot(usual - tone) > 0.0;
                let is_hair = darker && away(tone, usual) > 0.5;
                (is_one(at) && at.z > corners - TEMPLE[0][1]).then_some((at, is_hair))
            }))
        };
        let over = |at: Vec3| at.y - line(&arches, at.x);
        // Inner ends of brows are lower than their arches, and hair may hang down to them.
        let fringes = curtains(&|at| over(at) > ARCH);
        let curtains = curtains(&|at| at.y - brows > FOREHEAD[0]);
        let is_fringe = |at: Vec3| {
            let hangs = curtains.lowest(at).zip(fringes.lowest(at));
            let hangs = hangs.is_some_and(|(above, low)| above - low < curtains::BELOW);
            hangs && over(at) > ARCH && fringes.cover(at)
        };
        let mut hairless: Vec<f64> = covered.iter().map(|&c| f64::from(!c)).collect();
        for (v, tone) in tones {
            let outer = ((INNER - self.facings[v]) / (INNER - FACING[1])).clamp(0.0, 1.0);
            let at = parts.mean[v];
            let above = within(FOREHEAD, at.y - brows);
            let beside = within(TEMPLE[0], corners - at.z) * within(TEMPLE[1], at.y - nose);
            let mut off = away(tone, usual);
            if bearded && at.y < nose {
                off = off.min(away(tone, beard));
            }
            self.trust[v] *= 1.0 - off * outer;
            hairless[v] = (1.0 - off * f64::from(beside)) * (1.0 - hair(tone) * f64::from(above));
            if curtains.cover(at) || is_fringe(at) {
                hairless[v] = 0.0;
            }
        }
        let hair_of_brows = self.brow_hair();
        let off_brows = |v: usize| {
            let mut near = hair_of_brows.iter();
            near.all(|p| p.distance(parts.mean[v]) > BESIDE_BROW)
        };
        let contrasts: Vec<f64> = (0..hairless.len())
            .filter(|&v| hairless[v] < 0.5 && self.facings[v] > STRANDS_FACING && off_brows(v))
            .filter_map(|v| self.contrast(v))
            .collect();
        let has_strands = contrasts.len() > FEWEST_STRANDS
            && middle(contrasts).is_some_and(|contrast| contrast > STRANDS);
        let neighbours = self.neighbours();
        // Brows are beside the forehead, and theirs is worn.
        let brow = |v: usize| {
            if is_fringe(parts.mean[v]) {
                return 0.0;
            }
            let near = hair_of_brows.iter().map(|p| p.distance(parts.mean[v]));
            let near = near.fold(f32::INFINITY, f32::min);
            f64::from(1.0 - within([BROW, 1.5 * BROW], near))
        };
        let brow: Vec<f64> = (0..hairless.len()).map(brow).collect();
        // The edge of hair is half skin.
        let spread = |values: &mut Vec<f64>| {
            let before = values.clone();
            for (v, near) in neighbours.iter().enumerate() {
                let least = near.iter().map(|&n| before[n as usize]);
                values[v] = least.fold(before[v], f64::min).max(brow[v].min(before[v]));
            }
        };
        for _ in 0..EDGE {
            spread(&mut hairless);
        }
        let mut close = hairless.clone();
        for _ in 0..EDGE {
            spread(&mut close);
        }
        // From there on belief grows steadily: what is filled has no border.
        let mut soft = close.clone();
        for _ in 0..SOFT {
            let before = soft.clone();
            for (v, near) in neighbours.iter().enumerate().filter(|n| !n.1.is_empty()) {
                let sum: f64 = near.iter().map(|&n| before[n as usize]).sum();
                soft[v] = (before[v] + sum / near.len() as f64) / 2.0;
            }
        }
        for v in 0..hairless.len() {
            self.hidden[v] |= has_strands && hairless[v] < 0.5;
            self.trust[v] *= hairless[v].min(soft[v]).max(brow[v].min(hairless[v]));
            self.strands[v] = (1.0 - close[v].min(soft[v])) * (1.0 - brow[v]);
        }
    }

    /// How much of what is seen at a mix of three vertices is skin, where it is filled with a colour: single hairs
    /// fall farther than the rest, and at the outline what is behind it shines in.
    pub fn unmixed(&self, corners: [usize; 3], share: [f64; 3], seen: DVec3, fill: DVec3) -> f64 {
        let mean =
            |of: &dyn Fn(usize) -> f64| -> f64 { (0..3).map(|i| share[i] * of(corners[i])).sum() };
        let near = (2.0 * mean(&|v| self.strands[v])).min(1.0);
        let facing = mean(&|v| self.facings[v]);
        let outer = ((INNER - facing) / (INNER - FACING[0])).clamp(0.0, 1.0);
        if near + outer == 0.0 {
            return 1.0;
        }
        let brightness = |c: DVec3| c.dot(BRIGHTNESS).max(1e-3).ln();
        let darker = brightness(fill) - brightness(seen);
        let off = |by: f64, [none, all]: [f64; 2]| ((by - none) / (all - none)).clamp(0.0, 1.0);
        (1.0 - near * off(darker, STRAND)) * (1.0 - outer * off(-darker, RIM))
    }

    /// px a mm at a point.
    pub fn scale(&self, p: DVec3) -> f64 {
        self.camera.focal / self.camera.to_camera(p).z
    }

    /// The light within a mm of a point.
    pub fn lit(&self, p: DVec3) -> Option<DVec3> {
        let light = self.image.mean(self.camera.project(p), self.scale(p))?;
        Some(light * self.exposure)
    }

    /// By how much the logarithm of the light at a vertex differs from the mean of that on two sides of it, along the
    /// direction in which that is more: by strands, and not by shading, which changes evenly.
    pub fn contrast(&self, v: usize) -> Option<f64> {
        let place = self.places[v];
        let (across, along) = self.normals[v].as_dvec3().any_orthonormal_pair();
        let brightness = |p: DVec3| Some(self.lit(p)?.dot(BRIGHTNESS).max(BLACK).ln());
        let own = brightness(place)?;
        let off = |way: DVec3| {
            let [a, b] = [1.0, -1.0].map(|side| brightness(place + way * side * ACROSS_STRANDS));
            Some((own - (a? + b?) / 2.0).abs())
        };
        Some(off(across)?.max(off(along)?))
    }

    /// Does not believe what glasses cover, if they are worn: around the eyes all that is darker or brighter than
    /// skin is their frame, or lens, or its shadow.
    fn doubt_glasses(&mut self) {
        if !self.bridged() {
            return;
        }
        let parts = self.model.parts();
        let at = |i: u32| {
            let landmark = self.landmark(&format!("ibug_{i:02}"));
            landmark.map_or(Vec3::NAN, |l| l.position(&parts.mean))
        };
        let top = (17..=26).map(|i| at(i).y).fold(f32::NEG_INFINITY, f32::max) + LENS[0];
        let [bottom, nose] = [at(30).y - LENS[1], at(29).y];
        let near =
            |p: Vec3, points: &[Vec3], reach: f32| points.iter().any(|c| c.distance(p) < reach);
        let (hair, eyes) = (self.brow_hair(), (36..=47).map(at).collect::<Vec<_>>());
        let tones = self.seen_tones();
        let own = BRIGHTNESS.dot(median(
            tones
                .iter()
                .filter(|t| self.facings[t.0] > INNER)
                .map(|t| t.1),
        ));
        // What glasses may cover: not nostrils.
        let around = |p: Vec3| p.y < top && p.y > bottom && (p.x.abs() > NOSE || p.y > nose);
        let mut covered = vec![false; self.trust.len()];
        let mut counts = [[0, 0]; 2];
        for &(v, tone) in &tones {
            let p = parts.mean[v];
            if !around(p) {
                continue;
            }
            let off = BRIGHTNESS.dot(tone) - own;
            let is_off = !(-FRAME[0]..=FRAME[1]).contains(&off);
            let [lid, brow] = [near(p, &eyes, LID), near(p, &hair, BROW)];
            covered[v] = is_off && !lid && !brow;
            if near(p, &eyes, SOCKET) && !brow {
                let side = &mut counts[usize::from(p.x > 0.0)];
                side[usize::from(is_off)] += 1;
            }
        }
        // Behind a dark lens nothing is seen, lids and brows among it.
        for &(v, _) in &tones {
            let p = parts.mean[v];
            let [clear, dark] = counts[usize::from(p.x > 0.0)];
            covered[v] |= dark > clear && around(p) && near(p, &eyes, SOCKET);
        }
        self.dark_lenses = counts.iter().any(|[clear, dark]| dark > clear);
        let neighbours = self.neighbours();
        for _ in 0..EDGE {
            let before = covered.clone();
            for (own, near) in covered.iter_mut().zip(&neighbours) {
                *own |= near.iter().any(|&n| before[n as usize]);
            }
        }
        for (v, covered) in covered.into_iter().enumerate() {
            if covered {
                self.trust[v] = 0.0;
            }
            // Through a lens all is in another place and another light.
            self.hidden[v] |= around(parts.mean[v]);
        }
    }

    /// Whether a bar crosses the nose between the eyes, below the brows: all along it is darker, or brighter, than what
    /// is right above and right below.
    fn bridged(&self) -> bool {
        let at = |i: u32| -> Option<DVec2> {
            let stencil = &self.landmark(&format!("ibug_{i:02}"))?.stencil;
            let each = stencil.iter();
            Some(each.map(|&(v, w)| self.seen[v as usize] * w).sum())
        };
        let (Some(corners), Some(root)) = (
            [36, 39, 42, 45]
                .map(at)
                .into_iter()
                .collect::<Option<Vec<_>>>(),
            at(27),
        ) else {
            return false;
        };
        let [right, left] = [0, 2].map(|i| (corners[i] + corners[i + 1]) / 2.0);
        let mm = (left - right) / PUPILS;
        let up = DVec2::new(mm.y, -mm.x);
        // The nose is ahead of the eyes: of who looks aside its root is not in the middle between them.
        let middle = (left + right) / 2.0;
        let root = (root - middle).dot(mm) / mm.length_squared();
        let light = |x: f64, y: f64| {
            let light = self
                .image
                .mean(middle + mm * x + up * y, 0.5 * mm.length())?;
            Some((light.dot(BRIGHTNESS) * self.exposure).max(1e-3).ln())
        };
        // Means across the nose: noise of dark photos, and moles, are in none of it alone.
        let differs = |x: f64, y: f64, half: f64| -> Option<f64> {
            let across = steps(-BRIDGE_HALF, BRIDGE_HALF, BRIDGE_STEP).map(|beside| {
                let [above, bar, below] = [half, 0.0, -half].map(|off| light(x + beside, y + off));
                let [above, below] = [above? - bar?, below? - bar?];
                let [dark, bright] = [above.min(below), (-above).min(-below)];
                Some(DVec2::new(dark, bright).min(DVec2::splat(BRIDGE_MOST)))
            });
            let all: Option<Vec<DVec2>> = across.collect();
            let all = all?;
            Some((all.iter().sum::<DVec2>() / all.len() as f64).max_element())
        };
        steps(BRIDGE_HEIGHTS[0], BRIDGE_HEIGHTS[1], 0.5).any(|y| {
            BRIDGE_HALVES.iter().any(|&half| {
                BRIDGE_ASIDE
                    .iter()
                    .any(|&aside| differs(root + aside, y, half).is_some_and(|d| d > BRIDGE_DEPTH))
            })
        })
    }

    /// A landmark by its name; models need not have all.
    pub fn landmark(&self, name: &str) -> Option<&'a Landmark> {
        let landmarks = &self.model.parts().landmarks;
        landmarks.iter().find(|l| l.name == name)
    }

    /// Where the hair of brows grows on the mean head, mm; nowhere on a model without their points.
    pub fn brow_hair(&self) -> Vec<Vec3> {
        let mean = &self.model.parts().mean;
        let points: Option<Vec<Vec3>> = (17..=26)
            .map(|i| Some(self.landmark(&format!("ibug_{i:02}"))?.position(mean)))
            .collect();
        match points.and_then(|points| <[Vec3; 10]>::try_from(points).ok()) {
            Some(points) => brow_hair(points, mean).to_vec(),
            None => Vec::new(),
        }
    }

    /// The vertices around each of the skin's.
    pub fn neighbours(&self) -> Vec<Vec<u32>> {
        let topology = &self.model.parts().topology;
        let all = topology.triangles();
        let mut neighbours = vec![Vec::new(); self.trust.len()];
        for part in topology.parts.iter().filter(|p| p.name == "skin") {
            for &[a, b, c] in &all[part.first as usize..(part.first + part.count) as usize] {
                // Each edge inside has a triangle on either side, and counts once from each.
                for [from, to] in [[a, b], [b, c], [c, a]] {
                    neighbours[from as usize].push(to);
                }
            }
        }
        neighbours
    }
}

/// How high a line through points, from the subject's right to the left, is at this x; beyond its ends as high as these.
fn line(points: &[Vec3], x: f32) -> f32 {
    let next = points.partition_point(|p| p.x <= x);
    match (next.checked_sub(1).map(|i| points[i]), points.get(next)) {
        (Some(from), Some(to)) => from.y + (x - from.x) / (to.x - from.x) * (to.y - from.y),
        (Some(end), None) => end.y,
        (None, end) => end.map_or(f32::NEG_INFINITY, |end| end.y),
    }
}

/// By how much more light a photo is exposed as most are, so that its brightest parts are at least [`BRIGHT`]. Nobody
/// knows a dark skin from a dark photo by the skin alone; white shirts and walls, eyes and lamps tell. Only those
/// around the head (`seen`, px): a portrait on a large dark page is not dark. Where nothing is, as around pictures that
/// were cut out, nothing tells.
fn exposure(image: &Image, seen: impl Iterator<Item = DVec2>) -> f64 {
    let (low, high) = seen.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| {
        (low.min(p), high.max(p))
    });
    let around = NEAR * (high - low).max_element();
    let size = DVec2::new(image.width as f64, image.height as f64);
    let within = |p: DVec2| p.clamp(DVec2::ZERO, size).as_usizevec2();
    let (first, end) = (within(low - around), within(high + around));
    let (mut counts, mut all) = ([0_usize; 256], 0);
    for row in image
        .rgba
        .chunks_exact(4 * image.width)
        .take(end.y)
        .skip(first.y)
    {
        let pixels = row[4 * first.x..4 * end.x].chunks_exact(4);
        for pixel in pixels.filter(|p| p[3] > 0) {
            let brightness = linear([pixel[0], pixel[1], pixel[2]]).dot(BRIGHTNESS);
            counts[(brightness * 255.0) as usize] += 1;
            all += 1;
        }
    }
    let mut above = 0;
    let brightest = (0..256).rev().find(|&i| {
        above += counts[i];
        above as f64 > BRIGHTEST * f64::from(all)
    });
    let brightest = (brightest.unwrap_or(255) as f64 + 0.5) / 255.0;
    (BRIGHT / brightest).clamp(1.0, MOST_EXPOSED)
}

/// How much each vertex's colour is believed, 0..=1, and the cosine of the angle at which it is seen.
fn trust(
    model: &FaceModel,
    camera: &Camera,
    places: &[DVec3],
    normals: &[Vec3],
) -> Result<[Vec<f64>; 2]> {
    let parts = model.parts();
    let sight = Sight::new(camera, places, &parts.topology.triangles())
        .ok_or_else(|| Error::Mismatch("no face is seen in the photo".into()))?;
    let points = features(model);
    let mut trust = vec![0.0; places.len()];
    let mut facings = vec![0.0; places.len()];
    for v in bare(model) {
        let v = v as usize;
        let away = points.iter().map(|p| p.distance(parts.mean[v]));
        let away = away.fold(f32::INFINITY, f32::min);
        let near = ((AROUND[0] - away) / (AROUND[0] - AROUND[1])).clamp(0.0, 1.0);
        let facing = sight
            .facing(places[v], normals[v].as_dvec3())
            .unwrap_or(0.0);
        facings[v] = facing;
        let facing = ((facing - FACING[0]) / (FACING[1] - FACING[0])).clamp(0.0, 1.0);
        let beside = sight.beside(places[v], BESIDE[1]);
        let beside = ((beside - BESIDE[0]) / (BESIDE[1] - BESIDE[0])).clamp(0.0, 1.0);
        trust[v] = f64::from(near) * facing * beside;
    }
    Ok([trust, facings])
}

/// From one number to another, both included.
fn steps(from: f64, to: f64, step: f64) -> impl Iterator<Item = f64> {
    (0..=((to - from) / step).round() as usize).map(move |i| from + step * i as f64)
}
