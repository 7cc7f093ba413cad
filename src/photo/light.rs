//! The light on a face (semantic reshaping, section 4.2).
//!
//! What a matt surface sends to the camera is its albedo times a *shading*, which depends on its normal
//! alone as long as the lights are far away: all but a hundredth of that is a quadratic polynomial of
//! the normal (Ramamoorthi & Hanrahan 2001, "An efficient representation for irradiance environment
//! maps"), nine numbers a channel. They are found by least squares on the part of the skin that is
//! seen, with the model's colours for the albedo, reweighted so that hair, glasses, hands and shadows
//! do not count.

use glam::{DVec2, DVec3, Vec3};
use nalgebra::{SMatrix, SVector};

use super::Camera;
use super::cover::Cover;
use super::sight::Sight;
use crate::srgb::{BRIGHTNESS, linear};
use crate::{Error, Face, FaceModel, Result};

/// How many numbers a channel's shading has.
pub const HARMONICS: usize = 9;

/// From this alpha on a pixel is the person's.
const PERSON: u8 = 128;

/// A photo's pixels.
#[derive(Debug, Clone, Copy)]
pub struct Image<'a> {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) rgba: &'a [u8],
}

impl<'a> Image<'a> {
    /// Of pixels row by row from the upper left corner, four bytes each: sRGB, and how much of the pixel
    /// is of the person whose face it is; where that is not known it is 255 everywhere. What is less than half (128)
    /// is background, of which nothing is asked but whether the photo is dark; where it is 0 nothing is there,
    /// whatever its colour, as in pictures that were cut out.
    ///
    /// # Errors
    /// When there are no pixels, or not four bytes for each.
    pub fn new(width: u32, height: u32, rgba: &'a [u8]) -> Result<Self> {
        let (width, height) = (width as usize, height as usize);
        let bytes = width.checked_mul(height).and_then(|n| n.checked_mul(4));
        if bytes != Some(rgba.len()) || rgba.is_empty() {
            return Err(Error::Mismatch(format!(
                "{} bytes are no photo of {width} x {height} pixels",
                rgba.len()
            )));
        }
        Ok(Self {
            width,
            height,
            rgba,
        })
    }

    /// Whether these are the pixels of a photo of this size.
    pub(super) fn check_size(&self, [width, height]: [u32; 2]) -> Result<()> {
        match [self.width, self.height] == [width as usize, height as usize] {
            true => Ok(()),
            false => Err(Error::Mismatch(format!(
                "the photo is {width} x {height} pixels, its image {} x {}",
                self.width, self.height
            ))),
        }
    }

    /// Whether a pixel of the image is the person's.
    pub(super) fn is_person(&self, [x, y]: [usize; 2]) -> bool {
        self.rgba[4 * (y * self.width + x) + 3] >= PERSON
    }

    /// The pixel of the person's that a point (px) is in; `None` outside, and in the background.
    pub(super) fn pixel(&self, p: DVec2) -> Option<[usize; 2]> {
        let size = DVec2::new(self.width as f64, self.height as f64);
        let is_inside = p.min_element() >= 0.0 && p.x < size.x && p.y < size.y;
        let pixel = p.as_usizevec2().to_array();
        (is_inside && self.is_person(pixel)).then_some(pixel)
    }

    /// The linear light, 0 to 1, at a point (px) of the person, between the middles of four pixels, as far as they
    /// are the person's; `None` elsewhere.
    pub(super) fn at(&self, p: DVec2) -> Option<DVec3> {
        self.pixel(p)?;
        let size = DVec2::new(self.width as f64, self.height as f64);
        let q = (p - 0.5).clamp(DVec2::ZERO, size - 1.0);
        let low = q.as_usizevec2();
        let part = q - low.as_dvec2();
        let high = (low + 1).min((size - 1.0).as_usizevec2());
        let pixel = |x: usize, y: usize| {
            let at = 4 * (y * self.width + x);
            linear([self.rgba[at], self.rgba[at + 1], self.rgba[at + 2]])
        };
        let across = [(low.x, 1.0 - part.x), (high.x, part.x)];
        let around = [(low.y, 1.0 - part.y), (high.y, part.y)]
            .map(|(y, down)| across.map(|(x, right)| ([x, y], down * right)));
        if !around.as_flattened().iter().all(|a| self.is_person(a.0)) {
            // The point's own pixel is one of them, and counts a quarter at least.
            let own = around.as_flattened().iter().filter(|a| self.is_person(a.0));
            let (sum, all) = own.fold((DVec3::ZERO, 0.0), |(sum, all), &([x, y], weight)| {
                (sum + weight * pixel(x, y), all + weight)
            });
            return Some(sum / all);
        }
        let row = |y: usize| pixel(low.x, y).lerp(pixel(high.x, y), part.x);
        Some(row(low.y).lerp(row(high.y), part.y))
    }

