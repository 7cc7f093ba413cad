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
use phiz::fit::learn::attributes;
use phiz::fit::learn::crease::{Seam, seams};
use phiz::fit::learn::labels::{Labels, Told};
use phiz::fit::learn::persons::Persons;
use phiz::fit::learn::{Learned, Settings, doubled, far_beyond, learn};
use phiz::fit::mesh::mirror::mirrored;
use phiz::fit::truth::population;
use phiz::fit::validate::rounding;
use phiz::quantise::BLOCK_ERROR;
use phiz::{FaceModel, Random, Randomize};

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
        &Persons::each(COUNT),
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
            let each = Persons::each(some.len());
            let learned =
                learn(template, some.to_vec(), &each, about, &Settings::default()).unwrap();
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
    let each = Persons::each(few.len());
    let error = learn(template, few, &each, population::about(), &settings);
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
    // Labels that no report counts are told of, in a table too.
    std::fs::write(people.join("labels.csv"), "name,age\nanna,3\n").unwrap();
    // Other verbs leave them out and name the folder, too.
    for (verb, option) in [("basis", Some("--one-sided")), ("validate", None)] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_phiz-fit"));
        command
            .args([verb, "--template"])
            .arg(&file)
            .arg("--faces")
            .arg(&people);
        command.args(option).arg("-o").arg(root.path().join(verb));
        let done = command.output().unwrap();
        let [out, err] = [done.stdout, done.stderr].map(|said| String::from_utf8(said).unwrap());
        assert!(err.starts_with(&few), "{err}");
        let counted =
            "labels.csv: other labels than those of a synthetic population are not counted\n";
        assert_eq!(out.ends_with(counted), verb == "validate", "{out}");
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

/// One label that nobody can learn costs the others nothing.
#[test]
fn labels_are_learned_each_by_itself() {
    let (Some(folder), Some(template)) = (base_mesh::folder(), heads::plain()) else {
        return;
    };
    let people = population::sample(template, &folder, 40, 7).unwrap();
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/www/public/synthetic.phiz");
    let model = FaceModel::parse(&std::fs::read(path).unwrap()).unwrap();
    let column = |of: &dyn Fn(usize) -> Option<f64>| (0..40).map(of).collect::<Vec<_>>();
    let sex = |f: usize| people.labels[f].sex;
    let labels = |told: Vec<(&str, Vec<Option<f64>>)>| Labels {
        persons: Persons::each(40),
        together: (0..told.len()).map(|i| i..i + 1).collect(),
        told: told
            .into_iter()
            .map(|(name, values)| (name.into(), values))
            .collect(),
        besides: Vec::new(),
    };
    let learn =
        |labels: &Labels| attributes::learn(template, &model, &people.faces, labels, "they");
    let all = learn(&labels(vec![
        ("sex", column(&|f| Some(sex(f)))),
        ("sex of most", column(&|f| (f >= 5).then(|| sex(f)))),
        ("same", column(&|_| Some(0.1))),
        ("rare", column(&|f| Some(f64::from(u8::from(f == 12))))),
        ("hardly known", column(&|f| (f < 9).then(|| sex(f)))),
        ("day of birth", column(&|f| Some(19_000_000.0 + f as f64))),
        ("nearly same", column(&|f| Some(1e5 + 1e-6 * f as f64))),
    ]))
    .unwrap();
    let told: Vec<(&str, usize)> = (all.told.iter())
        .map(|told| (&*told.attribute.name, told.people))
        .collect();
    assert_eq!(told, [("sex", 40), ("sex of most", 35)]);
    // The same label of fewer people is told by nearly the same change of faces: a fifth of a sigma at most.
    let [sex_of_all, sex_of_most] = &all.told[..] else {
        panic!("two")
    };
    assert!((sex_of_all.length - sex_of_most.length).abs() < 0.2 * sex_of_all.length);
    let skipped: Vec<(&str, &str)> = (all.skipped.iter())
        .map(|(names, why)| (&*names[0], &**why))
        .collect();
    for ((name, why), (wanted, cause)) in skipped.iter().zip([
        ("same", "the same for all 40 people"),
        ("rare", "so few people differ in it"),
        ("hardly known", "known of 9 people, where 10 are the fewest"),
        ("day of birth", "from 19000000 to 19000040, where"),
        ("nearly same", "from 100000 to 100000, where"),
    ]) {
        assert!(*name == wanted && why.starts_with(cause), "{name}: {why}");
    }
    assert_eq!(skipped.len(), 5);
    // Who is crooked by chance is not told older by it: what is unlike on two sides has no part in it.
    let odd = model.parts().odd();
    assert!(odd.iter().any(|odd| *odd));
    for told in &all.told {
        let reading = told.attribute.reading.iter().zip(&odd);
        // The model's correlations of even and odd modes are nothing but rounding on a grid.
        let (mut even_most, mut odd_most) = (0.0_f32, 0.0_f32);
        for (w, &odd) in reading {
            let most = if odd { &mut odd_most } else { &mut even_most };
            *most = most.max(w.abs());
        }
        assert!(odd_most < 1e-3 * even_most, "{odd_most} {even_most}");
    }
    let odd = learn(&labels(vec![
        ("sex", column(&|f| Some(sex(f)))),
        ("age", column(&|f| Some(1.0 / (f as f64 - 3.0)))),
    ]));
    let said = odd.unwrap_err().to_string();
    assert_eq!(said, "label \"age\" of face 3 is not finite");
    let none = learn(&labels(vec![("same", column(&|_| Some(0.1)))])).unwrap_err();
    let said = "no label can be learned; same: the same for all 40 people";
    assert!(none.to_string().starts_with(said), "{none}");
    learn(&Labels::default()).unwrap_err();
    // What is known besides asks for more people.
    let mut many = labels(vec![("sex", column(&|f| Some(sex(f))))]);
    many.besides = vec![vec![1.0; 40]; 16];
    let said = learn(&many).unwrap_err().to_string();
    let few = "40 faces are too few to tell labels by; 42 people are the least: two for each of the 16 numbers";
    assert!(said.starts_with(few), "{said}");
}

