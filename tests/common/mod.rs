//! The models that the tests use: a sheet small enough to read, and the one that is committed.

#![allow(dead_code)] // Each test binary uses a part of it.

use glam::Vec3;
use phiz::FaceModel;
use phiz::anatomy::{Axis, Landmark, Measure, Part, Quantity};
use phiz::mesh::Topology;
use phiz::model::{
    About, Attribute, Blending, Block, Control, Licence, ModelParts, Modes, Rigid, Surround,
};
use phiz::quantise::{COORDINATES, CORRELATIONS, DISTANCES, FINEST_STEP, Quantised, TEXTURE};

/// Columns and rows of the sheet's vertices, 10 mm apart:
///
/// ```text
///  y=5  h h h h h h h h
///  y=4  h h h h h h h h        n  nose, 3 modes
///  y=3  h h n n n n h h        m  mouth, 2 modes
///  y=2  h h n n n n h h        h  in no feature; the block "head", 4 modes, moves all
///  y=1  h m m m m m m h
///  y=0  h m m m m m m h
/// ```
pub const COLUMNS: usize = 8;
/// See [`COLUMNS`].
pub const ROWS: usize = 6;
/// The sheet's vertices.
pub const VERTICES: usize = COLUMNS * ROWS;
/// The sheet's coefficients: nose, mouth, head.
pub const COEFFICIENTS: usize = 3 + 2 + 4;

const REGIONS: [&str; 3] = ["nose", "mouth", "head"];

fn region(column: usize, row: usize) -> u8 {
    match (column, row) {
        (2..=5, 2..=3) => 0,
        (1..=6, 0..=1) => 1,
        _ => 2,
    }
}

/// A bent sheet with a seam, three parts and three blocks that overlap as those of a head do.
pub fn sheet() -> ModelParts {
    let at = |column: usize, row: usize| (row * COLUMNS + column) as u32;
    let place = |v: usize| (v % COLUMNS, v / COLUMNS);
    let mean: Vec<Vec3> = (0..VERTICES)
        .map(|v| {
            let (column, row) = place(v);
            let x = 10.0 * (column as f32 - 3.5);
            let y = 10.0 * row as f32 - 25.0;
            let z = 60.0 - 0.02 * x * x - 0.01 * y * y;
            Vec3::new(x, y, COORDINATES.nearest(z.into()) as f32)
        })
        .collect();
    let texture = |u: f32, v: f32| [u, v].map(|x| TEXTURE.nearest(x.into()) as f32);
    let mut uvs: Vec<[f32; 2]> = (0..VERTICES)
        .map(|v| {
            let (column, row) = place(v);
            texture(column as f32 / 7.0, row as f32 / 5.0)
        })
        .collect();
    // A seam: the last column has second texture coordinates, used by the top right quad.
    let mut uv_vertices: Vec<u32> = (0..VERTICES as u32).collect();
    for row in 0..ROWS {
        uvs.push(texture(0.0, row as f32 / 5.0));
        uv_vertices.push(at(COLUMNS - 1, row));
    }
    let mut uv_triangles = Vec::new();
    for row in 0..ROWS - 1 {
        for column in 0..COLUMNS - 1 {
            let seam = row == ROWS - 2 && column == COLUMNS - 2;
            let right = |r: usize| {
                if seam {
                    (VERTICES + r) as u32
                } else {
                    at(column + 1, r)
                }
            };
            let (a, b, c, d) = (
                at(column, row),
                right(row),
                right(row + 1),
                at(column, row + 1),
            );
            uv_triangles.push([a, b, c]);
            uv_triangles.push([a, c, d]);
        }
    }
    let triangles = uv_triangles.len() as u32;
    let topology = Topology {
        uvs,
        uv_vertices,
        uv_triangles,
        parts: vec![
            Part {
                name: "lower".into(),
                first: 0,
                count: 20,
            },
            Part {
                name: "upper".into(),
                first: 20,
                count: triangles - 22,
            },
            Part {
                name: "strip".into(),
                first: triangles - 2,
                count: 2,
            },
        ],
        mirror: (0..VERTICES)
            .map(|v| at(COLUMNS - 1 - place(v).0, place(v).1))
            .collect(),
        region_names: REGIONS.map(str::to_owned).to_vec(),
        regions: (0..VERTICES)
            .map(|v| region(place(v).0, place(v).1))
            .collect(),
        colours: (0..VERTICES).map(|v| [200, 150, v as u8]).collect(),
    };
    let mut blocks = Vec::new();
    let mut first_coefficient = 0;
    for (r, modes) in [3, 2, 4].into_iter().enumerate() {
        let block = block(&topology, &mean, r as u8, modes, first_coefficient);
        first_coefficient += modes;
        blocks.push(block);
    }
    // One slider a coefficient, and one that moves two features and reads both.
    let mut controls: Vec<Control> = blocks
        .iter()
        .flat_map(|b| {
            let named = (1..).map(|k| format!("{} {k}", b.name));
            named
                .zip(b.coefficients())
                .map(|(name, i)| control(&name, &b.name, &[i]))
        })
        .collect();
    controls.push(control("long nose over wide mouth", "head", &[0, 3]));
    // 0.6^|i - j| is positive definite (the correlation of an autoregressive process), and gives
    // neighbours across two features something to say about each other.
    let correlation = (0..COEFFICIENTS * COEFFICIENTS)
        .map(|k| 0.6_f64.powi((k / COEFFICIENTS).abs_diff(k % COEFFICIENTS) as i32))
        .map(|r| CORRELATIONS.nearest(r) as f32)
        .collect();
    ModelParts {
        about: About {
            title: "sheet".into(),
            population: "None: made up for tests.".into(),
            caveat: "Not a face.".into(),
            faces: 1,
            made_by: "tests/common".into(),
            licences: vec![Licence {
                source: "phiz".into(),
                by: "phiz developers".into(),
                licence: "MIT OR Apache-2.0".into(),
            }],
        },
        mean,
        topology,
        blocks,
        controls,
        correlation,
        attributes: vec![],
        landmarks: vec![
            Landmark {
                name: "tip".into(),
                stencil: vec![(at(3, 2), 0.5), (at(4, 2), 0.5)],
            },
            Landmark {
                name: "left corner".into(),
                stencil: vec![(at(6, 1), 1.0)],
            },
            Landmark {
                name: "right corner".into(),
                stencil: vec![(at(1, 1), 1.0)],
            },
        ],
        measures: vec![Measure {
            name: "mouth width".into(),
            description: "From corner to corner.".into(),
            quantity: Quantity::Distance { from: 1, to: 2 },
        }],
        blending: Blending {
            alpha: 12.0,
            limits: [2.0, 40.0],
        },
    }
}

