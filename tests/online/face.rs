//! What must hold of every face, on the committed head and on a sheet that shows its numbers.

use std::sync::LazyLock;

use crate::common::{
    COEFFICIENTS, MODEL, edited_sheet, exercise, head_model, labelled_sheet, sheet_model,
};
use glam::{DVec3, Vec3};
use phiz::blob::{pack, seal};
use phiz::model::Block;
use phiz::{Error, Face, FaceModel, Random, Randomize};
use proptest::prelude::*;

static SHEET: LazyLock<FaceModel> = LazyLock::new(sheet_model);

/// The models that a property is checked on.
fn models() -> [&'static FaceModel; 2] {
    [head_model(), &SHEET]
}

fn random(model: &FaceModel, seed: u64) -> Face {
    let mut face = model.face();
    face.randomize(&seeded(seed)).expect("a seed is enough");
    face
}

fn seeded(seed: u64) -> Randomize {
    Randomize {
        seed: Some(seed),
        ..Default::default()
    }
}

fn region(model: &FaceModel, index: usize) -> String {
    model.parts().blocks[index].name.clone()
}

/// Area-weighted normals in f64, straight from their definition.
fn plain_normals(model: &FaceModel, positions: &[Vec3]) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; positions.len()];
    for t in model.parts().topology.triangles() {
        let [a, b, c] = t.map(|v| positions[v as usize].as_dvec3());
        let normal = (b - a).cross(c - a);
        t.iter().for_each(|&v| normals[v as usize] += normal);
    }
    normals.into_iter().map(DVec3::normalize_or_zero).collect()
}

/// The positions of some vertices in f64, straight from the definition of blocks and surrounds.
fn plain_positions(face: &Face, vertices: impl Iterator<Item = u32>) -> Vec<DVec3> {
    let parts = face.model().parts();
    let coefficients = face.coefficients();
    let moved = |block: &Block, place: usize| -> DVec3 {
        let each = (0..block.sigmas.len()).map(|k| {
            let q = [0, 1, 2].map(|axis| block.modes.get(k, 3 * place + axis));
            let c = f64::from(coefficients[block.first_coefficient + k]);
            DVec3::from(q.map(f64::from)) * (c * f64::from(block.modes.step()))
        });
        each.sum()
    };
    let by = |block: &Block, vertex: u32| {
        if let Ok(place) = block.support.binary_search(&vertex) {
            return moved(block, place);
        }
        let Some(surround) = &block.surround else {
            return DVec3::ZERO;
        };
        let Ok(t) = surround.targets.binary_search(&vertex) else {
            return DVec3::ZERO;
        };
        let fade = phiz::model::falloff(surround.distances[t] / face.alpha());
        let pulled: DVec3 = (surround.rows(&[t])[0].iter())
            .map(|&(place, weight)| moved(block, place as usize) * (f64::from(weight) / 65535.0))
            .sum();
        pulled * f64::from(fade)
    };
    vertices
        .map(|v| {
            let all: DVec3 = parts.blocks.iter().map(|block| by(block, v)).sum();
            parts.mean[v as usize].as_dvec3() + all
        })
        .collect()
}

/// The largest distance between two faces' vertices, mm.
fn farthest(a: &[Vec3], b: &[Vec3]) -> f32 {
    a.iter()
        .zip(b)
        .map(|(a, b)| a.distance(*b))
        .fold(0.0, f32::max)
}

#[test]
fn positions_of_a_thousand_faces_are_those_of_the_definition() {
    for model in models() {
        let mut face = model.face();
        let (mut squares, mut count, mut farthest) = (0.0, 0, 0.0_f64);
        for seed in 0..1000 {
            face.randomize(&seeded(seed)).unwrap();
            if seed % 100 == 99 {
                face.set_alpha(3.0 + seed as f32 / 100.0).unwrap();
            }
            // Other vertices each time.
            let some = || (seed as u32 % 97..face.positions().len() as u32).step_by(97);
            for (plain, v) in plain_positions(&face, some()).iter().zip(some()) {
                let off = plain.distance_squared(face.positions()[v as usize].as_dvec3());
                squares += off;
                count += 1;
                farthest = farthest.max(off.sqrt());
            }
        }
        let rms = (squares / f64::from(count)).sqrt();
        // 2 micrometres is what lib.rs promises. What moves a vertex that follows is rounded, mode
        // by mode, to a sixteenth of the block's step, the head's coordinates to 8 nanometres.
        println!("{count} vertices: {rms:.6} mm RMS, {farthest:.6} at most");
        assert!(rms < 0.002, "{rms} mm");
    }
}

#[test]
fn normals_are_those_of_a_plain_computation() {
    for model in models() {
        for seed in 0..5 {
            let face = random(model, seed);
            for (v, (plain, fast)) in plain_normals(model, face.positions())
                .iter()
                .zip(face.normals())
                .enumerate()
            {
                // Edges are differences of coordinates near 100 mm with a last bit of 8 nm: on the
                // shortest edges, 0.1 mm, that turns a normal by 1e-4; ten times that is allowed
                // for vertices amid slivers. A degree is 0.017.
                let off = plain.distance(fast.as_dvec3());
                assert!(off < 1e-3, "vertex {v} is off by {off}");
            }
        }
    }
}

#[test]
fn a_fresh_face_is_the_median_person() {
    for model in models() {
        let face = model.face();
        for control in &model.parts().controls {
            let value = face.get(&control.name).unwrap();
            if control.measure.is_some() {
                // The median person need not have the median of every measure.
                assert!((value - 0.5).abs() < 0.1, "{} is at {value}", control.name);
                continue;
            }
            // A coefficient is off its wish by half a step of the grid, 1/131072 sigma, and the
            // steepest table passes under 4 percentiles a hundredth of a sigma.
            assert!((value - 0.5).abs() < 1e-4, "{} is at {value}", control.name);
        }
    }
}

