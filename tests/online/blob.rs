//! A blob is read back as it was written, or refused with a reason: never a panic, a hang or a
//! huge allocation, and never a model on which a face panics later.

use std::sync::LazyLock;

use crate::common::{
    COEFFICIENTS, edited_sheet, exercise, head_model, labelled_sheet, n, sheet, sheet_blob,
    sheet_model, text, with_header,
};
use glam::Vec3;
use phiz::anatomy::{Axis, Quantity};
use phiz::blob::{VERSION, pack, seal, unpack};
use phiz::model::{ModelParts, Modes};
use phiz::quantise::FINEST_STEP;
use phiz::{Error, FaceModel, IncomingModel};
use proptest::prelude::*;

static BLOB: LazyLock<Vec<u8>> = LazyLock::new(sheet_blob);
static SYMMETRIC: LazyLock<Vec<u8>> =
    LazyLock::new(|| symmetric_sheet().write().expect("it is written"));

/// The sheet whose mean is its own mirror image, and each mode too, or every second one the opposite.
fn symmetric_sheet() -> ModelParts {
    let mut parts = sheet();
    let mirror = parts.topology.mirror.clone();
    for (v, &image) in mirror.iter().enumerate() {
        let p = parts.mean[v];
        parts.mean[image as usize] = match image as usize == v {
            true => p.with_x(0.0),
            false => p * Vec3::new(-1.0, 1.0, 1.0),
        };
    }
    for block in &mut parts.blocks {
        let (modes, support) = (&block.modes, &block.support);
        let count = modes.count();
        let mut numbers = modes.by_vertex();
        for (at, &v) in support.iter().enumerate() {
            let Ok(image) = support.binary_search(&mirror[v as usize]) else {
                continue;
            };
            for k in 0..count {
                for axis in 0..3 {
                    let negative = (axis == 0) == (k % 2 == 0);
                    let own = numbers[3 * (at * count + k) + axis];
                    numbers[3 * (image * count + k) + axis] = match (image == at, negative) {
                        (true, true) => 0,
                        (false, true) => -own,
                        _ => own,
                    };
                }
            }
        }
        block.modes = Modes::new(modes.step(), count, &numbers);
    }
    parts
}

/// What is the same on both sides is kept of one, and read back as it was.
#[test]
fn a_symmetric_model_is_kept_of_one_side() {
    let parts = symmetric_sheet();
    let model = FaceModel::parse(&SYMMETRIC).expect("a model");
    assert_eq!(*model.parts(), parts);
    // A block of all vertices at least has its images.
    let whole = parts
        .blocks
        .iter()
        .position(|b| b.support.len() == parts.mean.len());
    let block = &parts.blocks[whole.expect("the head")];
    let odd: Vec<bool> = (0..block.sigmas.len()).map(|k| k % 2 == 1).collect();
    assert_eq!(parts.odd()[block.coefficients()], odd);
    assert!(
        SYMMETRIC.len() < BLOB.len(),
        "{} of {} bytes",
        SYMMETRIC.len(),
        BLOB.len()
    );
    for at_once in [1, 100] {
        let incoming = incoming(&SYMMETRIC, at_once).expect("a model");
        assert_eq!(*incoming.parts(), parts);
    }
    exercise(&model);
}

/// The default model was learned from people and their mirror images: its mean is its own image, and each mode is,
/// or its opposite, to the bit, so that a file keeps one side. Some are the opposite, as people are not symmetric.
#[test]
fn modes_of_people_are_of_both_sides_or_of_one_against_the_other() {
    let parts = head_model().parts();
    let mirror = &parts.topology.mirror;
    for (v, &image) in mirror.iter().enumerate() {
        let flipped = parts.mean[v] * Vec3::new(-1.0, 1.0, 1.0);
        assert_eq!(parts.mean[image as usize], flipped);
    }
    let odd = parts.odd();
    for block in parts.blocks.iter().filter(|b| b.local_to.is_none()) {
        for (k, i) in block.coefficients().enumerate() {
            for (at, &v) in block.support.iter().enumerate() {
                let image = block.support.binary_search(&mirror[v as usize]);
                let image = image.expect("on both sides");
                for axis in 0..3 {
                    let sign = if (axis == 0) == odd[i] { 1 } else { -1 };
                    let number = |at: usize| i32::from(block.modes.get(k, 3 * at + axis));
                    assert_eq!(
                        number(at),
                        sign * number(image),
                        "{} {k} at {v}",
                        block.name
                    );
                }
            }
        }
    }
    let people = &odd[..parts.population()];
    let count = people.iter().filter(|odd| **odd).count();
    assert!(
        count > 3 && count < people.len() / 2,
        "{count} of {}",
        people.len()
    );
}

