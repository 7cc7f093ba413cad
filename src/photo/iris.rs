//! The colour of irises in a photo.
//!
//! An iris is told beside the white of its eye, whose albedo is known: an eye lies deeper than the light on the
//! skin tells. Of the iris counts the ring around the pupil, at its height and below: there is neither the shadow
//! of the upper lid nor, most often, the window or the lamp that a cornea mirrors. Where the detector of points sees
//! an iris it is; else it is what is dark between the lids.

use glam::{DVec2, DVec3};

use super::looks::Head;
use super::median;
use super::skin::BLACK;
use crate::srgb::BRIGHTNESS;

/// An iris's radius, mm; people differ by a tenth.
const RADIUS: f64 = 5.9;
/// The ring of an iris that tells its colour, in its radius: outside of pupils, which are wider in the dark, and inside
/// of the dark ring around it.
const RING: [f64; 2] = [0.5, 0.85];
/// Where its white is looked for.
const WHITE: [f64; 2] = [1.25, 2.0];
/// From so far above the middle of the iris on, and to so far below it, in its radius; of the white, which the lower lid shades,
/// less far.
const ABOVE: f64 = 0.15;
const BELOW: f64 = 0.5;
const WHITE_BELOW: f64 = 0.35;
/// Lids are fitted no better than this, in an iris's radius.
const LIDS: f64 = 0.12;
/// Of the ring's places these, by brightness, are its colour: the darkest are of the pupil, the brightest mirror.
const MIDDLE: [f64; 2] = [0.3, 0.7];
/// Fewer places of the ring, or of the white, tell nothing.
const FEWEST: [usize; 2] = [6, 4];
/// In a photo that is darker by this factor than usual noise is as strong as the light of an iris.
const TOO_DARK: f64 = 5.0;
/// An iris whose radius is fewer px has no colour but that of lids and lashes.
const LEAST: f64 = 2.5;
/// So many places along an iris's radius tell its colour, or as many as there are px.
const ACROSS: f64 = 10.0;
/// The albedo of the white of the eye between lids.
const SCLERA: f64 = 0.55;
/// What the cornea before an iris mirrors of its surroundings.
const CORNEA: f64 = 0.02;
/// The albedo of the darkest irises.
const MELANIN: f64 = 0.01;
/// The brightness of the palest.
const PALEST: f64 = 0.3;
/// Where nothing is seen there, the logarithm by which the surroundings of an iris are brighter than it.
const LEAST_CONTRAST: f64 = 0.2;

/// An eye in a photo, px.
struct Eye {
    lids: Vec<DVec2>,
    /// An iris's radius to the subject's left and down, on the face.
    left: DVec2,
    down: DVec2,
}

impl Eye {
    /// A place in an eye, whose middle is here, in an iris's radius.
    fn place(&self, middle: DVec2, at: DVec2) -> DVec2 {
        middle + self.left * at.x + self.down * at.y
    }

    fn is_between_lids(&self, p: DVec2) -> bool {
        let after = self.lids[1..].iter().chain(&self.lids[..1]);
        let crossed = self.lids.iter().zip(after).filter(|(a, b)| {
            (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
        });
        crossed.count() % 2 == 1
    }

    /// Whether it is between the lids however they are fitted.
    fn is_open(&self, p: DVec2) -> bool {
        [LIDS, -LIDS]
            .iter()
            .all(|&off| self.is_between_lids(p + self.down * off))
    }
}

impl Head<'_> {
    /// The irises' albedo, in the photo's white balance; of the right and of the left one the middles, px, if they are known. `None` when too
    /// little of the eyes is seen.
    pub fn irises(&self, middles: Option<[DVec2; 2]>) -> Option<DVec3> {
        if self.skin.dark_lenses || self.skin.exposure > TOO_DARK {
            return None;
        }
        let eyes = [(36, 0), (42, 1)].map(|(first, i)| self.eye(first, middles.map(|m| m[i])));
        let (mut ring, mut white) = (Vec::new(), Vec::new());
        // Two eyes of a person are alike: what a lid or a lamp hides of one is seen in the other.
        for (iris, beside) in eyes.into_iter().flatten() {
            ring.extend(iris);
            white.extend(beside);
        }
        if ring.len() < FEWEST[0] || white.len() < FEWEST[1] {
            return None;
        }
        let by_brightness = |a: &DVec3, b: &DVec3| a.dot(BRIGHTNESS).total_cmp(&b.dot(BRIGHTNESS));
        ring.sort_unstable_by(by_brightness);
        let [from, to] = MIDDLE.map(|part| (part * ring.len() as f64).round() as usize);
        let ring = ring[from..to].iter().sum::<DVec3>() / (to - from) as f64;
        white.sort_unstable_by(by_brightness);
        // Corners are red, and lashes dark. What is left has the hue of skin beside it: it tells how much light there is.
        let white = median(white[white.len() / 2..].iter().copied()).dot(BRIGHTNESS);
        let albedo = ring / white.max(BLACK) * SCLERA - CORNEA;
        // Brighter than any iris is the lid.
        let is_iris = albedo.dot(BRIGHTNESS) < PALEST;
        is_iris.then(|| albedo.clamp(DVec3::splat(MELANIN), DVec3::ONE))
    }