    /// The sum of the brightness in linear light, 0 to 1, of so many pixels from one on to the
    /// right, which are in the image.
    pub(super) fn brightness(&self, [x, y]: [usize; 2], count: usize) -> f64 {
        let first = 4 * (y * self.width + x);
        let pixels = self.rgba[first..first + 4 * count].chunks_exact(4);
        pixels
            .map(|p| linear([p[0], p[1], p[2]]).dot(BRIGHTNESS))
            .sum()
    }

    /// Whether a point is in the image.
    pub(super) fn contains(&self, p: DVec2) -> bool {
        let size = DVec2::new(self.width as f64, self.height as f64);
        p.cmpge(DVec2::ZERO).all() && p.cmplt(size).all()
    }

    /// The mean linear light, 0 to 1, of the person's pixels whose middles are within `reach` px of a point along
    /// both axes, at least of the pixel that it is in; `None` outside of the image and of the person.
    pub(super) fn mean(&self, p: DVec2, reach: f64) -> Option<DVec3> {
        self.pixel(p)?;
        let size = DVec2::new(self.width as f64, self.height as f64);
        let reach = (reach - 0.5).max(0.0);
        let low = (p - reach).max(DVec2::ZERO).as_usizevec2();
        let high = (p + reach).min(size - 1.0).as_usizevec2().max(low);
        let (mut sum, mut count) = (DVec3::ZERO, 0);
        for y in low.y..=high.y {
            let row = 4 * (y * self.width + low.x)..4 * (y * self.width + high.x + 1);
            for pixel in self.rgba[row].chunks_exact(4).filter(|p| p[3] >= PERSON) {
                sum += linear([pixel[0], pixel[1], pixel[2]]);
                count += 1;
            }
        }
        Some(sum / f64::from(count))
    }
}

/// A part of a photo in more pixels than the photo's face was fitted in.
#[derive(Debug, Clone, Copy)]
pub struct Detail<'a> {
    /// Its pixels. Where they are not the person's the photo's own are taken.
    pub image: Image<'a>,
    /// Its upper left corner, px of the photo as it was fitted.
    pub corner: DVec2,
    /// So many of its px are one of those.
    pub scale: f64,
}

impl Detail<'_> {
    /// The linear light, 0 to 1, at a point (px of the photo as it was fitted) of the person; `None` elsewhere.
    pub(super) fn at(&self, p: DVec2) -> Option<DVec3> {
        self.image.at((p - self.corner) * self.scale)
    }
}

/// The shading of a face by lights that are far away.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Light {
    /// For red, green and blue, the factors of 1, x, y, z, xy, yz, xz, x^2 - y^2 and 3 z^2 - 1, where
    /// x, y, z is the unit normal in the head's frame.
    pub coefficients: [[f64; HARMONICS]; 3],
    /// How far the skin that was believed is off the albedo times the shading: the root mean square of
    /// the difference as a part of that.
    pub rms: f64,
}

/// The spherical harmonics of degree 0 to 2 at a unit normal, without their constants.
pub(super) fn harmonics(n: DVec3) -> [f64; HARMONICS] {
    let DVec3 { x, y, z } = n;
    [
        1.0,
        x,
        y,
        z,
        x * y,
        y * z,
        x * z,
        x * x - y * y,
        3.0 * z * z - 1.0,
    ]
}

/// The standard deviations of the factors of degree 1 and 2, as parts of that of degree 0. A single light
/// has 2 and 0.6; most photos have softer ones.
const VARIATION: [f64; 2] = [1.0, 0.5];
/// How much redness, tan and shine make the albedo of skin vary on a large scale, as a part of it, and
/// in how many patches of a face independently: what looks like light by that much is none.
const STAINS: f64 = 0.1;
const PATCHES: f64 = 12.0;
/// The least that a point's light is off by, as a part of it: pores, spots and stubble.
const LEAST_NOISE: f64 = 0.05;
/// Points that are farther off than so many standard deviations do not count (Tukey's biweight, with
/// 95 % of the efficiency of the mean where there are no outliers).
const TUKEY: f64 = 4.685;
/// Steps of reweighting. Most of the light is told after three.
const STEPS: usize = 12;
/// Fewer points do not tell the light.
pub(super) const FEWEST: usize = 100;

/// The face reaches so far around its 68 points, mm: over the forehead, and not into the hair.
const AROUND: f32 = 35.0;