/// Parses bytes that may be anything; a model that comes out is used in every way.
fn survive(bytes: &[u8]) {
    if let Ok(model) = FaceModel::parse(bytes) {
        exercise(&model);
    }
}

fn refused(bytes: &[u8]) -> String {
    match FaceModel::parse(bytes) {
        Ok(_) => panic!("it was taken"),
        Err(error) => error.to_string(),
    }
}

/// The model of bytes that come in so many at a time.
fn incoming(bytes: &[u8], at_once: usize) -> Result<FaceModel, Error> {
    let mut incoming = IncomingModel::default();
    for chunk in bytes.chunks(at_once) {
        incoming.push(chunk.to_vec());
    }
    let (model, all) = incoming.finish()?;
    assert_eq!(all, bytes);
    Ok(model)
}

#[test]
fn a_model_that_comes_in_by_and_by_is_the_model() {
    for parts in [sheet(), edited_sheet(), labelled_sheet()] {
        let blob = parts.write().unwrap();
        for at_once in [7, 100, 1000, 12_345, blob.len()] {
            let model = incoming(&blob, at_once).unwrap();
            assert_eq!(*model.parts(), parts, "{at_once} at a time");
            let [whole, streamed] = [FaceModel::parse(&blob).unwrap(), model].map(|m| {
                let mut face = m.face();
                face.set(&m.parts().controls[0].name, 0.9).unwrap();
                (
                    face.code(),
                    face.positions().to_vec(),
                    face.normals().to_vec(),
                )
            });
            assert!(whole == streamed, "{at_once} at a time");
        }
    }
}

#[test]
fn modes_of_more_blocks_than_there_are_do_not_keep_a_reader_busy() {
    let parts = labelled_sheet();
    let mut bytes = parts.write().unwrap();
    for (name, more) in [("attributes", 0), ("read-outs", 1)] {
        let name = format!("{name:\0<16}");
        let at = bytes
            .windows(16)
            .position(|w| w == name.as_bytes())
            .unwrap();
        let other = format!("{:\0<16}", format!("modes.{}", parts.blocks.len() + more));
        bytes[at..at + 16].copy_from_slice(other.as_bytes());
    }
    seal(&mut bytes);
    let model = incoming(&bytes, 1000).unwrap();
    assert!(model.parts().attributes.is_empty());
    assert_eq!(model.parts(), FaceModel::parse(&bytes).unwrap().parts());
}

#[test]
fn a_model_that_comes_in_damaged_is_refused_as_one_that_is_there() {
    let blob = &*BLOB;
    for cut in [0, 20, 39, 500, blob.len() / 2, blob.len() - 1] {
        let why = incoming(&blob[..cut], 64)
            .map(|_| ())
            .unwrap_err()
            .to_string();
        assert_eq!(why, refused(&blob[..cut]), "the first {cut}");
    }
    for at in (0..blob.len()).step_by(211) {
        let mut bytes = blob.clone();
        bytes[at] ^= 4;
        let why = incoming(&bytes, 64).map(|_| ()).unwrap_err().to_string();
        assert_eq!(why, refused(&bytes), "byte {at}");
        // Behind a right checksum it is taken by both or by none.
        seal(&mut bytes);
        let [streamed, whole] = [incoming(&bytes, 64), FaceModel::parse(&bytes)].map(|model| {
            model
                .map(|m| m.parts().clone())
                .map_err(|why| why.to_string())
        });
        assert_eq!(
            format!("{streamed:?}"),
            format!("{whole:?}"),
            "byte {at}, sealed"
        );
    }
}

#[test]
fn what_is_written_is_read() {
    assert_eq!(*sheet_model().parts(), sheet());
}

#[test]
fn local_blocks_and_semantic_controls_are_read_as_they_were_written() {
    let parts = edited_sheet();
    let model = FaceModel::parse(&parts.write().unwrap()).unwrap();
    assert_eq!(*model.parts(), parts);
    assert_eq!(parts.population() + 1, parts.coefficients());
    exercise(&model);
}

