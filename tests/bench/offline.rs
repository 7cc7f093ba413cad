//! The offline half of phiz at the work that its peers do, one piece at a time.
//!
//!     offline MODEL DIR
//!
//! writes what is worked on to DIR, numbers of a kind one after the other, f64 or u32. Then it takes a
//! task a line from its input (`closest`, `pca`, `rbf`), does it on one thread, writes what comes out
//! to DIR/TASK.f64, and answers with the seconds that it took. `offline.py` asks, between its peers.

use std::collections::BTreeMap;
use std::hint::black_box;
use std::io::{BufRead, Write};
use std::path::Path;
use std::time::Instant;

use glam::DVec3;
use phiz::fit::mesh::surface::Surface;
use phiz::fit::register::warp::{Kernel, Warp};
use phiz::fit::statistics::pca::Spectrum;
use phiz::{Face, FaceModel, Randomize};

type Failure = Box<dyn std::error::Error>;

/// As many faces as the design's measurement of a PCA has.
const FACES: u64 = 200;

fn person(model: &FaceModel, seed: u64) -> Result<Face, Failure> {
    let mut face = model.face();
    face.randomize(&Randomize {
        seed: Some(seed),
        ..Randomize::default()
    })?;
    Ok(face)
}

fn places(face: &Face) -> Vec<DVec3> {
    face.positions().iter().map(|p| p.as_dvec3()).collect()
}

fn save(folder: &Path, name: &str, numbers: impl IntoIterator<Item = f64>) -> std::io::Result<()> {
    let bytes: Vec<u8> = numbers.into_iter().flat_map(f64::to_le_bytes).collect();
    std::fs::write(folder.join(name), bytes)
}

fn flat(points: &[DVec3]) -> impl Iterator<Item = f64> {
    points.iter().flat_map(|p| p.to_array())
}

/// Each triangle in four, at the middles of its sides.
fn split(positions: &[DVec3], triangles: &[[u32; 3]]) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut positions = positions.to_vec();
    let mut middles = BTreeMap::new();
    let mut finer = Vec::with_capacity(4 * triangles.len());
    for &[a, b, c] in triangles {
        let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|[from, to]| {
            *middles
                .entry([from.min(to), from.max(to)])
                .or_insert_with(|| {
                    positions.push((positions[from as usize] + positions[to as usize]) / 2.0);
                    positions.len() as u32 - 1
                })
        });
        finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    (positions, finer)
}

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [model, folder] = &arguments[..] else {
        // Whoever runs all benches (cargo does) asks for nothing of this one.
        println!("usage: offline MODEL DIR");
        return Ok(());
    };
    rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build_global()?;
    let model = FaceModel::parse(&std::fs::read(model)?)?;
    let folder = Path::new(folder);

    // A surface of 105,000 triangles, and another person's vertices to find their places on it.
    let first = places(&person(&model, 1)?);
    let topology = &model.parts().topology;
    let all = topology.triangles();
    let skin = topology
        .parts
        .iter()
        .find(|p| p.name == "skin")
        .ok_or("the model has no skin")?;
    let skin = &all[skin.first as usize..(skin.first + skin.count) as usize];
    let (surface, triangles) = split(&first, skin);
    let queries = places(&person(&model, 2)?);
    save(folder, "surface", flat(&surface))?;
    let corners = triangles
        .as_flattened()
        .iter()
        .flat_map(|v| v.to_le_bytes());
    std::fs::write(folder.join("triangles"), corners.collect::<Vec<u8>>())?;
    save(folder, "queries", flat(&queries))?;

    let people: Vec<Vec<f64>> = (0..FACES)
        .map(|seed| Ok(flat(&places(&person(&model, seed)?)).collect()))
        .collect::<Result<_, Failure>>()?;
    save(folder, "faces", people.iter().flatten().copied())?;

    let landmarks = |points: &Face| -> Vec<DVec3> {
        let all = model.parts().landmarks.iter();
        let ibug = all.filter(|l| l.name.starts_with("ibug_"));
        ibug.map(|l| l.place(points.positions())).collect()
    };
    let from = landmarks(&person(&model, 1)?);
    let to = landmarks(&person(&model, 2)?);
    save(folder, "from", flat(&from))?;
    save(folder, "to", flat(&to))?;
    save(folder, "head", flat(&first))?;

    println!("ready");
    for line in std::io::stdin().lock().lines() {
        let task = line?;
        let (seconds, out) = match task.as_str() {
            "closest" => {
                let started = Instant::now();
                let surface = Surface::new(&surface, &triangles);
                let found: Vec<f64> = (queries.iter())
                    .map(|&q| {
                        surface
                            .closest(q, f64::INFINITY)
                            .map_or(f64::NAN, |h| h.distance)
                    })
                    .collect();
                (started.elapsed(), found)
            }
            "pca" => {
                let samples = people.clone();
                let started = Instant::now();
                let spectrum = Spectrum::of(samples)?;
                let pca = black_box(spectrum.truncate(FACES as usize - 1));
                (started.elapsed(), pca.eigenvalues)
            }
            "rbf" => {
                let started = Instant::now();
                let warp = Warp::fit(&from, &to, Kernel::Biharmonic, 0.0)?;
                let warped = warp.apply_all(&first);
                (started.elapsed(), flat(&warped).collect())
            }
            _ => return Err(format!("there is no task \"{task}\"").into()),
        };
        save(folder, &format!("{task}.f64"), out)?;
        println!("{}", seconds.as_secs_f64());
        std::io::stdout().flush()?;
    }
    Ok(())
}
