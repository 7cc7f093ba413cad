//! People drawn from the default model, as files that other readers take.

use std::path::Path;
use std::process::Command;

use glam::Vec3;
use phiz::Randomize;
use phiz::fit::format::obj::Obj;
use phiz::fit::format::ply;
use phiz::fit::sample::{Target, write};

use crate::common::{self, person};

fn sample(path: &Path, count: u32, seed: u64) {
    let target = Target::parse(path).unwrap();
    let like = Randomize::default();
    write(common::head_model(), count, seed, &like, &target, |_| ()).unwrap();
}

#[test]
fn files_hold_the_faces_of_their_seeds() {
    let folder = tempfile::tempdir().unwrap();
    let model = common::head_model();
    for name in ["plain", "objs/a.obj", "glbs/b.glb", "all.npy"] {
        sample(&folder.path().join(name), 3, 20);
    }
    let text = std::fs::read(folder.path().join("objs/a.json")).unwrap();
    let about: serde_json::Value = serde_json::from_slice(&text).unwrap();
    assert_eq!(about["model"]["title"], model.parts().about.title);
    let array = std::fs::read(folder.path().join("all.npy")).unwrap();
    let array = npyz::NpyFile::new(&array[..]).unwrap();
    let n = model.parts().mean.len();
    assert_eq!(array.shape(), [3, n as u64, 3]);
    let array: Vec<f32> = array.into_vec().unwrap();
    for i in 0..3 {
        let face = person(20 + i as u64);
        let code = about["faces"][i]["code"].as_str().unwrap();
        assert_eq!(code, face.code());
        assert_eq!(about["faces"][i]["seed"], 20 + i);
        let same = |p: &[Vec3]| assert_eq!(p, face.positions());
        let number = format!("000{}", i + 1);

        let own: &[f32] = &array[3 * n * i..3 * n * (i + 1)];
        same(bytemuck::cast_slice(own));

        let path = folder.path().join(format!("plain/face_{number}.ply"));
        let read = ply::read_positions(&path).unwrap();
        same(&read.iter().map(|p| p.as_vec3()).collect::<Vec<_>>());

        let obj = Obj::read(&folder.path().join(format!("objs/a_{number}.obj"))).unwrap();
        same(
            &obj.positions
                .iter()
                .map(|p| p.as_vec3())
                .collect::<Vec<_>>(),
        );
        let topology = &model.parts().topology;
        assert_eq!(obj.polygons(), topology.uv_triangles.len());
        for (corner, uv) in obj.corners.iter().zip(topology.uv_triangles.as_flattened()) {
            assert_eq!(corner, &[topology.uv_vertices[*uv as usize], *uv]);
        }
        assert_eq!(obj.runs[1].group, "skin");

        // The importer of the `gltf` crate validates.
        let path = folder.path().join(format!("glbs/b_{number}.glb"));
        let (document, buffers, _) = gltf_import(&path);
        let primitive = document
            .meshes()
            .next()
            .unwrap()
            .primitives()
            .next()
            .unwrap();
        let reader = primitive.reader(|buffer| Some(&buffers[buffer.index()]));
        for (p, &v) in reader.read_positions().unwrap().zip(&topology.uv_vertices) {
            let mm = Vec3::from_array(p) * 1000.0;
            // Two roundings of f32 at 200 mm.
            assert!(mm.distance(face.positions()[v as usize]) < 1e-4);
        }
        let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
        assert_eq!(indices, topology.uv_triangles.as_flattened());
        assert_eq!(reader.read_normals().unwrap().count(), topology.uvs.len());
    }
}

type Import = (gltf::Document, Vec<Vec<u8>>, ());

fn gltf_import(path: &Path) -> Import {
    let gltf = gltf::Gltf::open(path).expect("valid");
    let blob = gltf.blob.clone().expect("has its bytes");
    (gltf.document, vec![blob], ())
}

#[test]
fn threads_do_not_change_samples() {
    let folder = tempfile::tempdir().unwrap();
    let run = |threads: usize, name: &str| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let path = folder.path().join(name);
        pool.build().unwrap().install(|| sample(&path, 5, 3));
        std::fs::read(path).unwrap()
    };
    assert_eq!(run(1, "one.npy"), run(2, "two.npy"));
}

/// Faces of a former run are written over, and none stays among others.
#[test]
fn no_face_of_a_former_run_stays() {
    let folder = tempfile::tempdir().unwrap();
    let like = Randomize::default();
    let again = |name: &str, count: u32| {
        let target = Target::parse(&folder.path().join(name)).unwrap();
        write(common::head_model(), count, 5, &like, &target, |_| ())
    };
    let files = || std::fs::read_dir(folder.path()).unwrap().count();
    again("a.ply", 3).unwrap();
    let error = again("a.ply", 2).unwrap_err().to_string();
    assert!(
        error.contains("a_0003.ply: a face that is none of these 2"),
        "{error}"
    );
    again("a.ply", 3).unwrap();
    // Those of other names and formats are told apart.
    again("b.ply", 1).unwrap();
    again("a.obj", 1).unwrap();
    std::fs::write(folder.path().join("a_me.ply"), "").unwrap();
    again("a.ply", 4).unwrap();
    assert_eq!(files(), 4 + 2 + 1 + 2);
    // Nor is written over what is of no run: the landmarks of a registered face, or what nobody can read.
    let landmarks = folder.path().join("face.json");
    for text in [r#"{"nasion": [0, 1, 2]}"#, "{"] {
        std::fs::write(&landmarks, text).unwrap();
        for name in ["face.npy", "face.ply", ""] {
            let error = again(name, 1).unwrap_err().to_string();
            assert!(error.contains("face.json: is of no former run"), "{error}");
        }
        assert_eq!(std::fs::read_to_string(&landmarks).unwrap(), text);
        assert_eq!(files(), 4 + 2 + 1 + 2 + 1);
    }
}

