//! Faces for the report, drawn without a GPU.

use glam::DVec3;
use rayon::prelude::*;

use super::{Validated, positions, random_face};
use crate::fit::FitResult;
use crate::fit::learn::FEATURES;
use crate::fit::picture::colour_bar;
use crate::fit::picture::render::{self, Camera, Image, Options};
use crate::{Face, FaceModel};

/// Modes of each block that are shown, and where on them.
const MODES: usize = 4;
const SIGMAS: [f64; 4] = [-3.0, -1.0, 1.0, 3.0];
/// Random faces in the gallery.
const GALLERY: u64 = 18;
/// Frames of a morph.
const FRAMES: usize = 7;
/// What parts a bright error from a dark one, mm.
const LARGEST_ERROR: f64 = 2.0;

/// The first modes of a block at -3, -1, 1 and 3 sigma (a row a mode), in the colour of how far
/// they move (Fig. 7). The bar says how far, mm.
pub fn eigenmeshes(model: &FaceModel, block: usize) -> FitResult<Image> {
    let parts = model.parts();
    let own = &parts.blocks[block];
    let whole = own.surround.is_none();
    let height = own
        .support
        .iter()
        .map(|&v| f64::from(parts.mean[v as usize].y))
        .sum::<f64>()
        / own.support.len() as f64;
    let camera = match whole {
        true => Camera::around(DVec3::new(0.0, -25.0, -40.0), 850.0, 30.0, 0.0),
        false => Camera::around(DVec3::new(0.0, height, -30.0), 560.0, 30.0, 4.0),
    };
    let mean: Vec<DVec3> = parts.mean.iter().map(|p| p.as_dvec3()).collect();
    let faces = own
        .coefficients()
        .take(MODES)
        .flat_map(|k| SIGMAS.map(|sigma| (k, sigma)))
        .map(|(k, sigma)| {
            let mut coefficients = vec![0.0; parts.coefficients()];
            coefficients[k] = sigma as f32;
            let mut face = model.face();
            face.set_coefficients(&coefficients)?;
            Ok(positions(&face))
        })
        .collect::<FitResult<Vec<_>>>()?;
    let far = |face: &[DVec3]| -> Vec<f64> {
        face.iter()
            .zip(&mean)
            .map(|(p, m)| p.distance(*m))
            .collect()
    };
    let largest = faces.iter().flat_map(|face| far(face)).fold(0.0, f64::max);
    // A round number for the bar.
    let largest = largest.ceil();
    let topology = &parts.topology;
    let triangles = topology.triangles();
    let images: Vec<Image> = faces
        .par_iter()
        .map(|face| {
            let colours: Vec<[u8; 3]> = (far(face).iter())
                .map(|&d| colour_bar::colour(d, largest))
                .collect();
            let options = small(220, 250, camera);
            render::face(&triangles, &topology.parts, face, &colours, &options)
        })
        .collect();
    Ok(colour_bar::below(
        &Image::grid(&images, SIGMAS.len())?,
        largest,
    ))
}

/// Random faces (Fig. 9).
pub fn gallery(model: &FaceModel) -> FitResult<Image> {
    let camera = Camera::around(DVec3::new(0.0, -25.0, -40.0), 850.0, 25.0, 0.0);
    let images = (1..=GALLERY)
        .into_par_iter()
        .map(|seed| Ok(draw(&random_face(model, seed)?, &small(230, 290, camera))))
        .collect::<FitResult<Vec<_>>>()?;
    Image::grid(&images, 6)
}

/// The first control of each feature from one of its extremes to the other (Fig. 10), a row each.
pub fn morph(model: &FaceModel) -> FitResult<Image> {
    let camera = Camera::around(DVec3::new(0.0, -25.0, -40.0), 800.0, 30.0, 0.0);
    let images = FEATURES
        .par_iter()
        .flat_map(|rule| (0..FRAMES).into_par_iter().map(move |frame| (rule, frame)))
        .map(|(rule, frame)| {
            let mut face = model.face();
            // The ends of a slider are the limits, where one in a thousand is.
            let at = 0.002 + 0.996 * frame as f64 / (FRAMES - 1) as f64;
            face.set(&format!("{} 1", rule.name), at)?;
            Ok(draw(&face, &small(190, 230, camera)))
        })
        .collect::<FitResult<Vec<_>>>()?;
    Image::grid(&images, FRAMES)
}

/// Held-out faces: the one that came back best, the one in the middle and the worst (a row each);
/// input and output from the front and from the side, and the distance between them (Fig. 11).
pub fn reconstructions(validated: &Validated) -> FitResult<Image> {
    let mut order: Vec<usize> = (0..validated.pairs.len()).collect();
    order.sort_by(|&a, &b| validated.pairs[a].rms.total_cmp(&validated.pairs[b].rms));
    let picked = [order[0], order[order.len() / 2], order[order.len() - 1]];
    let template = validated.template;
    let triangles = template.triangles();
    let parts = &template.topology.parts;
    let mut jobs = Vec::new();
    for pair in picked.map(|i| &validated.pairs[i]) {
        let errors: Vec<[u8; 3]> = (pair.input.iter().zip(&pair.output))
            .map(|(a, b)| colour_bar::colour(a.distance(*b), LARGEST_ERROR))
            .collect();
        for yaw in [0.0, 70.0] {
            jobs.push((&pair.input, template.topology.colours.clone(), yaw));
            jobs.push((&pair.output, template.topology.colours.clone(), yaw));
        }
        jobs.push((&pair.output, errors, 20.0));
    }
    let images: Vec<Image> = jobs
        .par_iter()
        .map(|(face, colours, yaw)| {
            let camera = Camera::around(DVec3::new(0.0, -25.0, -50.0), 850.0, *yaw, 0.0);
            render::face(&triangles, parts, face, colours, &small(240, 300, camera))
        })
        .collect();
    Ok(colour_bar::below(&Image::grid(&images, 5)?, LARGEST_ERROR))
}

fn small(width: usize, height: usize, camera: Camera) -> Options {
    Options {
        samples: 2,
        ..Options::new(width, height, camera)
    }
}

fn draw(face: &Face, options: &Options) -> Image {
    let topology = &face.model().parts().topology;
    render::face(
        &topology.triangles(),
        &topology.parts,
        &positions(face),
        &topology.colours,
        options,
    )
}
