//! Learning on the real generic head: seams, and the committed model made again.
#![cfg(feature = "fit")]

#[path = "common/base_mesh.rs"]
mod base_mesh;

use std::sync::LazyLock;
use std::time::Instant;

use glam::DVec3;
use phiz::blob::pack;
use phiz::fit::crease::seams;
use phiz::fit::learn::{Learned, Settings, learn};
use phiz::fit::pca::Pca;
use phiz::fit::template::Template;
use phiz::fit::validate::rounding;
use phiz::fit::{generic_head, population};
use phiz::quantise::BLOCK_ERROR;
use phiz::{FaceModel, Randomize};

/// As `./build.sh model` has them.
const COUNT: usize = 400;
const SEED: u64 = 1;

struct Trained {
    template: Template,
    learned: Learned,
    model: FaceModel,
}

/// The default model, learned once for all tests here.
static TRAINED: LazyLock<Option<Trained>> = LazyLock::new(|| {
    let folder = base_mesh::folder()?;
    let template = generic_head::build(&folder).unwrap();
    let people = population::sample(&template, &folder, COUNT, SEED).unwrap();
    let learned = learn(
        &template,
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
    let samples: Vec<Vec<f64>> = learned
        .aligned
        .iter()
        .map(|face| {
            face.iter()
                .zip(&mean)
                .flat_map(|(p, m)| (*p - *m).to_array())
                .collect()
        })
        .collect();
    let whole = Pca::learn(samples, 0.95).unwrap();
    let modes: Vec<Vec<DVec3>> = (whole.modes.iter().zip(&whole.sigmas))
        .map(|(mode, sigma)| {
            mode.chunks_exact(3)
                .map(|d| DVec3::from_slice(d) * *sigma)
                .collect()
        })
        .collect();
    let mut failed = false;
    for seam in seams(template, model, &modes).unwrap() {
        println!(
            "{:9} within {:2} mm: modes at 2 sigma {:5.1} deg, whole {:5.1}; random {:5.1}, whole \
             {:5.1}; {:.2} x; sharpest at {:.0?}",
            seam.feature,
            seam.width,
            seam.modes,
            seam.whole_modes,
            seam.random,
            seam.whole_random,
            seam.ratio(),
            seam.sharpest.to_array()
        );
        failed |= seam.ratio() > 1.2;
    }
    assert!(!failed, "a seam is sharper than 1.2 x a whole-face PCA");
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
    let faces = learned.aligned.len() as f64;
    let mean: Vec<DVec3> = (0..n)
        .map(|v| learned.aligned.iter().map(|f| f[v]).sum::<DVec3>() / faces)
        .collect();
    let rms = rounding(learned, &model).unwrap();
    let still = model.parts().mean.iter().zip(&mean);
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
    let width = |name: &str, face: &phiz::Face| face.measure(name).unwrap();
    for name in ["nose width", "mouth width", "face height"] {
        let trained: Vec<f64> = learned
            .coefficients
            .iter()
            .map(|row| {
                let mut face = model.face();
                let c: Vec<f32> = row.iter().map(|&c| c as f32).collect();
                face.set_coefficients(&c).unwrap();
                width(name, &face)
            })
            .collect();
        let drawn: Vec<f64> = (0..400)
            .map(|seed| {
                let mut face = model.face();
                face.randomize(&Randomize {
                    seed: Some(seed),
                    ..Default::default()
                })
                .unwrap();
                width(name, &face)
            })
            .collect();
        let moments = |v: &[f64]| {
            let mean = v.iter().sum::<f64>() / v.len() as f64;
            let sd = (v.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / v.len() as f64).sqrt();
            (mean, sd)
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
