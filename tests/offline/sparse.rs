//! Sparse components of small sheets whose deformations are known.

use glam::DVec3;
use phiz::Random;
use phiz::fit::mesh::geodesic::Geodesic;
use phiz::fit::sparse::compare::{Trial, compare, error};
use phiz::fit::sparse::{Kind, Region, Settings, SparseBasis, learn, principal};

use crate::heads;

/// Vertices a side of the sheet, 2 mm apart.
const SIDE: u32 = 21;
const STEP: f64 = 2.0;

struct Sheet {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    quarters: Vec<Region>,
}

fn sheet() -> Sheet {
    let at = |i: u32| DVec3::new(f64::from(i % SIDE), f64::from(i / SIDE), 0.0) * STEP;
    let mut triangles = Vec::new();
    for y in 0..SIDE - 1 {
        for x in 0..SIDE - 1 {
            let i = y * SIDE + x;
            triangles.push([i, i + 1, i + SIDE + 1]);
            triangles.push([i, i + SIDE + 1, i + SIDE]);
        }
    }
    let middle = SIDE / 2;
    let quarter = |v: &u32| usize::from(v % SIDE > middle) + 2 * usize::from(v / SIDE > middle);
    let quarters = (0..4)
        .map(|q| Region {
            name: format!("quarter {q}"),
            vertices: (0..SIDE * SIDE).filter(|v| quarter(v) == q).collect(),
        })
        .collect();
    Sheet {
        positions: (0..SIDE * SIDE).map(at).collect(),
        triangles,
        quarters,
    }
}

/// A bump in the middle of each quarter, 8 mm in radius, each in a direction of its own.
fn bumps(sheet: &Sheet) -> Vec<Vec<DVec3>> {
    let directions = [DVec3::Z, DVec3::X, DVec3::new(0.0, 0.6, 0.8), DVec3::Y];
    let centres = [(10.0, 10.0), (31.0, 10.0), (10.0, 31.0), (31.0, 31.0)];
    directions
        .iter()
        .zip(centres)
        .map(|(&direction, (x, y))| {
            let bump = |p: &DVec3| {
                let r = p.distance(DVec3::new(x, y, 0.0)) / 8.0;
                direction * 3.0 * (1.0 - r * r).max(0.0).powi(2)
            };
            sheet.positions.iter().map(bump).collect()
        })
        .collect()
}

/// Sheets with random amounts of each bump, and noise.
fn faces(sheet: &Sheet, count: usize, noise: f64, seed: u64) -> Vec<Vec<DVec3>> {
    let mut random = Random::new(seed);
    let bumps = bumps(sheet);
    (0..count)
        .map(|_| {
            let amounts: Vec<f64> = bumps.iter().map(|_| random.normal()).collect();
            let mut face = sheet.positions.clone();
            for (bump, amount) in bumps.iter().zip(amounts) {
                face.iter_mut()
                    .zip(bump)
                    .for_each(|(p, d)| *p += *d * amount);
            }
            for p in &mut face {
                *p += DVec3::from([(); 3].map(|()| random.normal())) * noise;
            }
            face
        })
        .collect()
}

fn regions(components: usize) -> Settings {
    Settings {
        components,
        kind: Kind::Regions {
            band: 8.0,
            inside: 0.01,
            outside: 1.0,
        },
        ..Settings::default()
    }
}

fn distance(components: usize) -> Settings {
    Settings {
        components,
        kind: Kind::Distance {
            near: 8.0,
            far: 20.0,
            penalty: 0.2,
        },
        ..Settings::default()
    }
}

/// The cosine between a component and a field over all vertices.
fn likeness(basis: &SparseBasis, k: usize, field: &[DVec3]) -> f64 {
    let component = &basis.components[k];
    let moved = component.support.iter().zip(&component.displacements);
    let dot: f64 = moved.map(|(&v, d)| d.dot(field[v as usize])).sum();
    let length = |vectors: &[DVec3]| vectors.iter().map(|d| d.length_squared()).sum::<f64>();
    dot.abs() / (length(&component.displacements) * length(field)).sqrt()
}

