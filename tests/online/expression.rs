//! Expressions on faces of the default model.

use std::sync::LazyLock;

use glam::Vec3;
use phiz::expression::{Expression, STEP, write};
use phiz::{Error, Expressions, Face, Performance};

use crate::common::{self, person};

static EXPRESSIONS: LazyLock<Expressions> = LazyLock::new(|| {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/www/public/expressions.phiz");
    Expressions::parse(&std::fs::read(path).unwrap(), common::head_model()).unwrap()
});

fn performed(face: &Face, shown: &[(&str, f64)]) -> Vec<Vec3> {
    let mut performance = Performance::new(&EXPRESSIONS);
    for &(name, weight) in shown {
        performance.set(name, weight).unwrap();
    }
    performance.perform(face).unwrap();
    performance.positions().to_vec()
}

fn at(positions: &[Vec3], landmark: &str) -> Vec3 {
    let landmarks = &common::head_model().parts().landmarks;
    let found = landmarks.iter().find(|l| l.name == landmark).unwrap();
    found.position(positions)
}

/// The upper and the lower lid of both eyes, where they are farthest apart.
const LIDS: [[&str; 2]; 4] = [
    ["ibug_37", "ibug_41"],
    ["ibug_38", "ibug_40"],
    ["ibug_43", "ibug_47"],
    ["ibug_44", "ibug_46"],
];

fn opening(positions: &[Vec3]) -> f32 {
    let open = LIDS.map(|[up, low]| at(positions, up).y - at(positions, low).y);
    open.iter().sum::<f32>() / 4.0
}

#[test]
fn a_face_at_rest_is_the_face() {
    let face = person(4);
    let mut performance = Performance::new(&EXPRESSIONS);
    performance.perform(&face).unwrap();
    assert!(performance.is_at_rest());
    assert_eq!(performance.positions(), face.positions());
    assert_eq!(performance.normals(), face.normals());
    performance.set("jawOpen", 1.0).unwrap();
    performance.perform(&face).unwrap();
    assert_ne!(performance.positions(), face.positions());
    performance.rest();
    performance.perform(&face).unwrap();
    assert_eq!(performance.positions(), face.positions());
}

/// Whoever shows an expression does without the normals of the face at rest, and gets them back.
#[test]
fn normals_of_the_face_at_rest_are_kept_or_not() {
    let (mut with, mut without) = (person(5), person(5));
    without.keep_normals(false);
    let mut shown = [&with, &without].map(|_| Performance::new(&EXPRESSIONS));
    for (slider, weight) in [("nose 1", 0.4), ("head 1", 0.7), ("chin 2", 0.0)] {
        for (face, performance) in [&mut with, &mut without].into_iter().zip(&mut shown) {
            face.set(slider, 0.9).unwrap();
            performance.set("jawOpen", weight).unwrap();
            performance.perform(face).unwrap();
        }
        assert!(without.normals().is_empty());
        assert_eq!(with.positions(), without.positions());
        assert_eq!(shown[0].positions(), shown[1].positions());
        // At rest there are as many as the face keeps.
        if weight > 0.0 {
            assert_eq!(shown[0].normals(), shown[1].normals());
        }
    }
    without.keep_normals(true);
    assert_eq!(with.normals(), without.normals());
    // The same face at rest, which keeps others than when it was last performed.
    let mut rest = Performance::new(&EXPRESSIONS);
    for kept in [false, true, false, true] {
        without.keep_normals(kept);
        rest.perform(&without).unwrap();
        assert_eq!(rest.normals(), without.normals());
        assert_eq!(rest.normals().is_empty(), !kept);
    }
    without.set("eyes 1", 0.2).unwrap();
    with.set("eyes 1", 0.2).unwrap();
    assert_eq!(with.normals(), without.normals());
}

