//! Pixels for the photos of [`photograph`](mod@super::photograph): a person of ICT under a light that is
//! known.
//!
//! What is drawn is ICT's own mesh with its own normals, not the template. The light is a polynomial
//! of degree 2 in the normal (nine spherical harmonics a channel): what comes from everywhere and
//! three coloured lamps, without shadows. The albedo is one colour of skin times a random field: the
//! exponential of waves over the mean head, 10 % in waves of 60 to 200 mm and 5 % in waves of 6 to 25
//! mm. Channels share four fifths of its variance: melanin and blood darken all of them, not alike.
//! A fit's idea of albedo (`photo::albedo`) has no waves, other lengths and other correlations.

use glam::{DVec2, DVec3};

use super::ict::Ict;
use super::photograph::{Photograph, SIZE};
use crate::Random;
use crate::fit::mesh::surface::normals;
use crate::photo::raster::{NOTHING, Raster};
use crate::srgb::{BRIGHTNESS, byte};

/// The mean colour of skin in linear light.
const SKIN: DVec3 = DVec3::new(0.723, 0.434, 0.305);
/// The standard deviations of the logarithm of the albedo and its waves' lengths, mm.
const STAINS: [(f64, [f64; 2]); 2] = [(0.10, [60.0, 200.0]), (0.05, [6.0, 25.0])];
/// The correlation of the albedo of two channels.
const SHARED: f64 = 0.8;
/// Pixels are off by this part of their light (one standard deviation), in each channel.
const NOISE: f64 = 0.03;
/// What one in a hundred pixels of the face is brighter than, of what a photo can show.
const EXPOSED: f64 = 0.9;
/// How many waves make a field.
const WAVES: usize = 60;
/// Light from everywhere and from three sides.
#[derive(Debug, Clone, Copy)]
pub struct Lamps {
    ambient: DVec3,
    lamps: [(DVec3, DVec3); 3],
}

/// The first three degrees of what a lamp sends a matt surface, by the cosine of the angle between
/// its normal and the lamp.
fn lambert(cosine: f64) -> f64 {
    0.25 + 0.5 * cosine + 0.3125 * (1.5 * cosine * cosine - 0.5)
}

impl Lamps {
    /// Lamps before the face, some to its sides, somewhat coloured.
    pub fn random(random: &mut Random) -> Self {
        let mut between = |least: f64, most: f64| least + (most - least) * random.uniform();
        let mut colour = |least: f64, most: f64| {
            let tint = DVec3::from_array([0; 3].map(|_| between(0.8, 1.2)));
            tint * between(least, most)
        };
        let ambient = colour(0.2, 0.4);
        let colours = [0; 3].map(|_| colour(0.1, 0.8));
        let lamps = colours.map(|colour| {
            let [x, y, z] = [(-1.0, 1.0), (-0.6, 0.8), (0.2, 1.0)].map(|(a, b)| between(a, b));
            (DVec3::new(x, y, z).normalize(), colour)
        });
        Self { ambient, lamps }
    }

    /// What a surface with this unit normal sends over its albedo.
    pub fn shade(&self, normal: DVec3) -> DVec3 {
        let lamps = self.lamps.iter();
        self.ambient
            + lamps
                .map(|(d, c)| *c * lambert(normal.dot(*d)))
                .sum::<DVec3>()
    }
}

/// A field over space: a sum of waves, of standard deviation 1.
struct Waves(Vec<(DVec3, f64)>);

impl Waves {
    fn random(random: &mut Random, lengths: [f64; 2]) -> Self {
        let turn = std::f64::consts::TAU;
        let waves = (0..WAVES).map(|_| {
            let along = DVec3::from_array([0; 3].map(|_| random.normal())).normalize();
            let length = lengths[0] * (lengths[1] / lengths[0]).powf(random.uniform());
            (along * (turn / length), turn * random.uniform())
        });
        Self(waves.collect())
    }

    fn at(&self, p: DVec3) -> f64 {
        let sum: f64 = self
            .0
            .iter()
            .map(|(k, phase)| (p.dot(*k) + phase).cos())
            .sum();
        sum * (2.0 / WAVES as f64).sqrt()
    }
}

/// A photo's pixels, and what made them.
#[derive(Debug, Clone)]
pub struct Portrait {
    /// [`SIZE`] x [`SIZE`] pixels of sRGB and alpha.
    pub rgba: Vec<u8>,
    /// The light, in ICT's frame; of a grey photo what its grey is made of.
    pub lamps: Lamps,
}

