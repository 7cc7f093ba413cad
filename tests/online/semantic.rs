//! Semantic controls of the default model: what they move, what they leave, and what holds.

use crate::common::head_model;
use nalgebra::{DMatrix, DVector};
use phiz::anatomy::Measure;
use phiz::model::{Control, LIMIT};
use phiz::{Error, Face, Randomize};

fn seeded(seed: u64) -> Randomize {
    Randomize {
        seed: Some(seed),
        ..Default::default()
    }
}

/// The population's mean.
fn mean_face() -> Face {
    let mut face = head_model().face();
    face.set_coefficients(&vec![0.0; head_model().parts().coefficients()])
        .unwrap();
    face
}

/// The semantic controls, each with its measure and the measure's standard deviation, mm.
fn semantic() -> Vec<(&'static Control, &'static Measure, f64)> {
    let parts = head_model().parts();
    let with_measure = |c: &'static Control| {
        let measure = &parts.measures[c.measure? as usize];
        // The ends of a control are 3 standard deviations from the mean.
        let ends = c.quantiles.last()? - c.quantiles.first()?;
        Some((c, measure, f64::from(ends / (2.0 * LIMIT))))
    };
    parts.controls.iter().filter_map(with_measure).collect()
}

/// Whether one measure is computed from lengths of the other: of those, one cannot move alone.
fn tied(a: &Measure, b: &Measure) -> bool {
    let (a, b) = (a.quantity.terms(), b.quantity.terms());
    a.iter().any(|term| b.contains(term))
}

/// Pairs that anatomy ties, the control first: an eye that goes up alone takes its inner corner
/// along the side of the nose, which leans.
const ANATOMY: [(&str, &str); 2] = [
    ("left eye vertical position", "inner eye distance"),
    ("right eye vertical position", "inner eye distance"),
];

#[test]
fn there_are_twenty_and_a_person_reads_what_they_measure() {
    let found = semantic();
    assert_eq!(found.len(), 20);
    for (control, measure, _) in &found {
        assert_eq!(control.name, measure.name);
        assert!(control.description.len() > 3, "{}", control.name);
    }
}

#[test]
fn each_moves_its_own_measure_and_hardly_another() {
    let face = mean_face();
    let all = semantic();
    let mut bad = Vec::new();
    for (control, measure, sigma) in &all {
        let start = face.measure(&measure.name).unwrap();
        for amount in [-2.0, 2.0] {
            let mut moved = face.clone();
            moved
                .set_measure(&measure.name, start + amount * sigma)
                .unwrap();
            let own = (moved.measure(&measure.name).unwrap() - start) / sigma;
            // Asked for are 2; 1.5 is the least.
            assert!(own * amount.signum() >= 1.5, "{}: {own}", control.name);
            for (_, other, spread) in &all {
                if other.name == measure.name || tied(measure, other) {
                    continue;
                }
                let was = face.measure(&other.name).unwrap();
                let change = (moved.measure(&other.name).unwrap() - was) / spread;
                let pair = (control.name.as_str(), other.name.as_str());
                let most = match pair {
                    pair if ANATOMY.contains(&pair) => 0.3,
                    _ => 0.15,
                };
                if change.abs() > most {
                    bad.push(format!("{pair:?} at {amount}: {change:.3}"));
                }
            }
        }
    }
    assert!(bad.is_empty(), "{bad:#?}");
}

#[test]
fn each_is_monotone_over_its_range() {
    for (control, measure, _) in semantic() {
        let mut face = mean_face();
        let lengths: Vec<f64> = (0..=20)
            .map(|step| {
                face.set(&control.name, f64::from(step) / 20.0).unwrap();
                face.measure(&measure.name).unwrap()
            })
            .collect();
        let rises = lengths.windows(2).all(|w| w[0] < w[1]);
        assert!(rises, "{}: {lengths:?}", control.name);
    }
}

/// Where its slider ends, a control has not crumpled the mean head: no line on the skin is shorter
/// than a third, where the trainer stopped at 0.4 of unrounded fields, and nothing is folded.
#[cfg(feature = "fit")]
#[test]
fn sliders_end_where_the_head_is_still_whole() {
    use glam::DVec3;
    use phiz::fit::head::folds::{Folds, Stretches};
    let triangles = head_model().parts().topology.triangles();
    let place = |face: &Face| -> Vec<DVec3> {
        let each = face.positions().iter();
        each.map(|p| p.as_dvec3()).collect()
    };
    let mean = place(&mean_face());
    let stretches = Stretches::new(&mean, &triangles, 0.025);
    let folds = Folds::new(&mean, triangles);
    let mut stopped = 0;
    for (control, ..) in semantic() {
        for end in control.limits {
            let mut face = mean_face();
            face.set(&control.name, f64::from(end)).unwrap();
            let there = place(&face);
            let least = stretches.least(&there);
            assert!(least > 0.33, "{} at {end}: {least:.2}", control.name);
            assert!(folds.of(&there).is_empty(), "{} at {end}", control.name);
            stopped += usize::from(end != 0.0 && end != 1.0);
        }
    }
    // A mouth cannot go as high as the nose lets it in other people.
    assert!(stopped > 0);
}

