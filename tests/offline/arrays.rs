//! A model as arrays, read by another reader of numpy's files than what wrote them.

use std::collections::BTreeMap;
use std::process::Command;

use glam::Vec3;
use npyz::NpyFile;
use phiz::{FaceModel, Randomize};

/// The files of a ZIP that are not packed, by its directory, each with its checksum checked.
fn files(zip: &[u8]) -> BTreeMap<String, &[u8]> {
    let half = |at: usize| u16::from_le_bytes(zip[at..at + 2].try_into().unwrap()) as usize;
    let word = |at: usize| u32::from_le_bytes(zip[at..at + 4].try_into().unwrap()) as usize;
    let end = zip.len() - 22;
    assert_eq!(&zip[end..end + 4], b"PK\x05\x06");
    let mut entry = word(end + 16);
    let mut files = BTreeMap::new();
    for _ in 0..half(end + 10) {
        assert_eq!(&zip[entry..entry + 4], b"PK\x01\x02");
        let (sum, size, name) = (word(entry + 16), word(entry + 24), half(entry + 28));
        let local = word(entry + 42);
        let name = &zip[entry + 46..entry + 46 + name];
        assert_eq!(&zip[local..local + 4], b"PK\x03\x04");
        let start = local + 30 + half(local + 26) + half(local + 28);
        assert_eq!(&zip[local + 30..local + 30 + name.len()], name);
        let bytes = &zip[start..start + size];
        let mut crc = flate2::Crc::new();
        crc.update(bytes);
        assert_eq!(crc.sum() as usize, sum);
        files.insert(String::from_utf8(name.to_vec()).unwrap(), bytes);
        entry += 46 + name.len() + half(entry + 30) + half(entry + 32);
    }
    assert_eq!(entry, end);
    files
}

#[test]
fn arrays_of_a_model_give_its_faces() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/www/public/synthetic.phiz");
    let model = FaceModel::parse(&std::fs::read(path).unwrap()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("model.npz");
    let mut command = Command::new(env!("CARGO_BIN_EXE_phiz-fit"));
    let done = command
        .arg("export")
        .arg(path)
        .arg("-o")
        .arg(&file)
        .output()
        .unwrap();
    assert!(
        done.status.success(),
        "{}",
        String::from_utf8_lossy(&done.stderr)
    );
    let zip = std::fs::read(&file).unwrap();
    let files = files(&zip);
    let numbers = |name: &str, shape: &[u64]| -> Vec<f32> {
        let array = NpyFile::new(files[&format!("{name}.npy")]).unwrap();
        assert_eq!(array.shape(), shape, "{name}");
        array.into_vec().unwrap()
    };
    let places = |name: &str, shape: &[u64]| -> Vec<u32> {
        let array = NpyFile::new(files[&format!("{name}.npy")]).unwrap();
        assert_eq!(array.shape(), shape, "{name}");
        array.into_vec().unwrap()
    };
    let parts = model.parts();
    let count = |n: usize| n as u64;
    let (n, k, p) = (parts.mean.len(), parts.coefficients(), parts.population());
    let mean = numbers("mean", &[count(n), 3]);
    let modes = numbers("modes", &[count(k), count(n), 3]);
    let mut face = model.face();
    let options = Randomize {
        seed: Some(5),
        ..Default::default()
    };
    face.randomize(&options).unwrap();
    face.set("nose width", 0.9).unwrap();
    let mut sums: Vec<f64> = mean.iter().map(|&x| x.into()).collect();
    for (mode, c) in modes.chunks_exact(3 * n).zip(face.coefficients()) {
        let own = sums.iter_mut().zip(mode);
        own.for_each(|(x, d)| *x += f64::from(*d) * f64::from(c));
    }
    let positions: &[[f32; 3]] = bytemuck::cast_slice(face.positions());
    let off = sums.iter().zip(positions.as_flattened());
    let off = off
        .map(|(a, b)| (a - f64::from(*b)).abs())
        .fold(0.0, f64::max);
    // Positions are within 2 micrometres RMS of such sums; five times that at one vertex of 18,000.
    assert!(off < 0.01, "{off} mm");

    assert_eq!(numbers("sigmas", &[count(k)])[0], parts.blocks[0].sigmas[0]);
    assert_eq!(
        numbers("correlation", &[count(p), count(p)]),
        parts.correlation
    );
    let triangles = parts.topology.triangles();
    let t = count(triangles.len());
    assert_eq!(places("triangles", &[t, 3]), triangles.as_flattened());
    assert_eq!(places("mirror", &[count(n)]), parts.topology.mirror);
    let corners = count(parts.topology.uvs.len());
    assert_eq!(
        numbers("uv", &[corners, 2]),
        parts.topology.uvs.as_flattened()
    );
    let sum: Vec<Vec3> = {
        let of =
            |name: &str| -> Vec<u32> { NpyFile::new(files[name]).unwrap().into_vec().unwrap() };
        let weights = NpyFile::new(files["landmark_weights.npy"]).unwrap();
        let weights: Vec<f32> = weights.into_vec().unwrap();
        let mut points = vec![Vec3::ZERO; parts.landmarks.len()];
        let entries = of("landmark_of.npy")
            .into_iter()
            .zip(of("landmark_vertices.npy"));
        for ((landmark, vertex), weight) in entries.zip(weights) {
            points[landmark as usize] += weight * face.positions()[vertex as usize];
        }
        points
    };
    for (point, landmark) in sum.iter().zip(&parts.landmarks) {
        // Sums of a few f32 of 100 mm.
        assert!(point.distance(landmark.position(face.positions())) < 1e-4);
    }
    let a = parts.attributes.len();
    let means = numbers("attribute_means", &[count(a)]);
    let readings = numbers("attribute_readings", &[count(a), count(p)]);
    for (i, attribute) in parts.attributes.iter().enumerate() {
        let each = readings[i * p..(i + 1) * p].iter().zip(face.coefficients());
        let reads = means[i] + each.map(|(w, c)| w * c).sum::<f32>();
        let own = face.attribute(&attribute.name).unwrap();
        // Of f32 where that was f64, in years at most.
        assert!((f64::from(reads) - own).abs() < 1e-3, "{}", attribute.name);
    }
    let part_of = places("part_of", &[t]);
    for (i, part) in parts.topology.parts.iter().enumerate() {
        let own = part.first as usize..(part.first + part.count) as usize;
        assert!(
            part_of[own].iter().all(|&at| at as usize == i),
            "{}",
            part.name
        );
    }
    let s = parts.controls.len();
    let quantiles = numbers("quantiles", &[count(s), 65]);
    assert_eq!(quantiles[65..130], parts.controls[1].quantiles);
    // Words are UTF-32 of one length, padded with zeros.
    let header = NpyFile::new(files["controls.npy"]).unwrap();
    assert_eq!(header.shape(), [count(s)]);
    let words = files["controls.npy"];
    let longest = parts
        .controls
        .iter()
        .map(|c| c.name.chars().count())
        .max()
        .unwrap();
    let words = words[words.len() - 4 * longest * s..].chunks_exact(4 * longest);
    let words: Vec<String> = words
        .map(|word| {
            let letters = word.chunks_exact(4).map(|c| char::from(c[0]));
            letters.filter(|c| *c != '\0').collect()
        })
        .collect();
    let names: Vec<&str> = parts.controls.iter().map(|c| &*c.name).collect();
    assert_eq!(words, names);
    assert_eq!(
        files["odd.npy"][files["odd.npy"].len() - k],
        u8::from(parts.odd()[0])
    );
}
