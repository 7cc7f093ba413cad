//! Landmarks that nobody marked: on made-up people, on simulated scans, on a real scan, and on what
//! is no face.

use std::sync::OnceLock;

use glam::{DMat3, DVec3};

use phiz::Random;
use phiz::fit::FitResult;
use phiz::fit::detect::{Detection, Detector};
use phiz::fit::format::ply::write_mesh;
use phiz::fit::head::template::Template;
use phiz::fit::scan::{Scan, Unit};
use phiz::fit::truth::population;
use phiz::fit::truth::simulate::{Settings, Simulator};

use crate::{base_mesh, heads, ict, james};

/// The generic head and its detector, built once.
fn head() -> Option<&'static (&'static Template, Detector)> {
    static HEAD: OnceLock<Option<(&'static Template, Detector)>> = OnceLock::new();
    HEAD.get_or_init(|| {
        let template = heads::plain()?;
        let detector = Detector::new(template).expect("it has a face");
        Some((template, detector))
    })
    .as_ref()
}

/// A real scan and its 68 points.
fn james() -> Option<(Scan, Vec<DVec3>)> {
    let folder = james::james()?;
    let scan = Scan::read(&folder.join("james.obj"), None).expect("reads");
    let text = std::fs::read_to_string(folder.join("james_ibug68.txt")).expect("reads");
    let numbers: Vec<f64> = text
        .split_whitespace()
        .map(|n| n.parse().expect("a number"))
        .collect();
    let points = numbers.chunks_exact(3).map(DVec3::from_slice).collect();
    Some((scan, points))
}

type Mesh = (Vec<DVec3>, Vec<[u32; 3]>);

/// The triangles whose corners are all wanted.
fn part((positions, triangles): &Mesh, wanted: impl Fn(DVec3) -> bool) -> Mesh {
    let kept = |t: &&[u32; 3]| t.iter().all(|&v| wanted(positions[v as usize]));
    let kept = triangles.iter().filter(kept).copied().collect();
    (positions.clone(), kept)
}

/// An ellipsoid with waves of a share of its radii.
fn ellipsoid(radii: DVec3, centre: DVec3, waves: f64) -> Mesh {
    const RINGS: u32 = 60;
    const ROUND: u32 = 120;
    let positions = (0..=RINGS)
        .flat_map(|i| (0..ROUND).map(move |j| (i, j)))
        .map(|(i, j)| {
            let down = std::f64::consts::PI * f64::from(i) / f64::from(RINGS);
            let round = std::f64::consts::TAU * f64::from(j) / f64::from(ROUND);
            let out = DVec3::new(
                down.sin() * round.sin(),
                down.cos(),
                down.sin() * round.cos(),
            );
            let wave = (7.0 * out.x).sin() * (5.0 * out.y + 1.0).sin() + (9.0 * out.z).sin();
            centre + out * radii * (1.0 + waves * wave)
        })
        .collect();
    let triangles = (0..RINGS * ROUND)
        .flat_map(|v| {
            let next = v / ROUND * ROUND + (v + 1) % ROUND;
            [[v, v + ROUND, next + ROUND], [v, next + ROUND, next]]
        })
        .collect();
    (positions, triangles)
}

fn together(a: &Mesh, b: &Mesh) -> Mesh {
    let first = a.0.len() as u32;
    let (mut positions, mut triangles) = a.clone();
    positions.extend(&b.0);
    triangles.extend(b.1.iter().map(|t| t.map(|v| v + first)));
    (positions, triangles)
}

/// Any rotation, all alike.
fn rotation(random: &mut Random) -> DMat3 {
    let q = glam::DQuat::from_xyzw(
        random.normal(),
        random.normal(),
        random.normal(),
        random.normal(),
    );
    DMat3::from_quat(q.normalize())
}

/// Finds the points on a turned mesh, and turns them back.
fn find_turned(detector: &Detector, mesh: &Mesh, by: DMat3) -> FitResult<Detection> {
    let away = DVec3::new(300.0, -200.0, 1000.0);
    let turned: Vec<DVec3> = mesh.0.iter().map(|&p| by * p + away).collect();
    let mut found = detector.find(&turned, &mesh.1)?;
    for p in &mut found.points {
        *p = by.transpose() * (*p - away);
    }
    Ok(found)
}

/// The 68 points of a face in the template's vertices.
fn points(template: &Template, face: &[DVec3]) -> Vec<DVec3> {
    let of = |i| {
        let name = format!("ibug_{i:02}");
        let at = template.landmarks.iter().position(|l| l.name == name);
        template.landmark(at.expect("an iBUG point"), face)
    };
    (0..68).map(of).collect()
}

/// The mean distance of some of the 68 points from the truth, mm.
fn error(
    template: &Template,
    found: &Detection,
    truth: &[DVec3],
    which: std::ops::Range<usize>,
) -> f64 {
    let count = which.len() as f64;
    which
        .map(|i| {
            let name = format!("ibug_{i:02}");
            let landmark = template.landmarks.iter().position(|l| l.name == name);
            found.points[landmark.expect("an iBUG point")].distance(truth[i])
        })
        .sum::<f64>()
        / count
}

/// All but the contour of the jaw, which has no feature to hold on to along it.
const INNER: std::ops::Range<usize> = 17..68;

#[test]
fn made_up_people_are_found_in_any_pose() {
    let Some((template, detector)) = head() else {
        return;
    };
    let data = base_mesh::folder().expect("it was there for the head");
    let people = population::sample(template, &data, 4, 31).expect("samples");
    let mut random = Random::new(1);
    for face in people.faces {
        let named = points(template, &face);
        let mesh = (face, template.triangles());
        let found = find_turned(detector, &mesh, rotation(&mut random)).expect("a face");
        // Issue 3's aim for landmarks without a hand is 2.5 mm.
        let mean = error(template, &found, &named, INNER);
        assert!(mean < 2.5, "{mean}");
    }
}

#[test]
fn a_jaw_that_hangs_is_found_where_it_is() {
    let Some(template) = heads::template() else {
        return;
    };
    let detector = Detector::new(template).expect("it has a face");
    let open = template.expressions.iter().find(|e| e.name == "jawOpen");
    let open = &open.expect("an expression").displacements;
    let data = base_mesh::folder().expect("it was there for the head");
    let people = population::sample(template, &data, 2, 33).expect("samples");
    let mut random = Random::new(3);
    for (mut face, strength) in people.faces.into_iter().zip([0.8, 1.1]) {
        for (p, d) in face.iter_mut().zip(open) {
            *p += *d * strength;
        }
        let named = points(template, &face);
        let mesh = (face, template.triangles());
        let found = find_turned(&detector, &mesh, rotation(&mut random)).expect("a face");
        // Lips and a chin that were taken for those of a shut mouth are 10 mm off and more; what is left is what people
        // differ by along a jaw.
        for range in [7..10, 48..68] {
            let mean = error(template, &found, &named, range.clone());
            assert!(mean < 5.0, "{strength}: {range:?} {mean}");
        }
    }
}

#[test]
fn a_face_in_units_of_its_own_is_found_and_nothing_else_is() {
    let Some((template, detector)) = head() else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scan.ply");
    let data = base_mesh::folder().expect("it was there for the head");
    let face = (population::sample(template, &data, 1, 32)
        .expect("samples")
        .faces)
        .remove(0);
    let truth = points(template, &face);
    let known = detector.find(&face, &template.triangles()).expect("a face");
    let known = error(template, &known, &truth, INNER);
    for by in [0.02, 3.0] {
        let scaled: Vec<DVec3> = face.iter().map(|&p| p * by).collect();
        write_mesh(&path, &scaled, &template.triangles()).expect("writes");
        let mut scan = Scan::read(&path, None).expect("reads");
        let mut found = detector.find_on(&mut scan, template).expect("a face");
        let said = |note: &String| note.starts_with("units: its own");
        assert_eq!(
            scan.notes.iter().filter(|n| said(n)).count(),
            1,
            "{:?}",
            scan.notes
        );
        assert!(
            scan.notes
                .iter()
                .all(|n| said(n) || !n.starts_with("units: "))
        );
        // Its face is taken to be of average size, which is some per cent off.
        assert!((scan.scale * by - 1.0).abs() < 0.12, "{}", scan.scale * by);
        for p in &mut found.points {
            *p /= scan.scale * by;
        }
        let mean = error(template, &found, &truth, INNER);
        println!("{by}: {mean:.2} mm off, {known:.2} where the unit is known");
        assert!(mean < known + 0.4, "{mean}");
        // A unit that was asked for is kept.
        let mut asked = Scan::read(&path, Some(Unit::Own(300.0 / by / 500.0))).expect("reads");
        let scale = asked.scale;
        let _ = detector.find_on(&mut asked, template);
        assert_eq!(asked.scale, scale);
    }
    // Inches are taken for centimetres at first; by its face it is told.
    let inches: Vec<DVec3> = face.iter().map(|&p| p / 25.4).collect();
    write_mesh(&path, &inches, &template.triangles()).expect("writes");
    let mut scan = Scan::read(&path, None).expect("reads");
    let found = detector.find_on(&mut scan, template).expect("a face");
    assert_eq!(scan.unit(), Unit::Inch, "{:?}", scan.notes);
    let mean = error(template, &found, &truth, INNER);
    assert!(mean < known + 0.4, "{mean}");
    let (positions, triangles) = ellipsoid(DVec3::new(3.0, 4.0, 3.5), DVec3::ZERO, 0.05);
    write_mesh(&path, &positions, &triangles).expect("writes");
    let mut scan = Scan::read(&path, None).expect("reads");
    let (scale, notes) = (scan.scale, scan.notes.clone());
    let message = detector.find_on(&mut scan, template).expect_err("no face");
    assert!(
        message.to_string().contains("no face was found"),
        "{message}"
    );
    assert_eq!((scan.scale, scan.notes), (scale, notes));
}

/// A square of so many mm around a place, of small triangles that face up.
fn floor(side: f64, at: DVec3) -> Mesh {
    const CELLS: u32 = 40;
    let step = |i: u32| side * (f64::from(i) / f64::from(CELLS) - 0.5);
    let positions = (0..=CELLS)
        .flat_map(|i| (0..=CELLS).map(move |j| at + DVec3::new(step(i), 0.0, step(j))))
        .collect();
    let triangles = (0..CELLS * CELLS)
        .map(|c| c / CELLS * (CELLS + 1) + c % CELLS)
        .flat_map(|v| {
            let next = v + CELLS + 1;
            [[v, v + 1, next + 1], [v, next + 1, next]]
        })
        .collect();
    (positions, triangles)
}

#[test]
fn a_floor_or_a_wall_does_not_turn_a_face_inside_out() {
    let Some((template, detector)) = head() else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scan.ply");
    let data = base_mesh::folder().expect("it was there for the head");
    let face = population::sample(template, &data, 1, 33).expect("samples");
    let face = (face.faces[0].clone(), template.triangles());
    // The face alone, as a camera sees it: what it has of a volume is little.
    let front = part(&face, |p| p.z > -60.0);
    let below = floor(800.0, DVec3::Y * -230.0);
    let turn = DMat3::from_rotation_x(std::f64::consts::FRAC_PI_2);
    let stand = |p: &DVec3| turn * *p - DVec3::Z * 100.0;
    let (flat, triangles) = floor(1000.0, DVec3::ZERO);
    let wall = (flat.iter().map(stand).collect(), triangles);
    for (what, around) in [("floor", below), ("wall", wall)] {
        let (positions, triangles) = together(&front, &around);
        for inside_out in [false, true] {
            let mut triangles = triangles.clone();
            if inside_out {
                triangles.iter_mut().for_each(|t| t.swap(1, 2));
            }
            write_mesh(&path, &positions, &triangles).expect("writes");
            for unit in [None, Some(Unit::Millimetre)] {
                let mut scan = Scan::read(&path, unit).expect("reads");
                let found = detector.find_on(&mut scan, template).expect("a face");
                let mean = error(template, &found, &points(template, &face.0), INNER);
                assert!(mean < 3.0, "{what}: {mean}");
                // What is registered is the way round in which the face was found, and only that is said.
                let said = |note: &&String| note.starts_with("triangles: all turned");
                let said = scan.notes.iter().filter(said).count();
                assert_eq!(said, usize::from(inside_out), "{what}: {:?}", scan.notes);
                let [a, b, c] = scan.triangles[0].map(|v| scan.positions[v as usize]);
                let [d, e, f] = front.1[0].map(|v| front.0[v as usize]);
                let facing = (b - a).cross(c - a).dot((e - d).cross(f - d));
                assert!(facing > 0.0, "{what}, inside out: {inside_out}");
            }
        }
    }
}

#[test]
fn of_two_people_one_is_found_and_the_other_said() {
    let Some((template, detector)) = head() else {
        return;
    };
    let data = base_mesh::folder().expect("it was there for the head");
    let people = population::sample(template, &data, 2, 34).expect("samples");
    let beside = DVec3::new(310.0, 40.0, -60.0);
    let turned = DMat3::from_rotation_y(0.4);
    let [first, mut second] = <[Vec<DVec3>; 2]>::try_from(people.faces).expect("two");
    second.iter_mut().for_each(|p| *p = beside + turned * *p);
    let truths = [&first, &second].map(|face| points(template, face));
    let (positions, triangles) = together(
        &(first, template.triangles()),
        &(second, template.triangles()),
    );
    let mut scan = Scan {
        positions,
        triangles,
        scale: 1.0,
        ..Scan::default()
    };
    let found = detector.find_on(&mut scan, template).expect("a face");
    let [one, other] = truths
        .each_ref()
        .map(|truth| error(template, &found, truth, INNER));
    assert!(one.min(other) < 2.5, "{one} {other}");
    let apart = truths[0][30].distance(truths[1][30]);
    assert_eq!(found.others.len(), 1);
    assert!(
        (found.others[0] - apart).abs() < 10.0,
        "{} of {apart}",
        found.others[0]
    );
    let said = scan
        .notes
        .iter()
        .any(|note| note.starts_with("face: one of 2, "));
    assert!(said, "{:?}", scan.notes);
}

#[test]
fn what_is_no_face_is_said_to_be_none() {
    let Some((template, detector)) = head() else {
        return;
    };
    let corners: Vec<DVec3> = (0..8)
        .map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)) * 180.0)
        .collect();
    let sides = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let cube = (
        corners,
        sides
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
            .collect(),
    );
    let whole = (template.positions.clone(), template.triangles());
    let tip = template
        .landmarks
        .iter()
        .position(|l| l.name == "ibug_30")
        .expect("a nose");
    let tip = template.landmark(tip, &template.positions);
    for (what, mesh) in [
        ("cube", cube),
        ("sphere", ellipsoid(DVec3::splat(95.0), DVec3::ZERO, 0.0)),
        (
            "lumpy head",
            ellipsoid(DVec3::new(75.0, 115.0, 95.0), DVec3::ZERO, 0.04),
        ),
        (
            "torso",
            ellipsoid(DVec3::new(230.0, 300.0, 110.0), DVec3::ZERO, 0.03),
        ),
        (
            "head without its face",
            part(&whole, |p| p.distance(tip) > 75.0),
        ),
        ("neck", part(&whole, |p| p.y < tip.y - 100.0)),
        ("nothing", (Vec::new(), Vec::new())),
    ] {
        match detector.find(&mesh.0, &mesh.1) {
            Ok(found) => panic!("{what}: a face with evidence {}", found.evidence),
            Err(why) => assert!(why.to_string().contains("no face was found"), "{why}"),
        }
    }
}

