//! Faces from the points of photos.

use std::sync::LazyLock;

use glam::{DVec2, DVec3};
use phiz::photo::{Camera, Fit, Fitter, POINTS, Photo};
use phiz::{Expressions, Face, Performance, Random};

use crate::common::{self, person};

static FITTER: LazyLock<Fitter> =
    LazyLock::new(|| Fitter::new(common::head_model(), None).expect("is a model of people"));

static EXPRESSIONS: LazyLock<Expressions> = LazyLock::new(|| {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/www/public/expressions.phiz");
    Expressions::parse(&std::fs::read(path).unwrap(), common::head_model()).unwrap()
});

const SIZE: [u32; 2] = [640, 480];

fn camera(angles: [f64; 3]) -> Camera {
    Camera {
        rotation: Camera::turned(angles),
        translation: DVec3::new(10.0, -15.0, 700.0),
        focal: 900.0,
        centre: DVec2::new(320.0, 240.0),
    }
}

/// The 68 landmarks of a face as a camera sees them, whatever hides them.
fn seen(positions: &[glam::Vec3], camera: &Camera) -> Vec<[f64; 2]> {
    let landmarks = &common::head_model().parts().landmarks;
    (0..POINTS)
        .map(|i| {
            let name = format!("ibug_{i:02}");
            let landmark = landmarks.iter().find(|l| l.name == name).unwrap();
            camera.project(landmark.place(positions)).to_array()
        })
        .collect()
}

fn noisy(points: &[[f64; 2]], sigma: f64, seed: u64) -> Vec<[f64; 2]> {
    let mut random = Random::new(seed);
    let each = points.iter();
    each.map(|p| p.map(|x| x + sigma * random.normal()))
        .collect()
}

fn photo(points: &[[f64; 2]]) -> Photo<'_> {
    Photo {
        width: SIZE[0],
        height: SIZE[1],
        points,
        focal: None,
        noise: None,
        jaw: None,
        irises: None,
        others: &[],
        image: None,
    }
}

/// Points that a face of the model has exactly, outline and all: those of a fit.
fn exact(seed: u64) -> (Vec<[f64; 2]>, Fit) {
    let given = seen(person(seed).positions(), &camera([0.3, 0.1, -0.1]));
    let fit = FITTER.fit(&photo(&given)).unwrap();
    let moved = given.iter().zip(&fit.residuals);
    let points = moved.map(|(p, r)| (DVec2::from_array(*p) + *r).to_array());
    (points.collect(), fit)
}

#[test]
fn points_without_noise_are_met() {
    for seed in 1..6 {
        let (points, _) = exact(seed);
        let noise = 0.01;
        let fit = FITTER.fit(&Photo {
            noise: Some(noise),
            ..photo(&points)
        });
        let fit = fit.unwrap();
        // The prior pulls, so that they are met within the noise that they are said to have.
        assert!(fit.quality.rms_px < 2.0 * noise, "{:?}", fit.quality);
        assert_eq!(fit.quality.refusal(), None);
    }
}

#[test]
fn a_face_and_its_camera_come_back() {
    let mut off = Vec::new();
    for seed in 1..9 {
        let angles = [0.08 * seed as f64 - 0.35, 0.1, 0.02 * seed as f64];
        let (face, camera) = (person(seed), camera(angles));
        let points = noisy(&seen(face.positions(), &camera), 0.5, seed);
        let fit = FITTER.fit(&photo(&points)).unwrap();
        let turn = fit.camera.rotation * camera.rotation.transpose();
        let turn = glam::DQuat::from_mat3(&turn).to_scaled_axis().length();
        // The same noise at the face is 0.4 mm; over 120 mm that is a fifth of a degree, and what
        // is unknown of the shape some times that.
        assert!(turn.to_degrees() < 5.0, "{seed}: {turn}");
        let mut fitted = person(seed);
        fitted.set_coefficients(&fit.coefficients).unwrap();
        assert_eq!(fitted.coefficients(), fit.coefficients, "on the grid");
        assert_eq!(fitted.code(), fit.code);
        let again = seen(fitted.positions(), &fit.camera);
        for i in 17..POINTS {
            let there = DVec2::from_array(points[i]) + fit.residuals[i];
            // Positions of a face are f32, their coefficients on a grid.
            assert!(there.distance(DVec2::from_array(again[i])) < 0.01, "{i}");
        }
        off.push(turn);
        assert_eq!(fit.quality.refusal(), None, "{:?}", fit.quality);
    }
    off.sort_by(f64::total_cmp);
    assert!(off[4].to_degrees() < 2.5, "{off:?}");
}

/// A person from the front and from the side, marked as people mark: 0.75 mm off.
fn two_views(seed: u64) -> [Vec<[f64; 2]>; 2] {
    [[0.05, 0.05, 0.0], [0.65, 0.0, 0.05]].map(|angles| {
        let own = seed + (1000.0 * angles[0]) as u64;
        noisy(&seen(person(seed).positions(), &camera(angles)), 1.0, own)
    })
}

/// How far the fitted face's vertices are from a person's, as the model has both, mm.
fn apart(seed: u64, fit: &Fit) -> f64 {
    let mut fitted = person(seed);
    fitted.set_coefficients(&fit.coefficients).unwrap();
    let truth = person(seed);
    let both = fitted.positions().iter().zip(truth.positions());
    both.map(|(p, q)| f64::from(p.distance(*q))).sum::<f64>() / truth.positions().len() as f64
}

#[test]
fn two_photos_of_a_person_tell_more_than_each() {
    let mut off = [0.0; 3];
    for seed in 1..13 {
        let [front, side] = two_views(seed);
        let others = [photo(&side)];
        let both = FITTER.fit(&Photo {
            others: &others,
            ..photo(&front)
        });
        let fits = [FITTER.fit(&photo(&front)), FITTER.fit(&photo(&side)), both];
        for (sum, fit) in off.iter_mut().zip(fits) {
            let fit = fit.unwrap();
            assert_eq!(fit.quality.refusal(), None, "{:?}", fit.quality);
            *sum += apart(seed, &fit) / 12.0;
        }
    }
    println!(
        "mm off from the front {:.3}, from the side {:.3}, from both {:.3}",
        off[0], off[1], off[2]
    );
    assert!(off[2] < 0.9 * off[0].min(off[1]), "{off:?}");
}