#[test]
fn planted_components_are_found_again() {
    let sheet = sheet();
    let faces = faces(&sheet, 30, 0.01, 1);
    for settings in [regions(4), distance(4)] {
        let (basis, report) = learn(
            &faces,
            &sheet.triangles,
            &sheet.quarters,
            &settings,
            |_, _| {},
        )
        .unwrap();
        assert!(report.converged);
        for bump in bumps(&sheet) {
            let best = (0..4)
                .map(|k| likeness(&basis, k, &bump))
                .fold(0.0, f64::max);
            // Noise of 0.01 mm under bumps of 3 mm; the penalty takes a little off their feet.
            assert!(best > 0.995, "{:?}: {best}", settings.kind);
        }
        // What is left is noise: its mean length is 1.6 of its deviations.
        assert!(error(&basis, &faces).unwrap() < 0.025);
    }
}

#[test]
fn the_objective_never_rises() {
    let sheet = sheet();
    let faces = faces(&sheet, 25, 0.3, 2);
    for bold in [false, true] {
        let settings = Settings {
            bold,
            iterations: 40,
            tolerance: 0.0,
            ..regions(12)
        };
        let mut told = Vec::new();
        let (_, report) = learn(
            &faces,
            &sheet.triangles,
            &sheet.quarters,
            &settings,
            |iteration, objective| told.push((iteration, objective)),
        )
        .unwrap();
        assert_eq!(report.objective.len(), 41);
        assert!(!report.converged);
        assert_eq!(told.len(), 41);
        for (i, pair) in report.objective.windows(2).enumerate() {
            assert_eq!(told[i], (i, pair[0]));
            // Rounding of sums whose terms are as large as the samples' square.
            assert!(pair[1] <= pair[0] * (1.0 + 1e-12), "{i}: {pair:?}");
        }
    }
}

#[test]
fn components_stay_within_their_band_and_weights_within_one() {
    let sheet = sheet();
    let faces = faces(&sheet, 25, 0.3, 3);
    let settings = regions(40);
    // More components than faces: each region has its own.
    let (basis, _) = learn(
        &faces,
        &sheet.triangles,
        &sheet.quarters,
        &settings,
        |_, _| {},
    )
    .unwrap();
    let surface = Geodesic::new(&sheet.positions, &sheet.triangles);
    for (k, component) in basis.components.iter().enumerate() {
        let name = component.region.as_ref().unwrap();
        let region = sheet.quarters.iter().find(|r| r.name == *name).unwrap();
        // Distances were measured on the mean, on which noise has 0.06 mm.
        let reach = surface.distances(&region.vertices, 9.0);
        assert!(
            component
                .support
                .iter()
                .all(|&v| reach[v as usize].is_finite())
        );
        assert!(component.support.contains(&component.centre));
        let largest = basis
            .weights
            .iter()
            .fold(0.0_f64, |m, row| m.max(row[k].abs()));
        assert_eq!(largest, 1.0);
    }
}

#[test]
fn threads_do_not_matter() {
    let sheet = sheet();
    let faces = faces(&sheet, 25, 0.3, 4);
    for settings in [regions(10), distance(6)] {
        let learned = [1, 4].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let (basis, _) = pool.unwrap().install(|| {
                learn(
                    &faces,
                    &sheet.triangles,
                    &sheet.quarters,
                    &settings,
                    |_, _| {},
                )
                .unwrap()
            });
            serde_json::to_vec(&basis).unwrap()
        });
        assert!(learned[0] == learned[1], "{:?}", settings.kind);
    }
}