/// Parts that are computed again must be what the whole would be, and whoever copies only what changed
/// must not miss anything.
#[test]
fn what_changed_is_in_the_range_and_a_part_is_as_the_whole() {
    let mut face = person(4);
    let n = face.positions().len();
    let mut performance = Performance::new(&EXPRESSIONS);
    let mut copy = (vec![Vec3::ZERO; n], vec![Vec3::ZERO; n]);
    let mut widths = Vec::new();
    for step in 0..12_u32 {
        let weight = 0.2 + 0.05 * f64::from(step);
        match step {
            0..4 => performance.set("mouthSmileLeft", weight).unwrap(),
            4..6 => face.set("chin 1", weight).unwrap(),
            6..8 => performance.set("eyeLookUpLeft", weight).unwrap(),
            8 => performance.rest(),
            9 => face.set("nose 1", weight).unwrap(),
            10 => performance.set("jawOpen", weight).unwrap(),
            _ => {}
        }
        performance.perform(&face).unwrap();
        let range = performance.changed();
        widths.push(range.len());
        let range = range.start as usize..range.end as usize;
        copy.0[range.clone()].copy_from_slice(&performance.positions()[range.clone()]);
        copy.1[range.clone()].copy_from_slice(&performance.normals()[range]);
        let mut whole = Performance::new(&EXPRESSIONS);
        for (expression, &weight) in EXPRESSIONS.list().iter().zip(performance.weights()) {
            whole.set(&expression.name, weight.into()).unwrap();
        }
        whole.perform(&face).unwrap();
        assert_eq!(copy.0, whole.positions(), "step {step}");
        assert_eq!(copy.1, whole.normals(), "step {step}");
    }
    assert_eq!(widths[0], n, "all of what is seen first");
    assert!((1..n).contains(&widths[1]), "{widths:?}");
    assert_eq!(widths[11], widths[10], "nothing was done: what it was");
}

/// On the mean head an expression is what its file says; lids are moved out of eyeballs, so only
/// what is below the nose is compared.
#[test]
fn on_the_mean_head_expressions_are_what_the_file_says() {
    let model = common::head_model();
    let mut face = model.face();
    let zero = vec![0.0; model.parts().coefficients()];
    face.set_coefficients(&zero).unwrap();
    let mean = &model.parts().mean;
    let mut compared = 0;
    for expression in EXPRESSIONS.list() {
        if !(expression.name.starts_with("mouth") || expression.name.starts_with("jaw")) {
            continue;
        }
        let moved = performed(&face, &[(&expression.name, 1.0)]);
        let mut wanted = mean.clone();
        for (&v, &d) in expression.support.iter().zip(&expression.displacements) {
            wanted[v as usize] += d;
        }
        // Maps are the identity but for f32 sums of 50 products of 100 mm.
        let below = at(mean, "ibug_33").y;
        let off = (moved.iter().zip(&wanted))
            .filter(|(_, wanted)| wanted.y < below)
            .map(|(a, b)| a.distance(*b));
        let worst = off.fold(0.0, f32::max);
        assert!(worst < 1e-3, "{}: {worst} mm", expression.name);
        compared += 1;
    }
    assert!(compared > 25);
}

#[test]
fn left_and_right_are_mirror_images() {
    let mirror = &common::head_model().parts().topology.mirror;
    for (i, left) in EXPRESSIONS.list().iter().enumerate() {
        let right = match left.name.strip_suffix("Left") {
            Some(stem) => {
                let right = &EXPRESSIONS.list()[i + 1];
                assert_eq!(right.name, format!("{stem}Right"));
                right
            }
            None if left.name.ends_with("Right") => continue,
            None => left,
        };
        for (&v, &d) in left.support.iter().zip(&left.displacements) {
            let there = right.support.binary_search(&mirror[v as usize]).unwrap();
            let image = right.displacements[there];
            assert_eq!(d, Vec3::new(-image.x, image.y, image.z), "{}", left.name);
        }
    }
}

