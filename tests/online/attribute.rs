//! What labels tell of a face, and faces that are asked for by them.

use std::sync::LazyLock;

use crate::common::{COEFFICIENTS, head_model, labelled_sheet, sheet, sheet_blob};
use phiz::model::Attribute;
use phiz::{Error, Face, FaceModel, Randomize};

static SHEET: LazyLock<FaceModel> = LazyLock::new(|| {
    let blob = labelled_sheet().write().expect("it is a model");
    FaceModel::parse(&blob).expect("it is a model")
});

fn models() -> [&'static FaceModel; 2] {
    [head_model(), &SHEET]
}

fn asking(seed: u64, asked: &[(&Attribute, f64)]) -> Randomize {
    let named = asked.iter().map(|(a, value)| (a.name.clone(), *value));
    Randomize {
        seed: Some(seed),
        attributes: named.collect(),
        ..Default::default()
    }
}

fn reads(face: &Face, attribute: &Attribute) -> f64 {
    face.attribute(&attribute.name).expect("it is there")
}

/// Positions of the limits, 0 to 1.
fn between(attribute: &Attribute, t: f64) -> f64 {
    let [least, most] = attribute.limits.map(f64::from);
    least + t * (most - least)
}

/// A thousandth of the limits, which is what randomize promises.
fn near(attribute: &Attribute) -> f64 {
    0.001 * (between(attribute, 1.0) - between(attribute, 0.0))
}

/// R w and w . R w for some coefficients.
fn along(model: &FaceModel, attribute: &Attribute) -> (Vec<f64>, f64) {
    let k = model.parts().population();
    let r = |i: usize, j: usize| f64::from(model.parts().correlation[i * k + j]);
    let w = |i: usize| f64::from(attribute.reading[i]);
    let along: Vec<f64> = (0..k)
        .map(|i| (0..k).map(|j| r(i, j) * w(j)).sum())
        .collect();
    let variance = (0..k).map(|i| along[i] * w(i)).sum();
    (along, variance)
}

#[test]
fn the_default_models_attributes_say_what_they_are() {
    let attributes = &head_model().parts().attributes;
    let names: Vec<&str> = attributes.iter().map(|a| a.name.as_str()).collect();
    assert_eq!(names, ["age", "african", "asian", "caucasian", "sex"]);
    for attribute in attributes {
        assert!(
            attribute.description.contains("synthetic"),
            "{}",
            attribute.description
        );
        assert!(attribute.explained >= 0.25, "{}", attribute.name);
    }
}

#[test]
fn faces_keep_their_codes_when_words_or_attributes_change_and_nothing_else_may() {
    for model in models() {
        let mut face = model.face();
        face.randomize(&asking(5, &[])).unwrap();
        let mut parts = model.parts().clone();
        parts.controls[0].description = "a slider".into();
        parts.attributes.truncate(1);
        let other = FaceModel::parse(&model.rewritten(&parts).unwrap()).unwrap();
        assert_eq!(*other.parts(), parts);
        let same = other.from_code(&face.code()).unwrap();
        assert_eq!(same.positions(), face.positions());
        assert_eq!(same.code(), face.code());
        // Written as a model of its own it has codes of its own.
        let own = FaceModel::parse(&parts.write().unwrap()).unwrap();
        assert!(own.from_code(&face.code()).is_err());

        parts.controls[0].limits[1] += 1.0;
        assert!(matches!(model.rewritten(&parts), Err(Error::Blob(_))));
    }
}

#[test]
fn a_read_out_is_linear_in_the_coefficients() {
    for model in models() {
        for attribute in &model.parts().attributes {
            let mut face = model.face();
            face.set_coefficients(&vec![0.0; model.parts().coefficients()])
                .unwrap();
            assert!((reads(&face, attribute) - f64::from(attribute.mean)).abs() < 1e-9);
            let mut other = model.face();
            face.randomize(&asking(1, &[])).unwrap();
            other.randomize(&asking(2, &[])).unwrap();
            let (from, to) = (reads(&face, attribute), reads(&other, attribute));
            for t in [0.25, 0.75] {
                let mut way = face.clone();
                way.blend(&other, t, None).unwrap();
                // Coefficients are rounded to half a step of 1/8192 sigma.
                let off: f32 = attribute.reading.iter().map(|w| w.abs()).sum();
                let off = f64::from(off) / 16384.0 + 1e-6;
                let wanted = from + t * (to - from);
                assert!((reads(&way, attribute) - wanted).abs() <= off);
            }
        }
    }
}

