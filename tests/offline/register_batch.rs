//! A folder of scans: what can be done is done, once, and what cannot is said.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::Mutex;
use std::time::SystemTime;

use glam::DVec3;
use phiz::fit::FitError;
use phiz::fit::format::ply::{read_positions, write_mesh};
use phiz::fit::head::template::Template;
use phiz::fit::register::Settings;
use phiz::fit::register::batch::{self, Job, Jobs, Recipe};
use phiz::fit::scan::{Scan, landmarks};

use crate::heads;

/// Writes the scan of a seed with its landmarks; small, since it is in the template's triangles.
fn write(folder: &Path, name: &str, seed: u64) -> Option<Scan> {
    let template = heads::template()?;
    let head = heads::bent(template, seed);
    let scan = heads::skin(template, &head);
    let path = folder.join(format!("{name}.ply"));
    write_mesh(&path, &scan.positions, &scan.triangles).expect("writes");
    let points = heads::points(template, &head);
    landmarks::write(&path.with_extension("json"), &points, &[], 1.0, template).expect("writes");
    Some(scan)
}

/// A scan with colours of its vertices, as PLY in text.
fn write_coloured(path: &Path, scan: &Scan) {
    let (vertices, triangles) = (&scan.positions, &scan.triangles);
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
         property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        vertices.len(),
        triangles.len()
    );
    for p in vertices {
        text += &format!("{} {} {} 180 120 100\n", p.x, p.y, p.z);
    }
    for [a, b, c] in triangles {
        text += &format!("3 {a} {b} {c}\n");
    }
    fs::write(path, text).expect("writes");
}

/// The files of a folder and when they were written.
fn files(folder: &Path) -> BTreeMap<String, SystemTime> {
    let entries = fs::read_dir(folder).expect("a folder");
    entries
        .map(|entry| {
            let entry = entry.expect("an entry");
            let written = entry.metadata().and_then(|m| m.modified());
            let name = entry.file_name().into_string().expect("a name");
            (name, written.expect("a time"))
        })
        .collect()
}

fn names(folder: &Path) -> Vec<String> {
    files(folder).into_keys().collect()
}

fn template_file(folder: &Path, template: &Template) -> PathBuf {
    let path = folder.join("template.phiz");
    fs::write(&path, template.to_bytes().expect("writes")).expect("writes");
    path
}

/// `phiz-fit register` with a template.
fn register(template: &Path, arguments: &[&Path]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_phiz-fit"));
    command.arg("register").arg("--template").arg(template);
    command.args(arguments).output().expect("runs")
}

/// A folder that is gone with what is first, and in it one for scans and one for faces.
fn folders() -> (tempfile::TempDir, PathBuf, PathBuf) {
    let root = tempfile::tempdir().expect("a folder");
    let (scans, faces) = (root.path().join("scans"), root.path().join("faces"));
    for folder in [&scans, &faces] {
        fs::create_dir(folder).expect("makes");
    }
    (root, scans, faces)
}

