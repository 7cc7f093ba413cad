//! Tables of what registered faces measure.

use std::path::Path;
use std::process::{Command, Output};

use glam::{DMat3, DVec3};
use phiz::fit::format::ply;
use phiz::{Face, Randomize};

use crate::common::head_model;

const MODEL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/www/public/model.phiz");

fn drawn(seed: u64) -> Face {
    let mut face = head_model().face();
    let seed = Some(seed);
    (face.randomize(&Randomize {
        seed,
        ..Randomize::default()
    }))
    .unwrap();
    face
}

fn wide(face: &Face) -> Vec<DVec3> {
    face.positions().iter().map(|p| p.as_dvec3()).collect()
}

fn write(folder: &Path, name: &str, positions: &[DVec3]) {
    let triangles = head_model().parts().topology.triangles();
    ply::write_mesh(&folder.join(name), positions, &triangles).unwrap();
}

fn run(faces: &Path, more: &[&Path]) -> Output {
    run_with(Path::new(MODEL), faces, more)
}

fn run_with(model: &Path, faces: &Path, more: &[&Path]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_phiz-fit"));
    command.arg("measure").arg(model).arg("--faces").arg(faces);
    command.args(more).output().unwrap()
}

fn table(path: &Path) -> (Vec<String>, Vec<Vec<String>>) {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let words = |record: &csv::StringRecord| record.iter().map(String::from).collect();
    let head = words(reader.headers().unwrap());
    let rows = reader.records().map(|row| words(&row.unwrap()));
    (head, rows.collect())
}

#[test]
fn faces_of_the_model_measure_what_they_are() {
    let model = head_model();
    let parts = model.parts();
    let folder = tempfile::tempdir().unwrap();
    let (faces, out) = (folder.path().join("faces"), folder.path().join("t.csv"));
    std::fs::create_dir(&faces).unwrap();
    let people: Vec<Face> = (1..=3).map(drawn).collect();
    // One as another scanner would have it, turned and elsewhere, with a name that a table has to quote.
    let turn = DMat3::from_euler(glam::EulerRot::YXZ, 0.5, -0.3, 0.2);
    let turned = wide(&people[1])
        .into_iter()
        .map(|p| turn * p + DVec3::new(40.0, -7.0, 300.0));
    write(&faces, "a.ply", &wide(&people[0]));
    write(&faces, "b, \"left\".ply", &turned.collect::<Vec<_>>());
    write(&faces, "c.ply", &wide(&people[2]));
    let designs = folder.path().join("designs.json");
    let options = [Path::new("-o"), &out, Path::new("--designs"), &designs];
    let done = run(&faces, &options);
    assert!(
        done.status.success(),
        "{}",
        String::from_utf8_lossy(&done.stderr)
    );
    let (head, rows) = table(&out);
    assert_eq!(rows.len(), 3);
    assert_eq!(rows[1][0], "b, \"left\"");
    let population = parts.population();
    assert_eq!(
        head.len(),
        4 + parts.measures.len() + parts.attributes.len() + parts.controls.len() + population
    );
    for (row, face) in rows.iter().zip(&people) {
        let cell = |name: &str| -> f64 {
            let at = head.iter().position(|h| h == name).expect(name);
            row[at].parse().unwrap()
        };
        // Floats of a PLY are off by up to 8 micrometres at 100 mm, and what is that little draws nothing to the mean.
        assert!(cell("left (mm)") < 0.01, "{}", cell("left (mm)"));
        let found = model.from_code(&row[3]).unwrap();
        let pairs = found.positions().iter().zip(face.positions());
        let farthest = pairs.map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        assert!(farthest < 0.05, "{farthest} mm");
        for measure in &parts.measures {
            let mm = cell(&format!("{} (mm)", measure.name));
            // What is turned back is off by f32's rounding, too.
            assert!(
                (mm - face.measure(&measure.name).unwrap()).abs() < 0.01,
                "{}",
                measure.name
            );
        }
        for control in &parts.controls {
            let percent = cell(&format!("{} (%)", control.name));
            let own = 100.0 * face.get(&control.name).unwrap();
            assert!(
                (percent - own).abs() < 1.0,
                "{}: {percent}, not {own}",
                control.name
            );
        }
        for attribute in &parts.attributes {
            let named = match attribute.unit.as_str() {
                "" => attribute.name.clone(),
                unit => format!("{} ({unit})", attribute.name),
            };
            let [least, most] = attribute.limits.map(f64::from);
            let own = face.attribute(&attribute.name).unwrap();
            assert!(
                (cell(&named) - own).abs() < 0.02 * (most - least),
                "{named}"
            );
        }
        let sigmas = row[head.len() - population..].iter();
        for (sigma, own) in sigmas.zip(face.coefficients()) {
            // Modes that are much alike leave more between them.
            assert!(
                (sigma.parse::<f32>().unwrap() - own).abs() < 0.1,
                "{sigma}, not {own}"
            );
        }
    }
    let written: serde_json::Value =
        serde_json::from_slice(&std::fs::read(&designs).unwrap()).unwrap();
    for (one, row) in written.as_array().unwrap().iter().zip(&rows) {
        assert_eq!(one["format"], "phiz-face");
        assert_eq!(one["model"], parts.about.title);
        assert_eq!([&one["name"], &one["code"]], [&row[0], &row[3]]);
    }
    // A face by itself is the same as among others.
    let alone = folder.path().join("alone.csv");
    let done = run(&faces.join("c.ply"), &[Path::new("-o"), &alone]);
    assert!(done.status.success());
    assert_eq!(table(&alone).1, rows[2..]);
}

