//! What the program refuses before it begins: with what is wrong, and the code 2 where that is how it was
//! called.

use std::path::Path;
use std::process::Command;

/// The exit code of the program, and what it says of an error.
fn called(arguments: &str) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_phiz-fit"));
    let done = command.args(arguments.split(' ')).output().expect("runs");
    let said = String::from_utf8_lossy(&done.stderr).into_owned();
    (done.status.code(), said)
}

fn folder_name(folder: &tempfile::TempDir) -> std::path::Display<'_> {
    folder
        .path()
        .file_name()
        .map(Path::new)
        .expect("a name")
        .display()
}

#[test]
fn what_is_not_meant_is_a_usage_error() {
    let basis = "basis --template t --faces f -o o";
    let train = "train --template t --faces f -o o --tau";
    for (arguments, said) in [
        ("landmarks --template t --scan s --least 1.5", "--least"),
        ("landmarks --template t --scan s --least nan", "--least"),
        ("simulate --ict i -o o --noise 11", "--noise"),
        ("simulate --ict i -o o --jitter=-1", "--jitter"),
        (
            "evaluate --ict i --template t --only clean,hard",
            "noisy-holes",
        ),
        (
            "evaluate --ict i --template t --save a --registered b",
            "--registered",
        ),
        ("register --template t --scan s -o face.obj", "face.obj: "),
        ("sample m -o faces.stl", "faces.stl: "),
        ("export m -o model.npy", "model.npy: "),
        (&format!("{train} 0"), "--tau"),
        (&format!("{train} 1.01"), "--tau"),
        (&format!("{basis} --compare 2"), "--compare"),
        (&format!("{basis} --compare 9 --test 0"), "--test"),
        (&format!("{basis} --compare 9 --splits 0"), "--splits"),
        (
            &format!("{basis} --compare 9 --components 3"),
            "--components",
        ),
        (&format!("{basis} --compare 9 --kind region"), "--kind"),
        (&format!("{basis} --compare 9 --area face"), "--area"),
        (&format!("{basis} --compare 9 --one-sided"), "--one-sided"),
        (&format!("{basis} --compare 9 --sigmas"), "--sigmas"),
        (
            &format!("{basis} --compare 9 --save-problem p"),
            "--save-problem",
        ),
        (
            &format!("{basis} --kind pca --save-problem p"),
            "--save-problem",
        ),
        (
            &format!("{basis} --kind pca --iterations 9"),
            "--iterations",
        ),
        (&format!("{basis} --kind pca --tolerance 1"), "--tolerance"),
        (&format!("{basis} --kind pca --plain"), "--plain"),
        (&format!("{basis} --tolerance nan"), "--tolerance"),
        (&format!("{basis} --tolerance=-1"), "--tolerance"),
        (
            "sample m -o f --attributes sex=1,age=3,sex=0",
            "sex is asked for twice",
        ),
        ("sample m -o f --regions nose,,mouth", "--regions"),
    ] {
        let (code, error) = called(arguments);
        assert_eq!(code, Some(2), "{arguments}: {error}");
        assert!(error.contains(said), "{arguments}: {error}");
    }
}

#[test]
fn a_folder_that_is_not_there_is_said_before_the_work() {
    for arguments in [
        "template --base-mesh b",
        "train --template t --faces f",
        "attributes --template t --faces f m",
        "basis --template t --faces f",
        "landmarks --template t --scan s",
    ] {
        let (code, error) = called(&format!("{arguments} -o no/such/file"));
        assert_eq!(code, Some(1), "{arguments}: {error}");
        assert!(
            error.starts_with("phiz-fit: no/such/file: "),
            "{arguments}: {error}"
        );
        assert_eq!(error.lines().count(), 1, "{error}");
    }
}

