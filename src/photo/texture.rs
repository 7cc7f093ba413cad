//! The colours of a head that wears a photo (semantic reshaping, section 4.2): its albedo, all round.
//!
//! Where the skin is seen its albedo is the photo's light over the shading, in the exposure and white
//! balance of the photo, unless it is too dark: a light that is everywhere cannot be told from a lighter skin, and people
//! look as in the photo when the usual shading is 1. What the camera does not
//! see of one side it mostly sees of the other, so that is taken from there. What remains has the
//! model's own colours, in the tone that the neighbourhood has: the logarithm of (seen / model's) is
//! continued smoothly over the mesh.

use glam::{DVec2, DVec3, Vec3};

use super::grain::{self, Smooth};
use super::median;
use super::raster::{NOTHING, Raster};
use super::skin::Skin;
use super::{Camera, Detail, Image, Light, tones};
use crate::srgb::{BRIGHTNESS, byte, encode};
use crate::{Error, FaceModel, Result};

/// An image in the model's texture coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    /// Its side, texels.
    pub size: usize,
    /// Row by row from the top (v = 1): sRGB, and how much of it is the photo's.
    pub rgba: Vec<u8>,
}

/// Brows are within this distance of the ten points where their hair grows, mm.
const BROW: f32 = 11.0;
/// What is painted darker than the skin by less than this logarithm is no brow.
const PAINTED: f64 = 0.04;
/// No brow is darker than so many times the model's, as logarithms.
const DARKEST_BROW: f64 = 2.0;
/// Skin mirrors lights from so far above the nose's base on, mm, wholly from the second on.
const SHINY: [f32; 2] = [-2.0, 4.0];
/// What is white in a light is told by the skin's hue, how much redder than blue it is, of its brightness: not at all
/// below the first of these, wholly from the second on. The palest skin has 0.3; a photo without colours has none, and
/// what is bright in it may be skin.
const HUE: [f64; 2] = [0.05, 0.15];
/// Blood makes skin redder and darker, melanin too. What is redder by more than the first of these logarithms of (red /
/// blue) and no darker has a light that nobody told from skin: this part of it is believed. It is dark enough for
/// blood from the first of the logarithms of brightness on, and not at all from the second.
const FLUSH: f64 = 0.15;
const STAIN: f64 = 0.25;
const PALE: [f64; 2] = [-0.3, -0.1];
/// A chart's colours are continued so many texels beyond its border, for whoever filters the image.
const MARGIN: usize = 6;
/// Of several photos that show a place each counts by how well it does, to this power: nearly all of it is the best one's,
/// and no border is seen.
const BEST: i32 = 4;
/// What the other side of the face shows is worth this part of what is seen.
const MIRRORED: f64 = 0.5;
/// Less well than this, as a part of what the sharpest photo shows from the front, nothing is seen.
const UNSEEN: f64 = 0.17;
/// More pixels than so many for a mm a texture does not have either.
const SHARP: f64 = 3.0;
/// Sides of a texture, texels.
const SIZES: std::ops::RangeInclusive<usize> = 64..=4096;

/// A face as a photo shows it.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    /// The photo's camera.
    pub camera: &'a Camera,
    /// The light on the face.
    pub light: &'a Light,
    /// The face's vertices in the photo, mm.
    pub positions: &'a [DVec3],
    /// Their unit normals.
    pub normals: &'a [Vec3],
    /// The photo.
    pub image: Image<'a>,
    /// Finer pixels of a part of it, where those are known.
    pub detail: Option<Detail<'a>>,
}

