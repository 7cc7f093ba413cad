//! The files that the package writes (`www/phiz/export`), read by the crate's own readers and the
//! `gltf` crate. Node writes them from the package in `pkg`, which `./build.sh build` makes; the
//! loaders of three.js and Khronos's validator read them in `tests/node/export.test.js`.

use std::collections::HashMap;
use std::path::Path;
use std::process::Command;

use glam::DVec3;
use phiz::fit::scan::{Scan, Unit};
use phiz::{Face, Randomize};

use crate::common::{MODEL, head_model};

/// What a file must keep, mm: OBJ has four decimals, PLY and GLB have f32.
const KEPT: f64 = 0.01;

/// A random person of the committed model.
fn person(seed: u64) -> Face {
    let mut face = head_model().face();
    let options = Randomize {
        seed: Some(seed),
        ..Default::default()
    };
    face.randomize(&options).expect("randomises");
    face
}

/// The folder in which Node has written the face as OBJ, PLY and GLB. Where the package was not
/// built there is nothing to read, and the test says so; in CI that is a failure.
fn exports(face: &Face) -> Option<tempfile::TempDir> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    if !root.join("pkg/simd/phiz_bg.wasm").exists() {
        let ci = std::env::var_os("CI").is_some_and(|ci| ci == "true");
        assert!(!ci, "no package in pkg");
        println!("skipped: there is no package in pkg; ./build.sh build makes it");
        return None;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let wrote = Command::new("node")
        .arg(root.join("tests/node/write-exports.js"))
        .args([MODEL, &face.code()])
        .arg(folder.path())
        .status()
        .expect("node starts");
    assert!(wrote.success());
    Some(folder)
}

fn positions(face: &Face) -> Vec<DVec3> {
    face.positions().iter().map(|p| p.as_dvec3()).collect()
}

#[test]
fn obj_ply_and_glb_read_back_as_the_face_that_the_core_computes() {
    let face = person(21);
    let Some(folder) = exports(&face) else { return };
    let wanted = positions(&face);
    let colours = &head_model().parts().topology.colours;
    for (ending, unit) in [
        ("obj", Unit::Millimetre),
        ("ply", Unit::Millimetre),
        ("glb", Unit::Metre),
    ] {
        let file = folder.path().join(format!("face.{ending}"));
        let scan = Scan::read(&file, Some(unit)).expect("reads");
        // The reader welds seams, so what it gives are the model's vertices, in some order.
        let mut places: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
        let cell = |p: DVec3| p.to_array().map(|x| (x / 0.1).floor() as i64);
        for (v, &p) in wanted.iter().enumerate() {
            places.entry(cell(p)).or_default().push(v);
        }
        assert_eq!(scan.positions.len(), wanted.len(), "{ending}");
        let mut met = vec![false; wanted.len()];
        for (at, &p) in scan.positions.iter().enumerate() {
            let around = [-KEPT, KEPT].into_iter().flat_map(|x| {
                [-KEPT, KEPT]
                    .into_iter()
                    .flat_map(move |y| [-KEPT, KEPT].into_iter().map(move |z| DVec3::new(x, y, z)))
            });
            let nearest = around
                .filter_map(|d| places.get(&cell(p + d)))
                .flatten()
                .copied()
                .min_by(|&a, &b| p.distance(wanted[a]).total_cmp(&p.distance(wanted[b])));
            let v = nearest.unwrap_or_else(|| panic!("{ending}: vertex {at} is no one's"));
            assert!(p.distance(wanted[v]) < KEPT, "{ending}: vertex {at}");
            met[v] = true;
            if ending != "glb" {
                assert_eq!(scan.colours[at], colours[v], "{ending}: colour of {at}");
            }
        }
        assert!(met.iter().all(|&met| met), "{ending}");
        let triangles = head_model().parts().topology.uv_triangles.len();
        assert_eq!(scan.triangles.len(), triangles, "{ending}");
    }
}

/// The mesh of a GLB with its morph targets, as the `gltf` crate reads it.
struct Morph {
    names: Vec<String>,
    base: Vec<DVec3>,
    targets: Vec<Vec<DVec3>>,
}

fn morph(file: &Path) -> Morph {
    let bytes = std::fs::read(file).expect("reads");
    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(&bytes).expect("valid");
    let blob = blob.expect("a binary chunk");
    let mesh = document.meshes().next().expect("a mesh");
    let primitive = mesh.primitives().next().expect("a primitive");
    let reader = primitive.reader(|_| Some(&blob));
    let millimetres = |p: [f32; 3]| DVec3::from_array(p.map(f64::from)) * 1000.0;
    let base = reader.read_positions().expect("positions");
    let base = base.map(millimetres).collect();
    let targets = reader
        .read_morph_targets()
        .map(|(positions, ..)| positions.expect("positions").map(millimetres).collect())
        .collect();
    // The crate reads `extras` only with one of its features; the JSON is all there.
    let glb = gltf::Glb::from_slice(&bytes).expect("GLB");
    let json: serde_json::Value = serde_json::from_slice(&glb.json).expect("JSON");
    let names = json["meshes"][0]["extras"]["targetNames"].clone();
    Morph {
        names: serde_json::from_value(names).expect("names"),
        base,
        targets,
    }
}

#[test]
fn driving_the_targets_of_a_glb_gives_the_face_that_the_core_computes() {
    let face = person(22);
    let Some(folder) = exports(&face) else { return };
    for name in ["face.glb", "dressed.glb"] {
        drives(&face, &morph(&folder.path().join(name)));
    }
}

/// Whether targets take a face to another person.
fn drives(face: &Face, morph: &Morph) {
    let controls = &head_model().parts().controls;
    let names: Vec<&str> = controls.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(morph.names, names);
    assert_eq!(morph.targets.len(), names.len());

    let other = person(23);
    let (from, to) = (face.coefficients(), other.coefficients());
    let mut driven = morph.base.clone();
    let mut met = vec![false; from.len()];
    for (control, target) in controls.iter().zip(&morph.targets) {
        // A mode is one coefficient; what moves several is made of coefficients of its own.
        let [(i, _)] = control.direction[..] else {
            continue;
        };
        let weight = f64::from(to[i as usize] - from[i as usize]);
        met[i as usize] = true;
        for (p, d) in driven.iter_mut().zip(target) {
            *p += *d * weight;
        }
    }
    assert!((0..from.len()).all(|i| met[i] || from[i] == to[i]));
    let wanted = positions(&other);
    let corners = &head_model().parts().topology.uv_vertices;
    assert_eq!(driven.len(), corners.len());
    let worst = driven
        .iter()
        .zip(corners)
        .map(|(p, &v)| p.distance(wanted[v as usize]))
        .fold(0.0, f64::max);
    // What the page's mesh must be reproduced to.
    assert!(worst < 0.05, "{worst} mm");
    let moved = wanted.iter().zip(positions(face));
    assert!(moved.map(|(a, b)| a.distance(b)).fold(0.0, f64::max) > 2.0);
}