#[cfg(feature = "fit")]
#[test]
fn displacement_lies_in_the_part_and_its_border_band() {
    use glam::DVec3;
    use phiz::fit::learn::semantic::BAND;
    use phiz::fit::mesh::geodesic::Geodesic;
    use phiz::fit::sparse::head_parts;
    let Some(template) = crate::heads::template() else {
        return;
    };
    let face = mean_face();
    let mean: Vec<DVec3> = face.positions().iter().map(|p| p.as_dvec3()).collect();
    let surface = Geodesic::new(&mean, &template.triangles());
    let parts = head_parts(template).unwrap();
    for (control, measure, sigma) in semantic() {
        let part = parts.iter().find(|p| p.name == control.group).unwrap();
        let distance = surface.distances(&part.vertices, BAND);
        let mut moved = face.clone();
        let start = face.measure(&measure.name).unwrap();
        moved
            .set_measure(&measure.name, start + 2.0 * sigma)
            .unwrap();
        let (mut inside, mut own_side, mut total) = (0.0, 0.0, 0.0);
        for (v, (p, q)) in face.positions().iter().zip(moved.positions()).enumerate() {
            let energy = f64::from(p.distance_squared(*q));
            total += energy;
            inside += if distance[v].is_finite() { energy } else { 0.0 };
            let left = p.x > 0.0;
            let wanted = match &control.name {
                name if name.starts_with("left") => left,
                name if name.starts_with("right") => !left,
                _ => true,
            };
            own_side += if wanted { energy } else { 0.0 };
        }
        let name = &control.name;
        assert!(inside >= 0.95 * total, "{name}: {:.3}", inside / total);
        assert!(own_side >= 0.95 * total, "{name}: {:.3}", own_side / total);
    }
}

#[test]
fn the_right_eye_is_the_mirror_image_of_the_left() {
    let mirror = &head_model().parts().topology.mirror;
    let face = mean_face();
    for what in ["eye vertical position", "eye length"] {
        let moved = |side: &str| {
            let name = format!("{side} {what}");
            let mut moved = face.clone();
            let block = semantic().into_iter().find(|s| s.0.name == name).unwrap();
            let mut c = moved.coefficients();
            c[block.0.direction[0].0 as usize] = 2.0;
            moved.set_coefficients(&c).unwrap();
            let each = moved.positions().iter().zip(face.positions());
            each.map(|(p, q)| *p - *q).collect::<Vec<_>>()
        };
        let (left, right) = (moved("left"), moved("right"));
        for (v, &image) in mirror.iter().enumerate() {
            let turned = right[image as usize] * glam::Vec3::new(-1.0, 1.0, 1.0);
            // Twice half a step of 0.02 mm in each coordinate, on each side.
            assert!(left[v].distance(turned) < 0.08, "{what}, vertex {v}");
        }
    }
}

#[test]
fn a_set_measure_is_met() {
    for seed in 1..=3 {
        let mut face = head_model().face();
        face.randomize(&seeded(seed)).unwrap();
        for measure in &head_model().parts().measures {
            let now = face.measure(&measure.name).unwrap();
            for mm in [now + 2.0, now - 1.5] {
                face.set_measure(&measure.name, mm).unwrap();
                let met = face.measure(&measure.name).unwrap();
                assert!((met - mm).abs() <= 0.01, "{}: {met}, {mm}", measure.name);
            }
        }
        // No nose is so wide, and none less than nothing.
        let before = face.coefficients();
        for mm in [1e6, -5.0, f64::NAN] {
            let refused = face.set_measure("nose width", mm);
            assert!(matches!(refused, Err(Error::Mismatch(_))), "{mm}");
            assert_eq!(face.coefficients(), before);
        }
    }
}