#[test]
fn unsound_local_blocks_and_semantic_controls_are_refused() {
    let check = |what: &str, change: &dyn Fn(&mut phiz::model::ModelParts)| {
        let mut parts = edited_sheet();
        change(&mut parts);
        let read = parts.write().and_then(|bytes| FaceModel::parse(&bytes));
        assert!(matches!(read, Err(Error::Blob(_))), "{what} was taken");
    };
    let last = |p: &mut phiz::model::ModelParts, change: &dyn Fn(&mut phiz::model::Control)| {
        change(p.controls.last_mut().expect("it has controls"))
    };
    check("a block local to none", &|p| {
        p.blocks[3].local_to = Some("ear".into())
    });
    check("a block local to itself", &|p| {
        p.blocks[3].local_to = Some("local mouth".into())
    });
    check("a population after a local block", &|p| {
        p.blocks[1].local_to = Some("nose".into());
    });
    check("a local block with a surround", &|p| {
        p.blocks[3].surround = p.blocks[1].surround.clone()
    });
    check("a support out of order", &|p| {
        p.blocks[3].support.swap(0, 1)
    });
    check("a vertex that is not there", &|p| {
        *p.blocks[3].support.last_mut().expect("it moves some") = 99
    });
    check("a measure that is not there", &|p| {
        last(p, &|c| c.measure = Some(2))
    });
    check("a semantic control that moves nothing", &|p| {
        last(p, &|c| c.direction.clear())
    });
    check("a semantic control that reads coefficients", &|p| {
        last(p, &|c| c.reading = vec![(0, 1.0)])
    });
    check("a direction beyond all coefficients", &|p| {
        last(p, &|c| c.direction[0].0 = 10)
    });
    check("an offset of no landmarks", &|p| {
        p.measures[1].quantity = Quantity::Offset {
            axis: Axis::X,
            of: vec![],
            over: vec![0],
        }
    });
    check("an offset of landmarks that are not there", &|p| {
        p.measures[1].quantity = Quantity::Offset {
            axis: Axis::X,
            of: vec![0],
            over: vec![3],
        }
    });
    check("a mean of nothing", &|p| {
        p.measures[1].quantity = Quantity::Mean { mean: vec![] }
    });
    check("a mean of a mean of a mean of a mean", &|p| {
        for _ in 0..3 {
            let inner = p.measures[1].quantity.clone();
            p.measures[1].quantity = Quantity::Mean { mean: vec![inner] };
        }
    });
}

/// Flipped bits of the edited sheet, behind a right checksum.
#[test]
fn damage_to_local_blocks_is_refused_or_harmless() {
    let blob = edited_sheet().write().unwrap();
    for bit in (0..blob.len() * 8).step_by(7) {
        let mut bytes = blob.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        seal(&mut bytes);
        if let Ok(model) = FaceModel::parse(&bytes)
            && bit % 10 == 0
        {
            exercise(&model);
        }
    }
}

/// Attributes are sections of their own, after which a model is read as before there were any.
#[test]
fn unsound_attributes_are_refused_and_damage_to_them_is_harmless() {
    let parts = labelled_sheet();
    let blob = parts.write().unwrap();
    let model = FaceModel::parse(&blob).unwrap();
    assert_eq!(*model.parts(), parts);
    exercise(&model);
    let check = |what: &str, change: &dyn Fn(&mut phiz::model::Attribute)| {
        let mut parts = labelled_sheet();
        change(&mut parts.attributes[1]);
        let read = parts.write().and_then(|bytes| FaceModel::parse(&bytes));
        assert!(matches!(read, Err(Error::Blob(_))), "{what} was taken");
    };
    check("a name of another", &|a| a.name = "age".into());
    check("limits that are no range", &|a| a.limits.reverse());
    check("a limit that is none", &|a| a.limits[0] = f32::NAN);
    check("a mean that is none", &|a| a.mean = f32::INFINITY);
    check("a read-out of nothing", &|a| a.reading.fill(0.0));
    check("a read-out of something else", &|a| a.reading[2] = 1e7);
    check("too few weights", &|a| a.reading.truncate(5));
    // Each is compared with all others.
    let of = |count: usize| {
        let mut parts = labelled_sheet();
        let one = parts.attributes[0].clone();
        let many = (0..count).map(|i| phiz::model::Attribute {
            name: format!("label {i}"),
            ..one.clone()
        });
        parts.attributes = many.collect();
        FaceModel::parse(&parts.write().unwrap())
    };
    assert_eq!(of(256).unwrap().parts().attributes.len(), 256);
    assert!(of(257).is_err());
    let at = blob.windows(3).rposition(|w| w == b"age").unwrap();
    for place in at - 12..blob.len() {
        let mut bytes = blob.clone();
        bytes[place] ^= 1 << (place % 8);
        seal(&mut bytes);
        survive(&bytes);
    }
}