/// So many people, each scanned so many times, each time so far on the way to somebody else.
fn scanned(
    template: &Template,
    people: usize,
    times: usize,
    apart: f64,
) -> Option<Vec<Vec<Vec<DVec3>>>> {
    let count = people * (1 + times);
    let faces = population::sample(template, &base_mesh::folder()?, count, 21)
        .unwrap()
        .faces;
    let (own, others) = faces.split_at(people);
    let scan = |face: &[DVec3], other: &[DVec3]| -> Vec<DVec3> {
        let both = face.iter().zip(other);
        both.map(|(p, q)| p.lerp(*q, apart)).collect()
    };
    let scans = |(face, others): (&Vec<DVec3>, &[Vec<DVec3>])| {
        others.iter().map(|other| scan(face, other)).collect()
    };
    Some(own.iter().zip(others.chunks(times)).map(scans).collect())
}

/// Ten people with five scans each: what their files are called has no part in what labels are said to tell, and labels
/// that are drawn at random tell nothing, unless a person's scans are taken for those of five.
#[test]
fn names_of_files_tell_no_labels() {
    const LABELS: usize = 12;
    let Some(template) = heads::plain() else {
        return;
    };
    let Some(people) = scanned(template, 10, 5, 0.05) else {
        return;
    };
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/www/public/synthetic.phiz");
    let model = FaceModel::parse(&std::fs::read(path).unwrap()).unwrap();
    let mut random = Random::new(8);
    let values: Vec<Vec<f64>> = (0..10)
        .map(|_| (0..LABELS).map(|_| random.normal()).collect())
        .collect();
    let namings: [fn(usize, usize) -> String; 2] = [
        |person, scan| format!("person {person}, scan {scan}"),
        |person, scan| format!("scan {scan}, person {person}"),
    ];
    let learned = |naming: fn(usize, usize) -> String, told: bool| {
        let all = (0..10).flat_map(|p| (0..5).map(move |s| (naming(p, s), p, s)));
        let mut all: Vec<(String, usize, usize)> = all.collect();
        all.sort();
        let of = |p: usize| {
            let labels = values[p].iter().enumerate();
            let labels = labels.map(|(l, y)| (format!("label {l:02}"), serde_json::json!(y)));
            let mut labels: serde_json::Map<String, serde_json::Value> = labels.collect();
            if told {
                labels.insert("person".into(), serde_json::json!(p));
            }
            labels
        };
        let json: std::collections::BTreeMap<_, _> =
            all.iter().map(|(name, p, _)| (name, of(*p))).collect();
        let folder = tempfile::tempdir().unwrap();
        let json = serde_json::to_vec(&json).unwrap();
        std::fs::write(folder.path().join("labels.json"), json).unwrap();
        let names: Vec<String> = all.iter().map(|(name, ..)| name.clone()).collect();
        let faces: Vec<Vec<DVec3>> = all.iter().map(|(_, p, s)| people[*p][*s].clone()).collect();
        let told = Told::beside(folder.path()).unwrap().unwrap();
        let labels = Labels::of(&told, &names);
        attributes::learn(template, &model, &faces, &labels, "they")
            .unwrap()
            .told
    };
    let [by_person, by_scan] = namings.map(|naming| learned(naming, true));
    assert_eq!(by_person.len(), LABELS);
    for (a, b) in by_person.iter().zip(&by_scan) {
        assert_eq!((a.people, b.people), (10, 10));
        // The same sums in another order; what is explained is in f32.
        assert!((a.error / b.error - 1.0).abs() < 1e-6);
        assert!((a.attribute.explained - b.attribute.explained).abs() < 1e-5);
        for (x, y) in a.attribute.reading.iter().zip(&b.attribute.reading) {
            assert!((x - y).abs() < 1e-4 * (1.0 + x.abs()), "{x} {y}");
        }
    }
    let mean = |told: &[attributes::Outcome]| {
        let sum: f32 = told.iter().map(|told| told.attribute.explained).sum();
        sum / LABELS as f32
    };
    let alone = mean(&learned(namings[0], false));
    println!(
        "explained {:.3}, {alone:.3} as other people's",
        mean(&by_person)
    );
    // Of ten people two numbers that have nothing to do with each other share a ninth of their variance by chance.
    assert!(mean(&by_person) < 0.12);
    assert!(alone > 0.5);
}

