//! What covers nose and mouth: a mask, or a scarf.
//!
//! It is more of the face that is seen than the skin is, so that no outlier tells it: of all that is seen it would
//! have the usual light, and the usual tone. It is told by the tip of the nose and what is under it, which have
//! the hue of the skin between the eyes, or of the forehead, on everybody whose nose is bare: a beard leaves
//! the nose free, and what shadows do to brightness is not asked.

use glam::{DVec2, DVec3, Vec3};

use super::Light;
use super::curtains::Curtains;
use super::light::{FEWEST, Point};
use super::median;
use crate::FaceModel;
use crate::srgb::BRIGHTNESS;

/// A nose that differs in hue (the logarithms of red and blue over green) by more is covered: bare ones, red ones
/// and such in the dark among them, have at most 0.28, white, grey, black and blue cloth has 0.6 and more.
const OTHER_HUE: f64 = 0.45;
/// So is one that is darker by this logarithm: black cloth in little light has no hue. Bare noses have at most 0.5.
const DARKER: f64 = 1.2;
/// Light below this is the camera's noise: it has the hue of the skin.
const BLACK: f64 = 0.01;
/// From fewer points nobody knows a tone.
const FEWEST_ALIKE: usize = 12;
/// How far the tip of the nose reaches around its point, mm; what is under the nose is so far beside the middle.
const TIP: f32 = 11.0;
const UNDER: f32 = 18.0;
/// The forehead begins so far above the brows, mm.
const FOREHEAD: f32 = 8.0;
/// Folds change the brightness of cloth, not its hue: a logarithm of brightness counts this part of one of hue.
const FOLDS: f64 = 0.4;

/// What is behind something that covers nose and mouth.
pub(super) struct Cover {
    /// Of the mean head, upside down: a mask hangs from below.
    below: Curtains,
    /// What is higher is free, mm on the mean head.
    top: f32,
}

/// Of the logarithm of a colour, or of how two differ: its hue, and as much as folds leave of its brightness.
fn told(tone: DVec3) -> DVec3 {
    hue(tone).extend(FOLDS * tone.dot(BRIGHTNESS))
}

fn hue(tone: DVec3) -> DVec2 {
    DVec2::new(tone.x - tone.y, tone.z - tone.y)
}

impl Cover {
    /// Of the points of a face that are seen; `None` when nose or mouth are bare, or nobody knows.
    pub fn of(model: &FaceModel, points: &[Point]) -> Option<Self> {
        let parts = model.parts();
        let place = |i: u32| {
            let name = format!("ibug_{i:02}");
            let landmark = parts.landmarks.iter().find(|l| l.name == name)?;
            Some(landmark.position(&parts.mean))
        };
        let [root, bridge, tip] = [place(27)?, place(28)?, place(30)?];
        let [base, lip] = [place(33)?, place(51)?];
        let brows = place(19)?.y.max(place(24)?.y);
        let at = |p: &Point| parts.mean[p.vertex];
        // The light is that of what no mask reaches.
        let free: Vec<Point> = (points.iter().filter(|p| at(p).y > bridge.y).copied()).collect();
        if free.len() < FEWEST {
            return None;
        }
        let light = Light::robust(&free);
        let noise = DVec3::splat(BLACK);
        let tone = |p: &Point| (p.seen.max(noise) / light.expected(p).max(noise)).map(f64::ln);
        let usual = |is_one: &dyn Fn(Vec3) -> bool| {
            let all = points.iter().filter(|p| is_one(at(p)));
            let tones: Vec<DVec3> = all.map(tone).collect();
            (tones.len() >= FEWEST_ALIKE).then(|| median(tones.into_iter()))
        };
        let nose = usual(&|p| p.distance(tip) < TIP)?;
        let under = usual(&|p| p.y < base.y && p.y > lip.y && p.x.abs() < UNDER)?;
        // Hair may cover a forehead and glasses the eyes, hardly both.
        let eyes = usual(&|p| p.y > bridge.y && p.y < brows);
        let forehead = usual(&|p| p.y > brows + FOREHEAD);
        let skins: Vec<DVec3> = eyes.into_iter().chain(forehead).collect();
        let is_other = |tone: DVec3| {
            skins.iter().all(|&skin| {
                let off = tone - skin;
                hue(off).length() > OTHER_HUE || off.dot(BRIGHTNESS) < -DARKER
            })
        };
        if skins.is_empty() || !is_other(nose) || !is_other(under) {
            return None;
        }
        let near = |skin: &DVec3| told(*skin - nose).length();
        let skin = *skins.iter().min_by(|a, b| near(a).total_cmp(&near(b)))?;
        // Nearer to the cover's tone than to the skin's.
        let cover = told((nose + under) / 2.0 - skin);
        let below = points.iter().filter(|p| at(p).y < root.y).map(|p| {
            let off = told(tone(p) - skin);
            let is_covered = off.dot(cover) > 0.5 * cover.length_squared();
            (at(p) * Vec3::new(1.0, -1.0, 1.0), is_covered)
        });
        Some(Self {
            below: Curtains::new(below),
            top: root.y,
        })
    }

    /// Whether a place on the mean head is behind it.
    pub fn hides(&self, at: Vec3) -> bool {
        at.y < self.top && self.below.cover(at * Vec3::new(1.0, -1.0, 1.0))
    }
}
