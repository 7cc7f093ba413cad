//! Photos of people whose true shape is known, and how far fits to them are off.
//!
//! A person of [`Ict`] is carried to the template by the linear transfer of [`Binding`], which is
//! exact: every vertex of the skin has its spot on ICT's. The points of a photo are the template's
//! landmarks there. A jaw point that is hidden is given where its level of the face ends in the
//! image, which is how people and detectors mark it.

use std::path::Path;

use glam::{DMat3, DVec2, DVec3};
use serde::Serialize;

use super::ict::Ict;
use super::mood::Mood;
use crate::fit::format::files::write_atomically;
use crate::fit::head::region::point;
use crate::fit::head::template::Template;
use crate::fit::mesh::align::Rigid;
use crate::fit::truth::binding::Binding;
use crate::fit::{FitError, FitResult};
use crate::photo::raster::Raster;
use crate::photo::{Camera, POINTS};
use crate::{Expressions, FaceModel, Random};

/// How a set of photos is taken.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Setting {
    /// What the set is called.
    pub name: &'static str,
    /// How wide faces are, between the first and the last point of the jaw of the mean head seen
    /// from the front, px.
    pub face: f64,
    /// The standard deviation of the points along each axis, px.
    pub noise: f64,
    /// The standard deviation by which jaw points slide along the outline, px.
    pub slide: f64,
}

/// The sets that are measured: faces near to a camera and large, as far away as portraits are taken,
/// and near with a jaw that was marked anywhere on the outline.
pub const SETTINGS: [Setting; 3] = [
    Setting {
        name: "close",
        face: 300.0,
        noise: 1.5,
        slide: 0.0,
    },
    Setting {
        name: "portrait",
        face: 120.0,
        noise: 0.6,
        slide: 0.0,
    },
    Setting {
        name: "sliding",
        face: 300.0,
        noise: 1.5,
        slide: 12.0,
    },
];

/// Photos are so many px wide and high.
pub const SIZE: u32 = 512;
/// The shortest and the longest lens, mm for film 36 mm wide. With the widths of faces in
/// [`SETTINGS`] they are taken from 24 to 59 cm and from 61 to 148 cm.
const LENS: [f64; 2] = [35.0, 85.0];
/// The width of film, mm.
const FILM: f64 = 36.0;
/// The greatest yaw, pitch and roll, degrees.
const ANGLES: [f64; 3] = [40.0, 15.0, 10.0];
/// How far the face's middle is from the image's at most, along each axis, px.
const OFF_CENTRE: f64 = 25.0;
/// What lies so much farther than a surface before it is another one, or hidden by it, mm.
const BEHIND: f64 = 6.0;
/// The jaw's points.
const JAW: usize = 17;

/// A photo's points and what is true of it.
#[derive(Debug, Clone)]
pub struct Photograph {
    /// The person's seed.
    pub seed: u64,
    /// Which of the person's photos it is.
    pub time: u64,
    /// The camera, in ICT's frame.
    pub camera: Camera,
    /// ICT's vertices as they are photographed, expression and all, mm.
    pub person: Vec<DVec3>,
    /// The 68 points, px.
    pub points: Vec<[f64; 2]>,
    /// Where each vertex of [`Photographer::face`] is without expression, mm, in ICT's frame.
    pub truth: Vec<DVec3>,
    /// The weight of each expression; empty when the photographer knows none.
    pub weights: Vec<f64>,
}

/// Takes photos of people.
pub struct Photographer<'a> {
    ict: &'a Ict,
    binding: Binding,
    /// The place in the binding and the weight of the corners of each landmark.
    landmarks: Vec<Vec<(usize, f64)>>,
    /// The vertices of the face area, increasing.
    pub face: Vec<u32>,
    /// Their places in the binding.
    places: Vec<usize>,
    /// How wide the mean face is, mm.
    width: f64,
    middle: DVec3,
    /// What people show.
    mood: Option<Mood<'a>>,
}