#[test]
fn simulated_people_are_found_whatever_surrounds_them() {
    let (Some((template, detector)), Some(ict)) = (head(), ict::ict()) else {
        return;
    };
    let simulator = Simulator::new(ict);
    let mut random = Random::new(2);
    for seed in 8100..8103 {
        let settings = Settings {
            noise: 0.3,
            jitter: 0.0,
            holes: true,
        };
        let person = simulator.scan(seed, &settings);
        let (pose, truth) = (person.truth.pose, person.landmarks);
        let head = (person.scan.positions, person.scan.triangles);
        let at = |x: f64, y: f64, z: f64| truth[27] + pose.rotation * DVec3::new(x, y, z);
        // The ends of the face, and what a scanner sees besides it.
        let front = part(&head, |p| p.distance(truth[30]) < 100.0);
        let left = pose.rotation * DVec3::X;
        let profile = part(&head, |p| (p - truth[27]).dot(left) > -5.0);
        let mut shoulders = ellipsoid(DVec3::new(230.0, 120.0, 110.0), DVec3::ZERO, 0.03);
        for p in &mut shoulders.0 {
            *p = at(0.0, -290.0, -90.0) + pose.rotation * *p;
        }
        for (what, mesh) in [
            ("head", head.clone()),
            ("front", front),
            ("profile", profile),
            ("bust", together(&head, &shoulders)),
        ] {
            let by = rotation(&mut random);
            let found = find_turned(detector, &mesh, by).expect(what);
            assert!(found.others.is_empty(), "{what}: {:?}", found.others);
            let mean = error(template, &found, &truth, INNER);
            // The side that a profile does not show is guessed.
            let most = SIMULATED + if what == "profile" { 1.5 } else { 0.0 };
            assert!(mean < most, "{what} of {seed}: {mean}");
            assert!(
                found.confidences.iter().all(|c| (0.0..=1.0).contains(c)),
                "{what}"
            );
        }
    }
}