#[test]
fn every_truncation_is_refused_sealed_or_not() {
    for end in 0..BLOB.len() {
        let mut cut = BLOB[..end].to_vec();
        assert!(FaceModel::parse(&cut).is_err(), "cut at {end}");
        // Every section of the sheet is needed to its last byte, so no cut is a model.
        seal(&mut cut);
        assert!(FaceModel::parse(&cut).is_err(), "cut at {end} and sealed");
    }
}

#[test]
fn every_flipped_bit_is_refused() {
    let mut bytes = BLOB.clone();
    for bit in 0..bytes.len() * 8 {
        bytes[bit / 8] ^= 1 << (bit % 8);
        assert!(FaceModel::parse(&bytes).is_err(), "bit {bit}");
        bytes[bit / 8] ^= 1 << (bit % 8);
    }
}

#[test]
fn every_flipped_bit_behind_a_right_checksum_is_refused_or_harmless() {
    let mut bytes = BLOB.clone();
    for bit in 0..bytes.len() * 8 {
        let kept = bytes.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        seal(&mut bytes);
        if let Ok(model) = FaceModel::parse(&bytes) {
            // A tenth of them in full; the sweep is over 150,000 bits.
            if bit % 10 == 0 {
                exercise(&model);
            }
        }
        bytes = kept;
    }
}

#[test]
fn bytes_after_the_end_are_refused() {
    let mut bytes = BLOB.clone();
    bytes.push(0);
    assert!(refused(&bytes).contains("bytes long"));
}

#[test]
fn another_version_is_named() {
    let mut bytes = BLOB.clone();
    bytes[8..12].copy_from_slice(&(VERSION + 1).to_le_bytes());
    seal(&mut bytes);
    let expected = Error::Version {
        found: VERSION + 1,
        expected: VERSION,
    };
    assert_eq!(FaceModel::parse(&bytes).err(), Some(expected));
}

/// A list of numbers of a header.
fn list(numbers: &[u32]) -> Vec<u8> {
    let each = numbers.iter().flat_map(|x| x.to_le_bytes());
    n(numbers.len() as u32).into_iter().chain(each).collect()
}

#[test]
fn oversized_numbers_in_the_header_are_refused_before_anything_is_allocated() {
    let f = |number: f32| number.to_le_bytes().to_vec();
    // Vertices, corners, triangles, quantiles, behind the unit.
    let sizes = |unit: &str, sizes: [u32; 4]| [text(unit), sizes.map(u32::to_le_bytes).concat()];
    // A block: its name, its regions, its modes.
    let block = |name: &str, region: &str, modes: u32| [text(name), n(1), text(region), n(modes)];
    // Its support, targets and rigid parts.
    let reach = |support, targets, rigid| [n(support), vec![1], n(targets), n(rigid)];
    let alpha = |alpha, least, most| [f(alpha), f(least), f(most)];
    let right = sizes("mm", [48, 54, 70, 21]).concat();
    let nose = block("nose", "nose", 3).concat();
    let near = reach(8, 32, 1).concat();
    let blending = alpha(12.0, 2.0, 40.0).concat();
    let distance = list(&[0, 1, 2]);
    let changes: Vec<(&[u8], Vec<u8>)> = vec![
        (&right, sizes("mm", [u32::MAX, 54, 70, 21]).concat()),
        (&right, sizes("mm", [49, 54, 70, 21]).concat()),
        (&right, sizes("mm", [48, u32::MAX, 70, 21]).concat()),
        (&right, sizes("mm", [48, 55, 70, 21]).concat()),
        (&right, sizes("mm", [48, 54, 71, 21]).concat()),
        (&right, sizes("mm", [48, 54, u32::MAX, 21]).concat()),
        (&right, sizes("mm", [48, 54, 70, 22]).concat()),
        (&right, sizes("mm", [48, 54, 70, u32::MAX]).concat()),
        (&right, sizes("cm", [48, 54, 70, 21]).concat()),
        (&nose, block("nose", "nose", 4).concat()),
        (&nose, block("nose", "nose", 0).concat()),
        (&nose, block("nose", "nose", u32::MAX).concat()),
        (&nose, block("nose", "none", 3).concat()),
        (&nose, block("mouth", "nose", 3).concat()),
        (&near, reach(9, 32, 1).concat()),
        (&near, reach(u32::MAX, 32, 1).concat()),
        (&near, reach(8, 33, 1).concat()),
        (&near, reach(8, u32::MAX, 1).concat()),
        (&near, reach(8, 32, 2).concat()),
        (&near, reach(8, 32, u32::MAX).concat()),
        // The last block moves all 48 vertices, and nothing around them.
        (&[48, 0, 0, 0, 0, 0], vec![47, 0, 0, 0, 0, 0]),
        // An option is there or not.
        (&[48, 0, 0, 0, 0, 0], vec![48, 0, 0, 0, 2, 0]),
        (&blending, alpha(-1.0, 2.0, 40.0).concat()),
        (&blending, alpha(99.0, 2.0, 40.0).concat()),
        (&blending, alpha(f32::NAN, 2.0, 40.0).concat()),
        (&blending, alpha(12.0, 2.0, f32::INFINITY).concat()),
        (&distance, list(&[0, 1, 3])),
        (&distance, list(&[0, 1])),
        (&distance, list(&[0, 1, 2, 0])),
        (&distance, list(&[9, 1, 2])),
        (&distance, list(&[1, 3, 1, 0, 1, 1])),
        (&distance, list(&[2, u32::MAX])),
        (&distance, list(&[1, 0, u32::MAX])),
        (&distance, list(&[2, 1, 2, 1, 2, 1, 2, 1, 2, 1, 0, 1, 2])),
        (&distance, n(u32::MAX)),
        (&distance, vec![]),
        (&distance, [list(&[0, 1, 2]), vec![0]].concat()),
    ];
    let stencil = |vertex: u32| [n(vertex).as_slice(), &1.0_f64.to_le_bytes()].concat();
    let control = |number: u32| text(&format!("nose {number}"));
    let upper = |first: u32| [text("upper"), n(first)].concat();
    let others = [
        (upper(20), upper(21)),
        (upper(20), upper(u32::MAX)),
        (stencil(14), stencil(99)),
        (control(2), control(1)),
        (text("mm"), [n(2), vec![0xff, 0xfe]].concat()),
    ];
    let others = others.iter().map(|(from, to)| (&from[..], to.clone()));
    for (from, to) in changes.into_iter().chain(others) {
        let why = refused(&with_header(&BLOB, from, &to));
        assert!(
            why.starts_with("not a usable phiz blob: "),
            "{from:?} -> {to:?}: {why}"
        );
    }
}