/// Beards are below the nose. Where the rest of the face says that chins are darker than skin by this logarithm
/// it is one, and nobody takes it for shadow: light from above that would make it so would make all that faces down
/// too pale.
const BEARD: f64 = 0.4;
/// The chin is so far below the nose's base, mm: under the mouth.
pub(super) const CHIN: f32 = 34.0;

/// A point of the skin that is seen.
#[derive(Clone, Copy)]
pub(super) struct Point {
    /// Of the mesh.
    pub vertex: usize,
    harmonics: SVector<f64, HARMONICS>,
    albedo: DVec3,
    /// Its light.
    pub seen: DVec3,
    /// How far it is below the nose's base on the mean head, mm.
    below: f32,
}

impl Light {
    /// The light on a face in a photo.
    ///
    /// # Errors
    /// When too little of the face is in the photo.
    pub fn of(face: &Face, camera: &Camera, image: &Image) -> Result<Self> {
        Self::on(
            face.model(),
            [face.positions(), face.normals()],
            camera,
            image,
        )
    }

    /// The light on a face with an expression: positions in mm and unit normals of a model's mesh.
    ///
    /// # Errors
    /// When the mesh is not the model's, or too little of the face is in the photo.
    pub fn on(
        model: &FaceModel,
        mesh: [&[Vec3]; 2],
        camera: &Camera,
        image: &Image,
    ) -> Result<Self> {
        let mean = &model.parts().mean;
        super::check_mesh(mesh[0].len(), mesh[1].len(), mean.len())?;
        let places: Vec<DVec3> = mesh[0].iter().map(|p| p.as_dvec3()).collect();
        let mut points = points(model, (&places, mesh[1]), camera, image);
        if let Some(cover) = Cover::of(model, &points) {
            points.retain(|p| !cover.hides(mean[p.vertex]));
        }
        if points.len() < FEWEST {
            return Err(Error::Mismatch("no face is seen in the photo".into()));
        }
        let (low, beardless): (Vec<Point>, Vec<Point>) =
            points.into_iter().partition(|p| p.below > 0.0);
        if beardless.len() >= FEWEST {
            let light = Self::robust(&beardless);
            let mut chin: Vec<f64> = low
                .iter()
                .filter(|p| p.below > CHIN)
                .map(|p| light.darker(p))
                .collect();
            chin.sort_unstable_by(f64::total_cmp);
            if chin.get(chin.len() / 2).is_some_and(|&off| off > BEARD) {
                return Ok(light);
            }
        }
        let all: Vec<Point> = beardless.into_iter().chain(low).collect();
        Ok(Self::robust(&all))
    }

    /// By weighted least squares, with weights from how far the points are off.
    pub(super) fn robust(points: &[Point]) -> Self {
        let mut weights = vec![1.0; points.len()];
        let mut light = Self {
            coefficients: [[0.0; HARMONICS]; 3],
            rms: 0.0,
        };
        for _ in 0..STEPS {
            light.coefficients = [0, 1, 2].map(|channel| fit(points, &weights, channel));
            let off: Vec<f64> = points.iter().map(|p| light.off(p)).collect();
            let mut sorted = off.clone();
            sorted.sort_unstable_by(f64::total_cmp);
            // Of a normal distribution half lie within 0.6745 standard deviations.
            let sigma = (sorted[sorted.len() / 2] / 0.6745).max(LEAST_NOISE);
            for (weight, off) in weights.iter_mut().zip(&off) {
                let t = (off / (TUKEY * sigma)).min(1.0);
                *weight = (1.0 - t * t).powi(2);
            }
            let square: f64 = off.iter().zip(&weights).map(|(o, w)| w * o * o).sum();
            light.rms = (square / weights.iter().sum::<f64>().max(1.0)).sqrt();
        }
        light
    }

    /// The shading of a surface with this unit normal in the head's frame: what it sends to the camera
    /// over its albedo, red, green and blue in linear light; 0 where the polynomial is below.
    pub fn shade(&self, normal: DVec3) -> DVec3 {
        let harmonics = harmonics(normal);
        let each = self.coefficients.map(|channel| {
            let terms = channel.iter().zip(harmonics);
            terms.map(|(c, h)| c * h).sum::<f64>().max(0.0)
        });
        DVec3::from_array(each)
    }

    /// What a point should send.
    pub(super) fn expected(&self, point: &Point) -> DVec3 {
        let shading = self.coefficients.map(|c| {
            let c = SVector::<f64, HARMONICS>::from(c);
            c.dot(&point.harmonics)
        });
        DVec3::from_array(shading) * point.albedo
    }