impl Texture {
    /// Of a face, and of others of the same person's in other photos, each of which counts where it shows the skin best.
    /// Tones are those of the first photo.
    ///
    /// # Errors
    /// When a mesh is not the model's, the face is not in a photo, the size is not from 64 to
    /// 4096, or finer pixels have no place.
    pub fn of(model: &FaceModel, view: &View, others: &[View], size: usize) -> Result<Self> {
        if !SIZES.contains(&size) {
            return Err(Error::Value {
                what: "a texture's side",
                wanted: format!("from {} to {} texels", SIZES.start(), SIZES.end()),
                got: size as f64,
            });
        }
        let views = || std::iter::once(view).chain(others);
        for Detail { corner, scale, .. } in views().filter_map(|view| view.detail) {
            let place = [
                ("a detail's scale", "above 0", scale, scale > 0.0),
                ("a detail's left edge", "a number of px", corner.x, true),
                ("a detail's upper edge", "a number of px", corner.y, true),
            ];
            for (what, wanted, got, fits) in place {
                if !(got.is_finite() && fits) {
                    let wanted = wanted.into();
                    return Err(Error::Value { what, wanted, got });
                }
            }
        }
        let skins = views().map(|view| {
            let mesh = (view.positions, view.normals);
            Skin::new(model, view.camera, view.light, mesh, &view.image)
        });
        let skins: Vec<Skin> = skins.collect::<Result<_>>()?;
        let worn = skins.iter().zip(views());
        let worn: Vec<_> = worn
            .map(|(skin, view)| smooth(skin, view.detail.as_ref()))
            .collect();
        let sources = skins.iter().zip(views()).zip(&worn);
        let mut sources = sources
            .map(|((skin, view), smooth)| {
                let smooth = smooth.as_ref().map(|(smooth, corner, scale)| {
                    Ok::<_, Error>(Detail {
                        image: Image::new(smooth.width as u32, smooth.height as u32, &smooth.rgba)?,
                        corner: *corner,
                        scale: scale / smooth.coarser as f64,
                    })
                });
                let (fill, shine) = fill(skin);
                Ok(Source {
                    way: Vec::new(),
                    sharp: sharpness(view).min(SHARP),
                    skin,
                    fill,
                    shine,
                    detail: smooth.transpose()?.or(view.detail),
                })
            })
            .collect::<Result<Vec<_>>>()?;
        let sharpest = sources.iter().map(|s| s.sharp).fold(0.0, f64::max);
        for source in &mut sources {
            source.sharp /= sharpest;
        }
        if let [first, others @ ..] = &mut sources[..] {
            for other in others {
                other.way = tones::between(first.skin, &first.fill, other.skin);
            }
        }
        Ok(bake(model, &sources, size))
    }
}

/// What is known of the head's colours by one photo.
struct Source<'a> {
    skin: &'a Skin<'a>,
    /// The colours of what is not seen.
    fill: Vec<DVec3>,
    shine: Shine,
    detail: Option<Detail<'a>>,
    /// From its tones to those of the first, at each vertex, as `tones` has it; of the first itself there is none.
    way: Vec<(DVec3, f64)>,
    /// How many pixels it has for a mm, as far as they count, as a part of the sharpest photo's.
    sharp: f64,
}

/// How many pixels of a photo are a mm at the head.
fn sharpness(view: &View) -> f64 {
    let middle = view.positions.iter().sum::<DVec3>() / view.positions.len() as f64;
    view.camera.focal / view.camera.to_camera(middle).length()
}

/// What of the photo is worn, without the grain that its exposure on the head would show, if it would; where its corner
/// is in the photo, and how many pixels of its source are one of the photo's.
fn smooth(skin: &Skin, detail: Option<&Detail>) -> Option<(Smooth, DVec2, f64)> {
    let own = skin.own();
    // Bytes of the head over those of the photo.
    let brightness = |light: DVec3| encode(light.dot(BRIGHTNESS)).max(1.0 / 255.0);
    let gain = brightness(own) / brightness(own * skin.usual / skin.exposure);
    if let Some(&Detail {
        image,
        corner,
        scale,
    }) = detail
    {
        let size = [image.width, image.height];
        return Some((grain::smooth(&image, [0, 0], size, gain)?, corner, scale));
    }
    let worn = (0..skin.trust.len()).filter(|&v| skin.trust[v] > 0.0);
    let (low, high) = worn
        .map(|v| skin.seen[v])
        .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| {
            (low.min(p), high.max(p))
        });
    let size = DVec2::new(skin.image.width as f64, skin.image.height as f64);
    let within = |p: DVec2| p.clamp(DVec2::ZERO, size).as_usizevec2();
    let (first, end) = (within(low.floor()), within(high.ceil()));
    let size = end.saturating_sub(first).to_array();
    let smooth = grain::smooth(skin.image, first.to_array(), size, gain)?;
    Some((smooth, first.as_dvec2(), 1.0))
}

/// What the model's brows are painted with, as far as that is more than skin.
struct Brows {
    /// The logarithm of (brow / skin) of each vertex; 0 beside them.
    paint: Vec<DVec3>,
    /// Whether brows of people may be there, which are thinner, or higher.
    near: Vec<bool>,
}

impl Brows {
    fn new(skin: &Skin) -> Self {
        let parts = skin.model.parts();
        let hair = skin.brow_hair();
        let away = |p: &Vec3| {
            let each = hair.iter().map(|a| a.distance(*p));
            each.fold(f32::INFINITY, f32::min)
        };
        let away: Vec<f32> = parts.mean.iter().map(away).collect();
        let around = (0..away.len()).filter(|&v| (BROW..2.0 * BROW).contains(&away[v]));
        let bare = median(around.map(|v| skin.painted[v]));
        let of = |v: usize| {
            let paint = (skin.painted[v] / bare).map(f64::ln);
            let is_brow = away[v] < BROW && paint.dot(BRIGHTNESS) < -PAINTED;
            if is_brow { paint } else { DVec3::ZERO }
        };
        Self {
            paint: (0..away.len()).map(of).collect(),
            near: away.iter().map(|&away| away < BROW).collect(),
        }
    }