#[test]
fn a_control_reads_what_it_was_set_to() {
    for model in models() {
        let mut face = random(model, 1);
        for control in &model.parts().controls {
            // Of nobody who has three standard deviations of everything.
            let before = face.get(&control.name).unwrap();
            for value in [0.0, 0.01, 0.25, 0.5, 0.9, 1.0, before] {
                face.set(&control.name, value).unwrap();
                let got = face.get(&control.name).unwrap();
                // As above; reading back divides by the table's local width.
                assert!(
                    (got - value).abs() < 2e-4,
                    "{}: {value} reads {got}",
                    control.name
                );
            }
        }
    }
}

#[test]
fn a_reset_is_a_fresh_face_and_a_locked_region_is_kept() {
    for model in models() {
        let mut face = random(model, 2);
        let before = face.coefficients();
        face.lock(&region(model, 0)).unwrap();
        face.reset(None).unwrap();
        let own = model.parts().blocks[0].coefficients();
        assert_eq!(face.coefficients()[own.clone()], before[own]);
        face.unlock(&region(model, 0)).unwrap();
        face.reset(Some(&region(model, 0))).unwrap();
        assert_eq!(face.positions(), model.face().positions());
        assert_eq!(face.normals(), model.face().normals());
    }
}

#[test]
fn a_code_gives_the_same_face_bit_for_bit() {
    for model in models() {
        for seed in 0..20 {
            let mut face = random(model, seed);
            let [least, most] = model.parts().blending.limits;
            face.set_alpha(least + (most - least) * seed as f32 / 20.0)
                .unwrap();
            let code = face.code();
            assert!(
                code.bytes()
                    .all(|b| b.is_ascii_alphanumeric() || b == b'-' || b == b'_')
            );
            let again = model.from_code(&code).unwrap();
            assert_eq!(again.coefficients(), face.coefficients());
            assert_eq!(again.alpha(), face.alpha());
            assert_eq!(again.positions(), face.positions());
            assert_eq!(again.normals(), face.normals());
            assert_eq!(again.code(), code);
        }
    }
}

#[test]
fn a_damaged_code_is_refused_and_changes_nothing() {
    let mut face = random(&SHEET, 1);
    let code = face.code();
    let before = face.clone();
    for end in 0..code.len() {
        assert!(
            matches!(face.set_code(&code[..end]), Err(Error::Code(_))),
            "cut at {end}"
        );
    }
    for wrong in [
        format!("{code}A"),
        format!("{code}!"),
        "é".into(),
        head_model().face().code(),
    ] {
        assert!(
            matches!(face.set_code(&wrong), Err(Error::Code(_))),
            "{wrong}"
        );
    }
    assert_eq!(face.positions(), before.positions());
    assert_eq!(face.coefficients(), before.coefficients());
}

#[test]
fn a_blend_ends_at_its_two_faces() {
    for model in models() {
        let (from, to) = (random(model, 3), random(model, 4));
        let mut face = from.clone();
        face.blend(&to, 0.0, None).unwrap();
        assert_eq!(face.positions(), from.positions());
        assert_eq!(face.changed(), 0..0);
        face.blend(&to, 1.0, None).unwrap();
        assert_eq!(face.positions(), to.positions());
        assert_eq!(face.normals(), to.normals());

        // One region only: the others keep their coefficients.
        let mut face = from.clone();
        face.blend(&to, 1.0, Some(&[region(model, 1)])).unwrap();
        for (b, block) in model.parts().blocks.iter().enumerate() {
            let own = block.coefficients();
            let wanted = if b == 1 { &to } else { &from };
            assert_eq!(face.coefficients()[own.clone()], wanted.coefficients()[own]);
        }
    }
}

#[test]
fn a_blend_halfway_lies_halfway() {
    for model in models() {
        let (from, to) = (random(model, 3), random(model, 4));
        let mut face = from.clone();
        face.blend(&to, 0.5, None).unwrap();
        let middle: Vec<Vec3> = from
            .positions()
            .iter()
            .zip(to.positions())
            .map(|(a, b)| (a + b) / 2.0)
            .collect();
        // Half a grid step a coefficient: 100 coefficients x 1/131072 sigma x 5 mm is 4
        // micrometres if all conspire; f32 sums add a tenth of one.
        assert!(farthest(face.positions(), &middle) < 0.004);
    }
}

#[test]
fn alpha_spreads_a_feature_and_leaves_the_feature_itself() {
    for model in models() {
        let [least, most] = model.parts().blending.limits;
        let control = model.parts().controls[0].name.clone();
        let block = model
            .parts()
            .blocks
            .iter()
            .find(|b| b.surround.is_some())
            .unwrap();
        let surround = block.surround.as_ref().unwrap();
        // How far the surround moves, in all, when the slider goes from one end to the other.
        let moved = |alpha: f32| -> (f32, Vec<Vec3>) {
            let mut face = model.face();
            face.set_alpha(alpha).unwrap();
            face.set(&control, 0.0).unwrap();
            let low = face.positions().to_vec();
            face.set(&control, 1.0).unwrap();
            let all = |v: &u32| (face.positions()[*v as usize] - low[*v as usize]).length();
            let feature = block
                .support
                .iter()
                .map(|&v| face.positions()[v as usize] - low[v as usize]);
            (surround.targets.iter().map(all).sum(), feature.collect())
        };
        let ((little, feature), (much, same)) = (moved(least), moved(most));
        assert!(
            much > 1.5 * little,
            "{much} mm at {most}, {little} mm at {least}"
        );
        // Two differences of f32 sums near 100 mm.
        assert!(farthest(&feature, &same) < 1e-4);
    }
}