/// Who smiles in one photo and not in the other has one face at rest.
#[test]
fn each_photo_of_a_person_has_an_expression_of_its_own() {
    let fitter = Fitter::new(common::head_model(), Some(&EXPRESSIONS)).unwrap();
    let list = EXPRESSIONS.list();
    let weight = |fit: &Fit, name: &str| {
        let at = list.iter().position(|e| e.name == name).unwrap();
        fit.expression[at]
    };
    let mut off = [0.0; 2];
    for seed in 1..7 {
        let [front, _] = two_views(seed);
        let face = person(seed);
        let mut performance = Performance::new(&EXPRESSIONS);
        performance.set("mouthSmileLeft", 0.6).unwrap();
        performance.set("mouthSmileRight", 0.6).unwrap();
        performance.perform(&face).unwrap();
        let side = seen(performance.positions(), &camera([0.6, 0.0, 0.05]));
        let side = noisy(&side, 1.0, seed);
        let [rest, smiling] = [(&front, &side), (&side, &front)].map(|(one, other)| {
            let others = [photo(other)];
            fitter
                .fit(&Photo {
                    others: &others,
                    ..photo(one)
                })
                .unwrap()
        });
        assert!(weight(&smiling, "mouthSmileLeft") > weight(&rest, "mouthSmileLeft") + 0.2);
        off[0] += apart(seed, &fitter.fit(&photo(&front)).unwrap());
        off[1] += apart(seed, &rest);
    }
    println!(
        "mm off from the front {:.3}, with a smile from the side {:.3}",
        off[0] / 6.0,
        off[1] / 6.0
    );
    assert!(off[1] < 0.9 * off[0], "{off:?}");
}

/// Whichever of the photos is asked for, the face is one.
#[test]
fn photos_of_a_person_agree_on_the_face() {
    for seed in 1..5 {
        let [front, side] = two_views(seed);
        let [a, b] = [(&front, &side), (&side, &front)].map(|(one, other)| {
            let others = [photo(other)];
            FITTER
                .fit(&Photo {
                    others: &others,
                    ..photo(one)
                })
                .unwrap()
        });
        let alone = FITTER.fit(&photo(&front)).unwrap();
        let far = |a: &Fit, b: &Fit| {
            let both = a.coefficients.iter().zip(&b.coefficients);
            both.map(|(a, b)| f64::from((a - b).powi(2)))
                .sum::<f64>()
                .sqrt()
        };
        println!("{seed}: {:.4} of {:.4}", far(&a, &b), far(&a, &alone));
        assert!(far(&a, &b) < 0.02 * far(&a, &alone));
    }
}

#[test]
fn the_size_of_the_image_does_not_matter() {
    let points = noisy(
        &seen(person(3).positions(), &camera([0.4, 0.0, 0.1])),
        1.0,
        3,
    );
    let fit = FITTER.fit(&photo(&points)).unwrap();
    let doubled: Vec<[f64; 2]> = points.iter().map(|p| p.map(|x| 2.0 * x)).collect();
    let large = FITTER.fit(&Photo {
        width: 2 * SIZE[0],
        height: 2 * SIZE[1],
        ..photo(&doubled)
    });
    let large = large.unwrap();
    // Rounding, and steps that end a little sooner or later.
    assert!((large.camera.focal / fit.camera.focal - 2.0).abs() < 1e-6);
    let apart = large.coefficients.iter().zip(&fit.coefficients);
    assert!(apart.fold(0.0, |m: f32, (a, b)| m.max((a - b).abs())) < 1e-3);
}

#[test]
fn nothing_is_left_of_an_earlier_fit() {
    let points = |seed| {
        noisy(
            &seen(person(seed).positions(), &camera([0.2; 3])),
            1.0,
            seed,
        )
    };
    let (one, other) = (points(1), points(2));
    let first = FITTER.fit(&photo(&one)).unwrap();
    let between = FITTER.fit(&photo(&other)).unwrap();
    assert_ne!(first, between);
    assert_eq!(first, FITTER.fit(&photo(&one)).unwrap());
    let fresh = Fitter::new(common::head_model(), None).unwrap();
    assert_eq!(first, fresh.fit(&photo(&one)).unwrap());
}

#[test]
fn a_jaw_that_is_known_to_be_badly_marked_moves_the_face_less() {
    let fitted = |points: &[[f64; 2]], jaw| {
        let given = Photo {
            jaw,
            ..photo(points)
        };
        FITTER.fit(&given).unwrap().coefficients
    };
    // How far a face goes, sigmas, when its outline is marked 6 px, 4.7 mm, farther out.
    let moved = |seed, jaw| {
        let points = seen(person(seed).positions(), &camera([0.1, 0.05, 0.0]));
        let points = noisy(&points, 0.5, seed);
        let mut wrong = points.clone();
        let middle = DVec2::from_array(points[30]);
        for point in &mut wrong[..17] {
            let out = DVec2::from_array(*point) - middle;
            *point = (DVec2::from_array(*point) + 6.0 * out.normalize()).to_array();
        }
        let (right, wrong) = (fitted(&points, jaw), fitted(&wrong, jaw));
        let squares = right.iter().zip(&wrong).map(|(a, b)| (a - b) * (a - b));
        squares.sum::<f32>().sqrt()
    };
    let sum = |jaw| -> f32 { (1..9).map(|seed| moved(seed, jaw)).sum() };
    let moved = [None, Some(6.0), Some(24.0)].map(sum);
    assert!(moved.is_sorted_by(|a, b| a > b), "{moved:?}");
    // An outline that may be off by 19 mm says next to nothing; what is left goes along it, from the tip of
    // the nose.
    assert!(moved[2] < 0.5 * moved[0], "{moved:?}");
}

#[test]
fn one_point_that_is_wrong_costs_little() {
    let points = seen(person(5).positions(), &camera([0.2, 0.1, 0.0]));
    let points = noisy(&points, 1.0, 5);
    let fit = FITTER.fit(&photo(&points)).unwrap();
    let mut wrong = points.clone();
    wrong[30][1] += 25.0;
    let other = FITTER.fit(&photo(&wrong)).unwrap();
    // The nose's tip is believed by what is left of it, not by 20 mm.
    assert!(other.residuals[30].length() > 20.0);
    let moved = |i: usize| {
        let there =
            |fit: &Fit, points: &[[f64; 2]]| DVec2::from_array(points[i]) + fit.residuals[i];
        there(&fit, &points).distance(there(&other, &wrong))
    };
    assert!((36..POINTS).all(|i| moved(i) < 3.0));
}