impl Portrait {
    /// Of the person and the camera of a photo; the albedo follows from the person's seed, light and noise from which of
    /// their photos it is, too.
    pub fn take(photo: &Photograph, ict: &Ict, colour: bool) -> Self {
        let person = &photo.person;
        let facing = normals(person, &ict.triangles);
        // Streams up to 8 are the scans' and the points'.
        let mut random = Random::stream(photo.seed, 9);
        let mut lamps = Lamps::random(&mut random);
        let albedo = stains(&ict.neutral, &mut random);
        // Another photo of the person has another light, and noise of its own.
        if photo.time > 0 {
            random = Random::stream(photo.seed, 9 + 100 * photo.time);
            lamps = Lamps::random(&mut random);
        }
        let size = SIZE as usize;
        let raster = Raster::new(&photo.camera, [size; 2], person, &ict.triangles);
        let eye = photo.camera.position();
        let turn = photo.camera.rotation.transpose();
        let mut sent: Vec<Option<DVec3>> = Vec::with_capacity(size * size);
        for (i, &t) in raster.triangles.iter().enumerate() {
            if t == NOTHING {
                sent.push(None);
                continue;
            }
            let corners = ict.triangles[t as usize].map(|v| v as usize);
            let [a, b, c] = corners.map(|v| person[v]);
            let pixel = DVec2::new((i % size) as f64, (i / size) as f64) + 0.5;
            let ray = turn * ((pixel - photo.camera.centre) / photo.camera.focal).extend(1.0);
            // Where the ray meets the triangle's plane, in the triangle's own coordinates.
            let whole = (b - a).cross(c - a);
            let p = eye + ray * ((a - eye).dot(whole) / ray.dot(whole));
            let part =
                |u: DVec3, v: DVec3| (u - p).cross(v - p).dot(whole) / whole.length_squared();
            let weights = [part(b, c), part(c, a), part(a, b)];
            let mix = |of: &[DVec3]| -> DVec3 {
                corners.iter().zip(weights).map(|(&v, w)| of[v] * w).sum()
            };
            let shade = lamps.shade(mix(&facing).normalize_or(DVec3::Z));
            sent.push(Some(mix(&albedo) * shade));
        }
        let mut brightest: Vec<f64> = sent.iter().flatten().map(|l| l.max_element()).collect();
        brightest.sort_unstable_by(f64::total_cmp);
        let white = brightest
            .get(brightest.len() * 99 / 100)
            .map_or(1.0, |b| b / EXPOSED);
        let mut rgba = Vec::with_capacity(4 * sent.len());
        for light in sent {
            let light = light.map_or(DVec3::splat(0.2), |l| l / white);
            let light = match colour {
                true => light * DVec3::from_array([0; 3].map(|_| 1.0 + NOISE * random.normal())),
                false => DVec3::splat(light.dot(BRIGHTNESS) * (1.0 + NOISE * random.normal())),
            };
            rgba.extend(light.to_array().map(byte));
            rgba.push(255);
        }
        Self { rgba, lamps }
    }

    /// What the photo's light sends a surface: of a grey one the same in all channels.
    pub fn shade(&self, normal: DVec3, colour: bool) -> DVec3 {
        let shade = self.lamps.shade(normal);
        match colour {
            true => shade,
            false => DVec3::splat((shade * SKIN).dot(BRIGHTNESS) / SKIN.dot(BRIGHTNESS)),
        }
    }
}

/// The albedo of each vertex.
fn stains(mean: &[DVec3], random: &mut Random) -> Vec<DVec3> {
    let mut logarithms = vec![DVec3::ZERO; mean.len()];
    for (sigma, lengths) in STAINS {
        let shared = Waves::random(random, lengths);
        let own = [0; 3].map(|_| Waves::random(random, lengths));
        for (sum, &p) in logarithms.iter_mut().zip(mean) {
            let own = DVec3::from_array([0, 1, 2].map(|c: usize| own[c].at(p)));
            *sum += sigma * (SHARED.sqrt() * shared.at(p) + (1.0 - SHARED).sqrt() * own);
        }
    }
    logarithms.into_iter().map(|l| SKIN * l.exp()).collect()
}