fn said(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn a_bad_scan_among_good_ones_does_not_stop_them() {
    let Some(registrar) = heads::registrar() else {
        return;
    };
    let (_root, scans, faces) = folders();
    for (name, seed) in [("anna", 11), ("emil", 12)] {
        write(&scans, name, seed);
    }
    // Without faces; and one whose landmarks are no landmarks.
    fs::write(scans.join("bad.ply"), "ply\nformat ascii 1.0\nend_header\n").expect("writes");
    fs::copy(scans.join("anna.ply"), scans.join("carl.ply")).expect("copies");
    fs::write(scans.join("carl.json"), "{}").expect("writes");
    // What is no scan is nobody's business.
    fs::write(scans.join("notes.md"), "done").expect("writes");

    // Landmarks are those of a name whatever the case of their ending; a clock may be wrong.
    fs::rename(scans.join("emil.json"), scans.join("emil.JSON")).expect("is called otherwise");
    let dated = |path: &Path, time: SystemTime| {
        let file = fs::File::options().append(true).open(path);
        file.and_then(|file| file.set_modified(time))
            .expect("a time");
    };
    let hour = std::time::Duration::from_secs(3600);
    dated(&scans.join("anna.ply"), SystemTime::now() + hour);

    let found = batch::jobs(&scans, &faces).expect("scans");
    assert!(found.refused.is_empty() && found.unclaimed.is_empty());
    let jobs = found.jobs;
    let job = |name: &str, points: Option<&str>| Job {
        scan: scans.join(format!("{name}.ply")),
        landmarks: points.map(|p| scans.join(p)),
        output: faces.join(format!("{name}.ply")),
    };
    let all = [
        job("anna", Some("anna.json")),
        job("bad", None),
        job("carl", Some("carl.json")),
        job("emil", Some("emil.JSON")),
    ];
    assert_eq!(jobs, all);
    let told = Mutex::new(Vec::new());
    let run = || {
        let done = |job: &Job, result: &Result<(), _>| {
            let name = job.scan.file_stem().expect("a name").to_owned();
            told.lock().expect("whole").push((name, result.is_ok()));
        };
        let also = |_: &Job, _: &_, _: &_| Ok(());
        let failed = batch::run(registrar, &jobs, None, &Settings::default(), also, done);
        let failed: Vec<String> = failed.iter().map(ToString::to_string).collect();
        let mut told = std::mem::take(&mut *told.lock().expect("whole"));
        told.sort();
        (failed, told)
    };
    let (failed, told) = run();
    assert_eq!(failed.len(), 2);
    assert!(failed[0].contains("bad.ply"), "{}", failed[0]);
    assert!(failed[1].contains("carl"), "{}", failed[1]);
    let results = [
        ("anna", true),
        ("bad", false),
        ("carl", false),
        ("emil", true),
    ];
    assert_eq!(told, results.map(|(name, good)| (name.into(), good)));
    // Nothing of the bad ones, and nothing half-written.
    let there = [
        ".anna.made",
        ".emil.made",
        "anna.json",
        "anna.ply",
        "emil.json",
        "emil.ply",
    ];
    assert_eq!(names(&faces), there);

    // Once more: what is there stays as it is.
    let before = files(&faces);
    let (again, told) = run();
    assert_eq!(again, failed);
    assert_eq!(told, [("bad".into(), false), ("carl".into(), false)]);
    assert_eq!(files(&faces), before);

    // Landmarks of an older date are others all the same, and so are none; what is as it was is done.
    let emil = &jobs[3];
    let points = emil.landmarks.as_deref().expect("landmarks");
    let was = files(&scans)["emil.JSON"];
    dated(points, was - hour);
    assert!(!emil.is_done());
    dated(points, was);
    assert!(emil.is_done());
    let without = Job {
        landmarks: None,
        ..emil.clone()
    };
    assert!(!without.is_done());
    // Where nobody kept what it was made of, dates tell.
    fs::remove_file(faces.join(".emil.made")).expect("goes");
    assert!(emil.is_done());
    dated(points, SystemTime::now() + hour);
    assert!(!emil.is_done());

    // A disk that is full takes no face away, and the job is there for the next time.
    dated(&jobs[0].scan, was);
    let full = |_: &Job, _: &_, _: &_| Err(FitError::Input("no space left".into()));
    let settings = Settings::default();
    let failed = batch::run(registrar, &jobs[..1], None, &settings, full, |_, _| {});
    assert_eq!(failed.len(), 1);
    assert!(failed[0].to_string().contains("no space left"));
    for name in ["anna.json", "anna.ply"] {
        assert_eq!(files(&faces)[name], before[name], "{name}");
    }
    assert!(!jobs[0].is_done());
}

#[test]
fn folders_that_cannot_be_meant_are_refused() {
    let root = tempfile::tempdir().expect("a folder");
    let (scans, faces) = (root.path().join("scans"), root.path().join("faces"));
    let error = |output: &Path| {
        let result = batch::jobs(&scans, output);
        result.map(|_| ()).expect_err("no").to_string()
    };
    assert!(error(&faces).starts_with(&scans.display().to_string()));
    for folder in [&scans, &faces] {
        fs::create_dir(folder).expect("makes");
    }
    let said = error(&faces);
    let none = "no scans in it (.obj, .ply, .glb, .gltf, .stl)";
    assert_eq!(said, format!("{}: {none}", scans.display()));
    // A folder a person is told of, not taken for nobody's scans; that of the faces is none of those.
    let deeper = scans.join("P001");
    for folder in [&deeper, &scans.join("faces")] {
        fs::create_dir(folder).expect("makes");
        fs::write(folder.join("neutral.obj"), "").expect("writes");
    }
    let said = error(&scans.join("faces"));
    assert!(said.contains("but in 1 of its folders, as P001"), "{said}");
    fs::remove_dir_all(scans.join("faces")).expect("goes");
    fs::write(scans.join("anna.ply"), "").expect("writes");
    let said = error(&scans.join("."));
    assert!(
        said.contains("registered faces go to a folder of their own"),
        "{said}"
    );
    // Two of one name, and a name that is taken, are no reason to leave out the others.
    for name in ["anna.OBJ", "recipe.ply", "emil.stl", "emil.pts"] {
        fs::write(scans.join(name), "").expect("writes");
    }
    // Hidden files are no scans and no faces, and neither are folders that are called like some.
    for folder in [&scans, &faces] {
        fs::write(folder.join("._emil.ply"), "").expect("writes");
        fs::create_dir(folder.join("otto.ply")).expect("makes");
    }
    assert!(!phiz::fit::format::ply::has_faces(&faces).expect("a folder"));
    // One that is set otherwise than it is spelled is nobody's, and that is said; so is a face without a scan.
    for name in ["Emil.json", "about.json", "notes.txt"] {
        fs::write(scans.join(name), "").expect("writes");
    }
    for name in ["anna.ply", "emil.ply", "gone.ply"] {
        fs::write(faces.join(name), "").expect("writes");
    }
    let found = batch::jobs(&scans, &faces).expect("emil");
    assert_eq!(found.deeper, [deeper]);
    assert_eq!(
        found.strays(&faces).expect("reads"),
        [faces.join("gone.ply")]
    );
    let Jobs {
        jobs,
        refused,
        unclaimed,
        ..
    } = found;
    assert_eq!(unclaimed, [scans.join("Emil.json")]);
    let emil = Job {
        scan: scans.join("emil.stl"),
        landmarks: Some(scans.join("emil.pts")),
        output: faces.join("emil.ply"),
    };
    assert_eq!(jobs, [emil]);
    let [anna, recipe] = &refused[..] else {
        panic!("{refused:?}")
    };
    let (anna, recipe) = (anna.to_string(), recipe.to_string());
    assert!(anna.contains("has the same name as"), "{anna}");
    assert!(
        anna.contains("anna.ply") && anna.contains("anna.OBJ"),
        "{anna}"
    );
    assert!(
        recipe.contains("recipe.ply") && recipe.contains("a name that is taken"),
        "{recipe}"
    );
    // Of two files of landmarks one may be older than a hand's work: which, nobody knows.
    fs::write(scans.join("emil.TXT"), "").expect("writes");
    let two = batch::jobs(&scans, &faces).expect("scans");
    assert!(two.jobs.is_empty());
    let two = two.refused.iter().map(ToString::to_string);
    let two = two.filter(|error| error.contains("emil.TXT and emil.pts"));
    assert_eq!(two.count(), 1);
    // As MeshLab calls it by itself.
    for name in ["emil.TXT", "emil.pts"] {
        fs::remove_file(scans.join(name)).expect("goes");
    }
    fs::write(scans.join("emil_picked_points.pp"), "").expect("writes");
    let found = batch::jobs(&scans, &faces).expect("scans");
    let points = found.jobs[0].landmarks.as_deref();
    assert_eq!(points, Some(&*scans.join("emil_picked_points.pp")));
}

#[cfg(unix)]
#[test]
fn a_scan_that_a_link_has_among_the_faces_is_not_written_over() {
    use std::os::unix::fs::symlink;
    let (_root, scans, faces) = folders();
    // The one's scan lies there, and another's landmarks and picture; and two have one face.
    for name in ["anna.ply", "emil.json", "otto.png"] {
        fs::write(faces.join(name), "kept").expect("writes");
        symlink(faces.join(name), scans.join(name)).expect("links");
    }
    for name in ["emil.ply", "otto.obj", "rosa.stl", "sara.stl"] {
        fs::write(scans.join(name), "").expect("writes");
    }
    fs::write(faces.join("rosa.ply"), "").expect("writes");
    symlink(faces.join("rosa.ply"), faces.join("sara.ply")).expect("links");
    let found = batch::jobs(&scans, &faces).expect("scans");
    let named = found.jobs.iter().map(|job| job.scan.clone());
    assert_eq!(named.collect::<Vec<_>>(), [scans.join("rosa.stl")]);
    let lost = [
        (&scans, "anna.ply", "anna.ply"),
        (&scans, "emil.json", "emil.json"),
        (&scans, "otto.png", "otto.png"),
        (&faces, "rosa.ply", "sara.ply"),
    ];
    assert_eq!(found.refused.len(), lost.len());
    for (error, (folder, is, to)) in found.refused.iter().zip(lost) {
        let error = error.to_string();
        let (to, is) = (faces.join(to), folder.join(is));
        let (to, is) = (to.display(), is.display());
        assert!(
            error.contains(&format!("written to {to}, which is {is}")),
            "{error}"
        );
    }
}

/// A face is all that there is of a person whose scan cannot be seen, or read, and stays; whose scan is seen to be another
/// that is none has no face.
#[cfg(unix)]
#[test]
fn a_scan_that_cannot_be_seen_or_read_costs_no_face() {
    use std::os::unix::fs::symlink;
    let Some(registrar) = heads::registrar() else {
        return;
    };
    let (root, scans, faces) = folders();
    write(&scans, "anna", 11);
    let run = || {
        let Jobs { jobs, .. } = batch::jobs(&scans, &faces).expect("a scan");
        let also = |_: &Job, _: &_, _: &_| Ok(());
        let settings = Settings::default();
        let failed = batch::run(registrar, &jobs, None, &settings, also, |_, _| {});
        (
            failed.iter().map(ToString::to_string).collect::<Vec<_>>(),
            jobs[0].is_done(),
        )
    };
    assert_eq!(run(), (Vec::new(), true));
    let made = files(&faces);
    let (scan, away) = (scans.join("anna.ply"), root.path().join("away.ply"));
    fs::rename(&scan, &away).expect("goes");
    let in_its_place = |target: &Path| {
        let _ = fs::remove_file(&scan);
        symlink(target, &scan).expect("links");
    };
    // A disk that is not connected; and a scan that is another, of whose two files one cannot be had.
    in_its_place(Path::new("/nowhere/anna.ply"));
    let gone = run();
    fs::remove_file(&scan).expect("goes");
    let parts =
        r#"{"asset": {"version": "2.0"}, "buffers": [{"byteLength": 36, "uri": "anna.bin"}]}"#;
    fs::write(scans.join("anna.gltf"), parts).expect("writes");
    let half = run();
    fs::remove_file(scans.join("anna.gltf")).expect("goes");
    for ((failed, is_done), cause) in [
        (gone, "anna.ply: "),
        (half, "anna.gltf: buffer 0: anna.bin: "),
    ] {
        let [error] = &failed[..] else {
            panic!("{cause}: {failed:?}")
        };
        assert!(!is_done && error.contains(cause), "{error}");
        assert!(error.ends_with("; its former face stays"), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
        assert_eq!(files(&faces), made, "{cause}");
    }
    // Nor do landmarks that cannot be seen; nor where nobody kept what the face was made of.
    let points = scans.join("anna.json");
    let bytes = fs::read(&points).expect("landmarks");
    in_its_place(&away);
    fs::remove_file(&points).expect("goes");
    symlink("/nowhere/anna.json", &points).expect("links");
    let (failed, _) = run();
    assert!(failed[0].contains("anna.json: "), "{failed:?}");
    assert_eq!(files(&faces), made);
    in_its_place(Path::new("/nowhere/anna.ply"));
    fs::rename(faces.join(".anna.made"), root.path().join("made")).expect("goes");
    let (failed, _) = run();
    assert!(failed[0].ends_with("; its former face stays"), "{failed:?}");
    fs::rename(root.path().join("made"), faces.join(".anna.made")).expect("comes");
    assert_eq!(files(&faces), made);

    // It is there again, as it was.
    fs::remove_file(&points).expect("goes");
    fs::write(&points, bytes).expect("writes");
    fs::remove_file(&scan).expect("goes");
    fs::rename(&away, &scan).expect("comes");
    // What is no scan any more has no face.
    fs::write(&scan, "").expect("writes");
    let (failed, _) = run();
    let gone = "the face of what it was before is taken away";
    assert!(failed[0].ends_with(gone), "{failed:?}");
    assert!(names(&faces).is_empty(), "{:?}", names(&faces));
}

#[test]
fn a_folder_has_faces_of_one_kind_whoever_they_are() {
    let folder = tempfile::tempdir().expect("a folder");
    let recipe = |template: u32| Recipe {
        template,
        prior: true,
        neutral: false,
        unit: None,
        made_by: "phiz-fit 9".into(),
    };
    recipe(1).keep(folder.path()).expect("written");
    // Where no face came of it, another may begin.
    recipe(2).keep(folder.path()).expect("written");
    fs::write(folder.path().join("of other scans.PLY"), "").expect("writes");
    recipe(2).keep(folder.path()).expect("the same");
    let error = recipe(3).keep(folder.path()).expect_err("no").to_string();
    assert!(error.contains("with another template"), "{error}");
    // Another version of the program is told, where one was kept.
    let newer = Recipe {
        made_by: "phiz-fit 10".into(),
        ..recipe(2)
    };
    let other = newer.keep(folder.path()).expect("the same but for that");
    assert_eq!(other.as_deref(), Some("phiz-fit 9"));
    let path = folder.path().join("recipe.json");
    let text = fs::read_to_string(&path).expect("reads");
    let old: String = text
        .lines()
        .filter(|line| !line.contains("made_by"))
        .collect();
    fs::write(&path, old).expect("writes");
    assert_eq!(newer.keep(folder.path()).expect("the same"), None);
}

#[test]
fn a_folder_tells_of_each_scan_what_was_guessed_or_found() {
    let Some(template) = heads::template() else {
        return;
    };
    let root = tempfile::tempdir().expect("a folder");
    let (scans, faces) = (root.path().join("scans"), root.path().join("faces"));
    fs::create_dir(&scans).expect("makes");
    let smile = |e: &&phiz::fit::head::expression::Expression| e.name.starts_with("mouthSmile");
    let mut smiling = template.positions.clone();
    for expression in template.expressions.iter().filter(smile) {
        let moves = smiling.iter_mut().zip(&expression.displacements);
        moves.for_each(|(p, d)| *p += *d * 0.8);
    }
    let far = DVec3::X * 4e6;
    for (name, head, by, at) in [
        ("inch", &template.positions, 1.0 / 25.4, DVec3::ZERO),
        ("smile", &smiling, 1.0, DVec3::ZERO),
        ("far", &template.positions, 1.0, far),
    ] {
        let scan = heads::skin(template, head);
        let mut text = String::new();
        for p in &scan.positions {
            let p = *p * by + at;
            text += &format!("v {} {} {}\n", p.x, p.y, p.z);
        }
        for [a, b, c] in &scan.triangles {
            text += &format!("f {} {} {}\n", a + 1, b + 1, c + 1);
        }
        fs::write(scans.join(format!("{name}.obj")), text).expect("writes");
        let points: Vec<(usize, DVec3)> = (heads::points(template, head).into_iter())
            .map(|(l, p)| (l, p * by + at))
            .collect();
        let file = scans.join(format!("{name}.json"));
        landmarks::write(&file, &points, &[], 1.0, template).expect("writes");
    }
    let deeper = scans.join("P001");
    fs::create_dir(&deeper).expect("makes");
    fs::write(deeper.join("a.obj"), "").expect("writes");
    let file = template_file(root.path(), template);
    let paths = ["--scans".as_ref(), &*scans, "-o".as_ref(), &*faces];
    let done = register(&file, &paths);
    let out = said(&done.stdout);
    assert_eq!(done.status.code(), Some(0), "{}", said(&done.stderr));
    let alone = format!(
        "{}: is a folder with scans, which is left out: ",
        deeper.display()
    );
    assert!(out.contains(&alone), "{out}");
    let line = |start: &str| {
        let found = out.lines().find(|line| line.starts_with(start));
        found.unwrap_or_else(|| panic!("{out}"))
    };
    assert!(
        line("inch: ").starts_with("inch: in inches, guessed"),
        "{out}"
    );
    assert!(line("smile: shows ").contains("mouthSmile"), "{out}");
    assert!(line("far: ").contains("from the origin"), "{out}");
    let all = line("units guessed: 1 in inches, 2 in millimetres (see --unit)");
    assert!(all.contains("with expressions (see --neutral)"), "{out}");

    // Where maps have their people, f32 are half a metre apart.
    let scan = root.path().join("map.obj");
    let moved: Vec<DVec3> = template
        .positions
        .iter()
        .map(|p| *p + DVec3::X * 5e9)
        .collect();
    let skin = heads::skin(template, &moved);
    let mut text = String::new();
    (skin.positions.iter()).for_each(|p| text += &format!("v {} {} {}\n", p.x, p.y, p.z));
    (skin.triangles.iter())
        .for_each(|t| text += &format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1));
    fs::write(&scan, text).expect("writes");
    let marks = root.path().join("map.json");
    landmarks::write(&marks, &heads::points(template, &moved), &[], 1.0, template).expect("writes");
    let face = root.path().join("map.ply");
    let paths = [
        "--scan".as_ref(),
        &*scan,
        "--landmarks".as_ref(),
        &*marks,
        "-o".as_ref(),
        &*face,
    ];
    let done = register(&file, &paths);
    let err = said(&done.stderr);
    assert_eq!(done.status.code(), Some(1), "{err}");
    assert!(
        err.contains("from the origin, where a PLY has steps of 512.00 mm"),
        "{err}"
    );
    assert!(
        err.contains(&format!("phiz-fit: {}: place: ", scan.display())),
        "{err}"
    );
    assert!(!face.exists());
}

#[test]
fn who_asks_for_another_format_or_for_the_beginning_gets_no_surprise() {
    let Some(template) = heads::template() else {
        return;
    };
    let root = tempfile::tempdir().expect("a folder");
    let at = |name: &str| root.path().join(name);
    let file = template_file(root.path(), template);
    write(root.path(), "anna", 11).expect("a template");
    let (scan, face) = (at("anna.ply"), at("face.obj"));
    let refused = register(&file, &["--scan".as_ref(), &scan, "-o".as_ref(), &face]);
    let err = said(&refused.stderr);
    assert_eq!(refused.status.code(), Some(2));
    assert!(err.contains("face.obj: ") && err.contains(".ply"), "{err}");
    assert!(!face.exists());

    // Every name of a landmark is in the help.
    for verb in ["register", "landmarks"] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_phiz-fit"));
        let help = command.args([verb, "--help"]).output().expect("runs");
        let help = said(&help.stdout);
        let help = help.split("Names of landmarks").nth(1).expect("names");
        let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
        for landmark in &template.landmarks {
            let name = &landmark.name;
            let pair = name.strip_suffix(" left").or(name.strip_suffix(" right"));
            let told = help.contains(pair.unwrap_or(name)) || name.starts_with("ibug_");
            assert!(told, "{name} in {help}");
        }
    }

    // Who reads the first line alone.
    let mut command = Command::new(env!("CARGO_BIN_EXE_phiz-fit"));
    let mut child = command
        .args(["landmarks", "--template"])
        .args([&file, Path::new("--scan"), &scan])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("runs");
    drop(child.stdout.take());
    let ended = child.wait_with_output().expect("ends");
    let err = said(&ended.stderr);
    assert!(!err.contains("panicked") && !err.contains("pipe"), "{err}");
}