/// The sheet with two labels that go together, as a nose's length and a head's height might.
pub fn labelled_sheet() -> ModelParts {
    let attribute = |name: &str, mean, weight: &dyn Fn(f32) -> f32| Attribute {
        name: name.into(),
        description: "made up for tests".into(),
        unit: "years".into(),
        limits: [mean - 20.0, mean + 20.0],
        mean,
        explained: 0.75,
        reading: (0..COEFFICIENTS).map(|i| weight(i as f32)).collect(),
    };
    ModelParts {
        attributes: vec![
            attribute("age", 40.0, &|i| 4.0 - i),
            attribute("height", -3.0, &|i| 1.0 + (2.0 * i).sin()),
        ],
        ..sheet()
    }
}

/// The sheet with an edit: a local block that widens the mouth, and a semantic control for it.
pub fn edited_sheet() -> ModelParts {
    let mut parts = sheet();
    let mouth = &parts.blocks[1];
    // Two millimetres of the mouth's fifty for a coefficient of 1.
    let values: Vec<f64> = (mouth.support.iter())
        .flat_map(|&v| [f64::from(parts.mean[v as usize].x) / 25.0, 0.0, 0.0])
        .collect();
    let local = Block {
        name: "local mouth".into(),
        regions: mouth.regions.clone(),
        support: mouth.support.clone(),
        modes: Modes::of(&Quantised::new(&values, FINEST_STEP), 1),
        sigmas: vec![2.0],
        first_coefficient: COEFFICIENTS,
        surround: None,
        local_to: Some("mouth".into()),
    };
    parts.blocks.push(local);
    parts.controls.push(Control {
        name: "mouth width".into(),
        group: "mouth".into(),
        description: "wider mouth".into(),
        direction: vec![(COEFFICIENTS as u32, 1.0)],
        reading: vec![],
        measure: Some(0),
        quantiles: (0..=20).map(|i| 44.0 + 0.6 * i as f32).collect(),
        limits: [0.05, 0.9],
    });
    parts.measures.push(Measure {
        name: "lips".into(),
        description: "A bit of everything.".into(),
        quantity: Quantity::GeometricMean {
            geometric_mean: vec![
                Quantity::Distance { from: 1, to: 2 },
                Quantity::Mean {
                    mean: vec![
                        Quantity::Offset {
                            axis: Axis::Y,
                            of: vec![0],
                            over: vec![1, 2],
                        },
                        Quantity::Distance { from: 0, to: 1 },
                    ],
                },
            ],
        },
    });
    parts
}