#[test]
fn a_known_focal_length_is_kept_and_tells_the_distance() {
    let points = noisy(&seen(person(6).positions(), &camera([0.1; 3])), 0.5, 6);
    let fit = |focal| {
        let given = Photo {
            focal: Some(focal),
            ..photo(&points)
        };
        FITTER.fit(&given).unwrap().camera
    };
    let (near, far) = (fit(500.0), fit(1800.0));
    // It is known to 3 %, and the points speak against it.
    assert!((near.focal / 500.0).ln().abs() < 0.15, "{}", near.focal);
    assert!((far.focal / 1800.0).ln().abs() < 0.15, "{}", far.focal);
    assert!(far.translation.z > 2.0 * near.translation.z);
}

#[test]
fn an_open_mouth_is_an_expression_and_not_a_face() {
    let fitter = Fitter::new(common::head_model(), Some(&EXPRESSIONS)).unwrap();
    let jaw = EXPRESSIONS.find("jawOpen").unwrap();
    let mut performance = Performance::new(&EXPRESSIONS);
    performance.set("jawOpen", 0.7).unwrap();
    for seed in 1..5 {
        let face = person(seed);
        performance.perform(&face).unwrap();
        let points = noisy(
            &seen(performance.positions(), &camera([0.2, 0.0, 0.1])),
            0.5,
            seed,
        );
        let with = fitter.fit(&photo(&points)).unwrap();
        let without = FITTER.fit(&photo(&points)).unwrap();
        assert!(
            (0.45..0.95).contains(&with.expression[jaw]),
            "{}",
            with.expression[jaw]
        );
        assert!(with.expression.iter().all(|w| (0.0..=1.0).contains(w)));
        assert!(with.quality.rms_px < without.quality.rms_px);
        assert!(with.quality.unusual < without.quality.unusual);
        assert!(without.expression.is_empty());
    }
    // Of a face at rest little is taken for an expression.
    let points = noisy(
        &seen(person(7).positions(), &camera([0.2, 0.0, 0.1])),
        0.5,
        7,
    );
    let rest = fitter.fit(&photo(&points)).unwrap();
    assert!(rest.expression[jaw] < 0.15, "{:?}", rest.expression);
}

#[test]
fn faces_at_rest_show_next_to_no_expressions() {
    let fitter = Fitter::new(common::head_model(), Some(&EXPRESSIONS)).unwrap();
    let (mut shown, mut sum) = (0, 0.0);
    let people = 12;
    for seed in 0..people {
        let turn = 0.06 * seed as f64 - 0.3;
        let points = seen(person(seed).positions(), &camera([turn, 0.1, 0.0]));
        let fit = fitter.fit(&photo(&noisy(&points, 1.0, seed))).unwrap();
        shown += fit.expression.iter().filter(|w| **w > 0.05).count();
        sum += fit.expression.iter().sum::<f64>();
    }
    // Of 50 people of ICT-FaceKit one each is shown, 0.16 in all; a half-normal prior shows sixteen, 2.4
    // in all.
    assert!(shown as f64 <= 2.0 * people as f64, "{shown}");
    assert!(sum <= 0.4 * people as f64, "{sum}");
}

/// The middles of the borders of the irises of the subject's right and left eye: where 28 degrees from ahead the vertices of
/// eyeballs at rest are, wherever these have gone.
fn irises(rest: &[glam::Vec3], performed: &[glam::Vec3], camera: &Camera) -> [[f64; 2]; 2] {
    ["right eyeball", "left eyeball"].map(|part| {
        let topology = &common::head_model().parts().topology;
        let ball: Vec<usize> = (topology.part_vertices(part).iter())
            .map(|&v| v as usize)
            .collect();
        let all = |of: fn(glam::Vec3, glam::Vec3) -> glam::Vec3| {
            ball.iter().map(|&v| rest[v]).reduce(of).unwrap()
        };
        let (low, high) = (all(glam::Vec3::min), all(glam::Vec3::max));
        let radius = (high.x - low.x) / 2.0;
        let middle = glam::Vec3::new(
            (low.x + high.x) / 2.0,
            (low.y + high.y) / 2.0,
            high.z - radius,
        );
        let border: Vec<DVec3> = (ball.iter())
            .filter(|&&v| {
                ((rest[v] - middle).angle_between(glam::Vec3::Z).to_degrees() - 28.0).abs() < 2.0
            })
            .map(|&v| performed[v].as_dvec3())
            .collect();
        camera
            .project(border.iter().sum::<DVec3>() / border.len() as f64)
            .to_array()
    })
}

/// What expressions show, of those that turn eyes to a side: to the subject's left is above 0.
fn looking(fit: &Fit) -> [f64; 2] {
    let weight = |name: &str| fit.expression[EXPRESSIONS.find(name).unwrap()];
    [
        weight("eyeLookInRight") - weight("eyeLookOutRight"),
        weight("eyeLookOutLeft") - weight("eyeLookInLeft"),
    ]
}

#[test]
fn eyes_look_where_irises_are() {
    let fitter = Fitter::new(common::head_model(), Some(&EXPRESSIONS)).unwrap();
    let (mut off, mut without) = (0.0, 0.0);
    let people = 12;
    for seed in 0..people {
        let aside = [-0.9, -0.5, 0.4, 0.8][seed as usize % 4];
        let camera = camera([0.1 * seed as f64 - 0.55, 0.1, 0.05]);
        let face = person(seed);
        let mut performance = Performance::new(&EXPRESSIONS);
        let names = match aside > 0.0 {
            true => ["eyeLookInRight", "eyeLookOutLeft"],
            false => ["eyeLookOutRight", "eyeLookInLeft"],
        };
        for name in names {
            performance.set(name, f64::abs(aside)).unwrap();
        }
        performance.perform(&face).unwrap();
        let points = noisy(&seen(performance.positions(), &camera), 0.5, seed);
        let irises = irises(face.positions(), performance.positions(), &camera);
        let fit = fitter.fit(&Photo {
            irises: Some(irises),
            ..photo(&points)
        });
        let told = looking(&fit.unwrap());
        // Both eyes look the same way; either turns as far as it goes there.
        assert!((told[0] - told[1]).abs() < 0.05, "{told:?}");
        off += ((told[0] + told[1]) / 2.0 - aside).abs();
        let blind = looking(&fitter.fit(&photo(&points)).unwrap());
        without += ((blind[0] + blind[1]) / 2.0 - aside).abs();
    }
    let [off, without] = [off, without].map(|sum| sum / people as f64);
    // An eyeball's middle lies 14 mm behind what points tell, and is fitted to a mm or so: some degrees of the 16 that eyes
    // turn at most.
    assert!(off < 0.15 && without > 0.5, "{off}, {without}");
}