#[test]
fn clearing_a_control_undoes_it_and_no_other() {
    let mut face = head_model().face();
    face.randomize(&seeded(1)).unwrap();
    let all = semantic();
    let names: Vec<&str> = all.iter().map(|s| s.0.name.as_str()).collect();
    for (i, name) in names.iter().enumerate() {
        face.set(name, [0.2, 0.7][i % 2]).unwrap();
    }
    for (control, ..) in &all {
        let before = face.coefficients();
        face.clear(&control.name).unwrap();
        for (i, (was, is)) in before.iter().zip(face.coefficients()).enumerate() {
            let own = control.direction.iter().any(|t| t.0 as usize == i);
            assert_eq!(is, if own { 0.0 } else { *was }, "{}", control.name);
        }
    }
    let mut plain = head_model().face();
    plain.randomize(&seeded(1)).unwrap();
    assert_eq!(face.positions(), plain.positions());
}

#[test]
fn held_measures_are_held_whatever_changes_the_face() {
    let locked = ["nose width", "face height", "left eye length"];
    let mut face = head_model().face();
    face.randomize(&seeded(1)).unwrap();
    face.set_measure("nose width", 38.0).unwrap();
    for name in locked {
        face.lock_measure(name).unwrap();
    }
    let held = locked.map(|name| face.measure(name).unwrap());
    let check = |face: &Face, what: &str| {
        for (name, mm) in locked.iter().zip(held) {
            let now = face.measure(name).unwrap();
            assert!(
                (now - mm).abs() <= 1e-4,
                "{what}: {name} is {now}, not {mm}"
            );
        }
    };
    for seed in 2..12 {
        face.randomize(&seeded(seed)).unwrap();
        check(&face, "a random face");
    }
    for control in [
        "nose 1",
        "head 1",
        "mouth width",
        "eyes size",
        "nose length",
    ] {
        face.set(control, 0.95).unwrap();
        check(&face, control);
    }
    let tip = face.positions().len() as u32 / 2;
    let target = face.positions()[tip as usize] + glam::Vec3::new(1.0, 2.0, -1.0);
    face.drag(tip, target).unwrap();
    check(&face, "a drag");
    let mut other = head_model().face();
    other.randomize(&seeded(77)).unwrap();
    face.blend(&other, 0.5, None).unwrap();
    check(&face, "a blend");
    face.clear("mouth width").unwrap();
    check(&face, "clearing");
    let mut beyond = face.coefficients();
    beyond[0] += 4.0;
    face.set_coefficients(&beyond).unwrap();
    check(&face, "coefficients");
    face.reset(None).unwrap();
    check(&face, "a reset");
    // Setting it moves it all the same, and holds it there.
    face.set_measure("nose width", 36.0).unwrap();
    face.randomize(&seeded(3)).unwrap();
    assert!((face.measure("nose width").unwrap() - 36.0).abs() <= 0.0101);
    // Another face by its code is held as it is.
    face.set_code(&other.code()).unwrap();
    assert_eq!(face.positions(), other.positions());
    let wide = face.measure("nose width").unwrap();
    face.set("nose 1", 0.7).unwrap();
    assert!((face.measure("nose width").unwrap() - wide).abs() <= 1e-4);
    face.unlock_measure("nose width").unwrap();
    assert_eq!(face.locked_measures().count(), 2);
}

/// Faces drawn around a locked region and held measures are as probable as any.
#[test]
fn faces_around_what_is_locked_are_of_the_population() {
    let parts = head_model().parts();
    let count = parts.population();
    let correlation = parts.correlation.iter().map(|&r| f64::from(r));
    let factor = DMatrix::from_row_iterator(count, count, correlation)
        .cholesky()
        .unwrap();
    let square = |face: &Face| {
        let c = face.coefficients();
        let c = DVector::from_iterator(count, c[..count].iter().map(|&c| f64::from(c)));
        c.dot(&factor.solve(&c))
    };
    // Chi-squared with so many degrees of freedom, normal after Fisher: 4 standard deviations, for
    // 40 draws.
    let most = 0.5 * ((2.0 * count as f64 - 1.0).sqrt() + 4.0).powi(2);
    for seed in 0..40 {
        let mut face = head_model().face();
        face.randomize(&seeded(1000 + seed)).unwrap();
        face.lock("nose").unwrap();
        face.lock_measure("mouth width").unwrap();
        face.lock_measure("face height").unwrap();
        face.randomize(&seeded(seed)).unwrap();
        assert!(square(&face) < most, "{} > {most}", square(&face));
    }
}