fn block(topology: &Topology, mean: &[Vec3], region: u8, modes: usize, first: usize) -> Block {
    let whole = region == 2;
    let support: Vec<u32> = (0..VERTICES as u32)
        .filter(|&v| whole || topology.regions[v as usize] == region)
        .collect();
    // Waves with a different frequency a mode and axis: no two modes are multiples of each other.
    let values: Vec<f64> = (0..modes)
        .flat_map(|k| support.iter().map(move |&v| (k, v)))
        .flat_map(|(k, v)| {
            let p = mean[v as usize].as_dvec3() / 20.0;
            let f = (k + 1) as f64;
            [
                (f * p.y + 0.3).sin() * 1.5,
                (f * p.x).cos(),
                (f * (p.x + p.y) + 0.7 * f64::from(region)).sin() * 2.0,
            ]
        })
        .collect();
    let surround = (!whole).then(|| {
        // Everything within 30 mm of the region along a straight line.
        let (mut targets, mut distances) = (Vec::new(), Vec::new());
        for v in (0..VERTICES as u32).filter(|v| support.binary_search(v).is_err()) {
            let to = |&s: &u32| mean[v as usize].distance(mean[s as usize]);
            let nearest = support.iter().map(to).fold(f32::INFINITY, f32::min);
            if nearest <= 30.0 {
                targets.push(v);
                distances.push(DISTANCES.nearest(nearest.into()) as f32);
            }
        }
        // As an eyeball beside a nose would.
        let rigid = Rigid {
            part: 2,
            sources: std::array::from_fn(|i| i as u32),
            weights: [40_000, 25_535, 0, 0, 0, 0, 0, 0],
        };
        let rigid = if region == 0 { vec![rigid] } else { vec![] };
        Surround::new(mean, topology, &support, targets, distances, rigid).expect("it is in order")
    });
    Block {
        name: REGIONS[region as usize].into(),
        regions: vec![region],
        support,
        modes: Modes::of(&Quantised::new(&values, FINEST_STEP), modes),
        sigmas: (0..modes).map(|k| 5.0 / (k + 1) as f32).collect(),
        first_coefficient: first,
        surround,
        local_to: None,
    }
}

/// Reads and moves the mean of some coefficients; the population is skewed.
fn control(name: &str, group: &str, coefficients: &[usize]) -> Control {
    let share = 1.0 / coefficients.len() as f32;
    Control {
        name: name.into(),
        group: group.into(),
        description: String::new(),
        direction: coefficients.iter().map(|&i| (i as u32, 1.0)).collect(),
        reading: coefficients.iter().map(|&i| (i as u32, share)).collect(),
        measure: None,
        limits: [0.0, 1.0],
        // -3 to 3, denser below: 21 percentiles of a population with a long upper tail.
        quantiles: (0..=20)
            .map(|i| {
                let p = i as f32 / 20.0;
                -3.0 + 6.0 * (0.7 * p + 0.3 * p * p * p)
            })
            .collect(),
    }
}

/// The sheet's blob.
pub fn sheet_blob() -> Vec<u8> {
    sheet().write().expect("the sheet is a model")
}

/// The sheet as a model.
pub fn sheet_model() -> FaceModel {
    FaceModel::parse(&sheet_blob()).expect("the sheet is a model")
}

