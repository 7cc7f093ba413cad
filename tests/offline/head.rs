//! The committed head, which a page shows while the model loads: made of the committed model, with
//! the same face.

use std::process::Command;

use glam::Vec3;
use phiz::{FaceModel, Randomize};

use crate::common::{MODEL, head_model};

const HEAD: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/www/public/head.phiz");

#[test]
fn the_committed_head_is_made_of_the_committed_model() {
    let folder = tempfile::tempdir().expect("a folder");
    let made = folder.path().join("head.phiz");
    let run = Command::new(env!("CARGO_BIN_EXE_phiz-fit"))
        .args(["head", MODEL, "-o"])
        .arg(&made)
        .output()
        .expect("runs");
    assert!(run.status.success());
    let (made, committed) = (
        std::fs::read(&made).expect("reads"),
        std::fs::read(HEAD).expect("reads"),
    );
    assert!(made == committed, "`phiz-fit head` makes another file");
    let model = std::fs::metadata(MODEL).expect("is there").len();
    // With three.js, the page and the module it has to stay below half a megabyte.
    assert!(
        committed.len() < 210_000,
        "{} of {model} bytes",
        committed.len()
    );
}

#[test]
fn its_face_is_the_median_person_and_it_does_all_that_a_face_does() {
    let head = FaceModel::parse(&std::fs::read(HEAD).expect("reads")).expect("parses");
    let median = head_model().face();
    let mut face = head.face();
    assert_eq!(face.positions().len(), median.positions().len());
    let farthest = |a: &[Vec3], b: &[Vec3]| {
        let pairs = a.iter().zip(b);
        pairs.map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
    };
    // Coordinates are rounded to a grid of 1/512 mm: half a step on each of three axes is 1.7
    // micrometres.
    assert!(farthest(face.positions(), median.positions()) < 1.8e-3);
    assert!(farthest(face.normals(), median.normals()) < 0.02);
    assert_eq!(head.parts().topology, head_model().parts().topology);

    // There is nothing to move, and nothing breaks.
    let code = face.code();
    assert!(face.set("nose 1", 0.9).is_err());
    face.randomize(&Randomize::default()).expect("randomises");
    face.reset(None).expect("resets");
    face.drag(17, Vec3::new(0.0, 100.0, 50.0)).expect("drags");
    face.set_alpha(5.0).expect("takes another distance");
    assert_eq!(face.positions(), head.face().positions());
    let again = head.from_code(&code).expect("reads its code");
    assert_eq!(again.normals(), head.face().normals());
    assert!(
        head_model().from_code(&code).is_err(),
        "it is another model"
    );
}

#[test]
fn it_has_no_pictures_of_modes_and_that_is_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let pictures = folder.path().join("pictures");
    let head = concat!(env!("CARGO_MANIFEST_DIR"), "/www/public/head.phiz");
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_phiz-fit"));
    let done = command.args(["pictures", head, "-o"]).arg(&pictures);
    let done = done.output().expect("runs");
    let said = String::from_utf8_lossy(&done.stderr);
    assert_eq!(done.status.code(), Some(1), "{said}");
    assert!(said.contains("head.phiz: a head alone"), "{said}");
    assert!(!pictures.exists());
}