#[test]
fn huge_counts_in_the_preamble_and_the_table_are_refused() {
    // Length, header length, section count; then type, offset and length of the first section.
    for at in [16, 20, 24, 40 + 16, 40 + 20, 40 + 24] {
        for number in [u32::MAX, u32::MAX / 2, 1 << 30, 1 << 16] {
            let mut bytes = BLOB.clone();
            seal(&mut bytes);
            bytes[at..at + 4].copy_from_slice(&number.to_le_bytes());
            if at != 16 {
                seal(&mut bytes);
            }
            assert!(FaceModel::parse(&bytes).is_err(), "{number} at byte {at}");
        }
    }
}

#[test]
fn sections_do_not_lie_over_each_other() {
    let count = u32::from_le_bytes(BLOB[24..28].try_into().unwrap()) as usize;
    let row = |i: usize| 40 + 32 * i + 20..40 + 32 * i + 28;
    // What has no bytes lies over nothing.
    let has_bytes = |i: &usize| BLOB[row(*i).start + 4..row(*i).end] != [0; 4];
    for i in 1..count {
        for j in (0..i).filter(has_bytes) {
            let mut bytes = BLOB.clone();
            let (from, to) = (row(j), row(i));
            bytes.copy_within(from, to.start);
            seal(&mut bytes);
            assert!(
                refused(&bytes).contains("not in its place"),
                "section {i} over {j}"
            );
        }
    }
}

#[test]
fn numbers_that_are_none_are_refused_in_every_float_section() {
    // Sigmas of the nose: 5 and 5 / 2; quantiles: from -3 on.
    for (section, start) in [("sigmas.0", 5.0_f32), ("quantiles", -3.0)] {
        let start = start.to_le_bytes();
        let at = BLOB.windows(4).position(|w| w == start);
        let at = at.expect("the section starts with it");
        for number in [f32::NAN, f32::INFINITY, -2e9] {
            let mut bytes = BLOB.clone();
            bytes[at..at + 4].copy_from_slice(&number.to_le_bytes());
            seal(&mut bytes);
            assert!(refused(&bytes).contains(&format!("{section:?}")));
        }
    }
}

/// Gives the first block modes of another step.
fn stepped(parts: &mut ModelParts, step: f32) {
    let modes = &mut parts.blocks[0].modes;
    *modes = Modes::new(step, modes.count(), &modes.by_vertex());
}

