//! The colours of a head that wears a photo (semantic reshaping, section 4.2): its albedo, all round.
//!
//! Where the skin is seen its albedo is the photo's light over the shading, in the exposure and white
//! balance of the photo, unless it is too dark: a light that is everywhere cannot be told from a lighter skin, and people
//! look as in the photo when the usual shading is 1. What the camera does not
//! see of one side it mostly sees of the other, so that is taken from there. What remains has the
//! model's own colours, in the tone that the neighbourhood has: the logarithm of (seen / model's) is
//! continued smoothly over the mesh.

use glam::{DVec2, DVec3, Vec3};

use super::raster::{NOTHING, Raster};
use super::skin::{Skin, median};
use super::{Camera, Image, Light};
use crate::srgb::byte;
use crate::{Error, FaceModel, Result};

/// An image in the model's texture coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    /// Its side, texels.
    pub size: usize,
    /// Row by row from the top (v = 1): sRGB, and how much of it is the photo's.
    pub rgba: Vec<u8>,
}

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
        mesh: (&[DVec3], &[Vec3]),
        image: &Image,
        size: usize,
    ) -> Result<Self> {
        if !SIZES.contains(&size) {
            return Err(Error::Value {
                what: "a texture's side",
                wanted: format!("from {} to {} texels", SIZES.start(), SIZES.end()),
                got: size as f64,
            });
        }
        let skin = Skin::new(model, camera, light, mesh, image)?;
        Ok(bake(&skin, &tones(&skin), size))
    }
}

/// The logarithm of (albedo / model's colour) of each vertex, all over the mesh.
fn tones(skin: &Skin) -> Vec<DVec3> {
    let mut known = skin.seen_tones();
    known.retain(|k| skin.trust[k.0] > 0.8);
    let usual = median(known.iter().filter(|k| skin.beardless(k.0)).map(|k| k.1));
    let mut tones = vec![usual; skin.trust.len()];
    let mut is_known = vec![false; tones.len()];
    let mirror = &skin.model.parts().topology.mirror;
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
    let all = skin.model.parts().topology.part_vertices("skin");
    let neighbours = skin.neighbours();
    for _ in 0..PASSES {
        for &v in &all {
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

fn bake(skin: &Skin, tones: &[DVec3], size: usize) -> Texture {
    let topology = &skin.model.parts().topology;
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
            .map(|i| skin.painted[corners[i]] * tones[corners[i]].map(f64::exp) * share[i])
            .sum();
        let (seen, trust) = skin.albedo(corners, share);
        let trust = trust * skin.strandless(corners, share, seen, own);
        let mirrored = corners.map(|v| topology.mirror[v] as usize);
        let (other, far) = skin.albedo(mirrored, share);
        let far = far * (1.0 - trust) * skin.strandless(mirrored, share, other, own);
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