    /// How much of the paint the brows of the photo are, each channel, from the tones that the skin beneath them
    /// would have.
    fn strength(&self, skin: &Skin, bare: &[DVec3]) -> DVec3 {
        let mut sums = [DVec3::ZERO; 2];
        for (v, tone) in skin.seen_tones() {
            if self.paint[v] != DVec3::ZERO && skin.trust[v] > 0.8 {
                let own = tone + self.paint[v] - bare[v];
                sums[0] += own * self.paint[v];
                sums[1] += self.paint[v] * self.paint[v];
            }
        }
        let [seen, painted] = sums;
        if painted.min_element() > 0.0 {
            (seen / painted).clamp(DVec3::ZERO, DVec3::splat(DARKEST_BROW))
        } else {
            DVec3::ONE
        }
    }
}

/// The lights that skin mirrors in a photo: they would turn with the head.
struct Shine {
    /// The skin without any, each vertex.
    matte: Vec<DVec3>,
    /// Where what is paler than skin is shine: above beards, and not at brows, which may be white; and how far the
    /// photo and the skin there have a hue to tell it by.
    share: Vec<f64>,
}

impl Shine {
    /// Of skin that usually has this tone.
    fn new(skin: &Skin, usual: DVec3, brow: &[bool]) -> Self {
        let parts = skin.model.parts();
        // Without the landmark there is none.
        let nose = skin.landmark("ibug_33");
        let nose = nose.map_or(f32::INFINITY, |l| l.position(&parts.mean).y);
        let matte = skin.painted.iter().map(|&p| p * usual.map(f64::exp));
        let matte: Vec<DVec3> = matte.collect();
        let hue = |c: DVec3| {
            let red = (c.x - c.z) / c.dot(BRIGHTNESS).max(1e-9);
            ((red - HUE[0]) / (HUE[1] - HUE[0])).clamp(0.0, 1.0)
        };
        let own = hue(skin.own());
        let share = |v: usize| {
            let above = (parts.mean[v].y - nose - SHINY[0]) / (SHINY[1] - SHINY[0]);
            if brow[v] {
                0.0
            } else {
                f64::from(above.clamp(0.0, 1.0)) * own * hue(matte[v])
            }
        };
        Self {
            share: (0..brow.len()).map(share).collect(),
            matte,
        }
    }

    /// A colour at a mix of three vertices without it: what is added to skin is white, so as much is taken off as
    /// gives it the skin's hue, but no more than is brighter (Shafer 1985, the dichromatic model).
    fn without(&self, corners: [usize; 3], share: [f64; 3], seen: DVec3) -> DVec3 {
        let matte: DVec3 = (0..3).map(|i| self.matte[corners[i]] * share[i]).sum();
        let much: f64 = (0..3).map(|i| self.share[corners[i]] * share[i]).sum();
        let brighter = (seen - matte).dot(BRIGHTNESS);
        let red = matte.x - matte.z;
        if brighter <= 0.0 || red <= 0.0 {
            return seen;
        }
        let white = (seen.z * matte.x - seen.x * matte.z) / red;
        seen - much * white.clamp(0.0, brighter)
    }

    /// A colour at a mix of three vertices, no redder than skin that is so bright.
    fn unstained(&self, corners: [usize; 3], share: [f64; 3], seen: DVec3) -> DVec3 {
        let matte: DVec3 = (0..3).map(|i| self.matte[corners[i]] * share[i]).sum();
        if seen.min_element() <= 0.0 || matte.min_element() <= 0.0 {
            return seen;
        }
        let tone = (seen / matte).map(f64::ln);
        let bright = tone.dot(BRIGHTNESS);
        let redder = tone.x - tone.z - FLUSH;
        let pale = ((bright - PALE[0]) / (PALE[1] - PALE[0])).clamp(0.0, 1.0);
        if redder <= 0.0 || pale == 0.0 {
            return seen;
        }
        let kept = 1.0 - pale * (1.0 - STAIN) * redder / (redder + FLUSH);
        matte * (bright + (tone - bright) * kept).map(f64::exp)
    }
}

/// The colours of what is not seen, all over the mesh: the model's own in the tones that are seen, and brows as
/// dark as the photo's; and what skin mirrors.
fn fill(skin: &Skin) -> (Vec<DVec3>, Shine) {
    let brows = Brows::new(skin);
    let (tones, usual) = tones::all_round(skin, &brows.near);
    let shine = Shine::new(skin, usual, &brows.near);
    let strength = brows.strength(skin, &tones);
    let colour = |v: usize| {
        let brow = (strength - 1.0) * brows.paint[v];
        skin.painted[v] * (tones[v] + brow).map(f64::exp)
    };
    ((0..tones.len()).map(colour).collect(), shine)
}