#[test]
fn the_program_finishes_the_rest_and_does_later_what_is_missing() {
    let Some(template) = heads::template() else {
        return;
    };
    let root = tempfile::tempdir().expect("a folder");
    let (scans, faces) = (root.path().join("scans"), root.path().join("faces"));
    fs::create_dir(&scans).expect("makes");
    let template_file = template_file(root.path(), template);
    let anna = write(&scans, "anna", 11).expect("a template");
    write_coloured(&scans.join("anna.ply"), &anna);
    write(&scans, "emil", 12);
    fs::write(scans.join("bad.glb"), "glTF?").expect("writes");
    fs::write(scans.join("about.json"), "{}").expect("writes");
    let labels = r#"{"anna": {"age": 40}, "emil": {"age": null}}"#;
    fs::write(scans.join("labels.json"), labels).expect("writes");
    fs::write(scans.join("nobody.pts"), "").expect("writes");

    let folder = ["--scans".as_ref(), scans.as_path(), "-o".as_ref(), &faces];
    let textures: Vec<&Path> = [&folder[..], &["--textures".as_ref()]].concat();
    let first = register(&template_file, &textures);
    assert_eq!(first.status.code(), Some(1));
    let (out, err) = (said(&first.stdout), said(&first.stderr));
    assert!(
        out.contains("2 faces registered, 0 were there, 1 failed"),
        "{out}"
    );
    assert!(
        out.contains("emil.ply: it has no colours, so there is no PNG"),
        "{out}"
    );
    assert!(!out.contains("anna.ply: it has no colours"), "{out}");
    assert!(
        out.contains("nobody.pts: belongs to no scan there"),
        "{out}"
    );
    assert!(!out.contains("learned from"), "{out}");
    assert!(err.lines().any(|line| line.contains("bad.glb")), "{err}");
    assert!(
        err.contains("1 of 3 scans could not be registered"),
        "{err}"
    );
    assert!(!err.contains("panicked"), "{err}");
    let there = [
        ".anna.made",
        ".emil.made",
        "about.json",
        "anna.json",
        "anna.ply",
        "anna.png",
        "emil.json",
        "emil.ply",
        "labels.json",
        "recipe.json",
        "register.csv",
    ];
    assert_eq!(names(&faces), there);
    // Whose scans they are and what is known of them is so of the faces.
    let copied = fs::read_to_string(faces.join("labels.json")).expect("labels");
    assert_eq!(copied, labels);
    // What was found on the way is told of each, and still of those that were there.
    let table = fs::read(faces.join("register.csv")).expect("a table");
    let mut reader = csv::Reader::from_reader(&table[..]);
    let rows: Vec<csv::StringRecord> = reader.records().map(|row| row.expect("a row")).collect();
    let cells = |row: usize| rows[row].iter().map(String::from).collect::<Vec<_>>();
    assert_eq!(
        [&cells(0)[..2], &cells(1)[..2]],
        [["anna", "anna.ply"], ["emil", "emil.ply"]]
    );
    for row in &rows {
        let seen: f64 = row[2].parse().expect("a part");
        // These scans are of all of the skin; a little is near their open edge.
        assert!((80.0..=100.0).contains(&seen), "{seen}");
        assert!(row[4].contains("units: "), "{row:?}");
    }
    // Labels that were made better beside the faces stay.
    let better = r#"{"anna": {"age": 41}}"#;
    fs::write(faces.join("labels.json"), better).expect("writes");
    // Of faces that were there no texture is baked, which is said.
    let again = said(&register(&template_file, &textures).stdout);
    let none = "1 of the faces that were there have no PNG, and get none";
    assert!(again.contains(none), "{again}");
    assert!(
        again.contains("labels.json: is not what lies beside the scans, and stays"),
        "{again}"
    );
    let kept = fs::read_to_string(faces.join("labels.json")).expect("labels");
    assert_eq!(kept, better);
    // Nor does a file join a table, where one of them is to be.
    fs::remove_file(faces.join("labels.json")).expect("goes");
    fs::write(faces.join("labels.csv"), "name,age\nanna,41\n").expect("writes");
    let as_table = said(&register(&template_file, &textures).stdout);
    assert!(
        as_table.contains("labels.csv: is not what lies beside the scans, and stays"),
        "{as_table}"
    );
    assert!(!faces.join("labels.json").exists());
    fs::remove_file(faces.join("labels.csv")).expect("goes");
    fs::write(faces.join("labels.json"), better).expect("writes");
    assert_eq!(
        fs::read(faces.join("register.csv")).expect("a table"),
        table
    );
    // The texture has the colour that the scan has all over; the skin takes a quarter of the layout.
    let image = image::open(faces.join("anna.png"))
        .expect("a picture")
        .into_rgb8();
    let same = image.pixels().filter(|p| p.0 == [180, 120, 100]).count();
    let part = same as f64 / f64::from(image.width() * image.height());
    assert!(part > 0.2, "{part}");

    // One is lost and the bad one is good now: those two are made, the other stays.
    let (before, emil) = (files(&faces), faces.join("emil.ply"));
    let bytes = fs::read(&emil).expect("a face");
    fs::remove_file(&emil).expect("goes");
    fs::remove_file(scans.join("bad.glb")).expect("goes");
    // A face whose scan is gone stays, which is said.
    let gone = faces.join("bad.ply");
    fs::copy(faces.join("anna.ply"), &gone).expect("copies");
    let second = register(&template_file, &folder);
    let out = said(&second.stdout);
    assert_eq!(second.status.code(), Some(0), "{}", said(&second.stderr));
    assert!(
        out.contains("1 face registered, 1 was there, 0 failed"),
        "{out}"
    );
    assert!(
        out.contains("bad.ply: of no scan there: it stays, and is learned from"),
        "{out}"
    );
    fs::remove_file(&gone).expect("is there");
    assert_eq!(fs::read(&emil).expect("a face"), bytes);
    let after = files(&faces);
    assert_eq!(names(&faces), there);
    for kept in ["anna.ply", "anna.json", "anna.png"] {
        assert_eq!(after[kept], before[kept], "{kept}");
    }

    // Who corrects the landmarks of one gets that one again.
    let (corrected, before) = (scans.join("emil.json"), files(&faces));
    let bytes = fs::read(&corrected).expect("landmarks");
    fs::write(&corrected, bytes).expect("writes");
    let third = register(&template_file, &folder);
    let out = said(&third.stdout);
    assert!(
        out.contains("1 face registered, 1 was there, 0 failed"),
        "{out}"
    );
    let after = files(&faces);
    assert!(after["emil.ply"] > before["emil.ply"]);
    assert_eq!(after["anna.ply"], before["anna.ply"]);

    // Faces that are made in another way do not join these.
    let plain = Template {
        expressions: Vec::new(),
        ..template.clone()
    };
    let other = root.path().join("other");
    fs::create_dir(&other).expect("makes");
    let another = self::template_file(&other, &plain);
    let neutral: Vec<&Path> = [&folder[..], &["--neutral".as_ref()]].concat();
    for (template, arguments, cause) in [
        (&another, &folder[..], "with another template"),
        (&template_file, &neutral, "with the expressions they show"),
    ] {
        let refused = register(template, arguments);
        assert_eq!(refused.status.code(), Some(1));
        let err = said(&refused.stderr);
        assert!(
            err.contains("recipe.json") && err.contains(cause) && err.lines().count() == 1,
            "{err}"
        );
        assert_eq!(files(&faces), after);
    }

    // What would be copied to the faces and is none is told before them.
    fs::write(scans.join("about.json"), r#"{"title": 1}"#).expect("writes");
    let refused = register(&template_file, &folder);
    let err = said(&refused.stderr);
    assert_eq!(refused.status.code(), Some(1));
    assert!(
        err.contains("about.json: ") && err.lines().count() == 1,
        "{err}"
    );
    fs::remove_file(scans.join("about.json")).expect("goes");
    fs::write(scans.join("labels.json"), r#"{"anna": {"sex": "F"}}"#).expect("writes");
    let refused = register(&template_file, &folder);
    let err = said(&refused.stderr);
    assert_eq!(refused.status.code(), Some(1));
    assert!(
        err.contains("labels.json: anna: its sex is no number") && err.lines().count() == 1,
        "{err}"
    );
    fs::remove_file(scans.join("labels.json")).expect("goes");
    fs::write(scans.join("labels.csv"), "name,sex\nanna,F\n").expect("writes");
    let refused = register(&template_file, &folder);
    let err = said(&refused.stderr);
    assert_eq!(refused.status.code(), Some(1));
    assert!(
        err.contains("labels.csv: row 2, column sex: \"F\" is no number")
            && err.lines().count() == 1,
        "{err}"
    );
    fs::remove_file(scans.join("labels.csv")).expect("goes");
    assert_eq!(files(&faces), after);

    // Where no face is left, nothing is mixed.
    for name in ["anna.ply", "emil.ply"] {
        fs::remove_file(faces.join(name)).expect("goes");
    }
    let anew = register(&another, &folder);
    let out = said(&anew.stdout);
    assert!(
        out.contains("2 faces registered, 0 were there, 0 failed"),
        "{out}{}",
        said(&anew.stderr)
    );
    // The picture of the face of before is none of this one's.
    assert!(faces.join("anna.ply").is_file() && !faces.join("anna.png").exists());
}

#[test]
fn a_picture_that_was_changed_makes_its_face_again_where_there_is_one_of_it() {
    let (Some(template), Some(registrar)) = (heads::template(), heads::registrar()) else {
        return;
    };
    let (_root, scans, faces) = folders();
    let head = heads::bent(template, 11);
    let scan = heads::skin(template, &head);
    let mut text = String::from("mtllib anna.mtl\nvt 0 0\nusemtl skin\n");
    (scan.positions.iter()).for_each(|p| text += &format!("v {} {} {}\n", p.x, p.y, p.z));
    (scan.triangles.iter())
        .for_each(|t| text += &format!("f {}/1 {}/1 {}/1\n", t[0] + 1, t[1] + 1, t[2] + 1));
    fs::write(scans.join("anna.obj"), text).expect("writes");
    fs::write(scans.join("anna.mtl"), "newmtl skin\nmap_Kd skin.png\n").expect("writes");
    let paint = |grey| {
        let image = image::RgbImage::from_pixel(2 + u32::from(grey), 2, image::Rgb([grey; 3]));
        image.save(scans.join("skin.png")).expect("writes");
    };
    paint(1);
    let points = heads::points(template, &head);
    landmarks::write(&scans.join("anna.json"), &points, &[], 1.0, template).expect("writes");
    let Jobs { jobs, .. } = batch::jobs(&scans, &faces).expect("scans");
    let picture = faces.join("anna.png");
    let also = |_: &Job, prepared: &batch::Prepared, _: &phiz::fit::register::Registered| {
        assert!(prepared.scan.texture.is_some());
        fs::write(&picture, "of it").map_err(|e| FitError::file(&picture, e))
    };
    let failed = batch::run(
        registrar,
        &jobs,
        None,
        &Settings::default(),
        also,
        |_, _| {},
    );
    assert!(failed.is_empty(), "{failed:?}");
    assert!(jobs[0].is_done());
    paint(9);
    assert!(!jobs[0].is_done());
    // Nobody looks at it; or it cannot be seen.
    fs::remove_file(&picture).expect("goes");
    assert!(jobs[0].is_done());
    fs::write(&picture, "of it").expect("writes");
    fs::remove_file(scans.join("skin.png")).expect("goes");
    assert!(jobs[0].is_done());
}

#[test]
fn what_failed_is_said_whatever_else_goes_wrong() {
    let Some(template) = heads::template() else {
        return;
    };
    let (root, scans, faces) = folders();
    let file = template_file(root.path(), template);
    write(&scans, "anna", 11);
    fs::write(scans.join("bad.glb"), "glTF?").expect("writes");
    // A table of somebody's.
    fs::write(faces.join("register.csv"), "who;when\n").expect("writes");
    let folder = ["--scans".as_ref(), &*scans, "-o".as_ref(), &*faces];
    let done = register(&file, &folder);
    let (out, err) = (said(&done.stdout), said(&done.stderr));
    assert_eq!(done.status.code(), Some(1));
    assert!(
        out.contains("1 face registered, 0 were there, 1 failed"),
        "{out}"
    );
    for part in [
        "bad.glb: ",
        "register.csv: is no table of what was registered: it stays",
    ] {
        assert!(err.contains(part), "{err}");
    }
    let table = fs::read_to_string(faces.join("register.csv")).expect("a table");
    assert_eq!(table, "who;when\n");
    // Where none can be, that is said before the work.
    fs::remove_file(faces.join("register.csv")).expect("goes");
    fs::remove_file(faces.join("anna.ply")).expect("goes");
    fs::create_dir(faces.join("register.csv")).expect("makes");
    let done = register(&file, &folder);
    let err = said(&done.stderr);
    assert_eq!(done.status.code(), Some(1));
    assert!(
        err.contains("register.csv: a folder, where a file is to be written"),
        "{err}"
    );
    assert!(!faces.join("anna.ply").exists());
}

#[test]
fn one_scan_gets_its_texture_and_its_picture() {
    let Some(template) = heads::template() else {
        return;
    };
    let root = tempfile::tempdir().expect("a folder");
    let at = |name: &str| root.path().join(name);
    let template_file = template_file(root.path(), template);
    let scan = write(root.path(), "anna", 11).expect("a template");
    let landmarks = at("anna.json");
    let one = |scan: &Path, options: &[&Path]| {
        let face = at("face.ply");
        let given: [&Path; 6] = [
            "--scan".as_ref(),
            scan,
            "--landmarks".as_ref(),
            &landmarks,
            "-o".as_ref(),
            &face,
        ];
        register(&template_file, &[&given[..], options].concat())
    };
    // Bare: a texture is refused before anything is written.
    let texture = at("texture.png");
    let refused = one(&at("anna.ply"), &["--texture".as_ref(), &texture]);
    let err = said(&refused.stderr);
    assert_eq!(refused.status.code(), Some(1));
    assert!(
        err.contains("anna.ply: neither a texture nor colours of its vertices"),
        "{err}"
    );
    assert!(!texture.exists() && !at("face.ply").exists());
    // Why it has none is said before.
    let materials = at("materials.obj");
    let mut text = String::from("mtllib gone.mtl\n");
    for p in &scan.positions {
        text += &format!("v {} {} {}\n", p.x, p.y, p.z);
    }
    for [a, b, c] in &scan.triangles {
        text += &format!("f {} {} {}\n", a + 1, b + 1, c + 1);
    }
    fs::write(&materials, text).expect("writes");
    let refused = one(&materials, &["--texture".as_ref(), &texture]);
    let err = said(&refused.stderr);
    let (before, last) = err.trim_end().rsplit_once('\n').expect("two lines");
    assert!(
        before.contains("no materials: ") && before.contains("gone.mtl"),
        "{err}"
    );
    assert!(last.contains("neither a texture nor colours"), "{err}");

    let (coloured, picture) = (at("coloured.ply"), at("picture.png"));
    write_coloured(&coloured, &scan);
    let options = [
        "--texture".as_ref(),
        &*texture,
        "--picture".as_ref(),
        &*picture,
    ];
    let done = one(&coloured, &options);
    assert_eq!(done.status.code(), Some(0), "{}", said(&done.stderr));
    let face = read_positions(&at("face.ply")).expect("a face");
    assert_eq!(face.len(), template.positions.len());
    for file in [&texture, &picture] {
        let image = image::open(file).expect("a picture");
        assert!(image.width() >= 1000, "{}", file.display());
    }

    // Options that do not belong together are told by their names.
    let folder = ["--scans".as_ref(), root.path(), "-o".as_ref(), root.path()];
    for option in ["--landmarks", "--texture", "--picture"] {
        let wrong = register(
            &template_file,
            &[&folder[..], &[option.as_ref(), &picture]].concat(),
        );
        assert_eq!(wrong.status.code(), Some(2), "{option}");
        let err = said(&wrong.stderr);
        assert!(err.contains(option) && err.contains("--scans"), "{err}");
    }
    let wrong = one(&coloured, &["--textures".as_ref()]);
    assert_eq!(wrong.status.code(), Some(2));
}

#[test]
fn an_expression_is_taken_off_where_that_is_asked_for() {
    let Some(template) = heads::template() else {
        return;
    };
    let root = tempfile::tempdir().expect("a folder");
    let scans = root.path().join("scans");
    fs::create_dir(&scans).expect("makes");
    // The rest pose with a broad smile.
    let smile = |e: &&phiz::fit::head::expression::Expression| e.name.starts_with("mouthSmile");
    let mut head = template.positions.clone();
    for expression in template.expressions.iter().filter(smile) {
        let moves = head.iter_mut().zip(&expression.displacements);
        moves.for_each(|(p, d)| *p += *d * 0.8);
    }
    let scan = heads::skin(template, &head);
    write_mesh(&scans.join("a.ply"), &scan.positions, &scan.triangles).expect("writes");
    let points = heads::points(template, &head);
    landmarks::write(&scans.join("a.json"), &points, &[], 1.0, template).expect("writes");

    let file = template_file(root.path(), template);
    let farthest = |face: &Path| {
        let face = read_positions(face).expect("a face");
        let apart = face.iter().zip(&template.positions);
        apart.map(|(p, rest)| p.distance(*rest)).fold(0.0, f64::max)
    };
    let run = |options: &[&str], output: &Path| {
        let paths = ["--scans".as_ref(), &*scans, "-o".as_ref(), output];
        let options = options.iter().map(Path::new);
        let all: Vec<&Path> = paths.into_iter().chain(options).collect();
        register(&file, &all)
    };
    let (shown, neutral) = (root.path().join("shown"), root.path().join("neutral"));
    for (options, output) in [(&[][..], &shown), (&["--neutral"][..], &neutral)] {
        let done = run(options, output);
        assert_eq!(done.status.code(), Some(0), "{}", said(&done.stderr));
    }
    let (kept, off) = (
        farthest(&shown.join("a.ply")),
        farthest(&neutral.join("a.ply")),
    );
    println!("{kept:.2} mm from the face at rest, {off:.2} mm without the expression");
    assert!(kept > 5.0 && off < 0.5 * kept, "{kept} {off}");
    // The landmarks beside a face are that face's.
    let corner = |folder: &Path| {
        let read = batch::read_registered(folder, template).expect("reads");
        let name = |p: &&(usize, DVec3)| template.landmarks[p.0].name == "ibug_48";
        read[0].1.points.iter().find(name).expect("is there").1
    };
    let at = template.landmarks.iter().position(|l| l.name == "ibug_48");
    let rest = template.landmark(at.expect("is there"), &template.positions);
    assert!(corner(&neutral).distance(rest) < 0.5 * corner(&shown).distance(rest));

    // One that knows no expressions takes none off, and one alone says so.
    let without = Template {
        expressions: Vec::new(),
        ..template.clone()
    };
    let folder = root.path().join("without");
    fs::create_dir(&folder).expect("makes");
    let file = template_file(&folder, &without);
    let (scan, face) = (scans.join("a.ply"), root.path().join("face.ply"));
    let options = ["--scan".as_ref(), &*scan, "-o".as_ref(), &face];
    let refused = register(&file, &[&options[..], &["--neutral".as_ref()]].concat());
    assert_eq!(refused.status.code(), Some(1));
    let err = said(&refused.stderr);
    assert!(
        err.contains("knows no expressions") && !face.exists(),
        "{err}"
    );
}

#[test]
fn a_scan_that_fails_leaves_no_former_face_and_no_scans_no_folder() {
    let Some(registrar) = heads::registrar() else {
        return;
    };
    let (root, scans, faces) = folders();
    for name in ["anna.ply", "anna.json", "anna.png", "emil.ply"] {
        fs::write(faces.join(name), "").expect("writes");
    }
    // Newer than its face, and no scan any more.
    let changed = fs::File::create(scans.join("anna.ply")).expect("writes");
    let later = SystemTime::now() + std::time::Duration::from_secs(60);
    changed.set_modified(later).expect("a time");
    // Whose picture lies where that of the face goes: nothing is touched.
    let mut text = String::from("mtllib rosa.mtl\n");
    for [x, y, z] in [[0, 0, 0], [200, 0, 0], [0, 200, 0], [0, 0, 200]] {
        text += &format!("v {x} {y} {z}\nvt 0 {}\n", z / 200);
    }
    text += "usemtl skin\nf 1/1 3/3 2/2\nf 1/1 2/2 4/4\nf 1/1 4/4 3/3\nf 2/2 3/3 4/4\n";
    fs::write(scans.join("rosa.obj"), text).expect("writes");
    let material = "newmtl skin\nmap_Kd ../faces/rosa.png\n";
    fs::write(scans.join("rosa.mtl"), material).expect("writes");
    for name in ["rosa.ply", "rosa.png"] {
        fs::write(faces.join(name), "kept").expect("writes");
    }
    let written = fs::File::options()
        .append(true)
        .open(scans.join("rosa.obj"));
    written
        .and_then(|file| file.set_modified(later))
        .expect("a time");
    let Jobs { jobs, .. } = batch::jobs(&scans, &faces).expect("scans");
    let also = |_: &Job, _: &batch::Prepared, _: &phiz::fit::register::Registered| Ok(());
    let settings = Settings::default();
    let failed = batch::run(registrar, &jobs, None, &settings, also, |_, _| {});
    let [error, rosa] = &failed[..] else {
        panic!("{failed:?}")
    };
    let (error, rosa) = (error.to_string(), rosa.to_string());
    assert!(
        error.contains("anna.ply: the file is empty; the face of"),
        "{error}"
    );
    assert!(
        rosa.contains("rosa.png: is a material, an image or a buffer of the scan"),
        "{rosa}"
    );
    assert_eq!(names(&faces), ["emil.ply", "rosa.ply", "rosa.png"]);

    let Some(template) = heads::template() else {
        return;
    };
    let file = template_file(root.path(), template);
    let (nowhere, new) = (root.path().join("nowhere"), root.path().join("new"));
    let done = register(&file, &["--scans".as_ref(), &nowhere, "-o".as_ref(), &new]);
    assert_eq!(done.status.code(), Some(1));
    assert!(!new.exists());
}