#[test]
fn eyes_close_on_everyone_and_never_through_the_eyeball() {
    let model = common::head_model();
    let topology = &model.parts().topology;
    let balls = ["left eyeball", "right eyeball"].map(|part| topology.part_vertices(part));
    let skin = topology.part_vertices("skin");
    let (mut worst, mut most) = (f32::NEG_INFINITY, f32::INFINITY);
    let mut inside = 0.0_f32;
    for seed in 0..40 {
        let face = person(seed);
        let open = opening(face.positions());
        let shut = performed(&face, &[("eyeBlinkLeft", 1.0), ("eyeBlinkRight", 1.0)]);
        worst = worst.max(opening(&shut));
        most = most.min(opening(&shut));
        let half = performed(&face, &[("eyeBlinkLeft", 0.5), ("eyeBlinkRight", 0.5)]);
        let part = opening(&half) / open;
        println!(
            "{seed}: half {part:.2} of {open:.2} mm, shut {:.2}",
            opening(&shut)
        );
        for ball in &balls {
            let (centre, radius) = middle_of(&shut, ball);
            for &v in &skin {
                let (then, now) = (face.positions()[v as usize], shut[v as usize]);
                let (then, now) = (then.distance(centre), now.distance(centre));
                if now < radius && now < then {
                    inside = inside.max(then.min(radius) - now);
                }
            }
        }
    }
    println!("shut lids are {most} to {worst} mm apart, {inside} mm inside of eyeballs");
    // No slit is left. Lids that are moved out of the eyeball end lower on it, so the upper one may
    // overlap.
    assert!(worst < 0.1 && most > -1.5, "{most} to {worst} mm");
    assert!(inside < 0.05, "{inside} mm");
}

/// The middle and the radius of a part of a sphere, by moving towards points that are too far away.
fn middle_of(positions: &[Vec3], ball: &[u32]) -> (Vec3, f32) {
    let points = || ball.iter().map(|&v| positions[v as usize]);
    let count = ball.len() as f32;
    let mut centre = points().sum::<Vec3>() / count;
    let mut radius = 0.0;
    for _ in 0..300 {
        radius = points().map(|p| p.distance(centre)).sum::<f32>() / count;
        let pull = points().map(|p| (p - centre) * (1.0 - radius / p.distance(centre)));
        centre += pull.sum::<Vec3>() / count;
    }
    (centre, radius)
}

#[test]
fn a_glance_turns_the_ball_about_its_middle() {
    let model = common::head_model();
    let face = person(2);
    let ball = model.parts().topology.part_vertices("left eyeball");
    let pupil = *ball
        .iter()
        .max_by(|a, b| {
            let z = |v: u32| face.positions()[v as usize].z;
            z(**a).total_cmp(&z(**b))
        })
        .unwrap() as usize;
    for (name, axis, sign) in [
        ("eyeLookUpLeft", 1, 1.0),
        ("eyeLookDownLeft", 1, -1.0),
        // Out is away from the nose: to the subject's left.
        ("eyeLookOutLeft", 0, 1.0),
        ("eyeLookInLeft", 0, -1.0),
    ] {
        let moved = performed(&face, &[(name, 1.0)]);
        let there = (moved[pupil] - face.positions()[pupil])[axis] * sign;
        assert!(there > 2.0, "{name}: {there} mm");
        // It keeps its shape, at any weight.
        for weight in [0.3, 1.0] {
            let moved = performed(&face, &[(name, weight)]);
            for pair in ball.windows(2) {
                let [a, b] = [pair[0] as usize, pair[1] as usize];
                let before = face.positions()[a].distance(face.positions()[b]);
                assert!((moved[a].distance(moved[b]) - before).abs() < 1e-4);
            }
        }
    }
}