impl<'a> Photographer<'a> {
    /// For people of `ict`; `reference` is the template registered to ICT's mean head (all vertices,
    /// mm, in ICT's pose).
    ///
    /// # Errors
    /// When the template lacks its skin or a landmark.
    pub fn new(template: &Template, reference: &[DVec3], ict: &'a Ict) -> FitResult<Self> {
        let binding = Binding::new(template, reference, ict)?;
        let mut landmarks = Vec::new();
        for i in 0..POINTS {
            let name = format!("ibug_{i:02}");
            // Says which one is missing.
            point(template, &name)?;
            let stencils = template.landmarks.iter().filter(|l| l.name == name);
            let corners = stencils.flat_map(|l| &l.stencil).filter_map(|&(v, w)| {
                let place = binding.vertices.binary_search(&v).ok()?;
                Some((place, w))
            });
            landmarks.push(corners.collect());
        }
        let places: Vec<usize> = (0..binding.vertices.len())
            .filter(|&i| binding.face[i] && binding.bound[i])
            .collect();
        let face = places.iter().map(|&i| binding.vertices[i]).collect();
        let mean = binding.truth(&ict.neutral, ict);
        let mut photographer = Self {
            ict,
            binding,
            landmarks,
            face,
            places,
            width: 0.0,
            middle: DVec3::ZERO,
            mood: None,
        };
        let jaw = [0, JAW - 1].map(|i| photographer.landmark(i, &mean));
        photographer.width = jaw[0].distance(jaw[1]);
        let all = (0..POINTS).map(|i| photographer.landmark(i, &mean));
        photographer.middle = all.sum::<DVec3>() / POINTS as f64;
        Ok(photographer)
    }

    /// Of people with expressions of a model of the same template.
    pub fn of_moods(mut self, model: &'a FaceModel, expressions: &'a Expressions) -> Self {
        self.mood = Some(Mood::new(model, expressions, &self.binding, self.ict));
        self
    }

    fn landmark(&self, i: usize, skin: &[DVec3]) -> DVec3 {
        let corners = self.landmarks[i].iter();
        corners.map(|&(place, weight)| skin[place] * weight).sum()
    }

    /// The photo of the person of a seed; everything of it is drawn from that seed, and what two
    /// settings share is the same.
    pub fn take(&self, seed: u64, setting: &Setting) -> Photograph {
        self.take_again(seed, 0, setting)
    }

    /// One of several photos of the person of a seed, each with a pose and a camera of its own: the first is that of
    /// [`Photographer::take`].
    pub fn take_again(&self, seed: u64, time: u64, setting: &Setting) -> Photograph {
        let mut person = self.ict.person(seed);
        let neutral = self.binding.truth(&person, self.ict);
        let weights = match &self.mood {
            Some(mood) => mood.show(seed, &self.binding, &neutral, &mut person),
            None => Vec::new(),
        };
        let skin = self.binding.truth(&person, self.ict);
        // Streams 1 to 5 are the scans', 6 to 8 the first photo's.
        let stream = |own: u64| Random::stream(seed, own + 100 * time);
        let mut random = stream(6);
        let mut between = |least: f64, most: f64| least + (most - least) * random.uniform();
        let angles = ANGLES.map(|most| between(-most, most).to_radians());
        let lens = between(LENS[0].ln(), LENS[1].ln()).exp();
        let focal = lens / FILM * f64::from(SIZE);
        let depth = focal * self.width / setting.face;
        let off = [0; 2].map(|_| between(-OFF_CENTRE, OFF_CENTRE));
        let rotation = Camera::turned(angles);
        let place = DVec2::from_array(off) / focal;
        let camera = Camera {
            rotation,
            translation: place.extend(1.0) * depth - rotation * self.middle,
            focal,
            centre: DVec2::splat(f64::from(SIZE) / 2.0),
        };
        let size = [SIZE as usize; 2];
        let raster = Raster::new(&camera, size, &person, &self.ict.triangles);
        let mut points: Vec<DVec2> = (0..POINTS)
            .map(|i| {
                let p = self.landmark(i, &skin);
                match i < JAW {
                    true => self.on_outline(p, &camera, &raster),
                    false => camera.project(p),
                }
            })
            .collect();
        let mut random = stream(7);
        if setting.slide > 0.0 {
            let slides: Vec<f64> = (0..JAW).map(|_| setting.slide * random.normal()).collect();
            let slid: Vec<DVec2> = (0..JAW)
                .map(|i| along(&points[..JAW], i, slides[i]))
                .collect();
            points[..JAW].copy_from_slice(&slid);
        }
        let mut random = stream(8);
        for point in &mut points {
            *point += DVec2::from_array([0; 2].map(|_| random.normal())) * setting.noise;
        }
        Photograph {
            time,
            seed,
            camera,
            points: points.into_iter().map(|p| p.to_array()).collect(),
            truth: self.places.iter().map(|&i| neutral[i]).collect(),
            person,
            weights,
        }
    }

    /// Where a point of the jaw is marked: itself, or if it is hidden, the end of what hides it, on
    /// the same level of the head.
    fn on_outline(&self, p: DVec3, camera: &Camera, raster: &Raster) -> DVec2 {
        let at = camera.project(p);
        let mut depth = raster.depth(at);
        if !(camera.to_camera(p).z > depth + BEHIND) {
            return at;
        }
        let out = DVec3::X * (p.x - self.middle.x).signum();
        let out = (camera.project(p + out) - at).normalize_or_zero();
        // Half a pixel at a time, across no more than the photo.
        let mut marked = at;
        for _ in 0..2 * SIZE {
            let next = marked + 0.5 * out;
            let there = raster.depth(next);
            if !(there < depth + BEHIND) {
                break;
            }
            (marked, depth) = (next, there);
        }
        marked
    }

