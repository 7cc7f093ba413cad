//! What a photo tells of a person beside the shape: the colours of skin, irises and hair, how far
//! the hair stands off and hangs down, and a beard.
//!
//! The skin's colour is its usual albedo, as in a [`Texture`](super::Texture); that of irises is in `iris`. Hair is what is person and not skin where scalps are; what is around the
//! head, downwards beside the face until it ends, outwards from the head, and on the forehead, is compared
//! with both.

use glam::{DVec2, DVec3, Vec3};

use super::sight::Sight;
use super::skin::{BLACK, Skin};
use super::{Camera, Image, Light};
use super::{median, middle};
use crate::srgb::BRIGHTNESS;
use crate::{FaceModel, Result};

/// What a photo tells of a person beside the shape. Colours are linear light, in the white balance and, unless that
/// is too dark, the exposure of the photo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Looks {
    /// The skin's albedo.
    pub skin: DVec3,
    /// The irises' albedo; `None` when too little of the eyes is seen, through dark glasses
    /// or in the dark.
    pub irises: Option<DVec3>,
    /// How much darker than the cheeks the skin is where a beard grows: the logarithm of the brightness.
    pub beard: f64,
    /// The albedo of a beard: of hair and of the skin between; `None` without one.
    pub beard_colour: Option<DVec3>,
    /// `None` when there is none, or the head is not seen above the forehead.
    pub hair: Option<Hair>,
}

/// The hair on a head.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hair {
    /// Its albedo.
    pub colour: DVec3,
    /// How much of the scalp that is seen it covers, 0 to 1.
    pub cover: f64,
    /// How far it stands off the head, mm.
    pub off: f64,
    /// How far it hangs beside the face: from the tragion down, mm, at most 190; 0 when it ends above.
    pub hangs: f64,
    /// How much of the forehead it covers, 0 to 1.
    pub forehead: f64,
    /// How much more of its left half than of its right one, -1 to 1; 0 when one of them is not seen.
    pub aside: f64,
    /// How its strands over the forehead lean, -1 to 1: 1 is down to the left, 0 straight down, across or every way.
    pub lean: f64,
}

/// How far hair is followed down beside the face, mm: to the shoulders.
const LOWEST: f64 = 190.0;

