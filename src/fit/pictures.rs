//! Pictures of a template and of a model, for people to check and for the documentation.

use std::path::Path;

use glam::DVec3;

use super::FitResult;
use super::learn::FEATURES;
use super::render::{self, Camera, Image, Options};
use super::template::Template;
use crate::{Face, FaceModel, Randomize};

/// Distinct colours for regions, in the order of their numbers.
const REGION_COLOURS: [[u8; 3]; 8] = [
    [86, 140, 226],
    [120, 190, 240],
    [236, 150, 60],
    [214, 80, 96],
    [112, 186, 100],
    [170, 120, 210],
    [206, 200, 190],
    [120, 120, 120],
];

/// Writes pictures of the template for a person to check: `head.png` (front, three-quarter,
/// side), `regions.png` and `landmarks.png`.
///
/// # Errors
/// When a picture cannot be written.
pub fn of_template(template: &Template, folder: &Path) -> FitResult<()> {
    let regions: Vec<[u8; 3]> = template
        .topology
        .regions
        .iter()
        .map(|&r| REGION_COLOURS[r as usize % REGION_COLOURS.len()])
        .collect();
    let triangles = template.triangles();
    let plain = vec![[205, 190, 180]; template.positions.len()];
    for (name, colours) in [
        ("head", &template.topology.colours),
        ("regions", &regions),
        ("landmarks", &plain),
    ] {
        let mut images = Vec::new();
        for yaw in [0.0, 40.0, 90.0] {
            let camera = Camera::around(DVec3::new(0.0, -25.0, -50.0), 900.0, yaw, 2.0);
            let options = Options::new(700, 900, camera);
            let mut image = render::face(
                &triangles,
                &template.topology.parts,
                &template.positions,
                colours,
                &options,
            );
            if name == "landmarks" {
                for index in 0..template.landmarks.len() {
                    let p = template.landmark(index, &template.positions);
                    let hidden = p.x < -1.0 && yaw > 45.0;
                    if !hidden {
                        image.dot(&camera, p, 4.0, [200, 30, 40]);
                    }
                }
            }
            images.push(image);
        }
        Image::grid(&images, 3)?.save(&folder.join(format!("{name}.png")))?;
    }
    Ok(())
}

/// Modes of each feature that are drawn.
const MODES: usize = 4;

/// `modes-FEATURE.png` for each feature (a column a mode, at -3 sigma, the mean, +3 sigma) and
/// `faces.png` (random faces).
///
/// # Errors
/// When a picture cannot be written.
pub fn of_model(model: &FaceModel, folder: &Path) -> FitResult<()> {
    for (b, feature) in FEATURES.iter().enumerate() {
        let block = &model.parts().blocks[b];
        let height = block
            .support
            .iter()
            .map(|&v| f64::from(model.parts().mean[v as usize].y))
            .sum::<f64>()
            / block.support.len() as f64;
        // Near enough for a nostril's rim, far enough that the border and what follows are in view.
        let camera = Camera::around(DVec3::new(0.0, height, -30.0), 560.0, 30.0, 4.0);
        let mut rows = Vec::new();
        for sigma in [-3.0, 0.0, 3.0] {
            for k in block.coefficients().take(MODES) {
                let mut coefficients = vec![0.0; model.parts().coefficients()];
                coefficients[k] = sigma;
                let mut face = model.face();
                face.set_coefficients(&coefficients)?;
                rows.push(draw(&face, &Options::new(420, 420, camera)));
            }
        }
        let columns = rows.len() / 3;
        Image::grid(&rows, columns)?.save(&folder.join(format!("modes-{}.png", feature.name)))?;
    }
    let faces = (1..=12)
        .map(|seed| {
            let mut face = model.face();
            face.randomize(&Randomize {
                seed: Some(seed),
                ..Randomize::default()
            })?;
            let camera = Camera::around(DVec3::new(0.0, -25.0, -40.0), 1000.0, 25.0, 0.0);
            Ok(draw(&face, &Options::new(320, 400, camera)))
        })
        .collect::<FitResult<Vec<_>>>()?;
    Image::grid(&faces, 6)?.save(&folder.join("faces.png"))
}

/// A face in the model's colours.
fn draw(face: &Face, options: &Options) -> Image {
    let topology = &face.model().parts().topology;
    let positions: Vec<DVec3> = face.positions().iter().map(|p| p.as_dvec3()).collect();
    render::face(
        &topology.triangles(),
        &topology.parts,
        &positions,
        &topology.colours,
        options,
    )
}