#[test]
fn a_face_that_is_none_of_the_models_is_measured_itself() {
    let folder = tempfile::tempdir().unwrap();
    let (face, out) = (drawn(4), folder.path().join("t.csv"));
    // A lump beside the nose, as no model has it.
    let cheek = face
        .positions()
        .iter()
        .copied()
        .max_by(|a, b| (a.x + a.z).total_cmp(&(b.x + b.z)));
    let cheek = cheek.unwrap().as_dvec3();
    let lump = |p: DVec3| DVec3::X * 6.0 * (-p.distance_squared(cheek) / 72.0).exp();
    let own = wide(&face);
    let squares: f64 = own.iter().map(|&p| lump(p).length_squared()).sum();
    let size = (squares / own.len() as f64).sqrt();
    let with_lump: Vec<DVec3> = own.iter().map(|&p| p + lump(p)).collect();
    write(folder.path(), "lump.ply", &with_lump);
    write(folder.path(), "none.ply", &own);
    let done = run(folder.path(), &[Path::new("-o"), &out]);
    assert!(done.status.success());
    let (_, rows) = table(&out);
    let left = |row: usize| rows[row][1].parse::<f64>().unwrap();
    // Broader cheeks take some of it on; most of so narrow a lump is left. Files are rounded.
    assert!(left(0) > 0.5 * size, "{} of {size}", left(0));
    assert!(left(1) < 0.01, "{}", left(1));
    let said = String::from_utf8(done.stdout).unwrap();
    assert!(said.contains(" of lump\n"), "{said}");
    // The more is taken to be left, the nearer it is to the mean.
    let far = |left: &str| -> f64 {
        let left = ["--left", left, "-o"].map(Path::new);
        assert!(
            run(
                &folder.path().join("none.ply"),
                &[left[0], left[1], left[2], &out]
            )
            .status
            .success()
        );
        let (head, rows) = table(&out);
        let sigmas = head
            .iter()
            .zip(&rows[0])
            .filter(|(name, _)| name.ends_with("(sigma)"));
        sigmas
            .map(|(_, sigma)| sigma.parse::<f64>().unwrap().powi(2))
            .sum()
    };
    let [close, usual, loose] = ["0.01", "1", "10"].map(far);
    assert!(
        close > usual && usual > loose && loose > 0.0,
        "{close}, {usual}, {loose}"
    );
}

#[test]
fn what_is_no_face_of_the_model_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("t.csv");
    let said = |faces: &Path, out: &Path| {
        let done = run(faces, &[Path::new("-o"), out]);
        assert_eq!(done.status.code(), Some(1));
        String::from_utf8(done.stderr).unwrap()
    };
    assert!(said(folder.path(), &out).contains("no .ply files"));
    let face = folder.path().join("a.ply");
    write(folder.path(), "a.ply", &wide(&drawn(1)));
    for faces in [folder.path(), &face] {
        assert!(said(faces, &face).contains("would be lost"));
    }
    let model = folder.path().join("model.phiz");
    std::fs::copy(MODEL, &model).unwrap();
    let done = run_with(&model, folder.path(), &[Path::new("-o"), &model]);
    assert!(
        String::from_utf8(done.stderr)
            .unwrap()
            .contains("is the model")
    );
    // In centimetres, metres and micrometres, as another program may write it; and nothing but a point.
    for unit in [0.1, 0.001, 1000.0, 0.0] {
        let other: Vec<DVec3> = wide(&drawn(1)).iter().map(|&p| unit * p).collect();
        write(folder.path(), "a.ply", &other);
        let error = said(folder.path(), &out);
        let cause = error.strip_prefix(&format!("phiz-fit: {}: ", face.display()));
        assert!(
            cause.is_some_and(|cause| cause.ends_with("registered faces are in millimetres\n")),
            "{error}"
        );
        assert_eq!(error.lines().count(), 1, "{error}");
    }
    ply::write_mesh(&face, &[DVec3::ZERO; 3], &[[0, 1, 2]]).unwrap();
    let error = said(folder.path(), &out);
    assert!(
        error.contains("a.ply") && error.contains("3 vertices"),
        "{error}"
    );
    assert!(!out.exists());
}