#[test]
fn all_of_a_face_has_its_blending_distance_with_it() {
    for model in models() {
        let usual = model.parts().blending.alpha;
        let (mut from, mut to) = (random(model, 1), random(model, 2));
        to.set_alpha(3.0).unwrap();
        let name = region(model, 0);
        let only = [name.clone()];
        from.blend(&to, 1.0, Some(&only)).unwrap();
        assert_eq!(from.alpha(), usual, "a region has none");
        from.blend(&to, 0.0, None).unwrap();
        assert_eq!(from.alpha(), usual);
        from.blend(&to, 0.5, None).unwrap();
        assert!((from.alpha() - (usual + 3.0) / 2.0).abs() < 1e-3);
        assert_eq!(from.changed(), 0..from.positions().len() as u32);
        from.blend(&to, 1.0, None).unwrap();
        assert_eq!(from.code(), to.code());
        assert_eq!(from.positions(), to.positions());
        from.reset(Some(&name)).unwrap();
        assert_eq!(from.alpha(), 3.0);
        from.reset(None).unwrap();
        assert_eq!(from.code(), model.face().code());
        assert_eq!(from.positions(), model.face().positions());
        // What is locked or held would move with it.
        let mut locked = random(model, 3);
        locked.lock(&name).unwrap();
        locked.blend(&to, 1.0, None).unwrap();
        assert_eq!(locked.alpha(), usual);
        let mut held = to.clone();
        held.lock_measure(&model.parts().measures[0].name).unwrap();
        held.reset(None).unwrap();
        assert_eq!(held.alpha(), 3.0);
    }
}

/// A file with attributes says its fingerprint itself: one that says another model's is another model all the same.
#[test]
fn a_model_that_says_it_is_another_is_not_blended_with_it() {
    let read = |bytes: &[u8]| FaceModel::parse(bytes).unwrap();
    let ours = labelled_sheet().write().unwrap();
    let fingerprint = |bytes: &[u8]| {
        let name = bytes.windows(3).rposition(|w| w == b"age").unwrap();
        name - 12..name - 8
    };
    let claim = |mut bytes: Vec<u8>| {
        let own = fingerprint(&bytes);
        bytes[own].copy_from_slice(&ours[fingerprint(&ours)]);
        seal(&mut bytes);
        read(&bytes)
    };
    let mut longer = edited_sheet();
    longer.attributes = labelled_sheet().attributes;
    let mut other_blocks = labelled_sheet();
    // As many coefficients in all.
    for (block, modes) in [(0, 2), (1, 3)] {
        let parts = &mut other_blocks;
        let count = 3 * parts.blocks[block].support.len() * modes;
        let numbers: Vec<i16> = (0..count).map(|i| (i * 37 % 101) as i16 - 50).collect();
        let step = parts.blocks[block].modes.step();
        parts.blocks[block].modes = phiz::model::Modes::new(step, modes, &numbers);
        parts.blocks[block].sigmas = vec![1.0; modes];
    }
    other_blocks.blocks[1].first_coefficient = 2;
    let mut farther = labelled_sheet();
    farther.blending.limits[1] = 400.0;
    let mut face = random(&read(&ours), 1);
    let before = face.code();
    for other in [longer, other_blocks, farther] {
        let other = claim(other.write().unwrap());
        let mut other = random(&other, 2);
        assert_eq!(other.code()[..5], before[..5], "it says that it is");
        assert!(matches!(
            face.blend(&other, 0.5, None),
            Err(Error::Mismatch(_))
        ));
        assert!(matches!(
            other.blend(&face, 0.5, None),
            Err(Error::Mismatch(_))
        ));
    }
    assert_eq!(face.code(), before);
    face.blend(&random(&read(&ours), 2), 0.5, None).unwrap();
}

/// A mesh of many loose parts is locked as soon as one of few.
#[test]
fn loose_parts_by_the_thousand_do_not_keep_a_lock_busy() {
    const PARTS: usize = 60_000;
    let mut parts = crate::common::sheet();
    let (n, more) = (parts.mean.len() as u32, 3 * PARTS as u32);
    let topology = &mut parts.topology;
    for corner in topology.uv_triangles.as_flattened_mut() {
        *corner += if *corner >= n { more } else { 0 };
    }
    topology
        .uvs
        .splice(n as usize..n as usize, (0..more).map(|_| [0.5; 2]));
    topology
        .uv_vertices
        .splice(n as usize..n as usize, n..n + more);
    let loose = (0..PARTS as u32).map(|i| [0, 1, 2].map(|corner| n + 3 * i + corner));
    topology.uv_triangles.extend(loose);
    topology.parts.push(phiz::anatomy::Part {
        name: "loose".into(),
        first: topology.uv_triangles.len() as u32 - PARTS as u32,
        count: PARTS as u32,
    });
    topology.mirror.extend(n..n + more);
    topology.regions.extend((0..more).map(|_| 2));
    topology.colours.extend((0..more).map(|_| [9; 3]));
    parts
        .mean
        .extend((0..more).map(|i| Vec3::new(40.0, 0.0, (i % 7) as f32)));
    // The head moves all vertices; those not at all.
    let head = &mut parts.blocks[2];
    head.support.extend(n..n + more);
    let modes = &head.modes;
    let mut numbers = modes.by_vertex();
    numbers.resize(numbers.len() + 3 * more as usize * modes.count(), 0);
    head.modes = phiz::model::Modes::new(modes.step(), modes.count(), &numbers);
    let model = FaceModel::parse(&parts.write().unwrap()).unwrap();
    let mut face = model.face();
    let begun = std::time::Instant::now();
    face.lock("nose").unwrap();
    // A hundredth of that; comparing each part with each vertex takes a minute.
    let taken = begun.elapsed().as_secs_f64();
    assert!(taken < 5.0, "{taken} s");
    let locked = face.positions().to_vec();
    face.set("head 1", 0.9).unwrap();
    assert!(farthest(&face.positions()[n as usize..], &locked[n as usize..]) < 1e-6);
}