#[test]
fn irises_of_eyes_that_tell_nothing_turn_none() {
    let fitter = Fitter::new(common::head_model(), Some(&EXPRESSIONS)).unwrap();
    let camera = camera([0.2, 0.0, 0.0]);
    let face = person(3);
    let mut performance = Performance::new(&EXPRESSIONS);
    let mut fit = |blink: f64, apart: f64| {
        for name in ["eyeBlinkLeft", "eyeBlinkRight"] {
            performance.set(name, blink).unwrap();
        }
        performance.perform(&face).unwrap();
        let points = seen(performance.positions(), &camera);
        let mut irises = irises(face.positions(), performance.positions(), &camera);
        // Both to the subject's left, and one of them back to the right.
        irises[0][0] += 4.0 - apart;
        irises[1][0] += 4.0;
        let fit = |irises| {
            let given = Photo {
                irises,
                ..photo(&points)
            };
            fitter.fit(&given).unwrap()
        };
        (fit(Some(irises)), fit(None))
    };
    let (open, _) = fit(0.0, 0.0);
    assert!(looking(&open)[1] > 0.1, "{:?}", looking(&open));
    for (blink, apart) in [(1.0, 0.0), (0.0, 9.0)] {
        let (with, without) = fit(blink, apart);
        assert_eq!(with, without, "{blink}, {apart}");
    }
    // Wherever they are said to be eyes turn no farther than they go.
    let points = seen(face.positions(), &camera);
    for at in [0.0, -1e9, 1e9, 1e300] {
        let fit = fitter.fit(&Photo {
            irises: Some([[at; 2]; 2]),
            ..photo(&points)
        });
        let weights = fit.unwrap().expression;
        assert!(
            weights.iter().all(|w| (0.0..=1.0).contains(w)),
            "{at}: {weights:?}"
        );
    }
    // Without expressions eyes do not turn.
    let given = Photo {
        irises: Some(irises(face.positions(), face.positions(), &camera)),
        ..photo(&points)
    };
    assert_eq!(
        FITTER.fit(&given).unwrap(),
        FITTER.fit(&photo(&points)).unwrap()
    );
}

#[test]
fn what_is_no_face_is_refused_in_a_sentence() {
    let points = seen(person(1).positions(), &camera([0.2, 0.1, 0.0]));
    let refused = |points: &[[f64; 2]]| FITTER.fit(&photo(points)).unwrap().quality.refusal();
    assert_eq!(refused(&points), None);
    let mut random = Random::new(9);
    let anywhere: Vec<[f64; 2]> = (0..POINTS)
        .map(|_| [random.uniform() * 640.0, random.uniform() * 480.0])
        .collect();
    assert!(refused(&anywhere).is_some());
    // The points in another scheme's order.
    let mut backwards = points.clone();
    backwards.reverse();
    assert!(refused(&backwards).is_some());
    // A mirror image whose points were not renamed.
    let mirrored: Vec<[f64; 2]> = points.iter().map(|p| [640.0 - p[0], p[1]]).collect();
    assert!(refused(&mirrored).is_some());
}

#[test]
fn whatever_is_given_the_answer_is_finite() {
    let good = seen(person(2).positions(), &camera([0.2, 0.1, 0.0]));
    let mut random = Random::new(11);
    let (mut fits, mut errors) = (0, 0);
    for case in 0..200 {
        // From a little noise to nothing but noise, over images of a pixel and of a million.
        let noise = 10_f64.powf(3.5 * random.uniform() - 1.0);
        let flat = if case % 3 == 0 { random.uniform() } else { 1.0 };
        let size = 10_f64.powf(7.0 * random.uniform() - 3.0);
        let points: Vec<[f64; 2]> = (good.iter())
            .map(|p| {
                let [x, y] = p.map(|x| (x + noise * random.normal()).clamp(-900.0, 1400.0));
                [x * size, y * flat * size]
            })
            .collect();
        let given = Photo {
            width: (640.0 * size).ceil() as u32,
            height: (480.0 * size).ceil() as u32,
            points: &points,
            focal: (case % 5 == 0).then(|| 10_f64.powf(8.0 * random.uniform() - 2.0)),
            noise: (case % 7 == 0).then(|| 10_f64.powf(12.0 * random.uniform() - 6.0)),
            jaw: (case % 3 == 0).then(|| 10_f64.powf(12.0 * random.uniform() - 6.0)),
            irises: None,
            others: &[],
            image: None,
        };
        let Ok(fit) = FITTER.fit(&given) else {
            errors += 1;
            continue;
        };
        fits += 1;
        assert!(fit.coefficients.iter().all(|c| c.abs() <= 255.0), "{case}");
        assert!(
            fit.camera.focal.is_finite() && fit.camera.focal > 0.0,
            "{case}"
        );
        assert!(fit.camera.translation.is_finite(), "{case}");
        assert!(
            (fit.camera.rotation.determinant() - 1.0).abs() < 1e-9,
            "{case}"
        );
        assert!(fit.residuals.iter().all(|r| r.is_finite()), "{case}");
        assert!(person(1).set_code(&fit.code).is_ok(), "{case}");
    }
    assert!(fits > 100, "{fits} fits, {errors} errors");
}