/// Parts that are changed by hand and must not survive being written and read.
#[test]
fn inconsistent_parts_are_refused() {
    let check = |what: &str, change: &dyn Fn(&mut phiz::model::ModelParts)| {
        let mut parts = sheet();
        change(&mut parts);
        let read = parts.write().and_then(|bytes| FaceModel::parse(&bytes));
        assert!(read.is_err(), "{what} was taken");
    };
    check("a step of 0", &|p| stepped(p, 0.0));
    check("a step that is none", &|p| stepped(p, f32::INFINITY));
    check("a support out of order", &|p| {
        p.blocks[0].support.swap(0, 1)
    });
    check("an empty support", &|p| {
        p.blocks[0].support.clear();
        p.blocks[0].modes = Modes::new(FINEST_STEP, 0, &[]);
    });
    check("a mirror that is none", &|p| p.topology.mirror[0] = 1);
    check("a triangle beyond the corners", &|p| {
        p.topology.uv_triangles[0][0] = 54
    });
    check("a target inside the region", &|p| {
        let inside = p.blocks[0].support[0];
        let surround = p.blocks[0].surround.as_mut().expect("the nose has one");
        surround.targets[0] = inside;
        surround.targets.sort_unstable();
    });
    let eyeball = |p: &mut phiz::model::ModelParts, change: &dyn Fn(&mut phiz::model::Rigid)| {
        let surround = p.blocks[0].surround.as_mut().expect("the nose has one");
        change(&mut surround.rigid[0]);
    };
    check("weights that do not sum to 1", &|p| {
        eyeball(p, &|rigid| rigid.weights[0] -= 1)
    });
    check("a source that is not there", &|p| {
        eyeball(p, &|rigid| rigid.sources[0] = 99)
    });
    check("a part that is not there", &|p| {
        eyeball(p, &|rigid| rigid.part = 3)
    });
    check("a distance beyond all heads", &|p| {
        let surround = p.blocks[0].surround.as_mut().expect("the nose has one");
        surround.distances[0] = 2e4;
    });
    check("a negative distance", &|p| {
        p.blocks[0]
            .surround
            .as_mut()
            .expect("the nose has one")
            .distances[0] = -1.0;
    });
    check("a correlation of 2", &|p| p.correlation[COEFFICIENTS] = 2.0);
    check("a mean that is none", &|p| p.mean[0].x = f32::NAN);
    check("a mean without an end", &|p| p.mean[0].y = f32::INFINITY);
    check("a mean far away", &|p| p.mean[0].z = -2e4);
    check("a correlation that no population has", &|p| {
        for (i, j) in [(0, 1), (1, 0), (1, 2), (2, 1)] {
            p.correlation[i * COEFFICIENTS + j] = 0.99;
        }
        p.correlation[2] = -0.99;
        p.correlation[2 * COEFFICIENTS] = -0.99;
    });
    check("quantiles that fall", &|p| {
        p.controls[0].quantiles.swap(3, 4)
    });
    check("limits that fall", &|p| p.controls[0].limits.reverse());
    check("a limit beyond all people", &|p| {
        p.controls[0].limits[1] = 1.5
    });
    check("a control that moves nothing", &|p| {
        p.controls[0].direction.clear()
    });
    check("a control of a coefficient that is not there", &|p| {
        p.controls[0].direction[0].0 = COEFFICIENTS as u32;
    });
    check("a coefficient twice in a direction", &|p| {
        let twice = p.controls[0].direction[0];
        p.controls[0].direction.push(twice);
    });
    // The last control reads a thousandth of coefficient 0 and has its median at -0.675: the
    // median person would have -675 sigmas of it.
    check("a median person out of all limits", &|p| {
        let last = p.controls.last_mut().expect("there are ten");
        last.direction = vec![(0, 1.0)];
        last.reading = vec![(0, 0.001)];
    });
    check("a blending distance below a micrometre", &|p| {
        p.blending.alpha = 1e-5;
        p.blending.limits[0] = 1e-6;
    });
    check("a landmark off the surface", &|p| {
        p.landmarks[0].stencil[0].1 = 5.0
    });
    check("a landmark of more than it needs", &|p| {
        p.landmarks[1].stencil = vec![(5, 1.0 / 65.0); 65];
    });
    check("a root that takes long", &|p| {
        let geometric_mean = vec![Quantity::Distance { from: 1, to: 2 }; 17];
        p.measures[0].quantity = Quantity::GeometricMean { geometric_mean };
    });
    check("a block of a region that is not there", &|p| {
        p.blocks[0].regions.push(3)
    });
    check("a mirror of fewer vertices", &|p| {
        p.topology.mirror.pop();
    });
    check("an image that is not there", &|p| p.topology.mirror[0] = 99);
    check("fewer distances than targets", &|p| {
        let surround = p.blocks[0].surround.as_mut().expect("the nose has one");
        surround.distances.pop();
    });
    check("a block without modes", &|p| {
        p.blocks[0].modes = Modes::new(FINEST_STEP, 0, &[]);
        p.blocks[0].sigmas.clear();
    });
}

