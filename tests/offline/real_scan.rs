//! A real scan, made by others: a head with hair, collar and a ragged edge, with its image.

use std::fmt::Write;

use glam::{DQuat, DVec3};
use phiz::anatomy::brow_hair;
use phiz::fit::register::batch::prepare;
use phiz::fit::scan::{Scan, Texture, check, landmarks};

use crate::{heads, james};

#[test]
fn a_real_scan_is_read_with_its_image_and_points() {
    let (Some(folder), Some(template)) = (james::james(), heads::plain()) else {
        return;
    };
    let mut scan = Scan::read(&folder.join("james.obj"), None).expect("reads");
    assert_eq!(scan.scale, 1.0);
    let texture = scan.texture.clone().expect("an image beside it");
    let bare = texture.triangles.iter().filter(|t| **t == Texture::BARE);
    assert_eq!(bare.count(), 0);
    let file = folder.join("james_ibug68.txt");
    let read = landmarks::read(&file, &mut scan, template).expect("68 points");
    let points = read.points;
    assert!(
        read.errors.is_empty(),
        "a text file does not tell how far points are off"
    );
    assert_eq!(points.len(), 68);
    assert_eq!(
        check(&mut scan, &points, template).expect("a face"),
        [""; 0]
    );

    // What is written is read again, in the units of the scan.
    let copy = tempfile::tempdir().expect("a folder");
    let json = copy.path().join("james.json");
    let mut errors = vec![0.0; template.landmarks.len()];
    for errors in [vec![], {
        errors[points[3].0] = 2.5;
        errors
    }] {
        landmarks::write(&json, &points, &errors, scan.scale, template).expect("writes");
        let read = landmarks::read(&json, &mut scan, template).expect("reads");
        assert_eq!((&read.points, read.errors), (&points, errors));
    }

    // Its mirror image is told even from four points, of which two are a pair.
    for names in [
        &["ibug_36", "ibug_45", "ibug_30", "ibug_08"][..],
        &["ibug_"],
    ] {
        let mut mirrored = scan.clone();
        mirrored.positions.iter_mut().for_each(|p| p.x = -p.x);
        mirrored.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        let points: Vec<_> = points
            .iter()
            .filter(|(l, _)| {
                let name = &template.landmarks[*l].name;
                names.iter().any(|n| name.starts_with(n))
            })
            .map(|&(l, p)| (l, p * DVec3::new(-1.0, 1.0, 1.0)))
            .collect();
        let error = check(&mut mirrored, &points, template).expect_err("mirrored");
        assert!(error.to_string().contains("mirror"), "{error}");
    }
}

/// Points of other programs are where people set them: brows on their hair, below the template's points.
#[test]
fn brows_are_marked_on_their_hair() {
    let (Some(template), Some(registrar)) = (heads::template(), heads::registrar()) else {
        return;
    };
    // The generic head itself, smaller, turned and elsewhere.
    let turn = DQuat::from_euler(glam::EulerRot::YXZ, 0.5, -0.2, 0.3);
    let placed = |p: DVec3| turn * (p * 0.9) + DVec3::new(40.0, -300.0, 120.0);
    let triangles = template.part_triangles("skin").expect("it has a skin");
    let mut obj = String::new();
    for p in template.positions.iter().copied().map(placed) {
        writeln!(obj, "v {} {} {}", p.x, p.y, p.z).expect("a string");
    }
    for [a, b, c] in &triangles {
        writeln!(obj, "f {} {} {}", a + 1, b + 1, c + 1).expect("a string");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let scan = folder.path().join("head.obj");
    std::fs::write(&scan, obj).expect("writes");
    let of = |i: usize| {
        let name = format!("ibug_{i:02}");
        template.landmarks.iter().position(|l| l.name == name)
    };
    let indices: Vec<usize> = (0..68).filter_map(of).collect();
    let own: Vec<DVec3> = (indices.iter())
        .map(|&l| template.landmark(l, &template.positions))
        .collect();
    let positions: Vec<_> = template.positions.iter().map(|p| p.as_vec3()).collect();
    let brows = std::array::from_fn(|i| own[17 + i].as_vec3());
    let hair = brow_hair(brows, &positions);
    let mut marked: Vec<DVec3> = own.iter().copied().map(placed).collect();
    for (i, p) in hair.iter().enumerate() {
        // In the upper half of it.
        marked[17 + i] = placed(own[17 + i].lerp(p.as_dvec3(), 0.75));
    }
    let lines: Vec<String> = (marked.iter())
        .map(|p| format!("{} {} {}", p.x, p.y, p.z))
        .collect();
    let text = folder.path().join("head.txt");
    std::fs::write(&text, lines.join("\n")).expect("writes");
    let read = prepare(registrar, &scan, Some(&text), None).expect("a face");
    for (i, &(l, p)) in read.points.iter().enumerate() {
        assert_eq!(l, indices[i]);
        let off = p.distance(placed(own[i]));
        // The hair's place is that of a vertex in depth, and edges are 3 mm long there.
        let most = if (17..27).contains(&i) { 1.5 } else { 1e-9 };
        assert!(off < most, "point {i} is {off} mm off");
    }
    // What this program writes is where the template has it, and stays.
    let json = folder.path().join("head.json");
    let points: Vec<(usize, DVec3)> = indices.iter().copied().zip(marked).collect();
    landmarks::write(&json, &points, &[], 1.0, template).expect("writes");
    let read = prepare(registrar, &scan, Some(&json), None).expect("a face");
    for (there, written) in read.points.iter().zip(&points) {
        // To the last place but one, as JSON's numbers are read.
        assert!(there.0 == written.0 && there.1.distance(written.1) < 1e-9);
    }

    let Some(james) = james::james() else {
        return;
    };
    let [scan, text] = ["james.obj", "james_ibug68.txt"].map(|name| james.join(name));
    let marked = landmarks::read(
        &text,
        &mut Scan::read(&scan, None).expect("reads"),
        template,
    );
    let read = prepare(registrar, &scan, Some(&text), None).expect("a face");
    let up: Vec<f64> = (read.points.iter().zip(&marked.expect("reads").points))
        .map(|(there, marked)| there.1.y - marked.1.y)
        .collect();
    for (i, up) in up.into_iter().enumerate() {
        let range = if (17..27).contains(&i) {
            3.0..8.0
        } else {
            0.0..1e-9
        };
        assert!(range.contains(&up), "point {i} is {up} mm higher");
    }
}
