//! The colours of a head that wears a photo (semantic reshaping, section 4.2): its albedo, all round.
//!
//! Where the skin is seen its albedo is the photo's light over the shading, in the exposure and white
//! balance of the photo: a light that is everywhere cannot be told from a lighter skin, and people
//! look as in the photo when the usual shading is 1. What the camera does not
//! see of one side it mostly sees of the other, so that is taken from there. What remains has the
//! model's own colours, in the tone that the neighbourhood has: the logarithm of (seen / model's) is
//! continued smoothly over the mesh.

use glam::{DVec2, DVec3, Vec3};

use super::light::bare;
use super::raster::{NOTHING, Raster};
use super::sight::Sight;
use super::{Camera, Image, Light};
use crate::anatomy::Landmark;
use crate::srgb::{byte, linear};
use crate::{Error, FaceModel, Result};

/// An image in the model's texture coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    /// Its side, texels.
    pub size: usize,
    /// Row by row from the top (v = 1): sRGB, and how much of it is the photo's.
    pub rgba: Vec<u8>,
}

/// What is seen at a cosine of the first is not believed, of the second wholly.
const FACING: [f64; 2] = [0.25, 0.6];
/// Towards the outline, at a cosine below this, what has another tone than the skin is hair or what is
/// behind the head, not skin.
const INNER: f64 = 0.85;
/// Hair falls into foreheads: from so many mm above the brows on other tones are doubted, too, wholly
/// from the second on.
const FOREHEAD: [f32; 2] = [2.0, 9.0];
/// So it does into temples, which face the camera when a head is turned: from so far behind the outer
/// corners of the eyes on, mm, wholly from the second on; and from so far above the nose's base, below
/// which it is a beard, that is worn.
const TEMPLE: [[f32; 2]; 2] = [[4.0, 16.0], [0.0, 12.0]];
/// Around what is doubted there so many edges of the mesh are doubted as well.
const EDGE: usize = 2;
/// The logarithms of tones that are another: none of the first is, all of the second are.
const OTHER: [f64; 2] = [0.2, 0.42];
/// The photo is worn within this distance of the 68 points, mm, wholly within the second.
const AROUND: [f32; 2] = [35.0, 24.0];
/// No tone is farther than this factor from the model's colours.
const LARGEST_TONE: f64 = 5.0;
/// Light below this part of the usual is shadow, whose albedo nobody knows.
const DARKEST: f64 = 0.15;
/// Smoothing passes over the mesh: tones are continued over some 40 mm, and the rest is drawn to the
/// usual one.
const PASSES: usize = 120;
/// How strongly an unseen vertex is drawn to the usual tone, of its neighbours' pull.
const USUAL: f64 = 0.01;
/// A chart's colours are continued so many texels beyond its border, for whoever filters the image.
const MARGIN: usize = 6;
/// Sides of a texture, texels.
const SIZES: std::ops::RangeInclusive<usize> = 64..=4096;

impl Texture {
    /// Of a face (positions in mm, unit normals) that a camera sees in an image.
    ///
    /// # Errors
    /// When the mesh is not the model's, the face is not in the photo, or the size is not from 64 to
    /// 4096.
    pub fn of(
        model: &FaceModel,
        camera: &Camera,
        light: &Light,
        (places, normals): (&[DVec3], &[Vec3]),
        image: &Image,
        size: usize,
    ) -> Result<Self> {
        let topology = &model.parts().topology;
        super::check_mesh(places.len(), normals.len(), topology.regions.len())?;
        if !SIZES.contains(&size) {
            return Err(Error::Value {
                what: "a texture's side",
                wanted: format!("from {} to {} texels", SIZES.start(), SIZES.end()),
                got: size as f64,
            });
        }
        let [trust, facings] = trust(model, camera, places, normals)?;
        let mut worn = Worn {
            model,
            light,
            image,
            normals,
            seen: places.iter().map(|&p| camera.project(p)).collect(),
            trust,
            painted: topology.colours.iter().map(|&c| linear(c)).collect(),
            usual: DVec3::ONE,
        };
        let lit = (0..facings.len()).filter(|&v| facings[v] > INNER);
        let shading = lit.map(|v| light.shade(normals[v].as_dvec3()));
        worn.usual = median(shading).max(DVec3::splat(1e-6));
        worn.doubt(&facings);
        let tones = worn.tones();
        Ok(worn.bake(&tones, size))
    }
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
    let points: Vec<Vec3> = (parts.landmarks.iter())
        .filter(|l| l.name.starts_with("ibug_"))
        .map(|l| l.position(&parts.mean))
        .collect();
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
        trust[v] = f64::from(near) * facing;
    }
    Ok([trust, facings])
}

/// A face with what is known of its colours.
struct Worn<'a> {
    model: &'a FaceModel,
    light: &'a Light,
    image: &'a Image<'a>,
    normals: &'a [Vec3],
    /// Where vertices are in the photo, px.
    seen: Vec<DVec2>,
    trust: Vec<f64>,
    /// The model's own colours, linear.
    painted: Vec<DVec3>,
    /// The usual shading.
    usual: DVec3,
}