#[test]
fn bad_input_is_an_error_with_a_reason() {
    let good = seen(person(1).positions(), &camera([0.2, 0.1, 0.0]));
    let error = |photo: &Photo| FITTER.fit(photo).unwrap_err().to_string();
    let with = |point: [f64; 2]| {
        let mut points = good.clone();
        points[40] = point;
        error(&photo(&points))
    };
    assert_eq!(
        error(&photo(&good[1..])),
        "67 points were given, a face has 68"
    );
    assert_eq!(
        with([f64::NAN, 3.0]),
        "a point's coordinate must be from -1280 to 1920 px, not NaN"
    );
    assert_eq!(
        with([3.0, f64::INFINITY]),
        "a point's coordinate must be from -960 to 1440 px, not inf"
    );
    assert!(with([-2000.0, 3.0]).contains("from -1280 to 1920 px"));
    let line = "the points lie on a line: they are no face's";
    assert_eq!(error(&photo(&[[5.0, 5.0]; POINTS])), line);
    let diagonal: Vec<[f64; 2]> = (0..POINTS).map(|i| [i as f64, 2.0 * i as f64]).collect();
    assert_eq!(error(&photo(&diagonal)), line);
    // Of another photo, too.
    let others = [photo(&good), photo(&good[1..])];
    let besides = error(&Photo {
        others: &others,
        ..photo(&good)
    });
    assert_eq!(besides, "67 points were given, a face has 68");
    let empty = Photo {
        width: 0,
        ..photo(&good)
    };
    assert_eq!(error(&empty), "a photo of 0 x 480 pixels is none");
    for focal in [0.0, -5.0, f64::NAN] {
        let given = Photo {
            focal: Some(focal),
            ..photo(&good)
        };
        assert!(error(&given).starts_with("the focal length must be above 0 px"));
    }
    let given = Photo {
        irises: Some([[300.0, 200.0], [340.0, f64::INFINITY]]),
        ..photo(&good)
    };
    assert_eq!(
        error(&given),
        "an iris's coordinate must be a number, not inf"
    );
    let head = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/www/public/head.phiz"));
    let head = phiz::FaceModel::parse(&head.unwrap()).unwrap();
    let error = Fitter::new(&head, None).unwrap_err().to_string();
    assert_eq!(
        error,
        "a photo needs a model of people, and this is one head"
    );
}

/// People of ICT-FaceKit that the model was not learned from.
#[cfg(feature = "fit")]
mod truth {
    use super::*;
    use crate::{heads, ict};

    use phiz::fit::register::Settings;
    use phiz::fit::scan::Scan;
    use phiz::fit::truth::photograph::{Photographer, Report, SETTINGS, SIZE};
    use phiz::fit::truth::portrait::Portrait;
    use phiz::photo::Image;

    #[test]
    fn people_are_fitted_better_than_by_the_mean() {
        let (Some(ict), Some(registrar)) = (ict::ict(), heads::registrar()) else {
            return;
        };
        let template = heads::template().expect("is there with the registrar");
        let mean = Scan {
            positions: ict.neutral.clone(),
            triangles: ict.triangles.clone(),
            scale: 1.0,
            ..Scan::default()
        };
        let points: Vec<(usize, DVec3)> = (0..POINTS)
            .map(|i| {
                let name = format!("ibug_{i:02}");
                let place = template.landmarks.iter().position(|l| l.name == name);
                let vertex = ict.landmarks[i] as usize;
                (place.expect("is there"), ict.neutral[vertex])
            })
            .collect();
        let reference = registrar.register(&mean, &points, &Settings::default());
        let reference = reference.expect("registers").positions;
        let photographer = Photographer::new(template, &reference, ict).expect("has landmarks");
        let model = common::head_model();
        let mean: Vec<DVec3> = model.parts().mean.iter().map(|p| p.as_dvec3()).collect();
        for setting in &SETTINGS {
            let (mut people, mut nobody) = (Vec::new(), Vec::new());
            let (mut few, mut lit) = (0.0, 0.0);
            for seed in 9000..9020 {
                let taken = photographer.take(seed, setting);
                let fit = FITTER.fit(&Photo {
                    width: SIZE,
                    height: SIZE,
                    ..photo(&taken.points)
                });
                let fit = fit.expect("is a face");
                assert_eq!(fit.quality.refusal(), None, "{seed} {:?}", fit.quality);
                let mut face = model.face();
                face.set_coefficients(&fit.coefficients).expect("fit");
                let face: Vec<DVec3> = face.positions().iter().map(|p| p.as_dvec3()).collect();
                let rotation = fit.camera.rotation;
                let errors = photographer.measure(&taken, &face, rotation);
                if seed < 9006 {
                    let portrait = Portrait::take(&taken, ict, true);
                    let image = Image::new(SIZE, SIZE, &portrait.rgba).expect("is one");
                    let photo = Photo {
                        width: SIZE,
                        height: SIZE,
                        ..photo(&taken.points)
                    };
                    let fit = FITTER.fit_pixels(&photo, &image).expect("is a face");
                    let mut face = model.face();
                    face.set_coefficients(&fit.coefficients).expect("fit");
                    let face: Vec<DVec3> = face.positions().iter().map(|p| p.as_dvec3()).collect();
                    few += errors.similarity;
                    lit += photographer
                        .measure(&taken, &face, fit.camera.rotation)
                        .similarity;
                }
                people.push((seed, errors));
                nobody.push((seed, photographer.measure(&taken, &mean, rotation)));
            }
            let (ours, mean) = (Report::of(setting, people), Report::of(setting, nobody));
            // Of 50 people it is 0.82 to 0.86; six are few.
            assert!(lit < 0.97 * few, "{lit} {few}");
            // Of 50 people some 0.60 and 0.55.
            assert!(
                ours.rigid < 0.7 * mean.rigid,
                "{} {}",
                ours.rigid,
                mean.rigid
            );
            assert!(ours.similarity < 0.65 * mean.similarity);
            // Of 150 people it is within 1 %; that of one is off by 3.2 %.
            assert!((ours.size - 1.0).abs() < 0.01 + 2.0 * 0.032 / 20_f64.sqrt());
            assert!(ours.turn < 1.6, "{}", ours.turn);
        }
    }
}

/// Photos of faces of the model whose light is known.
mod light {
    use super::*;
    use phiz::photo::raster::{NOTHING, Raster};
    use phiz::photo::{Image, Light};

    fn to_srgb(x: f64) -> u8 {
        let x = x.clamp(0.0, 1.0);
        let y = match x <= 0.003_130_8 {
            true => 12.92 * x,
            false => 1.055 * x.powf(1.0 / 2.4) - 0.055,
        };
        (y * 255.0).round() as u8
    }

    fn from_srgb(byte: u8) -> f64 {
        let x = f64::from(byte) / 255.0;
        match x <= 0.04045 {
            true => x / 12.92,
            false => ((x + 0.055) / 1.055).powf(2.4),
        }
    }