/// Of what a file does not say, as it follows from the rest, there is nothing else.
#[test]
fn what_would_be_read_otherwise_is_not_written() {
    let refused = |change: &dyn Fn(&mut phiz::mesh::Topology)| {
        let mut parts = sheet();
        change(&mut parts.topology);
        parts.write().unwrap_err().to_string()
    };
    let said = refused(&|t| {
        let image = (1..t.mirror.len()).find(|&v| t.mirror[v] < v as u32);
        let image = t.mirror[image.expect("the sheet has two sides")];
        t.mirror[image as usize] = image;
    });
    assert!(said.ends_with("mirror map is not an involution"), "{said}");
    let said = refused(&|t| t.uv_vertices.swap(0, 1));
    assert!(
        said.ends_with("corners of vertices are not in their order"),
        "{said}"
    );
    let said = refused(&|t| {
        t.colours.pop();
    });
    assert!(said.ends_with("of another number of vertices"), "{said}");
}

#[test]
fn a_packed_model_is_the_same_model_and_packs_to_the_same_bytes() {
    let packed = pack(&BLOB).unwrap();
    assert_eq!(*FaceModel::parse(&packed).unwrap().parts(), sheet());
    assert_eq!(pack(&BLOB).unwrap(), packed);
    assert_eq!(*unpack(&packed).unwrap(), **BLOB);
    assert_eq!(*unpack(&BLOB).unwrap(), **BLOB);
}

#[test]
fn damaged_packing_is_refused() {
    let packed = pack(&BLOB).unwrap();
    for end in 0..packed.len() {
        assert!(FaceModel::parse(&packed[..end]).is_err(), "cut at {end}");
    }
    for bit in 0..packed.len() * 8 {
        let mut flipped = packed.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        // A few bits mean nothing, such as the time in gzip's preamble. All that means something
        // is covered by two checksums.
        if let Ok(model) = FaceModel::parse(&flipped) {
            assert_eq!(*model.parts(), sheet(), "bit {bit}");
        }
    }
    let mut longer = packed.clone();
    longer.push(0);
    assert!(refused(&longer).contains("bytes follow"));
    let nested = pack(&packed).unwrap();
    assert!(refused(&nested).contains("packed"));
}

#[test]
fn a_packed_blob_that_inflates_without_end_is_refused() {
    // 64 MiB and a byte of zeros are 64 kB packed.
    let bomb = pack(&vec![0; (1 << 26) + 1]).unwrap();
    assert!(bomb.len() < 1 << 17);
    assert!(refused(&bomb).contains("limit of 67108864"));
}

/// A model of as many blocks as there may be is read as it was written.
#[test]
fn many_blocks_are_read_as_they_were_written() {
    let mut parts = sheet();
    let nose = parts.blocks[0].clone();
    // Six sections each.
    for i in 3..63 {
        parts.blocks.push(phiz::model::Block {
            name: format!("nose {i}"),
            first_coefficient: parts.coefficients(),
            ..nose.clone()
        });
    }
    // The others are independent.
    let (few, all) = (COEFFICIENTS, parts.coefficients());
    let of = |i: usize, j: usize| match (i == j, i < few && j < few) {
        (true, _) => 1.0,
        (_, true) => parts.correlation[i * few + j],
        _ => 0.0,
    };
    parts.correlation = (0..all * all).map(|k| of(k / all, k % all)).collect();
    let model = FaceModel::parse(&parts.write().unwrap()).unwrap();
    assert_eq!(*model.parts(), parts);
}

#[test]
fn what_comes_in_beyond_the_limit_is_let_go() {
    let most = 1 << 26;
    let mut bytes = BLOB.clone();
    bytes.resize(most, 0);
    let mut incoming = IncomingModel::default();
    incoming.push(bytes);
    incoming.push(vec![0]);
    for _ in 0..3 {
        incoming.push(vec![0; 1000]);
    }
    let why = incoming.finish().unwrap_err().to_string();
    assert!(why.contains("67108865 bytes are over the limit"), "{why}");
}