#[test]
fn a_measure_without_a_control_is_met_beside_what_is_held() {
    for (set, by) in [("jaw width", 8.0), ("face height", -6.0)] {
        let mut face = head_model().face();
        face.randomize(&seeded(3)).unwrap();
        let held = ["face width", "tragion width", "mouth width"].map(|name| {
            face.lock_measure(name).unwrap();
            (name, face.measure(name).unwrap())
        });
        let wanted = face.measure(set).unwrap() + by;
        face.set_measure(set, wanted).unwrap();
        // What the documents promise of both.
        let off = face.measure(set).unwrap() - wanted;
        assert!(off.abs() < 0.01, "{set} is {off} mm off");
        for (name, before) in held {
            let off = face.measure(name).unwrap() - before;
            assert!(off.abs() < 1e-4, "{name} moved by {off} mm");
        }
    }
}

/// Whatever is set beside whatever is held: both have their length, or the face stays as it was.
#[test]
fn any_measure_is_met_beside_any_that_is_held() {
    let measures = &head_model().parts().measures;
    let mut start = head_model().face();
    start.randomize(&seeded(3)).unwrap();
    let mut refused = Vec::new();
    for held in measures {
        let mut holding = start.clone();
        holding.lock_measure(&held.name).unwrap();
        let length = start.measure(&held.name).unwrap();
        for set in measures.iter().filter(|m| m.name != held.name) {
            let mut face = holding.clone();
            let wanted = start.measure(&set.name).unwrap() + 1.5;
            if face.set_measure(&set.name, wanted).is_err() {
                refused.push(format!("{} beside {}", set.name, held.name));
                assert_eq!(face.code(), holding.code());
                continue;
            }
            let what = format!("{} beside {}", set.name, held.name);
            let off = face.measure(&set.name).unwrap() - wanted;
            assert!(off.abs() <= 0.01, "{what} is {off} mm off");
            let off = face.measure(&held.name).unwrap() - length;
            assert!(off.abs() <= 1e-4, "{what} moves that by {off} mm");
        }
    }
    assert!(refused.is_empty(), "{refused:?}");
}

/// Semantic reshaping, Fig. 9: a liar's nose grows far beyond all limits.
#[test]
fn pinocchio_has_a_nose_and_otherwise_his_own_face() {
    let face = mean_face();
    let mut liar = face.clone();
    let length = face.measure("nose length").unwrap();
    liar.set_measure("nose length", length + 40.0).unwrap();
    let parts = head_model().parts();
    let nose = parts
        .blocks
        .iter()
        .find(|b| b.name == "local nose")
        .unwrap();
    for (v, (p, q)) in face.positions().iter().zip(liar.positions()).enumerate() {
        assert!(p == q || nose.support.binary_search(&(v as u32)).is_ok());
    }
    let tip = parts
        .landmarks
        .iter()
        .find(|l| l.name == "ibug_30")
        .unwrap();
    let moved = (tip.position(liar.positions()) - tip.position(face.positions())).length();
    let farthest = |name: &str| {
        let block = parts.blocks.iter().find(|b| b.name == name).unwrap();
        let each = block.support.iter().map(|&v| v as usize);
        each.map(|v| liar.positions()[v].distance(face.positions()[v]))
            .fold(0.0, f32::max)
    };
    println!(
        "the tip moves {moved:.1} mm; eyes at most {:.1}, mouth {:.1}, forehead {:.1}",
        farthest("eyes"),
        farthest("mouth"),
        farthest("forehead")
    );
    // The tip goes most of the way; the base that it is measured from sinks by the rest.
    assert!(moved > 20.0);
    // Smooth: how far vertices go from where their neighbours would take them, mm RMS over those that
    // move. A cone has some, on triangles of uneven size; with the ridges of all other controls it
    // would be 0.37.
    let moves: Vec<_> = (face.positions().iter().zip(liar.positions()))
        .map(|(p, q)| *q - *p)
        .collect();
    let mut around = vec![Vec::new(); moves.len()];
    for &[a, b, c] in &parts.topology.triangles() {
        for (v, others) in [(a, [b, c]), (b, [c, a]), (c, [a, b])] {
            around[v as usize].extend(others.map(|o| moves[o as usize]));
        }
    }
    let squares = (moves.iter().zip(&around))
        .filter(|(d, _)| **d != glam::Vec3::ZERO)
        .map(|(d, around)| {
            let sum: glam::Vec3 = around.iter().copied().sum();
            f64::from((*d - sum / around.len() as f32).length_squared())
        });
    let (count, sum) = squares.fold((0, 0.0), |(n, sum), s| (n + 1, sum + s));
    let rough = (sum / f64::from(count)).sqrt();
    println!("vertices leave their neighbours' mean by {rough:.3} mm RMS");
    assert!(rough < 0.3);
}
