//! What the generic head has learned from people: their mean as its rest pose, a prior, and where
//! on it the landmarks are set.
//!
//! It is kept as displacements of the base mesh's vertices ([`cage`](super::cage)), a quarter of the
//! template's, so that it is small enough to come with the program: `people.phiz` beside this file,
//! learned from people of ICT-FaceKit (MIT) by `./build.sh model`. The template that it makes is
//! still a subdivision of the base mesh.

use glam::DVec3;
use rayon::prelude::*;

use super::cage::Cage;
use super::generic_head::mirror_name;
use super::prior::ShapePrior;
use super::template::{Landmark, Template};
use crate::Error;
use crate::blob::record::record;
use crate::blob::{Blob, BlobWriter, Kind, pack, unpack};
use crate::fit::mesh::align::mean_of;
use crate::fit::mesh::mirror::{even, flip};
use crate::fit::mesh::surface::Surface;
use crate::fit::{FitError, FitResult};
use crate::quantise::Quantised;

/// The people that come with the program.
const BUNDLED: &[u8] = include_bytes!("people.phiz");

/// What rounding may move the vertices of random faces by, mm RMS: less than the cage itself loses.
const ERROR: f64 = 0.08;

/// Landmarks farther than this from a face's surface were not set on it, mm.
const OFF: f64 = 5.0;

/// A registered face and where its landmarks were set.
#[derive(Debug, Clone, PartialEq)]
pub struct RegisteredFace {
    /// All vertices of the template, mm.
    pub positions: Vec<DVec3>,
    /// Landmarks in the same pose: place in the template's list, position in mm. May be empty.
    pub points: Vec<(usize, DVec3)>,
}

/// Rest pose, prior and landmarks of a template, on its base mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct People {
    /// Displacement of each base vertex (those of [`Cage::vertices`]) from the plain rest pose, mm.
    rest: Vec<DVec3>,
    /// The prior's modes on the base vertices, mm at one standard deviation.
    modes: Quantised,
    /// The landmarks on the template.
    landmarks: Vec<Landmark>,
    /// Vertices of the template that all this is for.
    vertices: u32,
}

/// The header of the bundle.
struct Header {
    vertices: u32,
    base_vertices: u32,
    modes: u32,
    step: f32,
    landmarks: Vec<Landmark>,
}

record! { Header { vertices, base_vertices, modes, step, landmarks } }

impl People {
    /// Learns from faces registered to `template`, whose topology is that of the `plain` one.
    ///
    /// # Errors
    /// With fewer than three faces, or when they do not vary.
    pub fn learn(
        template: &Template,
        plain: &Template,
        faces: &[RegisteredFace],
    ) -> FitResult<Self> {
        let (points, faces): (Vec<_>, Vec<_>) = faces
            .iter()
            .map(|face| (face.points.clone(), face.positions.clone()))
            .unzip();
        let (mean, prior) = ShapePrior::learn(template, &faces)?;
        let cage = Cage::new(plain)?;
        let moved: Vec<DVec3> = mean
            .iter()
            .zip(&plain.positions)
            .map(|(m, p)| *m - *p)
            .collect();
        let modes: Vec<f64> = prior
            .modes
            .par_iter()
            .map(|mode| cage.fit(mode))
            .collect::<Vec<_>>()
            .into_iter()
            .flatten()
            .flat_map(|d| d.to_array())
            .collect();
        Ok(Self {
            rest: cage.fit(&moved),
            modes: Quantised::new(&modes, Quantised::step_for(ERROR, prior.modes.len())),
            landmarks: landmarks(template, &mean, &faces, &points)?,
            vertices: template.positions.len() as u32,
        })
    }

    /// The people that come with the program.
    ///
    /// # Errors
    /// When the bundle is damaged.
    pub fn bundled() -> FitResult<Self> {
        Self::from_bytes(BUNDLED)
    }

    /// Gives rest pose, prior and landmarks to the plain template.
    ///
    /// # Errors
    /// When they were learned on another topology.
    pub fn give(&self, plain: &Template) -> FitResult<Template> {
        let cage = Cage::new(plain)?;
        let base = self.rest.len();
        if base != cage.vertices.len() || self.vertices as usize != plain.positions.len() {
            let cause = "what was learned from people is for another base mesh";
            return Err(FitError::Input(cause.into()));
        }
        let mut template = plain.clone();
        for (p, d) in template.positions.iter_mut().zip(cage.apply(&self.rest)) {
            *p += d;
        }
        // The base mesh's own asymmetry is rounding; the template has none.
        template.positions = even(&template.positions, &template.topology.mirror);
        let origin = eyes_middle(&template)?;
        template.positions.iter_mut().for_each(|p| *p -= origin);
        let step = f64::from(self.modes.step);
        let values: Vec<f64> = self
            .modes
            .integers
            .iter()
            .map(|&i| f64::from(i) * step)
            .collect();
        let modes = values
            .par_chunks_exact(3 * base)
            .map(|mode| {
                let mode: Vec<DVec3> = mode.chunks_exact(3).map(DVec3::from_slice).collect();
                cage.apply(&mode)
            })
            .collect();
        template.prior = Some(ShapePrior { modes });
        template.landmarks.clone_from(&self.landmarks);
        Ok(template)
    }