#[test]
fn a_mean_at_the_limit_still_has_finite_faces() {
    let mut parts = sheet();
    parts.mean[0] = Vec3::splat(1e4);
    let model =
        FaceModel::parse(&parts.write().expect("it is a model")).expect("it is in the limits");
    exercise(&model);
}

#[derive(Debug, Clone)]
enum Damage {
    Set {
        at: prop::sample::Index,
        byte: u8,
    },
    Word {
        at: prop::sample::Index,
        word: u32,
    },
    Remove {
        at: prop::sample::Index,
        count: usize,
    },
    Insert {
        at: prop::sample::Index,
        bytes: Vec<u8>,
    },
    Copy {
        from: prop::sample::Index,
        to: prop::sample::Index,
        count: usize,
    },
}

fn damage() -> impl Strategy<Value = Damage> {
    use prop::sample::Index;
    // Numbers at which arithmetic goes wrong, beside any.
    let word = prop_oneof![
        any::<u32>(),
        Just(0),
        Just(u32::MAX),
        Just(1 << 31),
        Just(f32::NAN.to_bits()),
        Just(f32::INFINITY.to_bits()),
        Just(f32::MAX.to_bits()),
        Just(f32::MIN_POSITIVE.to_bits()),
    ];
    prop_oneof![
        (any::<Index>(), any::<u8>()).prop_map(|(at, byte)| Damage::Set { at, byte }),
        (any::<Index>(), word).prop_map(|(at, word)| Damage::Word { at, word }),
        (any::<Index>(), 1..64_usize).prop_map(|(at, count)| Damage::Remove { at, count }),
        (any::<Index>(), prop::collection::vec(any::<u8>(), 1..64))
            .prop_map(|(at, bytes)| Damage::Insert { at, bytes }),
        (any::<Index>(), any::<Index>(), 1..64_usize).prop_map(|(from, to, count)| Damage::Copy {
            from,
            to,
            count
        }),
    ]
}

fn apply(bytes: &mut Vec<u8>, damage: &Damage) {
    if bytes.is_empty() {
        return;
    }
    let n = bytes.len();
    match damage {
        Damage::Set { at, byte } => bytes[at.index(n)] = *byte,
        Damage::Word { at, word } => {
            let at = at.index(n) / 4 * 4;
            let end = (at + 4).min(n);
            bytes[at..end].copy_from_slice(&word.to_le_bytes()[..end - at]);
        }
        Damage::Remove { at, count } => {
            let at = at.index(n);
            bytes.drain(at..(at + count).min(n));
        }
        Damage::Insert { at, bytes: new } => {
            let at = at.index(n);
            bytes.splice(at..at, new.iter().copied());
        }
        Damage::Copy { from, to, count } => {
            let (from, to) = (from.index(n), to.index(n));
            let count = (*count).min(n - from).min(n - to);
            bytes.copy_within(from..from + count, to);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn damage_behind_a_right_checksum_is_refused_or_harmless(
        damages in prop::collection::vec(damage(), 1..6),
    ) {
        for blob in [&*BLOB, &*SYMMETRIC] {
            let mut bytes = blob.clone();
            damages.iter().for_each(|d| apply(&mut bytes, d));
            seal(&mut bytes);
            survive(&bytes);
        }
    }

    /// The header is a few thousand of the bytes and most of the meaning: damage aimed at it.
    #[test]
    fn a_damaged_byte_in_the_header_is_refused_or_harmless(
        places in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
    ) {
        let mut bytes = BLOB.clone();
        let sections = u32::from_le_bytes([bytes[24], bytes[25], bytes[26], bytes[27]]) as usize;
        let length = u32::from_le_bytes([bytes[20], bytes[21], bytes[22], bytes[23]]) as usize;
        let start = 40 + 32 * sections;
        for (place, byte) in places {
            bytes[start + place.index(length)] = byte;
        }
        seal(&mut bytes);
        survive(&bytes);
    }

    #[test]
    fn any_bytes_are_refused(bytes in prop::collection::vec(any::<u8>(), 0..4096)) {
        let mut bytes = bytes;
        prop_assert!(FaceModel::parse(&bytes).is_err());
        seal(&mut bytes);
        prop_assert!(FaceModel::parse(&bytes).is_err());
        // Behind a right signature and version it is the table that must refuse.
        if bytes.len() >= 40 {
            bytes[..16].copy_from_slice(&BLOB[..16]);
            seal(&mut bytes);
            survive(&bytes);
        }
    }
}