#[test]
fn what_is_read_is_not_written_over() {
    let register = "register --template t --scan s.ply --landmarks l";
    for (arguments, said) in [
        (format!("{register} -o s.ply"), "s.ply: is the scan"),
        (format!("{register} -o ./s.ply"), "s.ply: is the scan"),
        (
            format!("{register} --texture s.ply -o o.ply"),
            "s.ply: is the scan",
        ),
        (
            format!("{register} --picture l -o o.ply"),
            "l: is the scan's landmarks",
        ),
        (
            format!("{register} --texture t -o o.ply"),
            "t: is the template",
        ),
        (
            format!("{register} --texture p --picture p -o o.ply"),
            "p: two files",
        ),
        (
            "landmarks --template t --scan s -o s".into(),
            "s: is the scan",
        ),
        (
            "landmarks --template t --scan s -o t".into(),
            "t: is the template",
        ),
        (
            "template --base-mesh b --faces f --registered-to t -o t".into(),
            "t: is the template",
        ),
        (
            "train --template t --faces f -o t".into(),
            "t: is the template",
        ),
        (
            "basis --template t --faces f -o t".into(),
            "t: is the template",
        ),
        (
            "attributes --template t --faces f m -o t".into(),
            "t: is the template",
        ),
        (
            "expressions --template t --base-mesh b m -o m".into(),
            "m: is the model",
        ),
        ("head m -o m".into(), "m: is the model"),
        ("export m.npz -o m.npz".into(), "m.npz: is the model"),
    ] {
        let (code, error) = called(&arguments);
        assert_eq!(code, Some(1), "{arguments}: {error}");
        assert!(error.contains(said), "{arguments}: {error}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
    // Nor is a face of a folder, nor what is told of them; a model of before may lie there.
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["anna.ply", "labels.json", "ours.phiz"] {
        std::fs::write(folder.path().join(name), "").expect("writes");
    }
    let faces = folder.path().display();
    for verb in [
        "template --base-mesh b --registered-to t",
        "train --template t",
        "basis --template t",
        "attributes m --template t",
    ] {
        for (name, said) in [
            ("anna.ply", "is one of the files of the faces"),
            ("labels.json", "is one of the files of the faces"),
            ("ours.phiz", "No such file"),
        ] {
            let (code, error) = called(&format!("{verb} --faces {faces} -o {faces}/{name}"));
            assert_eq!(code, Some(1), "{verb} {name}: {error}");
            assert!(error.contains(said), "{verb} {name}: {error}");
        }
    }
    // Nor does a table become what is told of them.
    for name in ["labels.csv", "about.json"] {
        for (given, out) in [
            (faces.to_string(), format!("{faces}/{name}")),
            (
                format!("{faces}/."),
                format!("{faces}/../{}/{name}", folder_name(&folder)),
            ),
            (format!("{faces}/anna.ply"), format!("{faces}/{name}")),
        ] {
            let (code, error) = called(&format!("measure m --faces {given} -o {out}"));
            assert_eq!(code, Some(1), "{out}: {error}");
            let said = format!("phiz-fit: {out}: would be read as what is told of the faces there");
            assert!(error.starts_with(&said), "{error}");
        }
    }
    // A model with more in it may take its place.
    for arguments in [
        "attributes --template t --faces f m -o m",
        "describe m -o m",
    ] {
        let (_, error) = called(arguments);
        assert!(error.contains("No such file"), "{arguments}: {error}");
    }
}

#[test]
fn a_model_is_not_taken_for_a_template() {
    let model = concat!(env!("CARGO_MANIFEST_DIR"), "/www/public/head.phiz");
    let (code, error) = called(&format!("landmarks --template {model} --scan s"));
    assert_eq!(code, Some(1), "{error}");
    assert!(
        error.contains("head.phiz: a model, not a template"),
        "{error}"
    );
}

#[test]
fn a_model_of_one_face_tells_nothing_of_people() {
    let model = concat!(env!("CARGO_MANIFEST_DIR"), "/www/public/head.phiz");
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    for arguments in [
        format!("attributes --template t --faces f {model} -o"),
        format!("sample {model} --count 2 -o"),
    ] {
        let (code, error) = called(&format!("{arguments} {}", out.display()));
        assert_eq!(code, Some(1), "{arguments}: {error}");
        assert!(
            error.ends_with("head.phiz: a model of one face, which does not vary\n"),
            "{error}"
        );
        assert!(!out.exists());
    }
    // That one may be had as a file.
    let (code, error) = called(&format!("sample {model} --count 1 -o {}", out.display()));
    assert_eq!(code, Some(0), "{error}");
    assert!(out.join("face_0001.ply").is_file());
}

#[test]
fn a_short_report_takes_no_readme_but_its_own() {
    let folder = tempfile::tempdir().expect("a folder");
    let readme = folder.path().join("README.md");
    let short = folder.path().display();
    let validate = format!("validate --template t --faces f -o o --short {short}");
    std::fs::write(&readme, "# Ours\n").expect("writes");
    let (code, error) = called(&validate);
    assert_eq!(code, Some(1), "{error}");
    let said = format!("phiz-fit: {}: is no report of before", readme.display());
    assert!(
        error.starts_with(&said) && error.lines().count() == 1,
        "{error}"
    );
    let own = concat!(env!("CARGO_MANIFEST_DIR"), "/www/docs/validation/README.md");
    std::fs::copy(own, &readme).expect("copies");
    let (_, error) = called(&validate);
    assert!(error.starts_with("phiz-fit: t: "), "{error}");
}

#[test]
fn a_report_takes_no_page_but_its_own() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let validate = format!(
        "validate --template t --faces f -o {}",
        folder.path().display()
    );
    let refused = |name: &str| {
        let (code, error) = called(&validate);
        assert_eq!(code, Some(1), "{error}");
        let said = format!("phiz-fit: {}: is no report of before", at(name).display());
        assert!(
            error.starts_with(&said) && error.lines().count() == 1,
            "{error}"
        );
    };
    // Somebody's page, or numbers of somebody's beside none.
    std::fs::write(at("index.html"), "<!doctype html><title>Our lab</title>").expect("writes");
    refused("index.html");
    std::fs::remove_file(at("index.html")).expect("goes");
    std::fs::write(at("report.json"), "{}").expect("writes");
    refused("report.json");
    let own = "<!doctype html><meta name=\"generator\" content=\"phiz-fit validate\"><title>";
    std::fs::write(at("index.html"), own).expect("writes");
    let (_, error) = called(&validate);
    assert!(error.starts_with("phiz-fit: t: "), "{error}");
    // Among the faces, the numbers would be a face's landmarks.
    let faces = folder.path().display();
    let (code, error) = called(&format!("validate --template t --faces {faces} -o {faces}"));
    assert_eq!(code, Some(1), "{error}");
    assert!(
        error.contains("report.json: is one of the files of the faces"),
        "{error}"
    );
}

#[test]
fn one_scan_is_not_registered_to_where_nothing_can_be_written() {
    let register = "register --template t --scan s";
    for arguments in [
        "-o no/a.ply",
        "-o a.ply --texture no/a.ply",
        "-o a.ply --picture no/a.ply",
    ] {
        let (_, error) = called(&format!("{register} {arguments}"));
        assert!(
            error.starts_with("phiz-fit: no/a.ply: "),
            "{arguments}: {error}"
        );
    }
}