    /// The cosine's first three degrees: what a light from a direction sends a matt surface.
    fn lambert(cosine: f64) -> f64 {
        0.25 + 0.5 * cosine + 0.3125 * (1.5 * cosine * cosine - 0.5)
    }

    /// Two coloured lights and what comes from everywhere.
    struct Lamps([(DVec3, DVec3); 2], DVec3);

    impl Lamps {
        fn new(random: &mut Random) -> Self {
            let mut colour = |least: f64, most: f64| {
                DVec3::from_array([0; 3].map(|_| least + (most - least) * random.uniform()))
            };
            let ambient = colour(0.3, 0.5);
            let lamps = [(); 2].map(|()| {
                let towards = colour(-1.0, 1.0) * DVec3::new(1.0, 0.6, 0.3) + DVec3::Z * 0.6;
                (towards.normalize(), colour(0.2, 0.7))
            });
            Self(lamps, ambient)
        }

        fn shade(&self, normal: DVec3) -> DVec3 {
            let lamps = self.0.iter();
            self.1
                + lamps
                    .map(|(d, c)| *c * lambert(normal.dot(*d)))
                    .sum::<DVec3>()
        }
    }

    /// A sum of waves of some lengths (mm) over the mean head, of standard deviation 1.
    fn waves(random: &mut Random, lengths: [f64; 2]) -> impl Fn(DVec3) -> f64 + use<> {
        let all: Vec<(DVec3, f64)> = (0..40)
            .map(|_| {
                let along = DVec3::from_array([0; 3].map(|_| random.normal())).normalize();
                let length = lengths[0] * (lengths[1] / lengths[0]).powf(random.uniform());
                let turn = std::f64::consts::TAU;
                (along * (turn / length), turn * random.uniform())
            })
            .collect();
        move |p| {
            let sum: f64 = all.iter().map(|(k, phase)| (p.dot(*k) + phase).cos()).sum();
            sum * (2.0 / all.len() as f64).sqrt()
        }
    }

    /// sRGB pixels of a face before grey. Its albedo is the model's, times 10 % in waves of 60 to 200 mm
    /// and 5 % in waves of 6 to 25; pixels have 3 % of noise.
    fn taken(face: &Face, camera: &Camera, lamps: &Lamps, plain: bool, seed: u64) -> Vec<u8> {
        let mut random = Random::stream(seed, 2);
        let parts = face.model().parts();
        let (low, high) = (
            waves(&mut random, [60.0, 200.0]),
            waves(&mut random, [6.0, 25.0]),
        );
        let amount = f64::from(u8::from(!plain));
        let sent: Vec<DVec3> = (parts.mean.iter().zip(face.normals()))
            .zip(&parts.topology.colours)
            .map(|((p, n), colour)| {
                let p = p.as_dvec3();
                let albedo = DVec3::from_array(colour.map(from_srgb));
                let stain = (amount * (0.1 * low(p) + 0.05 * high(p))).exp();
                albedo * lamps.shade(n.as_dvec3()) * stain
            })
            .collect();
        let positions: Vec<DVec3> = face.positions().iter().map(|p| p.as_dvec3()).collect();
        let triangles = parts.topology.triangles();
        let size = SIZE.map(|s| s as usize);
        let raster = Raster::new(camera, size, &positions, &triangles);
        let mut pixels = Vec::new();
        for &t in &raster.triangles {
            let light = match t {
                NOTHING => DVec3::splat(0.2),
                t => {
                    triangles[t as usize]
                        .iter()
                        .map(|&v| sent[v as usize])
                        .sum::<DVec3>()
                        / 3.0
                }
            };
            let noise = 1.0 + 0.03 * amount * random.normal();
            pixels.extend((light * noise).to_array().map(to_srgb));
            pixels.push(255);
        }
        pixels
    }

    /// The root mean square of what is wrong of the shading of the facial features' skin that looks to the
    /// camera, as a part of it. How bright skin is of itself cannot be told from how bright the light is, so that
    /// one factor is free.
    fn wrong(light: &Light, lamps: &Lamps, face: &Face, camera: &Camera) -> f64 {
        let normals = || {
            let skin = face.model().parts().topology.part_vertices("skin");
            let topology = &face.model().parts().topology;
            let head = topology
                .region_names
                .iter()
                .position(|n| n == "head")
                .unwrap();
            let all = skin.into_iter().map(|v| v as usize);
            let all = all.filter(move |&v| usize::from(topology.regions[v]) != head);
            let eye = camera.position();
            all.filter_map(move |v| {
                let n = face.normals()[v].as_dvec3();
                let towards = (eye - face.positions()[v].as_dvec3()).normalize();
                (n.dot(towards) > 0.3).then_some(n)
            })
        };
        let ratios = normals().map(|n| light.shade(n) / lamps.shade(n));
        let (count, sum) = ratios.fold((0.0, 0.0), |(c, s), r| (c + 3.0, s + r.element_sum()));
        let factor = sum / count;
        let off = normals().map(|n| light.shade(n) / lamps.shade(n) / factor - 1.0);
        (off.map(|o| o.length_squared()).sum::<f64>() / count).sqrt()
    }

    fn near(yaw: f64) -> Camera {
        Camera {
            translation: DVec3::new(0.0, 0.0, 600.0),
            ..camera([yaw, 0.1, 0.0])
        }
    }

    #[test]
    fn the_light_of_a_plain_face_is_found() {
        for seed in 1..4 {
            let lamps = Lamps::new(&mut Random::new(seed));
            let (face, camera) = (person(seed), near(0.3 * seed as f64 - 0.6));
            let pixels = taken(&face, &camera, &lamps, true, seed);
            let image = Image::new(SIZE[0], SIZE[1], &pixels).unwrap();
            let light = Light::of(&face, &camera, &image).unwrap();
            let wrong = wrong(&light, &lamps, &face, &camera);
            println!("{seed}: {wrong:.4}, residuals {:.4}", light.rms);
            // Pixels have the mean colour of a triangle and vertices take their mean.
            assert!(wrong < 0.02, "{wrong}");
        }
    }

