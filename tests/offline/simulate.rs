//! Simulated scans: the same surface, and nothing else the same.

use std::collections::BTreeMap;

use glam::DVec3;
use phiz::fit::mesh::surface::Surface;
use phiz::fit::scan::Scan;
use phiz::fit::truth::simulate::{Settings, Simulator, Truth, write};

use crate::ict;

const CLEAN: Settings = Settings {
    noise: 0.0,
    jitter: 0.0,
    holes: false,
};

fn normal(p: &[DVec3], t: [u32; 3]) -> DVec3 {
    let [a, b, c] = t.map(|v| p[v as usize]);
    (b - a).cross(c - a).normalize_or_zero()
}

/// The triangles of each undirected edge; checks on the way that it is an oriented manifold.
fn edges(scan: &Scan) -> BTreeMap<(u32, u32), Vec<usize>> {
    let mut directed = BTreeMap::new();
    let mut edges: BTreeMap<_, Vec<usize>> = BTreeMap::new();
    for (t, &[a, b, c]) in scan.triangles.iter().enumerate() {
        assert!(a != b && b != c && c != a);
        for (a, b) in [(a, b), (b, c), (c, a)] {
            assert_eq!(directed.insert((a, b), t), None, "an edge twice one way");
            edges.entry((a.min(b), a.max(b))).or_default().push(t);
        }
    }
    edges
}

/// How many pairs of neighbouring triangles have normals over 120 degrees apart.
fn folds(scan: &Scan) -> usize {
    let normal = |t: usize| normal(&scan.positions, scan.triangles[t]);
    let pairs = edges(scan).into_values().filter(|t| t.len() == 2);
    pairs
        .filter(|t| normal(t[0]).dot(normal(t[1])) < -0.5)
        .count()
}

/// Every vertex is used, and its triangles are one fan.
fn one_fan_each(scan: &Scan) {
    let mut fans: Vec<Vec<[u32; 2]>> = vec![Vec::new(); scan.positions.len()];
    for &[a, b, c] in &scan.triangles {
        for (v, edge) in [(a, [b, c]), (b, [c, a]), (c, [a, b])] {
            fans[v as usize].push(edge);
        }
    }
    for fan in fans {
        let next: BTreeMap<u32, u32> = fan.iter().map(|e| (e[0], e[1])).collect();
        let ends: Vec<u32> = fan.iter().map(|e| e[1]).collect();
        let start = fan.iter().map(|e| e[0]).find(|v| !ends.contains(v));
        let mut at = start.unwrap_or_else(|| fan[0][0]);
        let mut steps = 0;
        while let Some(&to) = next.get(&at) {
            at = to;
            steps += 1;
            if steps == fan.len() {
                break;
            }
        }
        assert!(!fan.is_empty() && steps == fan.len());
    }
}

#[test]
fn a_scan_is_the_surface_with_other_vertices_and_triangles() {
    let Some(ict) = ict::ict() else { return };
    let simulator = Simulator::new(ict);
    // Given a person and the clean scan of that person.
    let made = simulator.scan(8101, &CLEAN);
    let scan = &made.scan;
    assert!((85_000..95_000).contains(&scan.triangles.len()));
    let truth = made.truth.positions(ict);
    let surface = Surface::new(&truth, &ict.triangles);

    // Then its vertices are on the person's surface, and hardly any is one of ICT's.
    let mut same = 0;
    for &p in &scan.positions {
        let hit = surface.closest(p, 1.0).expect("near");
        assert!(hit.distance < 1e-9, "{}", hit.distance);
        same += usize::from(hit.weights.iter().any(|&w| w > 1.0 - 1e-9));
    }
    assert!(same < scan.positions.len() / 40, "{same} are ICT's own");

    // Triangles cut corners of the polyhedron that the surface is, whose edges are 3 mm long: by
    // less than scanners' noise on average.
    let off: Vec<f64> = scan
        .triangles
        .iter()
        .map(|t| {
            let centre = t.iter().map(|&v| scan.positions[v as usize]).sum::<DVec3>() / 3.0;
            surface.closest(centre, 10.0).expect("near").distance
        })
        .collect();
    let mean = off.iter().sum::<f64>() / off.len() as f64;
    let most = off.iter().copied().fold(0.0, f64::max);
    println!("triangles' centres are off by {mean:.4} mm, at most {most:.3} mm");
    assert!(mean < 0.03 && most < 1.0);

    // And it is a manifold, as open as ICT's skin (212 edges, each halved), with no sharper folds.
    let edges = edges(scan);
    one_fan_each(scan);
    assert_eq!(edges.values().filter(|t| t.len() == 1).count(), 2 * 212);
    let whole = Scan {
        positions: truth.clone(),
        triangles: ict.triangles.clone(),
        ..Scan::default()
    };
    let (ours, theirs) = (folds(scan), folds(&whole));
    println!("pairs of triangles over 120 degrees apart: {ours}, where the person has {theirs}");
    // The pairs along an edge of the person become two or three pairs.
    assert!(ours <= 3 * theirs);

    // Irregular: not the six triangles around a vertex of a divided grid.
    let mut valence = vec![0; scan.positions.len()];
    for &v in scan.triangles.as_flattened() {
        valence[v as usize] += 1;
    }
    let six = valence.iter().filter(|&&n| n == 6).count();
    assert!(six < scan.positions.len() / 2, "{six} of valence 6");
}