#[test]
fn a_random_face_reads_what_it_was_asked_to() {
    for model in models() {
        for attribute in &model.parts().attributes {
            for seed in 0..40 {
                let value = between(attribute, seed as f64 / 39.0);
                let mut face = model.face();
                face.randomize(&asking(seed, &[(attribute, value)]))
                    .unwrap();
                let off = (reads(&face, attribute) - value).abs();
                assert!(off <= near(attribute), "{}: {off} off", attribute.name);
                let far = |c: &f32| c.abs() > 3.0;
                assert!(!face.coefficients().iter().any(far), "beyond 3 sigmas");
            }
        }
    }
}

/// The shares of the three ethnicities sum to 1, so the third is not free when two are asked for.
#[test]
fn several_are_asked_for_at_once_even_if_they_depend_on_each_other() {
    let model = head_model();
    let named = |name: &str| {
        let mut all = model.parts().attributes.iter();
        all.find(|a| a.name == name).expect("the model has it")
    };
    for seed in 0..20 {
        let ethnicity = ["african", "asian", "caucasian"];
        let mut asked: Vec<(&Attribute, f64)> = (ethnicity.iter().enumerate())
            .map(|(i, name)| {
                let own = seed as usize % 3 == i;
                (named(name), between(named(name), f64::from(u8::from(own))))
            })
            .collect();
        asked.push((named("sex"), between(named("sex"), (seed % 2) as f64)));
        asked.push((named("age"), 30.0 + 2.0 * seed as f64));
        let mut face = model.face();
        face.randomize(&asking(seed, &asked)).unwrap();
        for (attribute, value) in asked {
            let off = (reads(&face, attribute) - value).abs();
            // The labels' ends are not quite 0 and 1, so the shares asked for sum to 0.999.
            let allowed = 3.0 * near(attribute);
            assert!(off <= allowed, "{}: {off} off", attribute.name);
        }
    }
}

/// On the sheet, whose correlations are far from 0: coefficients c given w . c = a are normal with
/// the mean R w a / (w . R w) and the covariance R - R w (R w)' / (w . R w).
#[test]
fn what_an_attribute_does_not_tell_varies_as_before() {
    let attribute = &SHEET.parts().attributes[0];
    let (rw, variance) = along(&SHEET, attribute);
    let value = 44.0;
    let shift = (value - f64::from(attribute.mean)) / variance;
    let n = 4000;
    let draws: Vec<Vec<f64>> = (0..n)
        .map(|seed| {
            let mut face = SHEET.face();
            face.randomize(&asking(seed, &[(attribute, value)]))
                .unwrap();
            face.coefficients().iter().map(|&c| c.into()).collect()
        })
        .collect();
    let mean = |i: usize| draws.iter().map(|d| d[i]).sum::<f64>() / n as f64;
    let means: Vec<f64> = (0..COEFFICIENTS).map(mean).collect();
    for i in 0..COEFFICIENTS {
        // Five standard errors of a mean, at most 1/sqrt(n) each.
        assert!(
            (means[i] - rw[i] * shift).abs() < 0.08,
            "mean {i} is {}, not {}",
            means[i],
            rw[i] * shift
        );
        for j in 0..=i {
            let products = draws.iter().map(|d| (d[i] - means[i]) * (d[j] - means[j]));
            let got = products.sum::<f64>() / n as f64;
            let r = f64::from(SHEET.parts().correlation[i * COEFFICIENTS + j]);
            let wanted = r - rw[i] * rw[j] / variance;
            // As without attributes: five standard errors of sqrt(2/n), and the cut at 3 sigmas.
            assert!((got - wanted).abs() < 0.13, "{i}, {j}: {got}, not {wanted}");
        }
    }
}

#[test]
fn without_spread_it_is_the_mean_face_of_the_attribute() {
    for model in models() {
        let attribute = &model.parts().attributes[0];
        let (rw, variance) = along(model, attribute);
        let value = between(attribute, 0.75);
        let mut face = model.face();
        let options = Randomize {
            spread: Some(0.0),
            ..asking(1, &[(attribute, value)])
        };
        face.randomize(&options).unwrap();
        let shift = (value - f64::from(attribute.mean)) / variance;
        for (c, rw) in face.coefficients().iter().zip(rw) {
            // Half a step of the grid.
            assert!((f64::from(*c) - rw * shift).abs() < 1e-4);
        }
    }
}

