//! Learning on the real generic head: seams, and the committed model made again.

use std::process::Command;
use std::sync::LazyLock;
use std::time::Instant;

use glam::DVec3;
use phiz::blob::pack;
use phiz::fit::format::ply::write_mesh;
use phiz::fit::head::cage::Cage;
use phiz::fit::head::prior::ShapePrior;
use phiz::fit::head::template::Template;
use phiz::fit::learn::crease::{Seam, seams};
use phiz::fit::learn::{Learned, Settings, doubled, learn};
use phiz::fit::truth::population;
use phiz::fit::validate::rounding;
use phiz::quantise::BLOCK_ERROR;
use phiz::{FaceModel, Randomize};

use crate::{base_mesh, common, heads};

/// As `./build.sh model` has them.
const COUNT: usize = 400;
const SEED: u64 = 1;

struct Trained {
    template: &'static Template,
    learned: Learned,
    model: FaceModel,
}

/// The default model, learned once for all tests here.
static TRAINED: LazyLock<Option<Trained>> = LazyLock::new(|| {
    let folder = base_mesh::folder()?;
    let template = heads::plain()?;
    let people = population::sample(template, &folder, COUNT, SEED).unwrap();
    let learned = learn(
        template,
        people.faces,
        population::about(),
        &Settings::default(),
    )
    .unwrap();
    let model = FaceModel::parse(&learned.parts.write().unwrap()).unwrap();
    Some(Trained {
        template,
        learned,
        model,
    })
});

fn wide(positions: &[glam::Vec3]) -> Vec<DVec3> {
    positions.iter().map(|p| p.as_dvec3()).collect()
}

/// A seam may be this much sharper than the same place of whole faces.
const SHARPER: f64 = 1.2;

/// Of the variance of whole faces, the part that seams are compared with.
const WHOLE: f64 = 0.95;

/// Whether any seam's `ratio` is too large; prints all of them.
fn too_sharp(seams: &[Seam], ratio: fn(&Seam) -> f64) -> bool {
    for seam in seams {
        println!(
            "{:9} within {:2} mm: modes at 2 sigma {:5.1} deg, whole {:5.1}; random {:5.1}, whole \
             {:5.1}; {:.2} x; sharpest at {:.0?}",
            seam.feature,
            seam.width,
            seam.modes,
            seam.whole_modes,
            seam.random,
            seam.whole_random,
            ratio(seam),
            seam.sharpest.to_array()
        );
    }
    seams.iter().any(|seam| ratio(seam) > SHARPER)
}

/// Region borders bend the surface no more than a PCA of whole faces does there: for every
/// region, each mode at +-2 sigma, and random faces, measured as the largest change of a dihedral
/// angle within the blending distance, and one and a half of it, of the border.
#[test]
fn seams_are_as_clean_as_whole_faces() {
    let Some(Trained {
        template,
        learned,
        model,
    }) = &*TRAINED
    else {
        return;
    };
    let mean = wide(&model.parts().mean);
    let whole = ShapePrior::of(&learned.aligned, &mean, WHOLE, usize::MAX).unwrap();
    let found = seams(template, model, &whole.modes, &|face| face).unwrap();
    assert!(!too_sharp(&found, Seam::ratio));
}

/// The committed default model. Its blob does not keep the faces that it was learned from; whole
/// faces of the same people are what the generic head comes with, but written on the base mesh.
/// So the model's faces are measured as the base mesh has them too.
///
/// Only random faces are compared. A region gathers in a few modes what whole faces share out over
/// many, so one of its modes at 2 sigma bends farther than any one of theirs.
#[test]
fn random_faces_of_the_default_model_have_seams_as_clean_as_whole_faces() {
    let Some(template) = heads::template() else {
        return;
    };
    let all = &template.prior.as_ref().expect("it comes with people").modes;
    let variance = |mode: &Vec<DVec3>| mode.iter().map(|d| d.length_squared()).sum::<f64>();
    let total: f64 = all.iter().map(variance).sum();
    let mut sum = 0.0;
    let leading = all.iter().take_while(|mode| {
        let before = sum;
        sum += variance(mode);
        before < WHOLE * total
    });
    let whole: Vec<Vec<DVec3>> = leading.cloned().collect();
    let model = common::head_model();
    let mean = wide(&model.parts().mean);
    let cage = Cage::new(template).unwrap();
    let found = seams(template, model, &whole, &|face| {
        let moved: Vec<DVec3> = face.iter().zip(&mean).map(|(p, m)| *p - *m).collect();
        let moved = cage.apply(&cage.fit(&moved));
        mean.iter().zip(moved).map(|(m, d)| *m + d).collect()
    })
    .unwrap();
    assert!(!too_sharp(&found, |seam| seam.random / seam.whole_random));
}