    #[test]
    fn skin_that_is_stained_and_covered_tells_it_to_five_per_cent() {
        let mut all = Vec::new();
        for seed in 1..11 {
            let lamps = Lamps::new(&mut Random::new(seed));
            let camera = near(0.12 * seed as f64 - 0.66);
            let face = person(seed);
            let mut pixels = taken(&face, &camera, &lamps, false, seed);
            // Dark hair over the forehead and one cheek, and a bright pair of glasses.
            let points = seen(face.positions(), &camera);
            let [left, right] = [36, 45].map(|i: usize| DVec2::from_array(points[i]));
            let middle = (left + right) / 2.0;
            let unit = left.distance(right);
            for (i, pixel) in pixels.chunks_exact_mut(4).enumerate() {
                let x = (i % SIZE[0] as usize) as f64 - middle.x;
                let y = (i / SIZE[0] as usize) as f64 - middle.y;
                let hair = y < -0.65 * unit || (x < -0.75 * unit && y < 0.5 * unit);
                let glasses = y.abs() < 0.3 * unit && (x.abs() - 0.5 * unit).abs() < 0.08 * unit;
                match (hair, glasses) {
                    (true, _) => pixel[..3].copy_from_slice(&[30, 22, 18]),
                    (_, true) => pixel[..3].copy_from_slice(&[240, 240, 250]),
                    _ => {}
                }
            }
            let image = Image::new(SIZE[0], SIZE[1], &pixels).unwrap();
            // With the face that the points tell, as it will be used.
            let points = noisy(&points, 1.0, seed);
            let fit = FITTER.fit(&photo(&points)).unwrap();
            let mut fitted = person(seed);
            fitted.set_coefficients(&fit.coefficients).unwrap();
            let light = Light::of(&fitted, &fit.camera, &image).unwrap();
            all.push(wrong(&light, &lamps, &face, &camera));
        }
        println!("{all:.3?}");
        let rms = (all.iter().map(|w| w * w).sum::<f64>() / all.len() as f64).sqrt();
        assert!(rms < 0.05, "{rms}");
    }

    /// The mean distance of the facial features' vertices of a fit from the person's, their middles
    /// on each other, mm.
    fn off(fit: &Fit, truth: &Face) -> f64 {
        let mut fitted = truth.model().face();
        fitted.set_coefficients(&fit.coefficients).unwrap();
        let topology = &truth.model().parts().topology;
        let head = topology
            .region_names
            .iter()
            .position(|n| n == "head")
            .unwrap();
        let all = (0..topology.regions.len()).filter(|&v| usize::from(topology.regions[v]) != head);
        let by: Vec<DVec3> = all
            .map(|v| (fitted.positions()[v] - truth.positions()[v]).as_dvec3())
            .collect();
        let middle = by.iter().sum::<DVec3>() / by.len() as f64;
        by.iter().map(|d| (*d - middle).length()).sum::<f64>() / by.len() as f64
    }

    /// A person under lamps and their noisy points.
    fn sitting(seed: u64) -> (Face, Vec<[f64; 2]>, Vec<u8>) {
        let face = person(seed);
        let (points, pixels) = shot(&face, seed, 0.15 * seed as f64 - 0.5, seed);
        (face, points, pixels)
    }

    /// The noisy points and the pixels of a person of a seed who looks aside, under lamps of another. Stains are the
    /// person's.
    fn shot(face: &Face, seed: u64, yaw: f64, lamps: u64) -> (Vec<[f64; 2]>, Vec<u8>) {
        let camera = near(yaw);
        let points = noisy(&seen(face.positions(), &camera), 1.5, lamps);
        let lamps = Lamps::new(&mut Random::new(lamps));
        (points, taken(face, &camera, &lamps, false, seed))
    }

    fn with_pixels(points: &[[f64; 2]], pixels: &[u8]) -> Fit {
        let image = Image::new(SIZE[0], SIZE[1], pixels).unwrap();
        FITTER.fit_pixels(&photo(points), &image).unwrap()
    }

    #[test]
    fn pixels_tell_the_shape() {
        let (mut points_alone, mut both, mut covered) = (0.0, 0.0, [0.0; 5]);
        for seed in 1..7 {
            let (face, points, pixels) = sitting(seed);
            let first = FITTER.fit(&photo(&points)).unwrap();
            assert_eq!(first.appearance, None);
            let fit = with_pixels(&points, &pixels);
            let told = fit.appearance.expect("is lit");
            assert!(told.patches > 200 && told.rms < 0.1, "{told:?}");
            assert!(fit.quality.determined > first.quality.determined);
            points_alone += off(&first, &face);
            both += off(&fit, &face);
            assert_eq!(fit, with_pixels(&points, &pixels), "the same again");
            let at = |i: usize| DVec2::from_array(points[i]);
            let width = at(0).distance(at(16));
            let cheek = at(3).lerp(at(31), 0.5);
            let brow = at(19).lerp(at(24), 0.5);
            // A hand on one cheek, hair over the forehead and down the other, and a beard.
            let hand = |p: DVec2| ((p - cheek) / DVec2::new(0.18, 0.3) / width).length() < 1.0;
            let hair = |p: DVec2| {
                p.y < brow.y - 0.05 * width || (p.x > at(14).x - 0.1 * width && p.y < at(33).y)
            };
            let beard = |p: DVec2| p.y > at(33).y && (p - at(62)).length() > 0.28 * width;
            // Frames around both eyes and a bridge between them.
            let eyes = [[36, 39], [42, 45]].map(|[a, b]| at(a).lerp(at(b), 0.5));
            let size = DVec2::new(0.16, 0.12) * width;
            let rim = |p: DVec2, more: f64| {
                (eyes.iter()).any(|&eye| ((p - eye) / (size + more)).powf(4.0).element_sum() < 1.0)
            };
            let thick = 0.012 * width;
            let bridge = |p: DVec2| {
                (p.y - eyes[0].y).abs() < thick
                    && p.x > eyes[0].x + size.x
                    && p.x < eyes[1].x - size.x
            };
            let glasses = |p: DVec2| bridge(p) || rim(p, thick) && !rim(p, -thick);
            let strands = |p: DVec2| match (p.x / 2.0).sin() > 0.0 {
                true => [40, 28, 20],
                false => [84, 62, 46],
            };
            let cover = |is_covered: &dyn Fn(DVec2) -> bool, colour: &dyn Fn(DVec2) -> [u8; 3]| {
                let mut pixels = pixels.clone();
                for (i, pixel) in pixels.chunks_exact_mut(4).enumerate() {
                    let row = SIZE[0] as usize;
                    let here = DVec2::new((i % row) as f64, (i / row) as f64);
                    if is_covered(here) {
                        pixel[..3].copy_from_slice(&colour(here));
                    }
                }
                off(&with_pixels(&points, &pixels), &face)
            };
            covered[0] += cover(&hand, &|_| [90, 60, 45]);
            covered[1] += cover(&hair, &|_| [40, 28, 20]);
            covered[2] += cover(&beard, &|_| [55, 40, 32]);
            covered[3] += cover(&hair, &strands);
            covered[4] += cover(&glasses, &|_| [25, 25, 28]);
        }
        println!("{points_alone:.3} {both:.3} {covered:.3?}");
        // Of these six it is 0.84; 0.97 with the hand, 1.03 with hair and 1.04 with the beard.
        assert!(both < 0.9 * points_alone, "{both} {points_alone}");
        for covered in covered {
            assert!(covered < 1.1 * points_alone, "{covered} {points_alone}");
        }
        // What hair and glasses cover is not compared: it is 0.87 with strands and 0.88 with glasses, 0.97 and 1.01 when it is.
        for covered in &covered[3..] {
            assert!(*covered < 0.93 * points_alone, "{covered} {points_alone}");
        }
    }