    /// The bytes of the bundle: a gzipped blob.
    ///
    /// # Errors
    /// When the header cannot be written.
    pub fn to_bytes(&self) -> FitResult<Vec<u8>> {
        let base = self.rest.len();
        let header = Header {
            vertices: self.vertices,
            base_vertices: base as u32,
            modes: (self.modes.integers.len() / (3 * base).max(1)) as u32,
            step: self.modes.step,
            landmarks: self.landmarks.clone(),
        };
        let mut blob = BlobWriter::new(Kind::People, &header);
        let rest: Vec<f32> = self
            .rest
            .iter()
            .flat_map(|d| d.as_vec3().to_array())
            .collect();
        blob.section("rest", &rest);
        blob.section("modes", &self.modes.integers);
        Ok(pack(&blob.finish()?)?)
    }

    /// Reads a bundle.
    ///
    /// # Errors
    /// When it is damaged.
    pub fn from_bytes(bytes: &[u8]) -> FitResult<Self> {
        let unpacked = unpack(bytes)?;
        let blob = Blob::parse(&unpacked, Kind::People)?;
        let header: Header = blob.header()?;
        let (base, modes) = (header.base_vertices as usize, header.modes as usize);
        if base > 1 << 20 || modes > 1000 {
            return Err(Error::Blob("more modes or vertices than any head has".into()).into());
        }
        let rest = blob.section::<f32>("rest", 3 * base)?;
        let integers = blob.section::<i16>("modes", 3 * base * modes)?;
        let known = |l: &Landmark| l.stencil.iter().all(|s| s.0 < header.vertices);
        if !(rest.iter().all(|x| x.abs() < 1e4) && header.landmarks.iter().all(known)) {
            return Err(Error::Blob("its numbers are not sound".into()).into());
        }
        Ok(Self {
            rest: rest
                .chunks_exact(3)
                .map(|d| glam::Vec3::from_slice(d).as_dvec3())
                .collect(),
            modes: Quantised::from_parts(header.step, integers)?,
            landmarks: header.landmarks,
            vertices: header.vertices,
        })
    }
}

/// The midpoint between the eyeballs' centres, which is a template's origin.
fn eyes_middle(template: &Template) -> FitResult<DVec3> {
    let centre = |part: &str| -> FitResult<DVec3> {
        let vertices = template.part_vertices(part)?;
        let sum: DVec3 = vertices
            .iter()
            .map(|&v| template.positions[v as usize])
            .sum();
        Ok(sum / vertices.len() as f64)
    };
    Ok((centre("left eyeball")? + centre("right eyeball")?) / 2.0)
}

/// The template's landmarks where people set them: for each, the faces' own points carried to the
/// mean and averaged over faces and sides. One that no face has stays.
fn landmarks(
    template: &Template,
    mean: &[DVec3],
    faces: &[Vec<DVec3>],
    points: &[Vec<(usize, DVec3)>],
) -> FitResult<Vec<Landmark>> {
    let skin = template.part_triangles("skin")?;
    let on = |corners: [u32; 3], weights: [f64; 3], face: &[DVec3]| -> DVec3 {
        (0..3).map(|i| face[corners[i] as usize] * weights[i]).sum()
    };
    let placed: Vec<Vec<(usize, DVec3)>> = faces
        .par_iter()
        .zip(points)
        .map(|(face, points)| {
            let surface = Surface::new(face, &skin);
            points
                .iter()
                .filter_map(|&(l, p)| {
                    let hit = surface.closest(p, OFF)?;
                    Some((l, on(skin[hit.triangle as usize], hit.weights, mean)))
                })
                .collect()
        })
        .collect();
    let rest = Surface::new(mean, &skin);
    let of = |name: &str| -> Vec<DVec3> {
        let index = template.landmarks.iter().position(|l| l.name == name);
        let all = placed.iter().flatten().filter(|p| Some(p.0) == index);
        all.map(|p| p.1).collect()
    };
    Ok(template
        .landmarks
        .iter()
        .map(|landmark| {
            let mut spots = of(&landmark.name);
            spots.extend(of(&mirror_name(&landmark.name)).into_iter().map(flip));
            if spots.is_empty() {
                return landmark.clone();
            }
            let spots: Vec<Vec<DVec3>> = spots.into_iter().map(|p| vec![p]).collect();
            let Some(hit) = rest.closest(mean_of(&spots)[0], f64::MAX) else {
                return landmark.clone();
            };
            let corners = skin[hit.triangle as usize].into_iter().zip(hit.weights);
            Landmark {
                name: landmark.name.clone(),
                stencil: corners.filter(|c| c.1 > 1e-6).collect(),
            }
        })
        .collect())
}