#[test]
fn noise_holes_and_landmark_errors_are_what_was_asked_for() {
    let Some(ict) = ict::ict() else { return };
    let simulator = Simulator::new(ict);
    let clean = simulator.scan(8102, &CLEAN);
    let settings = Settings {
        noise: 0.3,
        jitter: 1.5,
        holes: false,
    };
    let noisy = simulator.scan(8102, &settings);

    // The same person, pose and vertices, each off along its normal.
    assert_eq!(noisy.truth.pose, clean.truth.pose);
    assert_eq!(noisy.scan.triangles, clean.scan.triangles);
    let square: f64 = noisy
        .scan
        .positions
        .iter()
        .zip(&clean.scan.positions)
        .map(|(a, b)| a.distance_squared(*b))
        .sum();
    let sigma = (square / noisy.scan.positions.len() as f64).sqrt();
    // Five standard errors of a standard deviation from 44,786 numbers.
    assert!((sigma - 0.3).abs() < 5.0 * 0.3 / (2.0 * 44_786.0_f64).sqrt());

    // Exact landmarks are the person's vertices; others are off by 1.5 mm on average. The length of
    // such an error has a standard deviation of 0.63 mm.
    let truth = clean.truth.positions(ict);
    let errors: Vec<f64> = (8102..8112)
        .flat_map(|seed| {
            let [exact, off] = [CLEAN, settings].map(|s| simulator.scan(seed, &s).landmarks);
            let pairs = exact.into_iter().zip(off);
            pairs.map(|(a, b)| a.distance(b)).collect::<Vec<f64>>()
        })
        .collect();
    let error = errors.iter().sum::<f64>() / errors.len() as f64;
    let tolerance = 5.0 * 0.63 / (errors.len() as f64).sqrt();
    assert!((error - 1.5).abs() < tolerance, "{error}");
    for (landmark, &vertex) in clean.landmarks.iter().zip(&ict.landmarks) {
        assert!(landmark.distance(truth[vertex as usize]) < 1e-9);
    }

    // Holes take some of it away and leave a manifold of the rest.
    let holes = Settings {
        holes: true,
        ..CLEAN
    };
    for seed in 8102..8106 {
        let scan = simulator.scan(seed, &holes).scan;
        assert!((60_000..88_000).contains(&scan.triangles.len()));
        edges(&scan);
        one_fan_each(&scan);
        let truth = simulator.scan(seed, &CLEAN);
        let surface = Surface::new(&truth.scan.positions, &truth.scan.triangles);
        for &p in &scan.positions {
            assert!(surface.closest(p, 1.0).expect("on it").distance < 1e-9);
        }
    }
}

#[test]
fn what_is_written_is_the_same_for_the_same_seed() {
    let Some(ict) = ict::ict() else { return };
    let simulator = Simulator::new(ict);
    let settings = Settings {
        noise: 0.2,
        jitter: 0.5,
        holes: true,
    };
    let folders = [1, 3].map(|threads| {
        let folder = tempfile::tempdir().expect("a folder");
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads")
            .install(|| write(&simulator, 8110, 3, &settings, false, folder.path(), || ()))
            .expect("writes");
        folder
    });
    let read = |folder: usize, name: &str| {
        std::fs::read(folders[folder].path().join(name)).expect("was written")
    };
    for name in [
        "about.json",
        "person_8110.ply",
        "person_8112.ply",
        "person_8112.json",
        "truth/person_8112.json",
    ] {
        assert!(read(0, name) == read(1, name), "{name}");
    }
    // The truth makes the person again, in the scan's pose.
    let truth: Truth =
        serde_json::from_slice(&read(0, "truth/person_8112.json")).expect("is a truth");
    let person = truth.positions(ict);
    let alone = simulator.scan(8112, &CLEAN);
    let off = |(a, b): (&DVec3, &DVec3)| a.distance(*b);
    let again = alone.truth.positions(ict);
    assert!(person.iter().zip(&again).map(off).all(|d| d < 1e-9));
    let landmarks: BTreeMap<String, [f64; 3]> =
        serde_json::from_slice(&read(0, "person_8112.json")).expect("are landmarks");
    assert_eq!(landmarks.len(), 68);
    assert!(landmarks.contains_key("ibug_00") && landmarks.contains_key("ibug_67"));

    // More people of the same kind join them; others do not, nor are they told to be whoever is there already.
    let folder = folders[0].path();
    let add = |seed, settings: &Settings| {
        let added = write(&simulator, seed, 1, settings, false, folder, || ());
        added.map_err(|e| e.to_string())
    };
    add(8113, &settings).expect("joins");
    let about = read(0, "about.json");
    let error = add(8114, &CLEAN).expect_err("others");
    assert!(
        error.contains("person_8110.ply: a person of other noise, errors or holes"),
        "{error}"
    );
    std::fs::write(folder.join("anna.ply"), "").expect("written");
    std::fs::write(folder.join("about.json"), "{}").expect("written");
    let error = add(8114, &settings).expect_err("somebody");
    assert!(
        error.contains("anna.ply: is none of these people's scans"),
        "{error}"
    );
    assert!(read(0, "about.json") == b"{}" && about != b"{}");
    assert!(!folder.join("person_8114.ply").exists());
}
