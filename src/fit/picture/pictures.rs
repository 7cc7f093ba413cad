//! Pictures of a template, of a model and of a registration, for people to check and for the
//! documentation.

use std::path::Path;

use glam::DVec3;

use rayon::prelude::*;

use super::colour_bar;
use super::render::{self, Camera, Image, Mesh, Options};
use crate::fit::head::template::Template;
use crate::fit::learn::FEATURES;
use crate::fit::mesh::align::Rigid;
use crate::fit::mesh::surface::Surface;
use crate::fit::scan::{Scan, Texture};
use crate::fit::truth::ict::Ict;
use crate::fit::{FitError, FitResult};
use crate::{Expressions, Face, FaceModel, Performance, Randomize};

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

/// `modes-FEATURE.png` for each feature (a column a mode, at -3 sigma, the mean, +3 sigma),
/// `attributes.png` (heads at both ends of each attribute) and
/// `faces.png` (random faces). The folder is made.
///
/// # Errors
/// When the model has not all features, as a head alone has none, and when a picture cannot be written.
pub fn of_model(model: &FaceModel, folder: &Path) -> FitResult<()> {
    if model.parts().blocks.len() < FEATURES.len() {
        let cause = "a head alone, without the modes that pictures of a model show";
        return Err(FitError::Input(cause.into()));
    }
    std::fs::create_dir_all(folder).map_err(|e| FitError::file(folder, e))?;
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
    semantic(model, folder)?;
    attributes(model, folder)?;
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

/// `people.png`: eight people of ICT-FaceKit that the default model has not learned from, and below
/// them eight random faces of a model, all in clay.
///
/// # Errors
/// When the picture cannot be written.
pub fn of_people(model: &FaceModel, ict: &Ict, folder: &Path) -> FitResult<()> {
    let (first, second) = (ict.landmarks[36] as usize, ict.landmarks[45] as usize);
    let eyes = (ict.neutral[first] + ict.neutral[second]) / 2.0;
    let options = |centre: DVec3| {
        let camera = Camera::around(centre + DVec3::new(0.0, -25.0, -40.0), 1000.0, 25.0, 0.0);
        Options::new(320, 400, camera)
    };
    let clay = |positions: &[DVec3], triangles: &[[u32; 3]], centre: DVec3| {
        let mesh = Mesh {
            positions,
            triangles,
            colours: &vec![CLAY; positions.len()],
            shine: 0.05,
            texture: None,
        };
        super::render::render(&[mesh], &options(centre))
    };
    let mut pictures: Vec<Image> = (9000..9008)
        .map(|seed| clay(&ict.person(seed), &ict.triangles, eyes - DVec3::Z * 12.0))
        .collect();
    let triangles = model.parts().topology.triangles();
    for seed in 1..=8 {
        let mut face = model.face();
        face.randomize(&Randomize {
            seed: Some(seed),
            ..Randomize::default()
        })?;
        let positions: Vec<DVec3> = face.positions().iter().map(|p| p.as_dvec3()).collect();
        pictures.push(clay(&positions, &triangles, DVec3::ZERO));
    }
    Image::grid(&pictures, 8)?.save(&folder.join("people.png"))
}

/// What `expressions.png` shows, a column each.
const SHOWN: [&[(&str, f64)]; 10] = [
    &[],
    &[
        ("mouthSmileLeft", 0.8),
        ("mouthSmileRight", 0.8),
        ("cheekSquintLeft", 0.5),
        ("cheekSquintRight", 0.5),
    ],
    &[("jawOpen", 0.8)],
    &[("eyeBlinkLeft", 1.0), ("eyeBlinkRight", 1.0)],
    &[("eyeBlinkLeft", 1.0), ("mouthSmileLeft", 0.6)],
    &[("mouthPucker", 1.0)],
    &[
        ("browInnerUp", 1.0),
        ("eyeWideLeft", 1.0),
        ("eyeWideRight", 1.0),
        ("mouthFunnel", 0.7),
    ],
    &[
        ("browDownLeft", 1.0),
        ("browDownRight", 1.0),
        ("noseSneerLeft", 1.0),
        ("noseSneerRight", 1.0),
    ],
    &[
        ("mouthFrownLeft", 1.0),
        ("mouthFrownRight", 1.0),
        ("browInnerUp", 0.8),
    ],
    &[
        ("eyeLookInLeft", 1.0),
        ("eyeLookOutRight", 1.0),
        ("cheekPuff", 1.0),
    ],
];

/// `expressions.png`: expressions on the mean and on three random faces of a model, a row each.
///
/// # Errors
/// When the picture cannot be written, or an expression is missing.
pub fn of_expressions(
    model: &FaceModel,
    expressions: &Expressions,
    folder: &Path,
) -> FitResult<()> {
    let topology = &model.parts().topology;
    let triangles = topology.triangles();
    let camera = Camera::around(DVec3::new(0.0, -40.0, -20.0), 640.0, 12.0, 2.0);
    let mut pictures = Vec::new();
    for seed in [None, Some(1), Some(3), Some(9)] {
        let mut face = model.face();
        if seed.is_some() {
            face.randomize(&Randomize {
                seed,
                ..Randomize::default()
            })?;
        }
        for shown in SHOWN {
            let mut performance = Performance::new(expressions);
            for &(name, weight) in shown {
                performance.set(name, weight)?;
            }
            performance.perform(&face)?;
            let positions = performance.positions().iter().map(|p| p.as_dvec3());
            pictures.push(render::face(
                &triangles,
                &topology.parts,
                &positions.collect::<Vec<_>>(),
                &topology.colours,
                &Options::new(240, 290, camera),
            ));
        }
    }
    Image::grid(&pictures, SHOWN.len())?.save(&folder.join("expressions.png"))
}

/// Clay, for shape alone.
const CLAY: [u8; 3] = [198, 186, 176];
/// Scans without colours.
const PLAIN: [u8; 3] = [178, 184, 192];
/// Vertices that do not lie on the scan.
const NO_SCAN: [u8; 3] = [150, 150, 152];
/// The length that has the brightest colour, mm.
const LARGEST_ERROR: f64 = 1.0;

/// One picture of a registration, from the front and from three-quarter: the scan, the registered
/// head with `texture` (of [`texture::bake`](crate::fit::register::texture::bake); without one in the template's
/// colours), in clay, and its distance to the scan's surface in colour, with a bar in mm; grey
/// where the head is not `covered`. The distance of a vertex is the largest at it and at the middles
/// of its edges: vertices alone are set on the scan, and would say nothing.
///
/// `positions` are the head's vertices in the scan's pose, mm.
///
/// # Errors
/// When the picture cannot be written.
pub fn of_registration(
    template: &Template,
    scan: &Scan,
    positions: &[DVec3],
    covered: &[bool],
    texture: Option<&Texture>,
    file: &Path,
) -> FitResult<()> {
    let skin = template.part_vertices("skin")?;
    let even = vec![1.0; positions.len()];
    // The scan keeps its pose; the pictures show the face from where the template is seen.
    let upright = Rigid::fit(positions, &template.positions, &skin, &even);
    let moved = |points: &[DVec3]| points.iter().map(|&p| upright.apply(p)).collect::<Vec<_>>();
    let (head, surface) = (moved(positions), moved(&scan.positions));
    let triangles = template.triangles();
    let found = Surface::new(&surface, &scan.triangles);
    let mut errors = vec![NO_SCAN; head.len()];
    for (v, distance) in distances(&head, covered, &triangles, &found) {
        errors[v] = colour_bar::colour(distance, LARGEST_ERROR);
    }
    let clay = vec![CLAY; head.len()];
    let plain = match scan.colours.len() == surface.len() {
        true => scan.colours.clone(),
        false => vec![PLAIN; surface.len()],
    };
    let topology = &template.topology;
    let parts = &topology.parts;
    // Eyeballs shine and are a few texels wide, so they are drawn in the painted colours, as dark
    // as the texture has them.
    let eyes = template.part_vertices("left eyeball")?;
    let sum = |colour: &dyn Fn(u32) -> DVec3| eyes.iter().map(|&v| colour(v)).sum::<DVec3>();
    let painted = |v: u32| DVec3::from_array(topology.colours[v as usize].map(f64::from));
    let exposure = texture.map_or(1.0, |texture| {
        let baked = sum(&|v| texture.sample(texture.uvs[v as usize]));
        baked.element_sum() / sum(&painted).element_sum()
    });
    let colours: Vec<[u8; 3]> = topology
        .colours
        .iter()
        .map(|colour| colour.map(|c| (f64::from(c) * exposure).round() as u8))
        .collect();
    let of_head =
        |colours, texture| render::head(&triangles, parts, &head, colours, texture).to_vec();
    let columns = [
        vec![Mesh {
            positions: &surface,
            triangles: &scan.triangles,
            colours: &plain,
            texture: scan.texture.as_ref(),
            shine: 0.0,
        }],
        of_head(&colours, texture),
        of_head(&clay, None),
        of_head(&errors, None),
    ];
    let mut images = Vec::new();
    for yaw in [0.0, 38.0] {
        let camera = Camera::around(DVec3::new(0.0, -45.0, -40.0), 980.0, yaw, 0.0);
        for meshes in &columns {
            images.push(render::render(meshes, &Options::new(480, 600, camera)));
        }
        if let Some(image) = images.last_mut() {
            colour_bar::draw(image, LARGEST_ERROR);
        }
    }
    Image::grid(&images, columns.len())?.save(file)
}

/// The largest distance from a surface at each covered vertex and at the middles of its edges to
/// covered ones, mm.
fn distances(
    positions: &[DVec3],
    covered: &[bool],
    triangles: &[[u32; 3]],
    surface: &Surface,
) -> Vec<(usize, f64)> {
    let far = |p: DVec3| {
        let hit = surface.closest(p, f64::INFINITY);
        hit.map_or(f64::INFINITY, |hit| hit.distance)
    };
    let mut largest: Vec<f64> = positions
        .par_iter()
        .zip(covered)
        .map(|(&p, covered)| if *covered { far(p) } else { f64::NEG_INFINITY })
        .collect();
    let mut edges: Vec<[usize; 2]> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[a, b]| [a.min(b) as usize, a.max(b) as usize])
        .filter(|edge| edge.iter().all(|&v| covered[v]))
        .collect();
    edges.sort_unstable();
    edges.dedup();
    let middles: Vec<f64> = edges
        .par_iter()
        .map(|&[a, b]| far(positions[a].midpoint(positions[b])))
        .collect();
    for (ends, distance) in edges.iter().zip(middles) {
        for &v in ends {
            largest[v] = largest[v].max(distance);
        }
    }
    largest
        .into_iter()
        .enumerate()
        .filter(|(v, _)| covered[*v])
        .collect()
}