/// What is locked stays, bit for bit; the others go their part of the way, on average that part of
/// the read-out's variance which is theirs.
#[test]
fn a_locked_region_stays_and_the_others_go_their_part_of_the_way() {
    for model in models() {
        let attribute = &model.parts().attributes[0];
        let nose = model.parts().blocks.iter().find(|b| b.name == "nose");
        let nose = nose.expect("both have one").coefficients();
        let mut face = model.face();
        face.randomize(&asking(3, &[])).unwrap();
        face.lock("nose").unwrap();
        let before = face.coefficients();
        let inside: Vec<usize> = (0..face.positions().len())
            .filter(|&v| {
                let region = model.parts().topology.regions[v] as usize;
                model.parts().topology.region_names[region].starts_with("nose")
            })
            .collect();
        let places: Vec<_> = inside.iter().map(|&v| face.positions()[v]).collect();
        let mut sums = [0.0; 2];
        let n = 200;
        for seed in 0..n {
            for (sum, value) in sums.iter_mut().zip([0.3, 0.7]) {
                let value = between(attribute, value);
                face.randomize(&asking(seed, &[(attribute, value)]))
                    .unwrap();
                assert_eq!(face.coefficients()[nose.clone()], before[nose.clone()]);
                for (&v, place) in inside.iter().zip(&places) {
                    // What a lock promises.
                    assert!(face.positions()[v].distance(*place) <= 1e-4);
                }
                *sum += reads(&face, attribute) / n as f64;
            }
        }
        // The same seeds: what is drawn and what is locked are alike in both means.
        let gone = (sums[1] - sums[0]) / (between(attribute, 0.7) - between(attribute, 0.3));
        assert!(gone > 0.5 && gone <= 1.0 + 1e-3, "{gone} of the way");
        // And a nose alone goes the rest of it at most: the two share what they tell together.
        face.unlock("nose").unwrap();
        let mut ends = [0.0; 2];
        for (end, value) in ends.iter_mut().zip([0.3, 0.7]) {
            let mut only = face.clone();
            only.randomize(&Randomize {
                regions: Some(vec!["nose".into()]),
                ..asking(5, &[(attribute, between(attribute, value))])
            })
            .unwrap();
            *end = reads(&only, attribute);
        }
        let nose_alone = (ends[1] - ends[0]) / (between(attribute, 0.7) - between(attribute, 0.3));
        assert!(nose_alone > 0.0, "{nose_alone} of the way");
        assert!(nose_alone + gone <= 1.0 + 1e-2, "{nose_alone} and {gone}");
    }
}

#[test]
fn labels_change_no_face_and_no_code() {
    let plain = FaceModel::parse(&sheet_blob()).unwrap();
    let mut face = plain.face();
    face.randomize(&asking(7, &[])).unwrap();
    let labelled = SHEET.from_code(&face.code()).unwrap();
    assert_eq!(labelled.positions(), face.positions());
    let mut same = SHEET.face();
    same.randomize(&asking(7, &[])).unwrap();
    assert_eq!(same.code(), face.code());
    assert_eq!(*SHEET.parts(), labelled_sheet());
    assert_ne!(*SHEET.parts(), sheet());
}

#[test]
fn what_cannot_be_asked_for_is_an_error_and_changes_nothing() {
    for model in models() {
        let attribute = &model.parts().attributes[0];
        let mut face = model.face();
        face.randomize(&asking(1, &[])).unwrap();
        let before = face.code();
        let [least, most] = attribute.limits.map(f64::from);
        for value in [least - 0.01, most + 0.01, f64::NAN, f64::INFINITY] {
            let error = face.randomize(&asking(2, &[(attribute, value)]));
            assert!(matches!(error, Err(Error::Value { .. })), "{value}");
        }
        let unknown = Randomize {
            attributes: vec![("no such".into(), 1.0)],
            ..Default::default()
        };
        let error = face.randomize(&unknown).unwrap_err().to_string();
        assert_eq!(error, "no attribute is called \"no such\"");
        assert!(face.attribute("no such").is_err());
        assert_eq!(face.code(), before);
    }
}

/// Attributes that are no shares of one whole.
fn alone(model: &FaceModel) -> Vec<&Attribute> {
    let shares = ["african", "asian", "caucasian"];
    let all = model.parts().attributes.iter();
    all.filter(|a| !shares.contains(&a.name.as_str())).collect()
}

/// A person near the middle, whom no limit of a coefficient stops.
fn somebody(model: &FaceModel, seed: u64) -> Face {
    let mut face = model.face();
    let options = Randomize {
        spread: Some(0.4),
        ..asking(seed, &[])
    };
    face.randomize(&options).unwrap();
    face
}