#[test]
fn what_is_outside_of_the_changed_range_did_not_change() {
    for model in models() {
        let mut face = random(model, 5);
        let check = |face: &mut Face, what: &str, change: &dyn Fn(&mut Face)| {
            let before = face.clone();
            change(face);
            let range = face.changed();
            let mut touched = face.positions().len()..0;
            for v in 0..face.positions().len() {
                if face.positions()[v] != before.positions()[v]
                    || face.normals()[v] != before.normals()[v]
                {
                    touched = touched.start.min(v)..v + 1;
                }
            }
            assert!(
                touched.is_empty()
                    || (range.start as usize <= touched.start && touched.end <= range.end as usize),
                "{what}: it says {range:?}, but {touched:?} changed"
            );
            // And the normals are those of the whole mesh, not stale ones.
            let whole = model.from_code(&face.code()).unwrap();
            assert_eq!(whole.normals(), face.normals(), "{what}");
        };
        for control in &model.parts().controls {
            check(&mut face, &control.name, &|f| {
                f.set(&control.name, 0.8).unwrap()
            });
        }
        let first = region(model, 0);
        check(&mut face, "reset", &|f| f.reset(Some(&first)).unwrap());
        check(&mut face, "randomize", &|f| {
            f.randomize(&seeded(9)).unwrap();
        });
        check(&mut face, "drag", &|f| {
            let target = f.positions()[0] + Vec3::Y;
            f.drag(0, target).unwrap();
        });
        check(&mut face, "alpha", &|f| {
            f.set_alpha(model.parts().blending.limits[0]).unwrap()
        });
        check(&mut face, "nothing", &|f| {
            let same = f.coefficients();
            f.set_coefficients(&same).unwrap();
            assert_eq!(f.changed(), 0..0);
        });
    }
}

#[test]
fn a_million_events_leave_no_drift() {
    // The small model takes nearly all of them: each is the same arithmetic.
    for (model, events) in models().into_iter().zip([4_000, 1_000_000]) {
        let mut face = model.face();
        let names: Vec<String> = (model.parts().controls.iter())
            .filter(|c| c.measure.is_none())
            .map(|c| c.name.clone())
            .collect();
        let mut random = Random::new(11);
        for event in 0..events {
            let value = 0.02 + 0.96 * random.uniform();
            face.set(&names[event % names.len()], value).unwrap();
        }
        let again = model.from_code(&face.code()).unwrap();
        // Not nearly: the bits are those of a face that was computed once.
        assert_eq!(face.positions(), again.positions());
        assert_eq!(face.normals(), again.normals());
    }
}

#[test]
fn random_faces_have_the_populations_mean_spread_and_correlation() {
    // 4,000 draws on the sheet, whose correlations are far from 0. A correlation r of n draws has
    // a standard error of (1 - r^2)/sqrt(n) <= 0.016 and a mean of 1/sqrt(n); five of them, and
    // 0.01 for the cut at 3 sigmas, which takes 1.4 % off a variance.
    let n = 4000;
    let mut face = SHEET.face();
    let draws: Vec<Vec<f32>> = (0..n)
        .map(|seed| {
            face.randomize(&seeded(seed)).unwrap();
            face.coefficients()
        })
        .collect();
    let mean = |i: usize| draws.iter().map(|d| f64::from(d[i])).sum::<f64>() / n as f64;
    let product = |i: usize, j: usize| {
        draws
            .iter()
            .map(|d| f64::from(d[i]) * f64::from(d[j]))
            .sum::<f64>()
            / n as f64
    };
    for i in 0..COEFFICIENTS {
        assert!(mean(i).abs() < 0.08, "mean {i} is {}", mean(i));
        // A variance has a standard error of sqrt(2/n) = 0.022.
        assert!(
            (product(i, i) - 1.0).abs() < 0.13,
            "variance {i} is {}",
            product(i, i)
        );
        for j in 0..i {
            let got = product(i, j) / (product(i, i) * product(j, j)).sqrt();
            let wanted = f64::from(SHEET.parts().correlation[i * COEFFICIENTS + j]);
            assert!((got - wanted).abs() < 0.09, "{i}, {j}: {got}, not {wanted}");
        }
    }
}

#[test]
fn a_random_face_fits_what_is_locked() {
    // The sheet's nose ends with coefficient 2 and its mouth starts with 3, correlated by 0.6.
    // With the nose locked at +2 sigmas, coefficient 3 is normal with mean 0.6 x 2 and variance
    // 1 - 0.36 (the process is Markov, so 0 and 1 add nothing).
    let mut face = SHEET.face();
    let mut coefficients = face.coefficients();
    coefficients[2] = 2.0;
    face.set_coefficients(&coefficients).unwrap();
    face.lock("nose").unwrap();
    let n = 4000;
    let (mut sum, mut squares) = (0.0, 0.0);
    for seed in 0..n {
        face.randomize(&seeded(seed)).unwrap();
        let drawn = face.coefficients();
        assert_eq!(drawn[..3], coefficients[..3]);
        sum += f64::from(drawn[3]);
        squares += f64::from(drawn[3]).powi(2);
    }
    let mean = sum / n as f64;
    let variance = squares / n as f64 - mean * mean;
    // Five standard errors, 0.8/sqrt(n) and 0.64 sqrt(2/n); the cut at 3 sigmas takes a little.
    assert!((mean - 1.2).abs() < 0.07, "{mean}");
    assert!((variance - 0.64).abs() < 0.08, "{variance}");
}

