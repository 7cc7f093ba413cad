//! Scans of heads whose truth is known without anybody's data: the generic head, bent.

#![allow(dead_code)] // Each test binary uses a part of it.

use std::sync::OnceLock;

use glam::DVec3;
use phiz::Random;
use phiz::fit::head::expression;
use phiz::fit::head::generic_head;
use phiz::fit::head::people::People;
use phiz::fit::head::template::Template;
use phiz::fit::mesh::resample::Resampler;
use phiz::fit::register::{Pulls, Registrar};
use phiz::fit::scan::Scan;

use crate::base_mesh;

/// The generic head.
pub fn plain() -> Option<&'static Template> {
    static PLAIN: OnceLock<Option<Template>> = OnceLock::new();
    PLAIN
        .get_or_init(|| Some(generic_head::build(&base_mesh::folder()?).expect("builds")))
        .as_ref()
}

/// The generic head with what the program knows of people and of expressions.
pub fn template() -> Option<&'static Template> {
    static TEMPLATE: OnceLock<Option<Template>> = OnceLock::new();
    TEMPLATE
        .get_or_init(|| {
            let (plain, folder) = (plain()?, base_mesh::folder()?);
            let people = People::bundled().expect("is whole");
            let mut template = people.give(plain).expect("of this topology");
            template.expressions = expression::visible(&template, &folder).expect("reads");
            Some(template)
        })
        .as_ref()
}

/// What registers to [`template`].
pub fn registrar() -> Option<&'static Registrar<'static>> {
    static REGISTRAR: OnceLock<Option<Registrar<'static>>> = OnceLock::new();
    REGISTRAR
        .get_or_init(|| Some(Registrar::new(template()?).expect("prepares")))
        .as_ref()
}

/// All vertices of the head of a seed: the rest pose under five waves of 120 to 250 mm, which
/// move it by some 3 mm, and which no prior was learned from.
pub fn bent(template: &Template, seed: u64) -> Vec<DVec3> {
    let mut random = Random::new(seed);
    let mut vector = || DVec3::from_array(std::array::from_fn(|_| random.normal()));
    let waves: Vec<(DVec3, DVec3)> = (0..5).map(|_| (vector(), vector())).collect();
    let bend = |p: DVec3| -> DVec3 {
        let waves = (0..).zip(&waves).map(|(i, &(along, by))| {
            let length = 120.0 + 32.0 * f64::from(i);
            let phase = std::f64::consts::TAU * p.dot(along.normalize_or_zero()) / length;
            by * 1.2 * (phase + f64::from(i)).sin()
        });
        p + waves.sum::<DVec3>()
    };
    template.positions.iter().map(|&p| bend(p)).collect()
}

/// The skin of a head as the template has it, in triangles and numbering of its own.
pub fn skin(template: &Template, head: &[DVec3]) -> Scan {
    let vertices = template.part_vertices("skin").expect("it has skin");
    let mut triangles = template.part_triangles("skin").expect("it has skin");
    for corner in triangles.as_flattened_mut() {
        *corner = vertices.binary_search(corner).expect("of the skin") as u32;
    }
    Scan {
        positions: vertices.iter().map(|&v| head[v as usize]).collect(),
        triangles,
        scale: 1.0,
        ..Scan::default()
    }
}

/// The skin of a head with other vertices and other triangles, some 90,000.
pub fn scan(template: &Template, head: &[DVec3], seed: u64) -> Scan {
    let skin = skin(template, head);
    let resampler = Resampler::new(skin.positions.len(), &skin.triangles);
    let (points, triangles) = resampler.resample(&skin.positions, &mut Random::new(seed));
    let on = |p: &phiz::fit::mesh::resample::SurfacePoint| p.on(&skin.positions, &skin.triangles);
    Scan {
        positions: points.iter().map(on).collect(),
        triangles,
        ..skin
    }
}

/// The 68 iBUG points of a head.
pub fn points(template: &Template, head: &[DVec3]) -> Pulls {
    let named = template.landmarks.iter().enumerate();
    named
        .filter(|(_, landmark)| landmark.name.starts_with("ibug_"))
        .map(|(i, _)| (i, template.landmark(i, head)))
        .collect()
}
