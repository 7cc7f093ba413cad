//! A real scan, made by others: a head with hair, collar and a ragged edge, with its image.

use glam::DVec3;
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