/// Of the scalp counts what is farther inside the hairline than this part of the forehead's height: hairlines
/// of people are elsewhere by as much.
const INSIDE: f32 = 0.14;
/// The usual hairline: at so many degrees around the head from the middle of the face, so high, where 0 is
/// the tragion and 1 the trichion.
const HAIRLINE: [[f32; 2]; 6] = [
    [0.0, 1.0],
    [36.0, 1.02],
    [51.0, 0.68],
    [71.0, 0.45],
    [85.0, 0.25],
    [180.0, 0.1],
];
/// The scalp is asked where the cosine of the angle at which it is seen is above this.
const FACING: f64 = 0.15;
/// Fewer vertices of it, or of an area of skin, tell nothing.
const FEWEST: usize = 12;
/// What is darker than the skin would be by this logarithm, or differs in hue (the logarithms of red and blue
/// over green), is no skin. Bald heads shine, so what is brighter is.
const DARKER: f64 = 0.45;
const OTHER_HUE: f64 = 0.3;
/// Light on the scalp within this factor of the usual is believed: the face, of which it is known, looks
/// elsewhere.
const UNUSUAL: f64 = 1.6;
/// A head whose scalp is covered less is bald.
const LEAST_COVER: f64 = 0.3;
/// Hair differs from its median by this logarithm at most: it shines and has shadows.
const VARIES: f64 = 1.8;
/// Steps in which hair is followed, mm, and how many in a row may be none.
const STEP: f64 = 4.0;
const GAPS: usize = 2;
/// Beside the face hair is looked for so far outside of the tragion, mm.
const BESIDE: [f64; 7] = [-6.0, 2.0, 10.0, 18.0, 26.0, 34.0, 42.0];
/// There it is followed from so far above the tragion, mm.
const ABOVE_EAR: f64 = 32.0;
/// A head is turned when the sine of the camera's direction is above this.
const TURNED: f64 = 0.3;
/// Skin that is darker than the cheeks by this logarithm has a beard.
const BEARDED: f64 = 0.4;
/// Upwards from the head it is followed at so many mm to the subject's left.
const CROWN: [f64; 5] = [-30.0, -15.0, 0.0, 15.0, 30.0];
/// Sideways from the head it is followed so many mm below the trichion.
const TEMPLES: [f64; 3] = [-20.0, 0.0, 20.0];
/// No hair stands off farther, mm.
const FARTHEST_OFF: f64 = 120.0;
/// Hair that stands off less is cropped, mm.
const CROPPED: f64 = 6.0;
/// Hair of which a photo does not show how far it stands off does so as most people's, mm.
const USUAL_OFF: f64 = 12.0;
/// Fewer places that show it do not.
const FEWEST_PLACES: usize = 4;
/// Hair that hangs beside the face by this, mm, or covers this part of the forehead, is not cropped.
const LONG: f64 = 20.0;
const FRINGE: f64 = 0.35;
/// Strands are told by the light so far to both sides, mm, and begin so far behind the hairline.
const BESIDE_STRAND: f64 = 1.5;
const BEHIND_HAIRLINE: f64 = 15.0;
/// Less contrast than this logarithm is no strand's.
const FAINT: f64 = 0.03;
/// A scalp with less, in the median, shines. Those of bald heads that the page drew have up to 0.022, hair that is brighter
/// than the skin 0.11 and more.
const SMOOTH: f64 = 0.05;
/// Nor does it shine everywhere: of those heads two thirds did at most.
const MOST_SHINY: f64 = 0.75;
/// With fewer px a mm strands are not seen.
const STRANDS_SEEN: f64 = 1.0;
impl Looks {
    /// Of a face (positions in mm, unit normals) that a camera sees in an image, where the middles of the irises of the subject's right
    /// and left eye are (px), if that is known.
    ///
    /// # Errors
    /// When the mesh is not the model's, or the face is not in the photo.
    pub fn of(
        model: &FaceModel,
        camera: &Camera,
        light: &Light,
        (places, normals): (&[DVec3], &[Vec3]),
        image: &Image,
        irises: Option<[DVec2; 2]>,
    ) -> Result<Self> {
        let skin = Skin::new(model, camera, light, (places, normals), image)?;
        let own = skin.own();
        let head = Head { skin: &skin, own };
        let (beard, beard_colour) = head.beard();
        let bearded = beard > BEARDED;
        Ok(Self {
            skin: own,
            irises: head.irises(irises),
            beard,
            beard_colour: beard_colour.filter(|_| bearded),
            hair: head.hair(bearded),
        })
    }
}

/// A head in a photo.
pub(super) struct Head<'a> {
    pub skin: &'a Skin<'a>,
    /// The skin's albedo.
    own: DVec3,
}

/// What hair and skin look like in a photo, linear light.
struct Tones {
    hair: DVec3,
    skin: DVec3,
}

impl Tones {
    /// Whether this light is nearer to the hair's than to the skin's.
    fn is_hair(&self, light: DVec3) -> bool {
        let tone = logarithm(light);
        let [hair, skin] = [self.hair, self.skin].map(|c| (tone - logarithm(c)).length());
        hair < VARIES && hair < skin
    }

    /// How much hair this light is a mixture of, the rest being skin.
    fn share(&self, light: DVec3) -> f64 {
        let across = self.skin - self.hair;
        let along = (self.skin - light).dot(across) / across.length_squared().max(1e-9);
        along.clamp(0.0, 1.0)
    }
}

fn logarithm(light: DVec3) -> DVec3 {
    light.max(DVec3::splat(BLACK)).map(f64::ln)
}

/// The logarithms of red and blue over green.
fn hue(logarithm: DVec3) -> DVec2 {
    DVec2::new(logarithm.x - logarithm.y, logarithm.z - logarithm.y)
}