impl Worn<'_> {
    /// The albedo at a mix of three vertices, and how much it is believed.
    fn albedo(&self, corners: [usize; 3], share: [f64; 3]) -> (DVec3, f64) {
        let trust: f64 = (0..3).map(|i| share[i] * self.trust[corners[i]]).sum();
        if !(trust > 0.0) {
            return (DVec3::ZERO, 0.0);
        }
        let place: DVec2 = (0..3).map(|i| self.seen[corners[i]] * share[i]).sum();
        let normal: DVec3 = (0..3)
            .map(|i| self.normals[corners[i]].as_dvec3() * share[i])
            .sum();
        let Some(seen) = self.image.at(place) else {
            return (DVec3::ZERO, 0.0);
        };
        let shading = self.light.shade(normal.normalize_or_zero()) / self.usual;
        (seen / shading.max(DVec3::splat(DARKEST)), trust)
    }

    /// The logarithms of (albedo / model's colour) of the vertices that are seen.
    fn seen_tones(&self) -> Vec<(usize, DVec3)> {
        let limit = DVec3::splat(LARGEST_TONE.ln());
        let each = (0..self.trust.len()).filter_map(|v| {
            let (albedo, trust) = self.albedo([v; 3], [1.0, 0.0, 0.0]);
            let tone = (albedo.max(DVec3::splat(1e-3)) / self.painted[v]).map(f64::ln);
            (trust > 0.0).then(|| (v, tone.clamp(-limit, limit)))
        });
        each.collect()
    }

    /// Believes less of what is near the outline or the hairline and has another tone than the skin.
    fn doubt(&mut self, facings: &[f64]) {
        let tones = self.seen_tones();
        let inner = tones.iter().filter(|t| facings[t.0] > INNER);
        let usual = median(inner.map(|t| t.1));
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
        let mut hairless = vec![1.0; self.trust.len()];
        let within = |[from, to]: [f32; 2], x: f32| ((x - from) / (to - from)).clamp(0.0, 1.0);
        for (v, tone) in tones {
            let off = ((tone - usual).length() - OTHER[0]) / (OTHER[1] - OTHER[0]);
            let outer = ((INNER - facings[v]) / (INNER - FACING[1])).clamp(0.0, 1.0);
            let at = parts.mean[v];
            let above = within(FOREHEAD, at.y - brows);
            let beside = within(TEMPLE[0], corners - at.z) * within(TEMPLE[1], at.y - nose);
            let off = off.clamp(0.0, 1.0);
            self.trust[v] *= 1.0 - off * outer.max(f64::from(above));
            hairless[v] = 1.0 - off * f64::from(beside);
        }
        // The edge of hair is half skin. (Brows are beside the forehead, and theirs is worn.)
        let neighbours = self.neighbours();
        for _ in 0..EDGE {
            let before = hairless.clone();
            for (own, near) in hairless.iter_mut().zip(&neighbours) {
                let least = near.iter().map(|&n| before[n as usize]);
                *own = least.fold(*own, f64::min);
            }
        }
        for (trust, hairless) in self.trust.iter_mut().zip(hairless) {
            *trust *= hairless;
        }
    }

    /// The logarithm of (albedo / model's colour) of each vertex, all over the mesh.
    fn tones(&self) -> Vec<DVec3> {
        let mut known = self.seen_tones();
        known.retain(|k| self.trust[k.0] > 0.8);
        let usual = median(known.iter().map(|k| k.1));
        let mut tones = vec![usual; self.trust.len()];
        let mut is_known = vec![false; tones.len()];
        let mirror = &self.model.parts().topology.mirror;
        for &(v, tone) in &known {
            tones[v] = tone;
            is_known[v] = true;
        }
        for &(v, tone) in &known {
            let other = mirror[v] as usize;
            if !is_known[other] {
                tones[other] = tone;
            }
        }
        let seen: Vec<bool> = (0..tones.len())
            .map(|v| is_known[v] || is_known[mirror[v] as usize])
            .collect();
        let skin = self.model.parts().topology.part_vertices("skin");
        let neighbours = self.neighbours();
        for _ in 0..PASSES {
            for &v in &skin {
                let v = v as usize;
                if seen[v] || neighbours[v].is_empty() {
                    continue;
                }
                let sum: DVec3 = neighbours[v].iter().map(|&n| tones[n as usize]).sum();
                let count = neighbours[v].len() as f64;
                tones[v] = (sum / count + usual * USUAL) / (1.0 + USUAL);
            }
        }
        tones
    }

    /// The vertices around each of the skin's.
    fn neighbours(&self) -> Vec<Vec<u32>> {
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

    fn bake(&self, tones: &[DVec3], size: usize) -> Texture {
        let topology = &self.model.parts().topology;
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
            let own: DVec3 = (0..3)
                .map(|i| self.painted[corners[i]] * tones[corners[i]].map(f64::exp) * share[i])
                .sum();
            let (seen, trust) = self.albedo(corners, share);
            let mirrored = corners.map(|v| topology.mirror[v] as usize);
            let (other, far) = self.albedo(mirrored, share);
            let far = far * (1.0 - trust);
            let rest = (1.0 - trust - far).max(0.0);
            let colour = seen * trust + other * far + own * rest;
            let coded = colour.to_array().map(byte);
            pixel[..3].copy_from_slice(&coded);
            pixel[3] = (255.0 * (trust + far).min(1.0) + 0.5) as u8;
            filled[at] = true;
        }
        widen(&mut rgba, &mut filled, size);
        Texture { size, rgba }
    }
}

/// The median of each channel; 0 of none.
fn median(tones: impl Iterator<Item = DVec3>) -> DVec3 {
    let tones: Vec<DVec3> = tones.collect();
    DVec3::from_array([0, 1, 2].map(|channel| {
        let mut all: Vec<f64> = tones.iter().map(|t| t[channel]).collect();
        all.sort_unstable_by(f64::total_cmp);
        all.get(all.len() / 2).copied().unwrap_or(0.0)
    }))
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
