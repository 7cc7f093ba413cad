//! What the program refuses before it begins: with what is wrong, and the code 2 where that is how it was
//! called.

use std::process::Command;

/// The exit code of the program, and what it says of an error.
fn called(arguments: &str) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_phiz-fit"));
    let done = command.args(arguments.split(' ')).output().expect("runs");
    let said = String::from_utf8_lossy(&done.stderr).into_owned();
    (done.status.code(), said)
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
        ("register --template t --scan s -o face.obj", "face.obj: "),
        ("sample m -o faces.stl", "faces.stl: "),
        (&format!("{train} 0"), "--tau"),
        (&format!("{train} 1.01"), "--tau"),
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