    /// The light of the ring of an iris and of the white beside it, between six points around an eye, from the one of this number on.
    fn eye(&self, first: u32, middle: Option<DVec2>) -> Option<(Vec<DVec3>, Vec<DVec3>)> {
        let points: Option<Vec<DVec3>> = (first..first + 6)
            .map(|i| Some(self.point(&format!("ibug_{i}"))?[0]))
            .collect();
        let points = points?;
        let centre = points.iter().sum::<DVec3>() / 6.0;
        let across = |way: DVec3| {
            let [a, b] = [1.0, -1.0].map(|s| self.skin.camera.project(centre + way * s * RADIUS));
            (a - b) / 2.0
        };
        let eye = Eye {
            lids: points
                .iter()
                .map(|&p| self.skin.camera.project(p))
                .collect(),
            left: across(DVec3::X),
            down: across(-DVec3::Y),
        };
        if RADIUS * self.skin.scale(centre) < LEAST {
            return None;
        }
        let step = 1.0 / ACROSS.min(eye.down.length());
        let middle = middle.or_else(|| self.darkest_disc(&eye))?;
        Some((
            self.lights(&eye, middle, step, RING, BELOW),
            self.lights(&eye, middle, step, WHITE, WHITE_BELOW),
        ))
    }

    /// The light between lids so far from the middle of an iris, and down to so far below it, in its radius.
    fn lights(
        &self,
        eye: &Eye,
        middle: DVec2,
        step: f64,
        from_to: [f64; 2],
        below: f64,
    ) -> Vec<DVec3> {
        let [near, far] = from_to;
        let count = |length: f64| (length / step).floor() as i32;
        let places = (-count(ABOVE)..=count(below)).flat_map(|y| {
            (-count(far)..=count(far)).map(move |x| DVec2::new(f64::from(x), f64::from(y)) * step)
        });
        let places = places.filter(|at| (near..far).contains(&at.length()));
        let places = places
            .map(|at| eye.place(middle, at))
            .filter(|&p| eye.is_open(p));
        let wide = (step * eye.down.length()).max(1.0);
        places
            .filter_map(|p| Some(self.skin.image.mean(p, 0.5 * wide)? * self.skin.exposure))
            .collect()
    }

    /// The middle of the darkest disc beside something brighter, of which lids cover no more than the half.
    fn darkest_disc(&self, eye: &Eye) -> Option<DVec2> {
        let radius = eye.down.length();
        let step = (radius / ACROSS).max(1.0);
        let pixels = self.between_lids(eye, step);
        let mean = |inside: &dyn Fn(f64) -> bool, centre: DVec2| {
            let all = pixels.iter().filter(|p| inside(p.0.distance(centre)));
            let (sum, count) = all.fold((0.0, 0), |(s, n), p| (s + p.1.dot(BRIGHTNESS), n + 1));
            (count > 0).then(|| (sum / f64::from(count), count))
        };
        let least = 0.45 * std::f64::consts::PI * (radius / step).powi(2);
        let score = |centre: DVec2| {
            let (disc, count) = mean(&|d| d < radius, centre)?;
            let (ring, _) = mean(&|d| d > 1.1 * radius && d < 1.8 * radius, centre)?;
            (f64::from(count) > least).then_some((ring / disc.max(1e-4)).ln())
        };
        let all = pixels.iter().filter_map(|p| Some((p.0, score(p.0)?)));
        let (centre, score) = all.max_by(|a, b| a.1.total_cmp(&b.1))?;
        (score >= LEAST_CONTRAST).then_some(centre)
    }

    /// Places between lids, so many px apart, and the light around each.
    fn between_lids(&self, eye: &Eye, step: f64) -> Vec<(DVec2, DVec3)> {
        let lids = eye.lids.iter().copied();
        let low = lids.clone().fold(DVec2::INFINITY, DVec2::min);
        let high = lids.fold(DVec2::NEG_INFINITY, DVec2::max);
        let count = ((high - low) / step).ceil().as_usizevec2();
        let places = (0..count.y).flat_map(|y| (0..count.x).map(move |x| [x, y]));
        // Of a small eye these are its pixels.
        let low = low.floor() + 0.5;
        let places = places.map(|p| low + step * DVec2::from_array(p.map(|c| c as f64)));
        let light = |p| Some((p, self.skin.image.mean(p, 0.5 * step)? * self.skin.exposure));
        places
            .filter(|&p| eye.is_between_lids(p))
            .filter_map(light)
            .collect()
    }
}