/// What a user types about scans of one person, and what is said of it.
#[test]
fn scans_of_one_person_are_told_and_labels_chosen() {
    let Some(template) = heads::plain() else {
        return;
    };
    let Some(people) = scanned(template, 12, 2, 0.05) else {
        return;
    };
    let root = tempfile::tempdir().unwrap();
    let at = |name: &str| root.path().join(name);
    std::fs::write(at("t.phiz"), template.to_bytes().unwrap()).unwrap();
    std::fs::create_dir(at("faces")).unwrap();
    let mut random = Random::new(2);
    let (mut json, mut csv) = (serde_json::Map::new(), String::new());
    for (p, scans) in people.iter().enumerate() {
        let (age, asian) = (20.0 + 3.0 * p as f64, random.uniform());
        for (s, face) in scans.iter().enumerate() {
            let name = format!("p{p} s{s}");
            let path = at("faces").join(format!("{name}.ply"));
            write_mesh(&path, face, &template.triangles()).unwrap();
            csv += &format!("{name},{p},{age},{asian},0,{}\n", 1.0 - asian);
            let told = serde_json::json!({
                "person": p, "age": age, "ethnicity": [0.0, asian, 1.0 - asian],
            });
            json.insert(name, told);
        }
    }
    json.insert("nobody".into(), serde_json::json!({"age": 3}));
    let json = serde_json::to_vec(&json).unwrap();
    std::fs::write(at("faces/labels.json"), &json).unwrap();
    let run = |arguments: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_phiz-fit"));
        let done = command.current_dir(root.path()).args(arguments.split(' '));
        let done = done.output().unwrap();
        let said = [done.stdout, done.stderr].map(|said| String::from_utf8(said).unwrap());
        (done.status.code(), said)
    };
    let model = concat!(env!("CARGO_MANIFEST_DIR"), "/www/public/synthetic.phiz");
    let attributes = format!("attributes --template t.phiz --faces faces {model} -o m.phiz");
    let (code, [out, err]) = run(&attributes);
    assert_eq!(code, Some(0), "{err}");
    let mut lines = out.lines();
    let strange = "faces/labels.json: 1 of its names are of no face there: nobody";
    assert_eq!(lines.next(), Some(strange), "{out}");
    let counted = "24 scans of 12 people, of whose skin the model leaves ";
    assert!(lines.next().unwrap().starts_with(counted), "{out}");
    // Nobody has any of the one share: the two others are learned without it.
    let left_out = "african    skipped: the same for all 12 people of whom it is known";
    assert_eq!(lines.next(), Some(left_out), "{out}");
    let told: Vec<&str> = lines.filter_map(|line| line.split(' ').next()).collect();
    assert_eq!(told, ["age", "asian", "caucasian", "m.phiz:"], "{out}");
    // A table that tells the same.
    std::fs::remove_file(at("faces/labels.json")).unwrap();
    csv.insert_str(0, "name,person,age,asian,african,caucasian\n");
    std::fs::write(at("faces/labels.csv"), csv).unwrap();
    let (_, [table, err]) = run(&attributes);
    assert_eq!(out.split_once('\n').unwrap().1, table, "{err}");
    let (_, [out, err]) = run(&format!("{attributes} --labels age"));
    let told: Vec<&str> = out.lines().skip(1).collect();
    assert!(told.len() == 2 && told[0].starts_with("age "), "{out}{err}");
    let (code, [_, err]) = run(&format!("{attributes} --labels age,agee"));
    assert_eq!(code, Some(1));
    let said = "phiz-fit: faces/labels.csv: no label of these faces is called \"agee\"; there are age, ethnicity\n";
    assert_eq!(err, said);
    for labels in ["", "age,,ethnicity"] {
        assert_eq!(run(&format!("{attributes} --labels {labels}")).0, Some(2));
    }
    // Files of other kinds are told by what they are.
    let expressions = concat!(env!("CARGO_MANIFEST_DIR"), "/www/public/expressions.phiz");
    for (file, said) in [
        ("t.phiz", "a template, not a model"),
        (expressions, "a model's expressions"),
    ] {
        let (code, [_, err]) = run(&format!("sample {file} -o s"));
        let said = format!("phiz-fit: {file}: {said}");
        assert!(code == Some(1) && err.starts_with(&said), "{err}");
    }
    let over = "attributes --template t.phiz --faces faces m.phiz -o faces/labels.csv";
    let (code, [_, err]) = run(over);
    assert!(
        code == Some(1) && err.contains("is one of the files of the faces"),
        "{err}"
    );
    // What is learned from is said to be people.
    let (code, [out, err]) = run("train --template t.phiz --faces faces -o n.phiz");
    assert_eq!(code, Some(0), "{err}");
    let said = "faces: 24 scans of 12 people, of each of whom the mean is learned from\n";
    assert!(out.starts_with(said), "{out}");
    let learned = FaceModel::parse(&std::fs::read(at("n.phiz")).unwrap()).unwrap();
    assert_eq!(learned.parts().about.faces, 12);
    // Other people than there are cannot be drawn.
    let (code, [out, err]) =
        run("basis --template t.phiz --faces faces --compare 9 --test 4 -o b.json");
    assert_eq!(code, Some(1));
    assert_eq!(
        out,
        "faces: 24 scans of 12 people, of each of whom the first is taken\n"
    );
    assert!(
        err.contains("12 faces are too few to learn from 9 and to test on 4 others"),
        "{err}"
    );
}