/// Uses a model in every way that a page does. Whatever the model holds, nothing may panic, and
/// every number that comes out must be one.
pub fn exercise(model: &FaceModel) {
    let finite = |face: &phiz::Face| {
        assert!(
            face.positions().iter().all(|p| p.is_finite()),
            "a position is no number"
        );
        assert!(
            face.normals().iter().all(|n| n.is_finite()),
            "a normal is no number"
        );
    };
    let parts = model.parts();
    let mut face = model.face();
    finite(&face);
    for control in &parts.controls {
        // A control may ask for more than 255 sigmas: that is an error, not a panic.
        for value in [0.0, 0.37, 1.0] {
            if face.set(&control.name, value).is_ok() {
                let back = face.get(&control.name).expect("the control is there");
                assert!((0.0..=1.0).contains(&back), "it reads {back}");
            }
        }
    }
    finite(&face);
    for attribute in &parts.attributes {
        for value in attribute.limits.map(f64::from) {
            face.randomize(&phiz::Randomize {
                seed: Some(4),
                attributes: vec![(attribute.name.clone(), value)],
                ..Default::default()
            })
            .expect("its limits may be asked for");
            finite(&face);
            let reads = face.attribute(&attribute.name).expect("it is there");
            assert!(reads.is_finite(), "it reads {reads}");
        }
    }
    let first = parts.blocks[0].name.clone();
    face.lock(&first).expect("the region is there");
    face.randomize(&phiz::Randomize {
        seed: Some(3),
        ..Default::default()
    })
    .expect("a seed is enough");
    finite(&face);
    let last = parts.mean.len() as u32 - 1;
    for vertex in [0, last / 2, last] {
        let target = face.positions()[vertex as usize] + Vec3::new(1.0, -2.0, 3.0);
        face.drag(vertex, target)
            .expect("vertex and target are sound");
        finite(&face);
    }
    face.unlock(&first).expect("the region is there");
    for alpha in parts.blending.limits {
        face.set_alpha(alpha).expect("the limits are allowed");
        finite(&face);
    }
    let range = face.changed();
    assert!(
        range.start <= range.end && range.end <= last + 1,
        "{range:?}"
    );
    for measure in &parts.measures {
        assert!(
            face.measure(&measure.name)
                .expect("it is there")
                .is_finite()
        );
    }
    for measure in &parts.measures {
        let now = face.measure(&measure.name).expect("it is there");
        // What the face cannot have is an error, not a panic; so is what cannot be held.
        for mm in [now + 0.5, -1e9, f64::NAN] {
            if face.set_measure(&measure.name, mm).is_ok() {
                let met = face.measure(&measure.name).expect("it is there");
                assert!((met - mm).abs() <= 0.01, "{met} mm, not {mm}");
            }
            finite(&face);
        }
        face.lock_measure(&measure.name).expect("it is there");
        let options = phiz::Randomize {
            seed: Some(5),
            ..Default::default()
        };
        let held = face.measure(&measure.name).expect("it is there");
        if face.randomize(&options).is_ok() {
            let now = face.measure(&measure.name).expect("it is there");
            assert!((now - held).abs() <= 1e-4, "{now} mm, held at {held}");
        }
        face.unlock_measure(&measure.name).expect("it is there");
        finite(&face);
    }
    if let Some(control) = parts.controls.last() {
        face.clear(&control.name).expect("it is there");
    }
    let again = model.from_code(&face.code()).expect("its own code");
    assert_eq!(again.positions(), face.positions());
    let other = model.face();
    face.blend(&other, 0.5, None).expect("the same model");
    face.reset(None).expect("everything");
    finite(&face);
    assert_eq!(face.coefficients(), other.coefficients());
}

/// The committed model: what `./build.sh model` makes.
pub const MODEL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/www/public/model.phiz");

/// The committed model. A face costs a millisecond or two, so tests share the model.
#[cfg(not(target_arch = "wasm32"))]
pub fn head_model() -> &'static FaceModel {
    static HEAD: std::sync::OnceLock<FaceModel> = std::sync::OnceLock::new();
    HEAD.get_or_init(|| {
        let bytes = std::fs::read(MODEL).unwrap_or_else(|why| panic!("{MODEL}: {why}"));
        FaceModel::parse(&bytes).unwrap_or_else(|why| panic!("{MODEL}: {why}"))
    })
}

/// Somebody of the committed model's population.
#[cfg(not(target_arch = "wasm32"))]
pub fn person(seed: u64) -> phiz::Face {
    let mut face = head_model().face();
    let options = phiz::Randomize {
        seed: Some(seed),
        ..phiz::Randomize::default()
    };
    face.randomize(&options).unwrap();
    face
}

/// A number of a header.
pub fn n(number: u32) -> Vec<u8> {
    number.to_le_bytes().to_vec()
}

/// A text of a header.
pub fn text(text: &str) -> Vec<u8> {
    [n(text.len() as u32), text.as_bytes().to_vec()].concat()
}

/// A blob with `from` in its header replaced by `to`, whatever their lengths: table, length and
/// checksum are made right again.
pub fn with_header(blob: &[u8], from: &[u8], to: &[u8]) -> Vec<u8> {
    let word = |at: usize| {
        u32::from_le_bytes([blob[at], blob[at + 1], blob[at + 2], blob[at + 3]]) as usize
    };
    let (length, sections) = (word(20), word(24));
    let start = 40 + 32 * sections;
    let header = &blob[start..start + length];
    let mut places = header.windows(from.len()).enumerate();
    let at = places.find(|(_, bytes)| *bytes == from).map(|(at, _)| at);
    let at = at.unwrap_or_else(|| panic!("{from:?} is not in the header"));
    let header = [&header[..at], to, &header[at + from.len()..]].concat();
    let mut out = blob[..start].to_vec();
    out[20..24].copy_from_slice(&(header.len() as u32).to_le_bytes());
    out.extend_from_slice(&header);
    for section in 0..sections {
        let row = 40 + 32 * section;
        let (offset, length) = (word(row + 20), word(row + 24));
        out.resize(out.len().next_multiple_of(16), 0);
        let moved = out.len() as u32;
        out[row + 20..row + 24].copy_from_slice(&moved.to_le_bytes());
        out.extend_from_slice(&blob[offset..offset + length]);
    }
    phiz::blob::seal(&mut out);
    out
}