    #[test]
    fn pixels_of_another_photo_tell_the_shape_too() {
        let (mut by_points, mut by_pixels, mut apart) = (0.0, 0.0, Vec::new());
        for seed in 1..9 {
            let (face, points, pixels) = sitting(seed);
            let (aside, beside) = shot(&face, seed, 0.5 - 0.13 * seed as f64, 100 + seed);
            let image = Image::new(SIZE[0], SIZE[1], &pixels).unwrap();
            let with = |rgba: Option<&[u8]>| {
                let image_of_other = rgba.map(|rgba| Image::new(SIZE[0], SIZE[1], rgba).unwrap());
                let others = [Photo {
                    image: image_of_other,
                    ..photo(&aside)
                }];
                let photo = Photo {
                    others: &others,
                    ..photo(&points)
                };
                let mut parts = vec![0.0];
                let fit = FITTER.fit_pixels_telling(&photo, &image, &mut |part| parts.push(part));
                assert!(parts.is_sorted() && parts.ends_with(&[1.0]), "{parts:?}");
                assert_eq!(
                    FITTER.fit(&photo).unwrap().appearance,
                    None,
                    "points alone are asked for"
                );
                fit.unwrap()
            };
            let (few, all) = (with(None), with(Some(&beside)));
            assert!(all.quality.determined > few.quality.determined + 3.0);
            by_points += off(&few, &face);
            by_pixels += off(&all, &face);
            // The other was taken so that this face has its points.
            let mut fitted = face.clone();
            fitted.set_coefficients(&all.coefficients).unwrap();
            let there = seen(fitted.positions(), &all.others[0].camera);
            let inner = aside.iter().zip(&there).skip(17);
            let squares = inner.map(|(a, b)| DVec2::from_array(*a).distance_squared((*b).into()));
            apart.push((squares.sum::<f64>() / 51.0).sqrt());
            // What tells nothing changes nothing.
            if seed == 1 {
                assert_eq!(with(Some(&vec![90; beside.len()])), few);
            }
        }
        println!("{by_points:.3} {by_pixels:.3} {apart:.2?}");
        // Of these eight it is 0.87.
        assert!(by_pixels < 0.95 * by_points, "{by_pixels} {by_points}");
        // No more than the points' noise; 3.0 px as the points of both told the other's pose.
        let mean = apart.iter().sum::<f64>() / apart.len() as f64;
        assert!(mean < 1.5 * 2_f64.sqrt(), "{mean}");
        let (_, points, pixels) = sitting(1);
        let image = Image::new(SIZE[0], SIZE[1], &pixels).unwrap();
        let others = [Photo {
            image: Image::new(SIZE[1], SIZE[0], &pixels).ok(),
            ..photo(&points)
        }];
        let photo = Photo {
            others: &others,
            ..photo(&points)
        };
        assert_eq!(
            FITTER.fit_pixels(&photo, &image).unwrap_err().to_string(),
            "the photo is 640 x 480 pixels, its image 480 x 640"
        );
    }

    #[test]
    fn pixels_that_tell_nothing_change_nothing() {
        let (_, points, pixels) = sitting(3);
        let alone = FITTER.fit(&photo(&points)).unwrap();
        for level in [0, 1, 128, 255] {
            let flat = vec![level; pixels.len()];
            assert_eq!(with_pixels(&points, &flat), alone, "{level}");
        }
        // No light that falls on a face: noise.
        let mut random = Random::new(8);
        let noise: Vec<u8> = pixels.iter().map(|_| random.bits() as u8).collect();
        let fit = with_pixels(&points, &noise);
        assert_eq!(fit.quality.refusal(), None);
        assert!(fit.quality.rms_px < 1.5 * alone.quality.rms_px);
        let image = Image::new(SIZE[1], SIZE[0], &pixels).unwrap();
        assert_eq!(
            FITTER
                .fit_pixels(&photo(&points), &image)
                .unwrap_err()
                .to_string(),
            "the photo is 640 x 480 pixels, its image 480 x 640"
        );
    }

    #[test]
    fn what_is_no_photo_of_a_face_is_an_error() {
        let error = |result: phiz::Result<Light>| result.unwrap_err().to_string();
        let bytes = [0; 64];
        assert_eq!(
            Image::new(4, 5, &bytes).unwrap_err().to_string(),
            "64 bytes are no photo of 4 x 5 pixels"
        );
        assert!(Image::new(0, 0, &[]).is_err());
        assert!(Image::new(u32::MAX, u32::MAX, &bytes).is_err());
        let image = Image::new(4, 4, &bytes).unwrap();
        let aside = Camera {
            translation: DVec3::new(5000.0, 0.0, 600.0),
            ..near(0.0)
        };
        let none = "no face is seen in the photo";
        assert_eq!(error(Light::of(&person(1), &aside, &image)), none);
        let behind = Camera {
            translation: DVec3::new(0.0, 0.0, -600.0),
            ..near(0.0)
        };
        assert_eq!(error(Light::of(&person(1), &behind, &image)), none);
    }
}