/// However many scans there are of a person, and however these lie: the model is that of one of each. And what is unlike
/// from scan to scan is not taken for how people differ.
#[test]
fn people_are_learned_from_and_not_their_scans() {
    let Some(template) = heads::plain() else {
        return;
    };
    let Some(people) = scanned(template, 12, 4, 0.05) else {
        return;
    };
    let learned = |scans: &[(usize, &Vec<DVec3>)]| {
        let names: Vec<String> = (0..scans.len()).map(|i| format!("{i}")).collect();
        let told: serde_json::Map<String, serde_json::Value> = (names.iter().zip(scans))
            .map(|(name, (p, _))| (name.clone(), serde_json::json!({ "person": p })))
            .collect();
        let folder = tempfile::tempdir().unwrap();
        let json = serde_json::to_vec(&told).unwrap();
        std::fs::write(folder.path().join("labels.json"), json).unwrap();
        let persons = Persons::told(&names, &Told::beside(folder.path()).unwrap().unwrap());
        let faces = scans.iter().map(|(_, face)| (*face).clone()).collect();
        let (about, settings) = (population::about(), Settings::default());
        learn(template, faces, &persons, about, &settings).unwrap()
    };
    let once: Vec<(usize, &Vec<DVec3>)> = people.iter().map(|p| &p[0]).enumerate().collect();
    let moved: Vec<Vec<DVec3>> = (once.iter())
        .map(|(p, face)| {
            let turn = glam::DQuat::from_rotation_y(0.1 * *p as f64 - 0.6);
            let shift = DVec3::new(0.0, 5.0, 3.0 * *p as f64);
            face.iter().map(|&x| turn * x + shift).collect()
        })
        .collect();
    // The last person six times, the first once, and so on; whose are whose in no order.
    let mut often = once.clone();
    (0..5).for_each(|k| often.extend(moved.iter().enumerate().filter(|(p, _)| p % 6 > k)));
    let (one, same) = (learned(&once), learned(&often));
    assert_eq!((one.faces.len(), same.faces.len()), (12, 42));
    assert_eq!(one.parts.about, same.parts.about);
    let far = one.mean.iter().zip(&same.mean).map(|(a, b)| a.distance(*b));
    // Alignment stops at a tenth of a nanometre.
    assert!(far.fold(0.0, f64::max) < 1e-6);
    for (a, b) in one.parts.blocks.iter().zip(&same.parts.blocks) {
        assert_eq!((&a.name, a.sigmas.len()), (&b.name, b.sigmas.len()));
        for (x, y) in a.sigmas.iter().zip(&b.sigmas) {
            assert!((x / y - 1.0).abs() < 1e-5, "{}: {x} {y}", a.name);
        }
    }
    // A scan is three fifths of a person and two fifths of somebody else. Of four scans' mean the variance is, in that of
    // people, 0.36 and a quarter of 0.16; of scans it is 0.36 and 0.16: 0.77 as much, but for what sampling makes of it.
    let people = scanned(template, 12, 4, 0.4).unwrap();
    let all: Vec<_> = people
        .iter()
        .enumerate()
        .flat_map(|(p, own)| own.iter().map(move |s| (p, s)))
        .collect();
    let each: Vec<_> = all.iter().enumerate().map(|(i, (_, s))| (i, *s)).collect();
    let (of_people, of_scans) = (learned(&all), learned(&each));
    let variance = |learned: &Learned| {
        let squares = learned.modes.iter().flatten().map(|d| d.length_squared());
        squares.sum::<f64>()
    };
    let part = variance(&of_people) / variance(&of_scans);
    println!("variance of 12 people {part:.2} of that of 48 scans");
    assert!((0.65..0.9).contains(&part), "{part}");
    assert_eq!(
        (of_people.aligned.len(), of_people.coefficients.len()),
        (12, 12)
    );
    assert_eq!(
        (of_people.faces.len(), of_scans.parts.about.faces),
        (48, 48)
    );
}