#[test]
fn broad_mouths_smile_broadly() {
    let smile = [("mouthSmileLeft", 1.0), ("mouthSmileRight", 1.0)];
    let width = |p: &[Vec3]| f64::from(at(p, "ibug_48").distance(at(p, "ibug_54")));
    let pairs: Vec<[f64; 2]> = (0..60)
        .map(|seed| {
            let face = person(seed);
            let rest = width(face.positions());
            [rest, width(&performed(&face, &smile)) - rest]
        })
        .collect();
    let mean = |i: usize| pairs.iter().map(|p| p[i]).sum::<f64>() / pairs.len() as f64;
    let means = [mean(0), mean(1)];
    let product = |i: usize, j: usize| -> f64 {
        let each = pairs.iter();
        each.map(|p| (p[i] - means[i]) * (p[j] - means[j])).sum()
    };
    let correlation = product(0, 1) / (product(0, 0) * product(1, 1)).sqrt();
    println!("{means:.1?} mm, correlation {correlation:.2}");
    assert!(correlation > 0.3);
}

/// From the side a smile does not stand off its teeth: lips grow thinner, and where they meet stays before them.
#[test]
fn lips_that_smile_lie_closer_to_the_teeth() {
    for seed in 0..20 {
        let face = person(seed);
        let rest = face.positions().to_vec();
        let smile = performed(&face, &[("mouthSmileLeft", 1.0), ("mouthSmileRight", 1.0)]);
        // The upper lip's edges, outer and inner.
        let back = ["ibug_51", "ibug_62"].map(|name| at(&rest, name).z - at(&smile, name).z);
        assert!(back[0] > 1.0, "seed {seed}: {back:?} mm");
        assert!(back[1] < 2.6, "seed {seed}: {back:?} mm, into the teeth");
        let thick = |p: &[Vec3]| at(p, "ibug_51").z - at(p, "ibug_62").z;
        assert!(thick(&smile) < thick(&rest) - 0.8, "seed {seed}");
    }
}

#[test]
fn weights_are_refused_by_name_and_range() {
    let mut performance = Performance::new(&EXPRESSIONS);
    assert!(matches!(
        performance.set("earWiggle", 0.5),
        Err(Error::Unknown { .. })
    ));
    for weight in [-0.1, 1.1, f64::NAN] {
        assert!(matches!(
            performance.set("jawOpen", weight),
            Err(Error::Value { .. })
        ));
    }
    assert!(performance.is_at_rest());
}

#[test]
fn what_is_written_is_read_again() {
    let model = common::head_model();
    let bytes = write(model, EXPRESSIONS.list()).unwrap();
    let again = Expressions::parse(&bytes, model).unwrap();
    assert_eq!(EXPRESSIONS.list(), again.list());
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/www/public/expressions.phiz");
    let file = std::fs::read(path).unwrap();
    assert!(file.len() < 200_000, "{} bytes", file.len());

    // Rounded to the stated step.
    let one = Expression {
        name: "twitch".into(),
        support: vec![5, 9],
        displacements: vec![Vec3::new(0.123, -4.567, 0.0), Vec3::ZERO],
        turns: [Vec3::ZERO; 2],
        meets: Vec::new(),
    };
    let bytes = write(model, std::slice::from_ref(&one)).unwrap();
    let read = Expressions::parse(&bytes, model).unwrap();
    let read = &read.list()[0];
    let mirror = &model.parts().topology.mirror;
    for (v, d) in read.support.iter().zip(&read.displacements) {
        let kept = *v <= mirror[*v as usize];
        let from = if kept { *v } else { mirror[*v as usize] };
        let i = one.support.iter().position(|s| *s == from).unwrap();
        let sign = if kept { 1.0 } else { -1.0 };
        let wanted = one.displacements[i] * Vec3::new(sign, 1.0, 1.0);
        assert!((*d - wanted).abs().max_element() <= 0.5 * STEP + 1e-6);
    }
}