#[test]
fn a_face_is_given_attributes_and_keeps_the_others_and_goes_back() {
    for model in models() {
        for (seed, t) in [(1, 0.2), (2, 0.5), (3, 0.8)] {
            for attribute in alone(model) {
                let mut face = somebody(model, seed);
                let before = face.coefficients();
                let read = reads(&face, attribute);
                let value = between(attribute, t);
                let give = |face: &mut Face, value: f64| {
                    face.set_attributes(&[(attribute.name.clone(), value)])
                };
                let others = |face: &Face| -> Vec<f64> {
                    let others = model.parts().attributes.iter();
                    let others = others.filter(|a| a.name != attribute.name);
                    others.map(|a| reads(face, a) / near(a)).collect()
                };
                let kept = others(&face);
                give(&mut face, value).unwrap();
                assert!((reads(&face, attribute) - value).abs() <= near(attribute));
                for (now, kept) in others(&face).iter().zip(kept) {
                    assert!((now - kept).abs() <= 1.0, "{}", attribute.name);
                }
                // There and back is where it was, to two steps of the grid and what is near.
                give(&mut face, read).unwrap();
                for (now, was) in face.coefficients().iter().zip(before) {
                    assert!((now - was).abs() < 2e-3, "{}: {now} {was}", attribute.name);
                }
            }
        }
    }
}

/// The change is R W (W' R W)^-1 of what the attributes change by, with W their read-outs: no other
/// with the same readings is as probable.
#[test]
fn the_change_to_an_attribute_is_the_most_probable_one() {
    let model = &*SHEET;
    let attributes = &model.parts().attributes;
    let mut face = somebody(model, 4);
    let before = face.coefficients();
    let asked: Vec<(String, f64)> = (attributes.iter())
        .zip([0.7, 0.4])
        .map(|(a, t)| (a.name.clone(), between(a, t)))
        .collect();
    let goals: Vec<f64> = (attributes.iter().zip(&asked))
        .map(|(a, (_, value))| value - reads(&face, a))
        .collect();
    face.set_attributes(&asked).unwrap();
    let ways: Vec<Vec<f64>> = attributes.iter().map(|a| along(model, a).0).collect();
    let gram = |i: usize, j: usize| -> f64 {
        let each = ways[i].iter().zip(&attributes[j].reading);
        each.map(|(rw, &w)| rw * f64::from(w)).sum()
    };
    let determinant = gram(0, 0) * gram(1, 1) - gram(0, 1) * gram(1, 0);
    let amounts = [
        (goals[0] * gram(1, 1) - goals[1] * gram(0, 1)) / determinant,
        (goals[1] * gram(0, 0) - goals[0] * gram(1, 0)) / determinant,
    ];
    for (i, (now, was)) in face.coefficients().iter().zip(before).enumerate() {
        let expected = amounts[0] * ways[0][i] + amounts[1] * ways[1][i];
        // Steps of the grid, and how near forty rounds come.
        assert!((f64::from(now - was) - expected).abs() < 1e-3, "{i}");
    }
}

#[test]
fn what_a_face_reads_already_changes_nothing_and_what_is_locked_stays() {
    for model in models() {
        let mut face = model.face();
        face.randomize(&asking(8, &[])).unwrap();
        let code = face.code();
        face.set_attributes(&[]).unwrap();
        assert_eq!(face.code(), code);

        let attribute = alone(model)[0];
        let nose = model.parts().blocks.iter().find(|b| b.name == "nose");
        let nose = nose.expect("both have one").coefficients();
        face.lock("nose").unwrap();
        let (before, read) = (face.coefficients(), reads(&face, attribute));
        let value = between(
            attribute,
            if read < between(attribute, 0.5) {
                0.8
            } else {
                0.2
            },
        );
        face.set_attributes(&[(attribute.name.clone(), value)])
            .unwrap();
        assert_eq!(face.coefficients()[nose.clone()], before[nose]);
        let gone = (reads(&face, attribute) - read) / (value - read);
        assert!(gone > 0.3 && gone <= 1.0 + 1e-3, "{gone} of the way");
    }
}

#[test]
fn an_attribute_that_cannot_be_given_is_an_error_and_changes_nothing() {
    for model in models() {
        let attribute = alone(model)[0];
        let mut face = somebody(model, 5);
        let before = face.code();
        let most = between(attribute, 1.0);
        for value in [most + 0.01, f64::NAN, f64::NEG_INFINITY] {
            let given = face.set_attributes(&[(attribute.name.clone(), value)]);
            assert!(matches!(given, Err(Error::Value { .. })), "{value}");
        }
        let unknown = face.set_attributes(&[("no such".into(), 1.0)]);
        assert!(matches!(unknown, Err(Error::Unknown { .. })));
        assert_eq!(face.code(), before);
    }
}