/// The vertices of the regions that some blocks cover.
fn vertices_of(model: &FaceModel, names: &[String]) -> Vec<usize> {
    let parts = model.parts();
    let blocks = parts.blocks.iter().filter(|b| names.contains(&b.name));
    let covered: Vec<u8> = blocks.flat_map(|b| b.regions.clone()).collect();
    let each = 0..parts.mean.len();
    each.filter(|&v| covered.contains(&parts.topology.regions[v]))
        .collect()
}

fn farthest_of(a: &[Vec3], b: &[Vec3], among: &[usize]) -> f32 {
    among.iter().fold(0.0, |m, &v| m.max(a[v].distance(b[v])))
}

#[test]
fn a_locked_region_stays_in_place_whatever_happens_elsewhere() {
    let model = head_model();
    let names: Vec<String> = (model.parts().blocks.iter())
        .filter(|b| b.local_to.is_none())
        .map(|b| b.name.clone())
        .collect();
    let mut sets: Vec<Vec<String>> = names.iter().map(|name| vec![name.clone()]).collect();
    sets.push(vec!["eyes".into(), "mouth".into()]);
    sets.push(vec!["nose".into(), "head".into()]);
    for locked in sets {
        let mut face = random(model, 3);
        let kept = vertices_of(model, &locked);
        let rest: Vec<String> = names
            .iter()
            .filter(|n| !locked.contains(n))
            .cloned()
            .collect();
        let free = vertices_of(model, &rest);
        assert!(kept.len() > 100 && free.len() > 100);
        for name in &locked {
            face.lock(name).unwrap();
        }
        let start = face.positions().to_vec();
        // Rounding of f32 at 200 mm is 0.000015 mm, and a few are added.
        let check = |face: &Face, what: &str, most: f32| {
            let moved = farthest_of(face.positions(), &start, &kept);
            assert!(moved < most, "{locked:?}, {what}: {moved} mm");
        };
        face.randomize(&seeded(4)).unwrap();
        check(&face, "randomize", 1e-4);
        assert!(
            farthest_of(face.positions(), &start, &free) > 2.0,
            "{locked:?}"
        );
        let other = random(model, 5);
        face.blend(&other, 0.7, None).unwrap();
        check(&face, "blend", 1e-4);
        for control in model
            .parts()
            .controls
            .iter()
            .filter(|c| !locked.contains(&c.group))
            .step_by(5)
        {
            face.set(&control.name, 0.9).unwrap();
            check(&face, &control.name, 1e-4);
        }
        // Coefficients farther out than any person's, of what is not locked.
        let mut beyond = face.coefficients();
        let blocks = &model.parts().blocks;
        for block in blocks.iter().filter(|b| rest.contains(&b.name)) {
            beyond[block.first_coefficient] += 4.0;
        }
        face.set_coefficients(&beyond).unwrap();
        check(&face, "coefficients", 1e-4);
        for &vertex in [free[0], free[free.len() / 2], kept[0]].iter() {
            let there = face.positions()[vertex] + Vec3::new(1.0, 2.0, -1.0);
            face.drag(vertex as u32, there).unwrap();
            check(&face, "drag", 1e-4);
        }
        face.reset(None).unwrap();
        check(&face, "reset", 1e-4);
        face.randomize(&seeded(6)).unwrap();

        // What is left is what the code gives, and unlocking moves nothing.
        let there = face.positions().to_vec();
        let again = model.from_code(&face.code()).unwrap();
        assert_eq!(again.positions(), there);
        assert_eq!(again.normals(), face.normals());
        for name in &locked {
            face.unlock(name).unwrap();
        }
        assert_eq!(face.positions(), there);
        assert_eq!(face.code(), again.code());
        // Nor does what assigns the coefficients that are there.
        face.set_coefficients(&face.coefficients()).unwrap();
        assert_eq!(face.code(), again.code());
        // Whoever is drawn anew is a person like any other.
        face.randomize(&seeded(7)).unwrap();
        assert_eq!(face.positions(), random(model, 7).positions());
        assert_eq!(face.changed(), 0..there.len() as u32);
    }
}