/// What a file of the model keeps, after packing and unpacking: random faces within the error that
/// `phiz::quantise` states, in a file that a page can load.
#[test]
fn rounding_moves_random_faces_by_the_stated_error() {
    let Some(Trained { learned, .. }) = &*TRAINED else {
        return;
    };
    let file = pack(&learned.parts.write().unwrap()).unwrap();
    let start = Instant::now();
    let model = FaceModel::parse(&file).unwrap();
    let took = start.elapsed();
    let n = model.parts().mean.len();
    let rms = rounding(learned, &model).unwrap();
    let still = model.parts().mean.iter().zip(&learned.mean);
    let still: f64 = still.map(|(p, q)| p.as_dvec3().distance_squared(*q)).sum();
    let still = (still / n as f64).sqrt();
    println!(
        "{} bytes, read in {took:.0?}; random faces {:.1}, the mean {:.2} micrometres off",
        file.len(),
        1000.0 * rms,
        1000.0 * still
    );
    // Nowhere more than two blocks and the surround of others, which move less.
    assert!(rms < 2.0 * BLOCK_ERROR, "{rms} mm");
    // A grid of 1/512 mm: half a step / sqrt(3) in each of three coordinates is a micrometre.
    assert!(still < 0.00125, "{still} mm");
    assert!(file.len() < 1_500_000, "{} bytes", file.len());
}

/// `www/public/synthetic.phiz` is what its sources give: same controls, and positions of 100 random
/// faces within 1 micrometre RMS.
#[test]
fn the_committed_model_is_made_from_its_sources() {
    let Some(Trained { model, .. }) = &*TRAINED else {
        return;
    };
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/www/public/synthetic.phiz");
    let committed = FaceModel::parse(&std::fs::read(path).unwrap()).unwrap();
    let names = |m: &FaceModel| -> Vec<String> {
        m.parts().controls.iter().map(|c| c.name.clone()).collect()
    };
    assert_eq!(names(&committed), names(model));
    let (mut sum, mut count) = (0.0, 0);
    for seed in 0..100 {
        let options = Randomize {
            seed: Some(seed),
            ..Default::default()
        };
        let mut a = committed.face();
        a.randomize(&options).unwrap();
        let mut b = model.face();
        b.set_coefficients(&a.coefficients()).unwrap();
        for (p, q) in a.positions().iter().zip(b.positions()) {
            sum += p.as_dvec3().distance_squared(q.as_dvec3());
            count += 1;
        }
    }
    let rms = (sum / f64::from(count)).sqrt();
    println!("remade model: {} micrometres RMS", rms * 1000.0);
    assert!(rms <= 0.001, "{rms} mm");
}

/// Drawing a face from the model gives lengths distributed as those of the faces it learned from.
#[test]
fn random_faces_look_like_the_training_faces_in_size() {
    let Some(Trained { learned, model, .. }) = &*TRAINED else {
        return;
    };
    let names = ["nose width", "mouth width", "face height"];
    let lengths = |face: &phiz::Face| names.map(|name| face.measure(name).unwrap());
    let trained: Vec<[f64; 3]> = learned
        .coefficients
        .iter()
        .map(|row| {
            let mut face = model.face();
            let mut c: Vec<f32> = row.iter().map(|&c| c as f32).collect();
            c.resize(model.parts().coefficients(), 0.0); // no edits
            face.set_coefficients(&c).unwrap();
            lengths(&face)
        })
        .collect();
    let mut face = model.face();
    let drawn: Vec<[f64; 3]> = (0..400)
        .map(|seed| {
            face.randomize(&Randomize {
                seed: Some(seed),
                ..Default::default()
            })
            .unwrap();
            lengths(&face)
        })
        .collect();
    for (k, name) in names.into_iter().enumerate() {
        let moments = |faces: &[[f64; 3]]| {
            let n = faces.len() as f64;
            let mean = faces.iter().map(|face| face[k]).sum::<f64>() / n;
            let variance = faces
                .iter()
                .map(|face| (face[k] - mean).powi(2))
                .sum::<f64>()
                / n;
            (mean, variance.sqrt())
        };
        let ((m1, s1), (m2, s2)) = (moments(&trained), moments(&drawn));
        println!("{name}: trained {m1:.1} +- {s1:.1}, drawn {m2:.1} +- {s2:.1}");
        // The mean of 400 has a standard error of a twentieth of the deviation; three of them for
        // each side. Shrinking the correlations costs a measure up to a fifth of its deviation.
        assert!((m1 - m2).abs() < 0.3 * s1);
        assert!((0.75..1.3).contains(&(s2 / s1)));
    }
}