/// Where people differ on one side only, so do their controls; elsewhere what is of one eye is the image of the other's.
/// And the tables of few people have no stairs.
#[test]
fn sides_are_alike_where_mirror_images_count() {
    let Some(Trained {
        template, learned, ..
    }) = &*TRAINED
    else {
        return;
    };
    // Faces whose right halves differ by a tenth alone.
    let faces: Vec<Vec<DVec3>> = (learned.aligned[..20].iter())
        .map(|face| {
            let left = |p: DVec3| ((p.x + 5.0) / 10.0).clamp(0.0, 1.0);
            let each = face.iter().zip(&learned.mean);
            each.map(|(p, rest)| rest.lerp(*p, 0.1 + 0.9 * left(*rest)))
                .collect()
        })
        .collect();
    for both_sides in [true, false] {
        let settings = Settings {
            both_sides,
            ..Settings::default()
        };
        let each = Persons::each(faces.len());
        let one = learn(
            template,
            faces.clone(),
            &each,
            population::about(),
            &settings,
        )
        .unwrap();
        let how = if both_sides {
            " (tau 0.95)"
        } else {
            " (tau 0.95, one-sided)"
        };
        assert!(
            one.parts.about.made_by.ends_with(how),
            "{}",
            one.parts.about.made_by
        );
        let table = |name: &str| {
            let control = one.parts.controls.iter().find(|c| c.name == name);
            &control.expect("a control").quantiles
        };
        let (left, right) = (table("left eye length"), table("right eye length"));
        let width = |table: &[f32]| table[48] - table[16];
        match both_sides {
            // In f32 of some 30 mm.
            true => assert!(left.iter().zip(right).all(|(a, b)| (a - b).abs() < 1e-4)),
            // A tenth of the left's, but for what sampling makes of twenty people.
            false => assert!(width(right) < 0.4 * width(left), "{left:?} {right:?}"),
        }
        // Neighbours in a table of twenty people differ by more than the least gap, but where two people are alike.
        let (mut level, mut all) = (0, 0);
        for control in one.parts.controls.iter().filter(|c| c.measure.is_none()) {
            for pair in control.quantiles[4..61].windows(2) {
                all += 1;
                level += usize::from(pair[1] - pair[0] < 1.5e-4);
            }
        }
        assert!(level < all / 20, "{level} of {all}");
    }
}