#[test]
fn what_cannot_be_written_is_said() {
    let wrong = Target::parse(Path::new("faces/a.stl")).unwrap_err();
    assert!(wrong.to_string().contains("obj, ply, glb, npy"), "{wrong}");
    let folder = tempfile::tempdir().unwrap();
    // A folder may have a dot in its name, if it is there or a slash says that it is one; endings may be large.
    let dotted = folder.path().join("faces.v2");
    Target::parse(&dotted).unwrap_err();
    Target::parse(&dotted.join("")).unwrap();
    std::fs::create_dir(&dotted).unwrap();
    let target = Target::parse(&dotted).unwrap();
    assert_eq!(target, Target::parse(&dotted.join("")).unwrap());
    let large = Target::parse(&dotted.join("a.PLY")).unwrap();
    assert_eq!(large, Target::parse(&dotted.join("a.ply")).unwrap());
    let file = folder.path().join("file");
    std::fs::write(&file, "here").unwrap();
    let target = Target::parse(&file.join("a.npy")).unwrap();
    let like = Randomize::default();
    let error = write(common::head_model(), 1, 1, &like, &target, |_| ()).unwrap_err();
    assert!(error.to_string().contains("file"), "{error}");
}

#[test]
fn people_are_drawn_as_they_are_asked_for() {
    let model = common::head_model();
    let folder = tempfile::tempdir().unwrap();
    let run = |options: &str, name: &str| {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/www/public/model.phiz");
        let mut command = Command::new(env!("CARGO_BIN_EXE_phiz-fit"));
        command
            .args(["sample", path, "--count", "4", "-o"])
            .arg(folder.path().join(name));
        let done = command.args(options.split_whitespace()).output().unwrap();
        (done.status.code(), String::from_utf8(done.stderr).unwrap())
    };
    let faces = |name: &str| -> Vec<phiz::Face> {
        let text = std::fs::read(folder.path().join(name).with_extension("json")).unwrap();
        let about: serde_json::Value = serde_json::from_slice(&text).unwrap();
        let codes = about["faces"].as_array().unwrap().iter();
        codes
            .map(|face| model.from_code(face["code"].as_str().unwrap()).unwrap())
            .collect()
    };
    assert_eq!(
        run("--attributes age=70,sex=0", "old.npy"),
        (Some(0), String::new())
    );
    for face in faces("old.npy") {
        // A code's grid is a thousandth of a sigma, of which an age has some years.
        assert!((face.attribute("age").unwrap() - 70.0).abs() < 0.1);
        assert!(face.attribute("sex").unwrap().abs() < 0.01);
    }
    assert_eq!(run("--spread 0", "mean.npy"), (Some(0), String::new()));
    let mean = faces("mean.npy");
    assert!(mean.iter().all(|face| face.code() == mean[0].code()));
    assert_eq!(run("--regions nose", "noses.npy"), (Some(0), String::new()));
    let (noses, median) = (faces("noses.npy"), model.face());
    for face in &noses {
        assert_eq!(face.get("chin 1").unwrap(), median.get("chin 1").unwrap());
        assert_ne!(face.get("nose 1").unwrap(), median.get("nose 1").unwrap());
    }
    assert_ne!(noses[0].code(), noses[1].code());
    for (options, said) in [
        ("--attributes height=3", "height"),
        ("--attributes Age=30", "\"Age\"; there are age, "),
        ("--regions ears", "\"ears\"; there are eyes, nose, "),
        (
            "--attributes sex=1,age=900",
            "age goes from 18 to 80, not to 900",
        ),
    ] {
        let (code, error) = run(options, "none.npy");
        assert_eq!(code, Some(1), "{error}");
        assert!(
            error.contains(said) && error.lines().count() == 1,
            "{error}"
        );
        assert!(!folder.path().join("none.npy").exists());
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/www/public/model.phiz");
    let mut command = Command::new(env!("CARGO_BIN_EXE_phiz-fit"));
    command.args(["sample", path, "--count", "2", "--regions", "nose, chin"]);
    // Into the folder that it is called in.
    let done = command.current_dir(folder.path()).args(["-o", "two.obj"]);
    let done = done.output().unwrap();
    assert!(done.status.success(), "{done:?}");
    assert!(folder.path().join("two_0002.obj").exists());
    for options in ["--attributes age", "--attributes age=x", "--spread 4"] {
        assert_eq!(run(options, "none.npy").0, Some(2));
    }
}