/// The same faces give the same bytes on one thread or many.
#[test]
fn threads_do_not_change_a_model() {
    let Some(Trained {
        template, learned, ..
    }) = &*TRAINED
    else {
        return;
    };
    let some = &learned.aligned[..30];
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| {
            let about = population::about();
            let learned = learn(template, some.to_vec(), about, &Settings::default()).unwrap();
            learned.parts.write().unwrap()
        })
    };
    assert!(on(1) == on(4));
}

/// Faces that are there twice are told by their numbers, and what few of them cannot teach is said.
#[test]
fn doubled_faces_are_told_and_too_few_are_refused_in_words() {
    let (Some(folder), Some(template)) = (base_mesh::folder(), heads::plain()) else {
        return;
    };
    let mut faces = population::sample(template, &folder, 4, SEED)
        .unwrap()
        .faces;
    assert!(doubled(&faces).is_empty());
    faces.push(faces[1].clone());
    faces.push(faces[1].clone());
    assert_eq!(doubled(&faces), [(4, 1), (5, 1)]);
    let settings = Settings::default();
    // Two people, one of them twice: nothing is between them.
    let few = [0, 0, 2].map(|face: usize| faces[face].clone()).to_vec();
    let error = learn(template, few, population::about(), &settings);
    let error = error.map(|_| ()).expect_err("no spread").to_string();
    let start = "3 faces are too few, or too alike, to learn \"";
    assert!(error.starts_with(start), "{error}");

    // The program leaves them out, and says of which files.
    let root = tempfile::tempdir().unwrap();
    let (file, people) = (root.path().join("t.phiz"), root.path().join("people"));
    std::fs::write(&file, template.to_bytes().unwrap()).unwrap();
    std::fs::create_dir(&people).unwrap();
    for (name, face) in [("anna", 0), ("anna again", 0), ("emil", 1)] {
        let path = people.join(name).with_extension("ply");
        write_mesh(&path, &faces[face], &template.triangles()).unwrap();
    }
    let mut command = Command::new(env!("CARGO_BIN_EXE_phiz-fit"));
    command.args(["train", "--template"]).arg(&file);
    let model = root.path().join("m.phiz");
    command.arg("--faces").arg(&people).arg("-o").arg(&model);
    let done = command.output().unwrap();
    let [out, err] = [done.stdout, done.stderr].map(|said| String::from_utf8(said).unwrap());
    assert_eq!(
        out,
        "anna.ply is the same face as anna again.ply: counted once\n"
    );
    let few = format!("phiz-fit: {}: 2 faces are too few", people.display());
    assert!(err.starts_with(&few), "{err}");
    // Other verbs leave them out and name the folder, too.
    for (verb, option) in [("basis", Some("--one-sided")), ("validate", None)] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_phiz-fit"));
        command
            .args([verb, "--template"])
            .arg(&file)
            .arg("--faces")
            .arg(&people);
        command.args(option).arg("-o").arg(root.path().join(verb));
        let err = String::from_utf8(command.output().unwrap().stderr).unwrap();
        assert!(err.starts_with(&few), "{err}");
    }
    // The generic head learns from them once, too.
    let mut command = Command::new(env!("CARGO_BIN_EXE_phiz-fit"));
    command.args(["template", "--base-mesh"]).arg(&folder);
    command.arg("--faces").arg(&people);
    command.arg("--registered-to").arg(&file);
    command.arg("-o").arg(root.path().join("learned.phiz"));
    let done = command.output().unwrap();
    let out = String::from_utf8(done.stdout).unwrap();
    let err = String::from_utf8(done.stderr).unwrap();
    let copied = "anna.ply is the same face as anna again.ply: counted once\n";
    assert!(out.starts_with(copied), "{out}{err}");
}