/// "Keep the nose, draw, let it go, keep the eyes, draw": what is let go is like anybody's, but for a
/// border beside what is locked now, which stays.
#[test]
fn what_was_locked_before_lets_go_beside_what_is_locked_now() {
    let model = head_model();
    let parts = model.parts();
    let names: Vec<String> = (parts.blocks.iter())
        .filter(|b| b.local_to.is_none())
        .map(|b| b.name.clone())
        .collect();
    let vertices = |name: &String| vertices_of(model, std::slice::from_ref(name));
    for former in &names {
        let mut before = random(model, 3);
        before.lock(former).unwrap();
        before.randomize(&seeded(4)).unwrap();
        before.unlock(former).unwrap();
        for locked in names.iter().filter(|name| *name != former) {
            let kept = vertices(locked);
            // Farther from what stays than weights are worth anything.
            let mut deep = vertices(former);
            deep.retain(|&v| {
                let far = |&k: &usize| parts.mean[v].distance(parts.mean[k]) > 60.0;
                kept.iter().all(far)
            });
            let start = before.positions().to_vec();
            let one = Some(vec![former.clone()]);
            type Change<'a> = (&'a str, &'a dyn Fn(&mut Face));
            let changes: [Change; 4] = [
                ("drawn", &|face| drop(face.randomize(&seeded(5)))),
                ("reset", &|face| face.reset(None).unwrap()),
                ("reset of it", &|face| face.reset(Some(former)).unwrap()),
                ("drawn alone", &|face| {
                    let regions = one.clone();
                    drop(face.randomize(&Randomize {
                        regions,
                        ..seeded(5)
                    }))
                }),
            ];
            for (what, change) in changes {
                let mut face = before.clone();
                face.lock(locked).unwrap();
                change(&mut face);
                let what = format!("{former}, then {locked}, {what}");
                let moved = farthest_of(face.positions(), &start, &kept);
                assert!(moved < 1e-4, "{what}: {moved} mm");
                let mut plain = model.face();
                plain.set_coefficients(&face.coefficients()).unwrap();
                let off = farthest_of(face.positions(), plain.positions(), &deep);
                // Of the centimetre between two people a hundredth may be: weights end nowhere.
                assert!(off < 0.1, "{what}: {off} mm of it are left");
                assert_eq!(
                    model.from_code(&face.code()).unwrap().positions(),
                    face.positions()
                );
            }
        }
    }

    // In turn, again and again.
    let mut face = random(model, 3);
    for (seed, name) in (10..).zip(["nose", "eyes"].repeat(6)) {
        face.lock(name).unwrap();
        let kept = vertices(&name.to_owned());
        let start = face.positions().to_vec();
        face.randomize(&seeded(seed)).unwrap();
        let moved = farthest_of(face.positions(), &start, &kept);
        assert!(moved < 1e-4, "{seed}, {name}: {moved} mm");
        face.unlock(name).unwrap();
    }
    face.randomize(&seeded(7)).unwrap();
    assert_eq!(face.positions(), random(model, 7).positions());
}

#[test]
fn a_locked_region_follows_its_own_sliders_and_no_other_locked_one_does() {
    let model = head_model();
    let mut face = random(model, 3);
    face.lock("nose").unwrap();
    face.lock("mouth").unwrap();
    face.randomize(&seeded(4)).unwrap();
    let start = face.positions().to_vec();
    let value = match face.get("nose 1").unwrap() < 0.5 {
        true => 0.9,
        false => 0.1,
    };
    face.set("nose 1", value).unwrap();
    assert!((face.get("nose 1").unwrap() - value).abs() < 1e-3);
    let [nose, mouth] = ["nose", "mouth"].map(|name| vertices_of(model, &[name.into()]));
    assert!(farthest_of(face.positions(), &start, &nose) > 0.5);
    let moved = farthest_of(face.positions(), &start, &mouth);
    assert!(moved < 1e-4, "{moved} mm");
    // A length of a locked region can be asked for: its own control moves.
    let wanted = face.measure("nose length").unwrap() + 2.0;
    face.set_measure("nose length", wanted).unwrap();
    assert!((face.measure("nose length").unwrap() - wanted).abs() < 0.01);
    let moved = farthest_of(face.positions(), &start, &mouth);
    assert!(moved < 1e-4, "{moved} mm");
}

#[test]
fn what_is_locked_stays_beside_what_is_held_in_it() {
    let model = head_model();
    let controls = &model.parts().controls;
    let moving: Vec<_> = ["head 1", "head 2", "eyes 1", "mouth 1"]
        .into_iter()
        .collect();
    for region in ["mouth", "nose"] {
        let own = vertices_of(model, &[region.into()]);
        let measured = controls.iter().filter(|c| c.group == region);
        for measure in measured.filter_map(|c| c.measure) {
            let measure = &model.parts().measures[measure as usize].name;
            let mut face = random(model, 4);
            face.lock(region).unwrap();
            face.lock_measure(measure).unwrap();
            let (start, mm) = (face.positions().to_vec(), face.measure(measure).unwrap());
            for name in moving.iter().filter(|name| !name.starts_with(region)) {
                let code = face.code();
                if face.set(name, 0.95).is_err() {
                    assert_eq!(face.code(), code, "{measure}, {name}");
                }
                let moved = farthest_of(face.positions(), &start, &own);
                assert!(moved < 1e-4, "{measure}, {name}: {moved} mm");
                let off = face.measure(measure).unwrap() - mm;
                assert!(off.abs() < 1e-3, "{measure}, {name}: off by {off} mm");
            }
            // Its own sliders move it.
            let slider = format!("{region} 1");
            let other = 1.0 - face.get(&slider).unwrap();
            face.set(&slider, other).unwrap();
            assert!((face.get(&slider).unwrap() - other).abs() < 0.05);
        }
    }
}

#[test]
fn where_all_is_locked_what_is_held_stays() {
    let model = head_model();
    let mut face = random(model, 4);
    let blocks = &model.parts().blocks;
    let regions: std::collections::BTreeSet<_> = blocks.iter().map(Block::region).collect();
    for region in regions {
        face.lock(region).unwrap();
    }
    face.lock_measure("face width").unwrap();
    let (code, mm) = (face.code(), face.measure("face width").unwrap());
    assert!(face.set("head 1", 0.95).is_err());
    assert_eq!(face.code(), code);
    assert_eq!(face.measure("face width").unwrap(), mm);
}