/// `semantic.png`: every semantic control at -2 and +2 standard deviations of its measure, four
/// controls a row in the order of the model (semantic reshaping, Figs. 7 and 8), and
/// `pinocchio.png`: the nose ever longer (Fig. 9).
fn semantic(model: &FaceModel, folder: &Path) -> FitResult<()> {
    let parts = model.parts();
    let mut cells = Vec::new();
    for control in &parts.controls {
        let Some(measure) = control.measure.map(|m| &parts.measures[m as usize]) else {
            continue;
        };
        let (height, distance) = match control.group.as_str() {
            "eyes" => (0.0, 400.0),
            "forehead" => (25.0, 520.0),
            _ => (-38.0, 400.0),
        };
        // What lies before or behind something else is seen from the side.
        let ahead = ["length", "protrusion", "convexity"];
        let deep = ahead.iter().any(|word| measure.name.ends_with(word)) && control.group != "eyes";
        let yaw = if deep { 60.0 } else { 0.0 };
        let camera = Camera::around(DVec3::new(0.0, height, 0.0), distance, yaw, 2.0);
        let limit = f64::from(crate::model::LIMIT);
        let (least, most) = (control.quantile(0.0)?, control.quantile(1.0)?);
        let (least, most) = (f64::from(least), f64::from(most));
        for sigmas in [-2.0, 2.0] {
            let mut face = model.face();
            let mm = (least + most) / 2.0 + sigmas * (most - least) / (2.0 * limit);
            face.set_measure(&measure.name, mm)?;
            cells.push(draw(&face, &Options::new(230, 260, camera)));
        }
    }
    if cells.is_empty() {
        return Ok(());
    }
    Image::grid(&cells, 8)?.save(&folder.join("semantic.png"))?;
    let camera = Camera::around(DVec3::new(20.0, -25.0, -20.0), 900.0, 55.0, 2.0);
    let grown = [0.0, 8.0, 20.0, 45.0].map(|longer| -> FitResult<Image> {
        let mut face = model.face();
        let length = face.measure(PINOCCHIO)?;
        face.set_measure(PINOCCHIO, length + longer)?;
        Ok(draw(&face, &Options::new(420, 460, camera)))
    });
    let grown = grown.into_iter().collect::<FitResult<Vec<_>>>()?;
    Image::grid(&grown, 4)?.save(&folder.join("pinocchio.png"))
}

/// Each attribute at its two ends: the mean face of it from two sides, and two random faces.
fn attributes(model: &FaceModel, folder: &Path) -> FitResult<()> {
    let mut cells = Vec::new();
    for attribute in &model.parts().attributes {
        for value in attribute.limits.map(f64::from) {
            for (seed, spread, yaw) in [(0, 0.0, 0.0), (0, 0.0, 50.0), (1, 1.0, 0.0), (2, 1.0, 0.0)]
            {
                let mut face = model.face();
                face.randomize(&Randomize {
                    seed: Some(seed),
                    spread: Some(spread),
                    attributes: vec![(attribute.name.clone(), value)],
                    ..Default::default()
                })?;
                let camera = Camera::around(DVec3::new(0.0, -25.0, -50.0), 900.0, yaw, 2.0);
                cells.push(draw(&face, &Options::new(160, 208, camera)));
            }
        }
    }
    if cells.is_empty() {
        return Ok(());
    }
    Image::grid(&cells, 8)?.save(&folder.join("attributes.png"))
}

/// The measure of which a liar has ever more.
const PINOCCHIO: &str = "nose length";

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