impl Source<'_> {
    /// The colour at a mix of three vertices, how much of it is the photo's, and how well it is seen there.
    fn colour(
        &self,
        corners: [usize; 3],
        mirrored: [usize; 3],
        share: [f64; 3],
    ) -> (DVec3, [f64; 2]) {
        let (skin, shine) = (self.skin, &self.shine);
        let detail = self.detail.as_ref();
        let own: DVec3 = (0..3).map(|i| self.fill[corners[i]] * share[i]).sum();
        let (seen, trust) = skin.albedo(corners, share, detail);
        let trust = trust * skin.unmixed(corners, share, seen, own);
        let (other, far) = skin.albedo(mirrored, share, detail);
        let far = far * (1.0 - trust) * skin.unmixed(mirrored, share, other, own);
        let rest = (1.0 - trust - far).max(0.0);
        let [seen, other, own] = [(corners, seen), (mirrored, other), (corners, own)]
            .map(|(corners, colour)| shine.without(corners, share, colour));
        let colour = shine.unstained(corners, share, seen * trust + other * far + own * rest);
        let facing = |corners: [usize; 3]| -> f64 {
            (0..3).map(|i| skin.facings[corners[i]] * share[i]).sum()
        };
        let well = self.sharp * (trust * facing(corners) + MIRRORED * far * facing(mirrored));
        if self.way.is_empty() {
            return (colour, [trust + far, well]);
        }
        let way = |corners: [usize; 3]| {
            let each = (0..3).map(|i| (self.way[corners[i]], share[i]));
            each.fold(
                (DVec3::ZERO, 0.0),
                |(sum, all), ((gain, believed), share)| {
                    (sum + gain * share, all + believed * share)
                },
            )
        };
        let [own, other] = [way(corners), way(mirrored)];
        let gain = own.0.lerp(other.0, far);
        let believed = own.1 + (other.1 - own.1) * far;
        (
            colour * gain.map(f64::exp),
            [(trust + far) * believed, well * believed],
        )
    }
}

fn bake(model: &FaceModel, sources: &[Source], size: usize) -> Texture {
    let topology = &model.parts().topology;
    let side = size as f64;
    let texel = |corner: u32| {
        let [u, v] = topology.uvs[corner as usize].map(f64::from);
        DVec3::new(u * side, (1.0 - v) * side, 1.0)
    };
    let layout = || topology.uv_triangles.iter().map(|t| t.map(texel));
    let raster = Raster::of([size, size], layout());
    let layout: Vec<[DVec3; 3]> = layout().collect();
    let triangles = topology.triangles();
    let mut rgba = vec![0; 4 * size * size];
    let mut filled = vec![false; size * size];
    for (at, pixel) in rgba.chunks_exact_mut(4).enumerate() {
        let triangle = raster.triangles[at];
        if triangle == NOTHING {
            continue;
        }
        let corners = triangles[triangle as usize].map(|v| v as usize);
        let here = DVec2::new((at % size) as f64, (at / size) as f64) + 0.5;
        let share =
            super::raster::barycentric(here, layout[triangle as usize].map(|c| c.truncate()));
        let mirrored = corners.map(|v| topology.mirror[v] as usize);
        let (mut colour, [mut shown, well]) = sources[0].colour(corners, mirrored, share);
        if sources.len() > 1 {
            // What no photo shows has the first one's colours.
            let mut weight = well.powi(BEST) + UNSEEN.powi(BEST);
            colour *= weight;
            for source in &sources[1..] {
                let (other, [much, well]) = source.colour(corners, mirrored, share);
                let counts = well.powi(BEST);
                colour += counts * other;
                weight += counts;
                shown = shown.max(much);
            }
            colour /= weight;
        }
        let coded = colour.to_array().map(byte);
        pixel[..3].copy_from_slice(&coded);
        pixel[3] = (255.0 * shown.min(1.0) + 0.5) as u8;
        filled[at] = true;
    }
    widen(&mut rgba, &mut filled, size);
    Texture { size, rgba }
}

/// Continues colours over the border of what is filled.
fn widen(rgba: &mut [u8], filled: &mut [bool], size: usize) {
    for _ in 0..MARGIN {
        let mut added = Vec::new();
        for at in (0..size * size).filter(|&at| !filled[at]) {
            let (x, y) = (at % size, at / size);
            let beside = [
                (x > 0).then(|| at - 1),
                (x + 1 < size).then_some(at + 1),
                (y > 0).then(|| at - size),
                (y + 1 < size).then_some(at + size),
            ];
            let source = beside.into_iter().flatten().find(|&at| filled[at]);
            added.extend(source.map(|source| (at, source)));
        }
        for (at, source) in added {
            rgba.copy_within(4 * source..4 * source + 4, 4 * at);
            filled[at] = true;
        }
    }
}