impl Head<'_> {
    /// A named point on the head in the photo, and on the mean head.
    pub fn point(&self, name: &str) -> Option<[DVec3; 2]> {
        let landmark = self.skin.landmark(name)?;
        let stencil = landmark.stencil.iter();
        let here = stencil
            .map(|&(v, w)| self.skin.places[v as usize] * w)
            .sum();
        let mean = &self.skin.model.parts().mean;
        Some([here, landmark.position(mean).as_dvec3()])
    }

    /// The shading of a vertex over the usual one, where that is believed.
    fn shade(&self, v: usize) -> DVec3 {
        let shade = self.skin.light.shade(self.skin.normals[v].as_dvec3()) / self.skin.usual;
        shade.clamp(DVec3::splat(1.0 / UNUSUAL), DVec3::splat(UNUSUAL))
    }

    /// The median albedo of the skin that is seen within some mm of points on the mean head.
    fn albedo_near(&self, points: &[DVec3], reach: f64) -> Option<DVec3> {
        let mean = &self.skin.model.parts().mean;
        let near = |v: usize| {
            let p = mean[v].as_dvec3();
            points.iter().any(|q| q.distance(p) < reach)
        };
        let each = (0..mean.len()).filter(|&v| self.skin.facings[v] > 0.4 && near(v));
        let seen: Vec<DVec3> = each.filter_map(|v| self.skin.vertex(v)).collect();
        (seen.len() >= FEWEST).then(|| median(seen.into_iter()))
    }

    /// How much darker than the cheeks it is where a beard grows, and its albedo there.
    fn beard(&self) -> (f64, Option<DVec3>) {
        let between = |a: &str, b: &str| Some((self.point(a)?[1] + self.point(b)?[1]) / 2.0);
        let brightness = |points: [Option<DVec3>; 2], reach: f64| {
            let points: Vec<DVec3> = points.into_iter().flatten().collect();
            let albedo = self.albedo_near(&points, reach)?;
            Some((albedo.dot(BRIGHTNESS).max(BLACK).ln(), albedo))
        };
        let cheeks = brightness(
            [between("ibug_41", "ibug_48"), between("ibug_46", "ibug_54")],
            12.0,
        );
        let lip = brightness(
            [between("ibug_33", "ibug_50"), between("ibug_33", "ibug_52")],
            5.0,
        );
        let chin = brightness([between("ibug_57", "ibug_08"), None], 12.0);
        // Who has turned, or looks down, shows it from the side.
        let chin = chin.or_else(|| {
            let beside = [between("ibug_48", "ibug_05"), between("ibug_54", "ibug_11")];
            brightness(beside, 12.0)
        });
        match (cheeks, lip, chin) {
            (Some((cheeks, _)), Some((lip, _)), Some((chin, colour))) => {
                ((cheeks - lip.max(chin)).max(0.0), Some(colour))
            }
            _ => (0.0, None),
        }
    }

    fn hair(&self, bearded: bool) -> Option<Hair> {
        let [tragion_left, tragion] = self.point("tragion left")?;
        let tragion_right = self.point("tragion right")?[0];
        let trichion = self.point("trichion")?[1];
        let mean = &self.skin.model.parts().mean;
        let topology = &self.skin.model.parts().topology;
        let sight = Sight::new(self.skin.camera, self.skin.places, &topology.triangles())?;
        let tall = (trichion.y - tragion.y) as f32;
        let axis = tragion.z as f32 + 0.11 * tall;
        let inside =
            |p: Vec3| (p.y - tragion.y as f32) / tall - hairline(p.x.atan2(p.z - axis).abs());
        let mut samples = Vec::new();
        let (mut bright, mut contrasts) = (Vec::new(), Vec::new());
        let mut bare = 0;
        for v in topology.part_vertices("skin") {
            let v = v as usize;
            if inside(mean[v]) < INSIDE {
                continue;
            }
            let facing = sight.facing(self.skin.places[v], self.skin.normals[v].as_dvec3());
            let Some(light) = facing
                .filter(|&f| f > FACING)
                .and(self.skin.lit(self.skin.places[v]))
            else {
                continue;
            };
            let skin = logarithm(self.own * self.shade(v));
            let tone = logarithm(light);
            let darker = skin.dot(BRIGHTNESS) - tone.dot(BRIGHTNESS);
            let hue = (hue(tone) - hue(skin)).length();
            let sample = (light, light / self.shade(v));
            match darker > DARKER || hue > OTHER_HUE {
                true if darker < 0.0 => {
                    bright.push(sample);
                    contrasts.extend(self.skin.contrast(v));
                }
                true => samples.push(sample),
                false => bare += 1,
            }
        }
        // What is brighter than skin and of another hue is fair or grey hair, or a bald head that shines.
        let is_seen = self.skin.scale(self.point("trichion")?[0]) > STRANDS_SEEN;
        let is_smooth = middle(contrasts).is_some_and(|contrast| contrast < SMOOTH);
        let all = samples.len() + bright.len() + bare;
        let some = samples.len() + bright.len();
        match is_seen && is_smooth && (some as f64) < MOST_SHINY * all as f64 {
            true => bare += bright.len(),
            false => samples.extend(bright),
        }
        let count = samples.len() + bare;
        let cover = samples.len() as f64 / count.max(1) as f64;
        if samples.len() < FEWEST || cover < LEAST_COVER {
            return None;
        }
        let tones = Tones {
            hair: median(samples.iter().map(|s| s.0)),
            skin: self.own,
        };
        let off = self.off(&tones);
        let hangs = [(tragion_left, 1.0), (tragion_right, -1.0)]
            .map(|(p, side)| self.hangs(p, side, bearded, &tones));
        let hangs = hangs[0].max(hangs[1]);
        let [right, left] = self.forehead(&tones);
        let forehead = (right.sum + left.sum) / (right.count + left.count).max(1) as f64;
        let aside = match right.count.min(left.count) < FEWEST {
            true => 0.0,
            false => left.sum / left.count as f64 - right.sum / right.count as f64,
        };
        // Skin shows between short hairs. What hangs is longer, wherever the photo ends.
        if off < CROPPED && hangs < LONG && forehead < FRINGE {
            let bright = |s: &(DVec3, DVec3)| s.0.dot(BRIGHTNESS);
            samples.sort_unstable_by(|a, b| bright(a).total_cmp(&bright(b)));
            samples.truncate(samples.len() / 2);
        }
        Some(Hair {
            colour: median(samples.into_iter().map(|s| s.1)),
            cover,
            off,
            hangs,
            forehead,
            aside,
            lean: self.lean(&tones),
        })
    }

    /// How far hair hangs down from beside an ear. Of a head that is turned the nape is seen there, so only
    /// what hangs before the ear counts; beside a beard only what hangs outside of it.
    fn hangs(&self, tragion: DVec3, side: f64, bearded: bool, tones: &Tones) -> f64 {
        let to_eye = (self.skin.camera.position() - tragion).normalize_or_zero();
        let turned = to_eye.x.abs() > TURNED;
        let places = BESIDE.iter().filter(|&&b| {
            if turned {
                b < 6.0
            } else {
                !bearded || b > 16.0
            }
        });
        let places: Vec<f64> = places.copied().collect();
        let hair_at = |down: f64| {
            let found = places.iter().filter(|&&beside| {
                let p = tragion + DVec3::new(side * beside, -down, 12.0);
                self.skin.lit(p).is_some_and(|light| tones.is_hair(light))
            });
            found.count() > 1
        };
        let steps = (LOWEST / STEP) as usize;
        let from = -ABOVE_EAR;
        (followed(steps, |i| hair_at(from + i as f64 * STEP)) + from).max(0.0)
    }

    /// How far hair stands off the head, seen against what is behind it: the median of some places above
    /// the crown and beside the temples.
    fn off(&self, tones: &Tones) -> f64 {
        let away = |from: DVec3, along: DVec3| {
            let steps = (FARTHEST_OFF / STEP) as usize;
            let at = |i: usize| from + along * (i as f64 * STEP);
            let far = followed(steps, |i| {
                self.skin
                    .lit(at(i))
                    .is_some_and(|light| tones.is_hair(light))
            });
            // Where the photo ends hair goes on that nobody sees.
            let ends = (far / STEP) as usize;
            self.skin
                .image
                .contains(self.skin.camera.project(at(ends)))
                .then_some(far)
        };
        let mut all = Vec::new();
        let mut farthest = |along: DVec3, near: &dyn Fn(DVec3) -> bool| {
            let places = self.skin.places.iter().copied().filter(|&p| near(p));
            let out = places.max_by(|a, b| a.dot(along).total_cmp(&b.dot(along)));
            all.extend(out.and_then(|out| away(out, along)));
        };
        for x in CROWN {
            farthest(DVec3::Y, &|p| (p.x - x).abs() < 4.0);
        }
        let top = self.point("trichion").map_or(0.0, |p| p[0].y);
        for down in TEMPLES {
            for side in [DVec3::X, DVec3::NEG_X] {
                farthest(side, &|p| (p.y - top + down).abs() < 4.0);
            }
        }
        all.sort_unstable_by(f64::total_cmp);
        match all.len() < FEWEST_PLACES {
            true => USUAL_OFF,
            false => all[all.len() / 2],
        }
    }

    /// The vertices of the forehead that are seen, up to so far above the hairline, mm.
    fn on_forehead(&self, above: f64) -> Vec<usize> {
        let found = [
            self.point("trichion"),
            self.point("ibug_19"),
            self.point("ibug_24"),
        ];
        let [Some(trichion), Some(right), Some(left)] = found else {
            return Vec::new();
        };
        let brows = right[1].y.max(left[1].y);
        let mean = &self.skin.model.parts().mean;
        let across = left[1].x;
        let on_it = |p: &Vec3| {
            let p = p.as_dvec3();
            let within = brows + 9.0..trichion[1].y + above;
            p.x.abs() < across && p.z > 0.0 && within.contains(&p.y)
        };
        (0..mean.len())
            .filter(|&v| on_it(&mean[v]) && self.skin.facings[v] > 0.4)
            .collect()
    }

    /// How much of the forehead's right and left halves hair covers.
    fn forehead(&self, tones: &Tones) -> [Covered; 2] {
        let mut halves = [Covered::default(); 2];
        let mean = &self.skin.model.parts().mean;
        for v in self.on_forehead(-8.0) {
            if let Some(light) = self.skin.lit(self.skin.places[v]) {
                let half = &mut halves[usize::from(mean[v].x > 0.0)];
                half.sum += tones.share(light / self.shade(v));
                half.count += 1;
            }
        }
        halves
    }

    /// How strands over the forehead lean, as [`Hair::lean`]: light varies across strands and not along them, so its
    /// gradients there tell their direction (the structure tensor; Bigun and Granlund 1987).
    fn lean(&self, tones: &Tones) -> f64 {
        let brightness = |p: DVec3| {
            let light = self.skin.lit(p)?;
            Some(light.dot(BRIGHTNESS).max(BLACK).ln())
        };
        let gradients: Vec<DVec2> = (self.on_forehead(BEHIND_HAIRLINE).into_iter())
            .filter_map(|v| {
                let p = self.skin.places[v];
                let is_hair = tones.share(self.skin.lit(p)? / self.shade(v)) > 0.5;
                let along = |axis: DVec3| {
                    let step = axis * BESIDE_STRAND;
                    Some(brightness(p + step)? - brightness(p - step)?)
                };
                is_hair.then_some(DVec2::new(along(DVec3::X)?, along(DVec3::Y)?))
            })
            .collect();
        if gradients.len() < FEWEST {
            return 0.0;
        }
        // All of it may be in a light that falls off.
        let count = gradients.len() as f64;
        let mean = gradients.iter().sum::<DVec2>() / count;
        let (mut across, mut all) = (0.0, count * FAINT * FAINT);
        for gradient in gradients.iter().map(|g| g - mean) {
            across += 2.0 * gradient.x * gradient.y;
            all += gradient.length_squared();
        }
        across / all
    }
}

/// What hair covers of some vertices.
#[derive(Debug, Default, Clone, Copy)]
struct Covered {
    /// The shares of hair at them, in sum.
    sum: f64,
    /// How many vertices they are.
    count: usize,
}

/// How far something goes on without a gap, mm.
fn followed(steps: usize, is_there: impl Fn(usize) -> bool) -> f64 {
    let (mut last, mut gap) = (0, 0);
    for i in 0..steps {
        match is_there(i) {
            true => (last, gap) = (i + 1, 0),
            false => gap += 1,
        }
        if gap > GAPS {
            break;
        }
    }
    last as f64 * STEP
}

/// How high the hairline is at an angle from the middle of the face (radians, not below 0).
fn hairline(angle: f32) -> f32 {
    let angle = angle.to_degrees();
    let next = HAIRLINE
        .iter()
        .position(|p| p[0] >= angle)
        .unwrap_or(HAIRLINE.len() - 1)
        .max(1);
    let [from, to] = [HAIRLINE[next - 1], HAIRLINE[next]];
    let part = ((angle - from[0]) / (to[0] - from[0])).clamp(0.0, 1.0);
    from[1] + part * (to[1] - from[1])
}