/// Heads whose sides are alike have no slider that is of rounding, and others are not held to it.
#[test]
fn what_is_the_same_for_all_has_no_slider() {
    let (Some(folder), Some(template)) = (base_mesh::folder(), heads::plain()) else {
        return;
    };
    let mut faces = population::sample(template, &folder, 12, SEED)
        .unwrap()
        .faces;
    for face in &mut faces {
        let image = mirrored(face, &template.topology.mirror);
        let both = face.iter_mut().zip(image);
        both.for_each(|(p, q)| *p = p.midpoint(q));
    }
    let (each, about) = (Persons::each(12), population::about());
    let learned = learn(template, faces, &each, about, &Settings::default()).unwrap();
    let semantic = learned.parts.controls.iter();
    let semantic: Vec<&str> = semantic
        .filter(|control| control.measure.is_some())
        .map(|control| &*control.name)
        .collect();
    assert_eq!(semantic.len(), 18, "{semantic:?}");
    assert!(!semantic.iter().any(|name| name.contains("lateral")));
    for table in &learned.tables {
        assert!(table.sigmas.iter().all(|sigma| *sigma > 0.1), "{table:?}");
    }
}

/// Who is far from all others is named, and what a model says of how it was made is what was asked for.
#[test]
fn training_names_a_face_that_is_far_beyond_the_others() {
    let (Some(folder), Some(template)) = (base_mesh::folder(), heads::plain()) else {
        return;
    };
    let mut faces = population::sample(template, &folder, 10, SEED)
        .unwrap()
        .faces;
    let root = tempfile::tempdir().unwrap();
    let (file, people) = (root.path().join("t.phiz"), root.path().join("people"));
    std::fs::write(&file, template.to_bytes().unwrap()).unwrap();
    std::fs::create_dir(&people).unwrap();
    // In another unit.
    faces[4].iter_mut().for_each(|p| *p *= 1.3);
    for (i, face) in faces.iter().enumerate() {
        let path = people.join(format!("person {i}.ply"));
        write_mesh(&path, face, &template.triangles()).unwrap();
    }
    let run = |arguments: &[&std::ffi::OsStr]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_phiz-fit"));
        let done = command.args(arguments).output().unwrap();
        let said = [done.stdout, done.stderr].map(|said| String::from_utf8(said).unwrap());
        (done.status.code(), said)
    };
    let model = root.path().join("m.phiz");
    let train = [
        "train".as_ref(),
        "--template".as_ref(),
        file.as_os_str(),
        "--faces".as_ref(),
    ];
    let rest = [
        people.as_os_str(),
        "--one-sided".as_ref(),
        "-o".as_ref(),
        model.as_os_str(),
    ];
    let (code, [out, err]) = run(&[&train[..], &rest].concat());
    assert_eq!(code, Some(0), "{err}");
    for line in err.lines() {
        assert!(
            line.starts_with("phiz-fit: warning: person 4.ply: far beyond the others in"),
            "{err}"
        );
    }
    assert!(err.contains(" in size, by "), "{err}");
    assert!(out.contains("(person 4.ply)"), "{out}");
    let (_, [out, _]) = run(&["inspect".as_ref(), model.as_os_str()]);
    assert!(out.contains("learned from 10 faces by phiz-fit "), "{out}");
    assert!(out.contains("(tau 0.95, one-sided);"), "{out}");
    // Another mesh's vertices are no face's, though they are as many.
    let mut turned = template.triangles();
    turned.iter_mut().for_each(|corners| corners.swap(0, 1));
    write_mesh(&people.join("person 7.ply"), &faces[7], &turned).unwrap();
    let (code, [_, err]) = run(&[&train[..], &rest].concat());
    assert_eq!(code, Some(1), "{err}");
    let said = format!(
        "phiz-fit: {}: its triangles are not the template's",
        people.join("person 7.ply").display()
    );
    assert!(err.starts_with(&said) && err.lines().count() == 1, "{err}");
    let usual = &TRAINED.as_ref().expect("made of the same").learned.faces;
    assert!(far_beyond(usual).is_empty(), "{:?}", far_beyond(usual));
}