    /// The logarithm of how much darker a point is than it should be.
    fn darker(&self, point: &Point) -> f64 {
        let expected = self.expected(point).dot(BRIGHTNESS);
        (expected.max(0.02) / point.seen.dot(BRIGHTNESS).max(0.002)).ln()
    }

    /// How far a point is off, as a part of what it should send: the root mean square of its channels.
    fn off(&self, point: &Point) -> f64 {
        let expected = self.expected(point);
        // In deep shadow noise is no part of the light; a fiftieth of white stands for it.
        let scale = expected.max(DVec3::splat(0.02));
        ((point.seen - expected) / scale).length() / 3_f64.sqrt()
    }
}

/// What a face's bare skin is around on the mean head, mm: the 68 points, and some between the jaw's and the wings of the
/// nose, as broad cheeks are farther from all of them in their middle.
pub(super) fn features(model: &FaceModel) -> Vec<Vec3> {
    let parts = model.parts();
    let ibug = parts
        .landmarks
        .iter()
        .filter(|l| l.name.starts_with("ibug_"));
    let mut points: Vec<Vec3> = ibug.map(|l| l.position(&parts.mean)).collect();
    let cheeks = (1..=15).flat_map(|jaw| {
        let wing = if jaw < 8 { 31 } else { 35 };
        let ends = points.get(jaw).zip(points.get(wing));
        let between = |(jaw, wing): (&Vec3, &Vec3)| [0.33, 0.67].map(|part| jaw.lerp(*wing, part));
        ends.map(between).into_iter().flatten()
    });
    let cheeks: Vec<Vec3> = cheeks.collect();
    points.extend(cheeks);
    points
}

/// The vertices of the skin that are not under hair, on most heads.
pub(super) fn bare(model: &FaceModel) -> Vec<u32> {
    let parts = model.parts();
    let points = features(model);
    let mut skin = parts.topology.part_vertices("skin");
    skin.retain(|&v| {
        let p = parts.mean[v as usize];
        points
            .iter()
            .any(|q| q.distance_squared(p) < AROUND * AROUND)
    });
    skin
}

/// The vertices of the face that are seen.
pub(super) fn points(
    model: &FaceModel,
    (positions, normals): (&[DVec3], &[Vec3]),
    camera: &Camera,
    image: &Image,
) -> Vec<Point> {
    let parts = model.parts();
    let topology = &parts.topology;
    // Without the landmark nothing is below it.
    let nose = parts.landmarks.iter().find(|l| l.name == "ibug_33");
    let nose = nose.map_or(f32::NEG_INFINITY, |l| l.position(&parts.mean).y);
    let Some(sight) = Sight::new(camera, positions, &topology.triangles()) else {
        return Vec::new();
    };
    let vertices = bare(model).into_iter();
    vertices
        .filter_map(|v| {
            let v = v as usize;
            let normal = normals[v].as_dvec3();
            if !sight.sees(positions[v], normal) {
                return None;
            }
            // A mm around the vertex.
            let reach = 0.5 * camera.focal / camera.to_camera(positions[v]).z;
            let light = image.mean(camera.project(positions[v]), reach)?;
            Some(Point {
                vertex: v,
                harmonics: harmonics(normal).into(),
                albedo: linear(topology.colours[v]),
                seen: light,
                below: nose - parts.mean[v].y,
            })
        })
        .collect()
}

/// A channel's coefficients by weighted least squares of the light over the albedo.
fn fit(points: &[Point], weights: &[f64], channel: usize) -> [f64; HARMONICS] {
    let mut square = SMatrix::<f64, HARMONICS, HARMONICS>::zeros();
    let mut right = SVector::<f64, HARMONICS>::zeros();
    let mut brightness = 0.0;
    let mut total = 0.0;
    for (p, &weight) in points.iter().zip(weights) {
        let albedo = p.albedo[channel];
        square += p.harmonics * p.harmonics.transpose() * (weight * albedo * albedo);
        right += p.harmonics * (weight * albedo * p.seen[channel]);
        brightness += weight * albedo * p.seen[channel];
        total += weight * albedo * albedo;
    }
    // What all that is seen is worth against the prior, both in the mean shading.
    let mean = (brightness / total.max(1e-12)).max(1e-6);
    let noise = STAINS * STAINS * total / PATCHES;
    for i in 1..HARMONICS {
        square[(i, i)] += noise / VARIATION[usize::from(i > 3)].powi(2);
    }
    square[(0, 0)] += 1e-9 * total.max(1e-12);
    let found = square.cholesky().map(|factor| factor.solve(&right));
    found.map_or_else(
        || {
            let mut ambient = [0.0; HARMONICS];
            ambient[0] = mean;
            ambient
        },
        Into::into,
    )
}