#[test]
fn what_a_measure_left_between_the_grid_s_points_is_locked_there() {
    let model = head_model();
    let head = vertices_of(model, &["head".into()]);
    for seed in 4..8 {
        let mut face = random(model, seed);
        let wanted = face.measure("face width").unwrap() + 2.0;
        face.set_measure("face width", wanted).unwrap();
        face.lock("head").unwrap();
        let start = face.positions().to_vec();
        face.set("nose 1", 0.9).unwrap();
        let moved = farthest_of(face.positions(), &start, &head);
        assert!(moved < 1e-4, "{moved} mm");
    }
}

#[test]
fn what_fails_beside_a_lock_changes_nothing() {
    let model = head_model();
    let mut face = random(model, 3);
    face.lock("nose").unwrap();
    face.randomize(&seeded(4)).unwrap();
    face.lock_measure("nose length").unwrap();
    let (code, positions) = (face.code(), face.positions().to_vec());
    assert!(face.set_measure("mouth width", 4000.0).is_err());
    assert!(face.set_measure("face width", -5.0).is_err());
    assert_eq!(face.code(), code);
    assert_eq!(face.positions(), positions);
}

#[test]
fn faces_with_locks_behind_them_blend_to_each_other() {
    let model = head_model();
    let locked = |seed: u64| {
        let mut face = random(model, seed);
        face.lock("eyes").unwrap();
        face.randomize(&seeded(seed + 1)).unwrap();
        face.unlock("eyes").unwrap();
        face
    };
    let (mut from, to) = (locked(3), locked(8));
    let start = from.positions().to_vec();
    from.blend(&to, 0.5, None).unwrap();
    for (v, p) in from.positions().iter().enumerate() {
        let middle = (start[v] + to.positions()[v]) / 2.0;
        // The grid of coefficients is 0.00008 mm at a mode of 5 mm, and there are 135 of them.
        assert!(p.distance(middle) < 2e-3, "{v}");
    }
    from.blend(&to, 1.0, None).unwrap();
    assert_eq!(from.positions(), to.positions());
    assert_eq!(from.code(), to.code());
}

#[test]
fn a_seed_is_a_face_and_the_spread_scales_it() {
    for model in models() {
        assert_eq!(random(model, 7).positions(), random(model, 7).positions());
        assert_ne!(random(model, 7).positions(), random(model, 8).positions());
        let mut face = model.face();
        face.randomize(&Randomize {
            spread: Some(0.0),
            ..seeded(7)
        })
        .unwrap();
        assert!(face.coefficients().iter().all(|&c| c == 0.0));
        face.randomize(&Randomize {
            spread: Some(3.0),
            ..seeded(7)
        })
        .unwrap();
        assert!(face.coefficients().iter().all(|&c| c.abs() <= 3.0));
        // Without a seed one is drawn, and given back.
        let seed = face.randomize(&Randomize::default()).unwrap();
        assert_eq!(random(model, seed).positions(), face.positions());
    }
}

#[test]
fn a_drag_brings_the_vertex_to_its_target() {
    for model in models() {
        let mut worst = 0.0_f32;
        for step in 0..10 {
            let mut face = model.face();
            let vertex = (model.parts().mean.len() * step / 10) as u32;
            let start = face.positions()[vertex as usize];
            // Half a millimetre is within reach of the population everywhere on a head.
            let target = start + Vec3::new(0.2, -0.3, 0.35);
            face.drag(vertex, target).unwrap();
            worst = worst.max(face.positions()[vertex as usize].distance(target));
        }
        // The ridge of a millionth and the grid leave micrometres; a hundredth of the way is
        // allowed for vertices that can hardly move along an axis.
        assert!(worst < 0.005, "{worst} mm");
    }
}

#[test]
fn a_drag_keeps_what_is_locked_and_stays_within_the_limits() {
    for model in models() {
        let mut face = random(model, 6);
        let before = face.coefficients();
        face.lock(&region(model, 0)).unwrap();
        face.drag(0, Vec3::splat(1e6)).unwrap();
        let after = face.coefficients();
        let own = model.parts().blocks[0].coefficients();
        assert_eq!(after[own.clone()], before[own]);
        assert!(after.iter().all(|c| c.abs() <= 3.0));
        for target in [f32::MAX, f32::MIN] {
            face.drag(0, Vec3::splat(target)).unwrap();
        }
    }
}

#[test]
fn a_drag_is_the_least_mahalanobis_change() {
    // Any other change that brings the vertex to the same place is less probable: add to the
    // drag's change any direction that does not move the vertex, and its length only grows.
    let mut face = SHEET.face();
    face.set_coefficients(&[0.0; COEFFICIENTS]).unwrap();
    let target = face.positions()[20] + Vec3::new(0.5, 0.2, -0.4);
    face.drag(20, target).unwrap();
    let change = nalgebra::DVector::from_iterator(
        COEFFICIENTS,
        face.coefficients().into_iter().map(f64::from),
    );
    let correlation = nalgebra::DMatrix::from_row_iterator(
        COEFFICIENTS,
        COEFFICIENTS,
        SHEET.parts().correlation.iter().map(|&r| f64::from(r)),
    );
    let precision = correlation.try_inverse().unwrap();
    // The vertex's Jacobian by differences of one sigma; positions are linear.
    let origin = {
        let mut face = SHEET.face();
        face.set_coefficients(&[0.0; COEFFICIENTS]).unwrap();
        face.positions()[20]
    };
    let jacobian = nalgebra::DMatrix::from_fn(3, COEFFICIENTS, |axis, i| {
        let mut unit = [0.0; COEFFICIENTS];
        unit[i] = 1.0;
        let mut face = SHEET.face();
        face.set_coefficients(&unit).unwrap();
        f64::from((face.positions()[20] - origin)[axis])
    });
    // Optimal exactly when R^-1 c lies in the row space of J: the part outside is 0 up to f32.
    let pull = &precision * &change;
    let gram = (&jacobian * jacobian.transpose()).try_inverse().unwrap();
    let inside = jacobian.transpose() * gram * &jacobian * &pull;
    assert!((pull.clone() - inside).norm() < 1e-3 * pull.norm());
}