    /// How far a shading of a face is off (normals of all of its vertices, and what light sends a surface), as
    /// a part of the true one: the root mean square over the face area's vertices that look to the
    /// camera, and over channels. How bright skin is of itself cannot be told from how bright the
    /// light is, so that one factor a channel is free.
    pub fn shading(
        &self,
        photo: &Photograph,
        truth: impl Fn(DVec3) -> DVec3,
        normals: &[DVec3],
        fitted: impl Fn(DVec3) -> DVec3,
    ) -> f64 {
        let facing = crate::fit::mesh::surface::normals(&photo.person, &self.ict.triangles);
        let facing = self.binding.truth(&facing, self.ict);
        let skin = self.binding.truth(&photo.person, self.ict);
        let eye = photo.camera.position();
        let mut ratios = Vec::new();
        for (&place, &v) in self.places.iter().zip(&self.face) {
            let normal = facing[place].normalize_or_zero();
            if normal.dot((eye - skin[place]).normalize()) > 0.3 {
                ratios.push(fitted(normals[v as usize]) / truth(normal));
            }
        }
        let mean = ratios.iter().sum::<DVec3>() / ratios.len() as f64;
        let squares = ratios
            .iter()
            .map(|r| (*r / mean - 1.0).length_squared() / 3.0);
        (squares.sum::<f64>() / ratios.len() as f64).sqrt()
    }

    /// The normals that the person has on the mesh of a fitted face (all vertices, mm, in any pose), in the photo's frame: no fit
    /// on that mesh has better ones. What is not bound to ICT's head is the fit's.
    pub fn normals(&self, photo: &Photograph, face: &[DVec3], mesh: &[[u32; 3]]) -> Vec<DVec3> {
        let fitted: Vec<DVec3> = self.face.iter().map(|&v| face[v as usize]).collect();
        let every: Vec<u32> = (0..fitted.len() as u32).collect();
        let even = vec![1.0; fitted.len()];
        let align = Rigid::fit(&fitted, &photo.truth, &every, &even);
        let mut all: Vec<DVec3> = face.iter().map(|&p| align.apply(p)).collect();
        let skin = self.binding.truth(&photo.person, self.ict);
        for (i, &v) in self.binding.vertices.iter().enumerate() {
            if self.binding.bound[i] {
                all[v as usize] = skin[i];
            }
        }
        crate::fit::mesh::surface::normals(&all, mesh)
    }

    /// How far a face is off (all vertices of the template, mm, in any pose), with the camera that
    /// goes with it.
    pub fn measure(&self, photo: &Photograph, face: &[DVec3], rotation: DMat3) -> Errors {
        let fitted: Vec<DVec3> = self.face.iter().map(|&v| face[v as usize]).collect();
        let every: Vec<u32> = (0..fitted.len() as u32).collect();
        let even = vec![1.0; fitted.len()];
        let align = Rigid::fit(&fitted, &photo.truth, &every, &even);
        let mean = |scale: f64| {
            let middle = fitted.iter().sum::<DVec3>() / fitted.len() as f64;
            let pairs = fitted.iter().zip(&photo.truth);
            let each = pairs.map(|(f, t)| align.apply(middle + (*f - middle) * scale).distance(*t));
            each.sum::<f64>() / fitted.len() as f64
        };
        // With the rotation that fits best, the scale that does is that of the projections.
        let truth_middle = photo.truth.iter().sum::<DVec3>() / fitted.len() as f64;
        let (mut across, mut square, mut true_square) = (0.0, 0.0, 0.0);
        for (f, t) in fitted.iter().zip(&photo.truth) {
            let (f, t) = (align.apply(*f) - truth_middle, *t - truth_middle);
            across += f.dot(t);
            square += f.length_squared();
            true_square += t.length_squared();
        }
        // From ICT's frame to the fit's, then to the camera's.
        let seen = rotation * align.rotation.transpose();
        let turn = glam::DQuat::from_mat3(&(seen * photo.camera.rotation.transpose()));
        Errors {
            rigid: mean(1.0),
            similarity: mean(across / square),
            size: (square / true_square).sqrt(),
            turn: turn.to_scaled_axis().length().to_degrees(),
        }
    }
}

