//! Pictures of a template and of a model, for people to check and for the documentation.

use std::path::Path;

use glam::DVec3;

use super::FitResult;
use super::learn::FEATURES;
use super::render::{self, Camera, Image, Options};
use crate::{Face, FaceModel, Randomize};

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