/// What nobody could read is not written.
#[test]
fn expressions_that_no_reader_takes_are_not_written() {
    let model = common::head_model();
    let one = |name: &str| Expression {
        name: name.into(),
        support: vec![5, 9],
        displacements: vec![Vec3::X, Vec3::Y],
        turns: [Vec3::ZERO; 2],
        meets: Vec::new(),
    };
    let changed = |change: &dyn Fn(&mut Expression)| {
        let mut expression = one("twitch");
        change(&mut expression);
        vec![expression]
    };
    for (what, wrong) in [
        ("a name twice", vec![one("twitch"), one("twitch")]),
        ("vertices out of order", changed(&|e| e.support.swap(0, 1))),
        ("a vertex twice", changed(&|e| e.support[1] = 5)),
        (
            "a vertex that is not there",
            changed(&|e| e.support[1] = 1 << 30),
        ),
        (
            "too few displacements",
            changed(&|e| e.displacements.truncate(1)),
        ),
        (
            "a vertex far away",
            changed(&|e| e.displacements[0].x = 2e3),
        ),
        ("a turn of a whole", changed(&|e| e.turns[0].x = 6.3)),
        (
            "landmarks that are not there",
            changed(&|e| e.meets = vec![[0, 9999]]),
        ),
    ] {
        assert!(
            matches!(write(model, &wrong), Err(Error::Blob(_))),
            "{what}"
        );
    }
    // Two sections each, so many a reader takes.
    let many = |count: usize| -> Vec<Expression> {
        (0..count).map(|i| one(&format!("twitch {i}"))).collect()
    };
    let bytes = write(model, &many(512)).unwrap();
    assert_eq!(Expressions::parse(&bytes, model).unwrap().list().len(), 512);
    assert!(write(model, &many(513)).is_err());
}

/// What expressions name by number is of the model that they were read for.
#[test]
fn expressions_go_on_a_face_of_a_model_without_landmarks() {
    let parts = common::sheet();
    let bare = phiz::model::ModelParts {
        landmarks: Vec::new(),
        measures: Vec::new(),
        ..parts.clone()
    };
    let [model, bare] = [parts, bare].map(|p| phiz::FaceModel::parse(&p.write().unwrap()).unwrap());
    let shut = Expression {
        name: "shut".into(),
        support: vec![19, 20],
        displacements: vec![Vec3::NEG_Y; 2],
        turns: [Vec3::ZERO; 2],
        meets: vec![[0, 1]],
    };
    let bytes = write(&model, &[shut]).unwrap();
    let mut performance = Performance::new(&Expressions::parse(&bytes, &model).unwrap());
    performance.set("shut", 1.0).unwrap();
    let [with, without] = [&model, &bare].map(|model| {
        performance.perform(&model.face()).unwrap();
        performance.positions().to_vec()
    });
    assert_ne!(with, model.face().positions());
    assert_eq!(without, with);
}

#[test]
fn a_damaged_file_is_an_error() {
    let model = common::head_model();
    let bytes = write(model, EXPRESSIONS.list()).unwrap();
    for at in (0..bytes.len()).step_by(bytes.len() / 300) {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0x41;
        assert!(Expressions::parse(&damaged, model).is_err(), "byte {at}");
        // With a checksum that fits, what is left must still be checked: no panic.
        phiz::blob::seal(&mut damaged);
        if let Ok(read) = Expressions::parse(&damaged, model) {
            let mut performance = Performance::new(&read);
            let first = read.list()[0].name.clone();
            performance.set(&first, 1.0).unwrap();
            performance.perform(&model.face()).unwrap();
        }
    }
    for end in [0, 1, 39, 100, bytes.len() / 2, bytes.len() - 1] {
        assert!(Expressions::parse(&bytes[..end], model).is_err());
    }
    let model_file = concat!(env!("CARGO_MANIFEST_DIR"), "/www/public/model.phiz");
    let wrong = Expressions::parse(&std::fs::read(model_file).unwrap(), model);
    assert!(wrong.unwrap_err().to_string().contains("expressions"));
    let other = concat!(env!("CARGO_MANIFEST_DIR"), "/www/public/synthetic.phiz");
    let other = phiz::FaceModel::parse(&std::fs::read(other).unwrap()).unwrap();
    assert!(matches!(
        Expressions::parse(&bytes, &other),
        Err(Error::Mismatch(_))
    ));
}