#[test]
fn what_has_no_meaning_is_an_error_and_changes_nothing() {
    for model in models() {
        let mut face = random(model, 1);
        let before = face.clone();
        let control = model.parts().controls[0].name.clone();
        for value in [f64::NAN, f64::INFINITY, -0.001, 1.001] {
            assert!(
                matches!(face.set(&control, value), Err(Error::Value { .. })),
                "{value}"
            );
            assert!(
                matches!(face.set_alpha(value as f32), Err(Error::Value { .. })),
                "{value}"
            );
            let other = model.face();
            assert!(face.blend(&other, value, None).is_err(), "{value}");
        }
        for spread in [f64::NAN, -0.1, 3.1] {
            assert!(
                face.randomize(&Randomize {
                    spread: Some(spread),
                    ..seeded(1)
                })
                .is_err()
            );
        }
        let names = Some(vec!["no such".to_owned()]);
        assert!(
            face.randomize(&Randomize {
                regions: names.clone(),
                ..seeded(1)
            })
            .is_err()
        );
        assert!(face.blend(&before, 0.5, names.as_deref()).is_err());
        assert!(matches!(
            face.set("no such", 0.5),
            Err(Error::Unknown { .. })
        ));
        assert!(face.get("no such").is_err());
        assert!(face.lock("no such").is_err());
        assert!(face.unlock("no such").is_err());
        assert!(face.reset(Some("no such")).is_err());
        assert!(face.measure("no such").is_err());
        assert!(face.drag(u32::MAX, Vec3::ZERO).is_err());
        assert!(face.drag(0, Vec3::new(0.0, f32::NAN, 0.0)).is_err());
        assert!(face.set_coefficients(&[]).is_err());
        let mut far = before.coefficients();
        for number in [f32::NAN, f32::NEG_INFINITY, 256.0] {
            far[0] = number;
            assert!(face.set_coefficients(&far).is_err());
        }
        assert_eq!(face.positions(), before.positions());
        assert_eq!(face.coefficients(), before.coefficients());
    }
    let mut face = head_model().face();
    assert!(matches!(
        face.blend(&SHEET.face(), 0.5, None),
        Err(Error::Mismatch(_))
    ));
}

#[test]
fn the_committed_model_takes_every_use() {
    let model = head_model();
    exercise(model);
    // The file is what the parts write, packed, with the fingerprint that it had before its controls were described
    // anew: it holds nothing else.
    let written = pack(&model.rewritten(model.parts()).unwrap()).unwrap();
    assert!(written == std::fs::read(MODEL).unwrap());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// f(a + t (b - a)) = f(a) + t (f(b) - f(a)).
    #[test]
    fn positions_are_linear_in_the_coefficients(
        a in prop::collection::vec(-3.0_f32..3.0, COEFFICIENTS),
        b in prop::collection::vec(-3.0_f32..3.0, COEFFICIENTS),
        t in 0.0_f32..1.0,
    ) {
        let positions = |c: &[f32]| {
            let mut face = SHEET.face();
            face.set_coefficients(c).expect("they are within 255 sigmas");
            face.positions().to_vec()
        };
        let between: Vec<f32> = a.iter().zip(&b).map(|(a, b)| a + t * (b - a)).collect();
        let (from, to, got) = (positions(&a), positions(&b), positions(&between));
        let wanted: Vec<Vec3> = from.iter().zip(&to).map(|(a, b)| *a + t * (*b - *a)).collect();
        // Three roundings to the grid of 9 coefficients, at up to 4.5 mm a sigma: 0.3
        // micrometres each at worst; the f32 sums are smaller.
        prop_assert!(farthest(&got, &wanted) < 0.001);
    }

    /// However a state is reached, its positions are the same bits.
    #[test]
    fn positions_do_not_depend_on_the_way(
        steps in prop::collection::vec((0..10_usize, 0.0_f64..1.0), 1..30),
    ) {
        for model in models() {
            let mut face = model.face();
            for &(control, value) in &steps {
                let controls = &model.parts().controls;
                face.set(&controls[control % controls.len()].name, value).expect("in 0..=1");
            }
            let mut straight = model.face();
            straight.set_coefficients(&face.coefficients()).expect("its own");
            prop_assert_eq!(straight.coefficients(), face.coefficients());
            prop_assert_eq!(straight.positions(), face.positions());
            prop_assert_eq!(straight.normals(), face.normals());
        }
    }

    /// Reading is monotone: a higher percentile is a higher read-out.
    #[test]
    fn a_control_is_monotone(control in 0..10_usize, a in 0.0_f64..1.0, b in 0.0_f64..1.0) {
        for model in models() {
            let controls = &model.parts().controls;
            let control = &controls[control % controls.len()];
            let mut face = model.face();
            face.set(&control.name, a).expect("in 0..=1");
            let low = control.read(&face.coefficients());
            face.set(&control.name, b).expect("in 0..=1");
            let high = control.read(&face.coefficients());
            // The grid may swap what lies closer than a step of it.
            prop_assert!((b - a) * f64::from(high - low) >= -1e-4);
        }
    }
}