/// The point that is `by` px along a line of points from point `i`; the line goes on straight
/// beyond its ends.
fn along(line: &[DVec2], i: usize, by: f64) -> DVec2 {
    let (mut at, mut left) = (i, by.abs());
    let ahead = by > 0.0;
    loop {
        let next = match ahead {
            true => at + 1,
            false => at.wrapping_sub(1),
        };
        let Some(&end) = line.get(next) else {
            let before = if ahead { at - 1 } else { at + 1 };
            let way = (line[at] - line[before]).normalize_or_zero();
            return line[at] + way * left;
        };
        let length = line[at].distance(end);
        if left <= length {
            return line[at] + (end - line[at]) * (left / length.max(1e-9));
        }
        left -= length;
        at = next;
    }
}

/// How far a fit is off.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Errors {
    /// The mean distance of the face area's vertices from where they belong, in the pose that fits
    /// best, mm.
    pub rigid: f64,
    /// The same in the pose and size that fit best.
    pub similarity: f64,
    /// How large the face is as a part of what it should be: its centroid size, the root mean
    /// square distance of its vertices from their middle.
    pub size: f64,
    /// By how much its rotation to the camera is off, degrees.
    pub turn: f64,
}

/// How far the weights of expressions are off, of which what is true is 0 for people at rest.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Mistaken {
    /// How many weights are above 0.05, from where on most expressions are seen.
    pub shown: f64,
    /// The sum of the weights of what is not shown in truth.
    pub spurious: f64,
    /// The sum of the differences of all weights from the true ones.
    pub off: f64,
}

/// A weight above this is seen, of most expressions.
const SHOWN: f64 = 0.05;

impl Mistaken {
    /// Of weights, and the true ones; none are none.
    pub fn of(fitted: &[f64], truth: &[f64]) -> Self {
        let truth = truth.iter().copied().chain(std::iter::repeat(0.0));
        let mut all = Self::default();
        for (&weight, truth) in fitted.iter().zip(truth) {
            all.shown += f64::from(u8::from(weight > SHOWN));
            all.spurious += if truth == 0.0 { weight } else { 0.0 };
            all.off += (weight - truth).abs();
        }
        all
    }

    /// The mean of some, of which there must be at least one.
    pub fn mean(all: &[Self]) -> Self {
        let mean = |of: fn(&Self) -> f64| all.iter().map(of).sum::<f64>() / all.len() as f64;
        Self {
            shown: mean(|m| m.shown),
            spurious: mean(|m| m.spurious),
            off: mean(|m| m.off),
        }
    }
}

/// What was measured on the photos of a setting.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// How they were taken.
    pub setting: Setting,
    /// What was measured on each.
    pub people: Vec<(u64, Errors)>,
    /// The mean of [`Errors::rigid`].
    pub rigid: f64,
    /// The mean of [`Errors::similarity`].
    pub similarity: f64,
    /// The mean of [`Errors::size`].
    pub size: f64,
    /// The median of [`Errors::turn`].
    pub turn: f64,
}

impl Report {
    /// Of these, of which there must be at least one.
    pub fn of(setting: &Setting, people: Vec<(u64, Errors)>) -> Self {
        let mean = |of: fn(&Errors) -> f64| {
            people.iter().map(|p| of(&p.1)).sum::<f64>() / people.len() as f64
        };
        let mut turns: Vec<f64> = people.iter().map(|p| p.1.turn).collect();
        turns.sort_by(f64::total_cmp);
        Self {
            setting: *setting,
            rigid: mean(|e| e.rigid),
            similarity: mean(|e| e.similarity),
            size: mean(|e| e.size),
            turn: turns.get(turns.len() / 2).copied().unwrap_or(f64::NAN),
            people,
        }
    }
}

/// Writes what another program needs to fit the same photos with the same model (`tests/peers`), into
/// a folder. Numbers in `.f32` files are little-endian, x, y, z a point:
/// - `mean.f32`: the 68 points and then the face area's vertices on the mean head, mm;
/// - `modes.f32`: how these move by each mode of the population, mm, a mode after another; the
///   modes' coefficients are independent and standard normal.
///
/// # Errors
/// When the folder cannot be written to, or the model lacks a landmark.
pub fn write_model(model: &FaceModel, photographer: &Photographer, dir: &Path) -> FitResult<()> {
    std::fs::create_dir_all(dir).map_err(|e| FitError::file(dir, e))?;
    let (mean, modes) = crate::photo::linear(model, &photographer.face)?;
    write_floats(&dir.join("mean.f32"), &mean)?;
    write_floats(&dir.join("modes.f32"), &modes)
}

/// Writes some points, as [`write_model`] has them.
///
/// # Errors
/// When the file cannot be written.
pub fn write_floats(path: &Path, points: &[DVec3]) -> FitResult<()> {
    let numbers = points.iter().flat_map(|p| p.as_vec3().to_array());
    let bytes: Vec<u8> = numbers.flat_map(f32::to_le_bytes).collect();
    write_atomically(path, &bytes)
}