/// Mean error on simulated people, mm: what is measured is 2.1 to 3, of which 1.5 is that the generic
/// head's points are not quite those that ICT names.
const SIMULATED: f64 = 4.0;

#[test]
fn a_real_scan_is_found_in_any_pose_and_cut_to_the_face() {
    let (Some((template, detector)), Some((scan, truth))) = (head(), james()) else {
        return;
    };
    let whole = (scan.positions, scan.triangles);
    let found = detector.find(&whole.0, &whole.1).expect("james has a face");
    // His points were placed by somebody else's scheme; eyes, mouth and the tip of the nose agree.
    for (range, most) in [(30..31, 4.0), (36..48, 4.0), (48..68, 4.5)] {
        let mean = error(template, &found, &truth, range.clone());
        assert!(mean < most, "{range:?}: {mean}");
    }
    // His lips are shut.
    let lip = |name: &str| {
        let at = template.landmarks.iter().position(|l| l.name == name);
        found.points[at.expect("an iBUG point")]
    };
    for [upper, lower] in [
        ["ibug_61", "ibug_67"],
        ["ibug_62", "ibug_66"],
        ["ibug_63", "ibug_65"],
    ] {
        let gap = lip(upper).distance(lip(lower));
        assert!(gap < 1.5, "{upper} is {gap} mm from {lower}");
    }
    let again = detector.find(&whole.0, &whole.1).expect("as before");
    assert_eq!(found, again);
    let z_up = DMat3::from_cols(DVec3::X, DVec3::Z, -DVec3::Y);
    let upside_down = DMat3::from_diagonal(DVec3::new(-1.0, -1.0, 1.0));
    let face = part(&whole, |p| p.distance(truth[30]) < 100.0);
    for (mesh, by) in [(&whole, z_up), (&whole, upside_down), (&face, z_up)] {
        let turned = find_turned(detector, mesh, by).expect("james has a face");
        let apart =
            error(template, &turned, &truth, INNER) - error(template, &found, &truth, INNER);
        // Surfels fall elsewhere, and where the face was cut the rest is guessed.
        assert!(apart.abs() < 0.7, "{apart}");
    }
}