#[test]
fn weights_of_a_face_are_found_again_and_sigmas_are_unit() {
    let sheet = sheet();
    let faces = faces(&sheet, 25, 0.3, 5);
    let (basis, _) = learn(
        &faces,
        &sheet.triangles,
        &sheet.quarters,
        &regions(12),
        |_, _| {},
    )
    .unwrap();
    let mut random = Random::new(9);
    let drawn: Vec<f64> = basis.sigmas.iter().map(|s| s * random.normal()).collect();
    let face = basis.reconstruct(&drawn);
    let found = basis.projection(0.0).unwrap().weights(&face).unwrap();
    for (a, b) in drawn.iter().zip(&found) {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }
    // The stronger the ridge, the fewer sigmas.
    let sigmas = |weights: &[f64]| -> f64 {
        let pairs = weights.iter().zip(&basis.sigmas);
        pairs.map(|(w, s)| (w / s).powi(2)).sum()
    };
    let held = basis.projection(100.0).unwrap().weights(&face).unwrap();
    assert!(sigmas(&held) < 0.95 * sigmas(&found));

    let scaled = basis.clone().in_sigmas();
    for k in 0..12 {
        let column: Vec<f64> = scaled.weights.iter().map(|row| row[k]).collect();
        let mean = column.iter().sum::<f64>() / 25.0;
        let variance = column.iter().map(|w| (w - mean).powi(2)).sum::<f64>() / 24.0;
        assert!((variance - 1.0).abs() < 1e-12);
    }
    let mut none = basis.clone();
    none.components.clear();
    let said = none.projection(0.0).unwrap_err().to_string();
    assert_eq!(said, "a basis without components");
    let one = basis.reconstruct(&basis.weights[3]);
    let other = scaled.reconstruct(&scaled.weights[3]);
    assert!(one.iter().zip(&other).all(|(a, b)| a.distance(*b) < 1e-12));
}

#[test]
fn principal_components_explain_the_most_and_local_ones_generalise() {
    let sheet = sheet();
    let train = faces(&sheet, 4, 0.0, 6);
    let test = faces(&sheet, 20, 0.0, 7);
    let whole = principal(&train, &sheet.quarters, 3).unwrap();
    let (local, _) = learn(
        &train,
        &sheet.triangles,
        &sheet.quarters,
        &regions(4),
        |_, _| {},
    )
    .unwrap();
    // Three principal components are all that four faces have, and say nothing about four bumps
    // that go their own ways.
    assert!(error(&whole, &train).unwrap() < 1e-5);
    assert!(error(&local, &test).unwrap() < 0.3 * error(&whole, &test).unwrap());
}

#[test]
fn what_cannot_be_learned_from_is_refused() {
    let sheet = sheet();
    let good = faces(&sheet, 5, 0.1, 8);
    let refusal = |faces: &[Vec<DVec3>], regions: &[Region], settings: &Settings| {
        let done = learn(faces, &sheet.triangles, regions, settings, |_, _| {});
        done.unwrap_err().to_string()
    };
    let settings = regions(4);
    let all = &sheet.quarters;
    assert!(refusal(&good[..2], all, &settings).contains("2 faces are too few"));
    let still = vec![sheet.positions.clone(); 4];
    assert!(refusal(&still, all, &settings).contains("do not vary"));
    let none = Settings {
        components: 0,
        ..settings
    };
    assert!(refusal(&good, all, &none).contains("at least 1 component"));
    assert!(refusal(&good, all, &regions(17)).contains("17 components are more than the 16"));
    let mut other = good.clone();
    other[3].pop();
    assert!(refusal(&other, all, &settings).contains("face 3 has 440 vertices"));
    let mut nowhere = good.clone();
    nowhere[1][7].y = f64::NAN;
    assert!(refusal(&nowhere, all, &settings).contains("face 1"));
    let mut empty = all.clone();
    empty[2].vertices.clear();
    assert!(refusal(&good, &empty, &settings).contains("\"quarter 2\" has no vertices"));
    let mut twice = all.clone();
    twice[0].vertices.push(SIDE * SIDE - 1);
    assert!(refusal(&good, &twice, &settings).contains("two regions"));
    assert!(refusal(&good, &[], &settings).contains("no region"));
    let backwards = Settings {
        kind: Kind::Distance {
            near: 20.0,
            far: 10.0,
            penalty: 1.0,
        },
        ..settings
    };
    assert!(refusal(&good, all, &backwards).contains("larger"));
    assert!(principal(&good, all, 5).is_err());
}

#[test]
fn a_split_of_more_faces_than_there_are_is_refused() {
    let Some(template) = heads::plain() else {
        return;
    };
    let faces = vec![template.positions.clone(); 4];
    for test in [0, 2, usize::MAX] {
        let trial = Trial {
            train: 3,
            test,
            seed: 1,
            components: vec![1],
        };
        let kinds = [Kind::REGIONS, Kind::DISTANCE];
        let done = compare(template, &faces, &trial, &Settings::default(), kinds, || ());
        let said = format!("4 faces are too few to learn from 3 and to test on {test} others");
        assert_eq!(done.unwrap_err().to_string(), said);
    }
}