/// The file of a basis is the same of each run.
#[test]
fn a_basis_is_the_same_file_each_time() {
    let (Some(folder), Some(template)) = (base_mesh::folder(), heads::plain()) else {
        return;
    };
    let root = tempfile::tempdir().unwrap();
    let (file, people) = (root.path().join("t.phiz"), root.path().join("people"));
    std::fs::write(&file, template.to_bytes().unwrap()).unwrap();
    let some = population::sample(template, &folder, 6, SEED).unwrap();
    population::write(&some, template, &people).unwrap();
    let written = ["a.json", "b.json"].map(|name| {
        let path = root.path().join(name);
        let mut command = Command::new(env!("CARGO_BIN_EXE_phiz-fit"));
        command
            .args(["basis", "--template"])
            .arg(&file)
            .arg("--faces")
            .arg(&people);
        command
            .args(["--components", "5", "--iterations", "2", "-o"])
            .arg(&path);
        let done = command.output().unwrap();
        // How long it took is said, and not written.
        let out = String::from_utf8(done.stdout).unwrap();
        assert!(out.contains(" s for the start, "), "{out}");
        std::fs::read(&path).unwrap()
    });
    assert!(written[0] == written[1]);
    // An image of a face is not told to be one more.
    for i in 1..6 {
        std::fs::remove_file(people.join(format!("face_{i:04}.ply"))).unwrap();
    }
    let mut command = Command::new(env!("CARGO_BIN_EXE_phiz-fit"));
    command.args(["basis", "--template"]).arg(&file);
    command.arg("--faces").arg(&people);
    let done = command.arg("-o").arg(root.path().join("c.json")).output();
    let err = String::from_utf8(done.unwrap().stderr).unwrap();
    assert!(
        err.contains(": 1 face is too few to learn from; 2 are the least"),
        "{err}"
    );
}
