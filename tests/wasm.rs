//! The core on wasm32, in Node: `wasm-pack test --node -- --test wasm`.
//!
//! Positions are exact sums, and the rest is plain IEEE arithmetic without fused operations, so wasm
//! gives the very bits that native code does; `tests/online/face.rs` holds those to their definition.
#![cfg(target_arch = "wasm32")]

mod common;

use common::{exercise, n, sheet, sheet_blob, sheet_model, text};
use phiz::{FaceModel, Randomize};
use wasm_bindgen_test::wasm_bindgen_test;

/// The committed model's blob. A page inflates it with what the browser has.
fn head() -> FaceModel {
    let packed: &[u8] = include_bytes!("../www/public/model.phiz");
    let mut blob = Vec::new();
    std::io::Read::read_to_end(&mut flate2::bufread::GzDecoder::new(packed), &mut blob).unwrap();
    FaceModel::parse(&blob).unwrap()
}

#[wasm_bindgen_test]
fn what_is_packed_is_the_pages_to_inflate() {
    let packed: &[u8] = include_bytes!("../www/public/model.phiz");
    let error = FaceModel::parse(packed).unwrap_err().to_string();
    assert!(error.contains("inflate it first"), "{error}");
}

#[wasm_bindgen_test]
fn the_committed_model_takes_every_use() {
    exercise(&head());
}

#[wasm_bindgen_test]
fn the_sheet_takes_every_use_and_is_read_as_it_was_written() {
    exercise(&sheet_model());
    assert_eq!(*sheet_model().parts(), sheet());
}

#[wasm_bindgen_test]
fn positions_do_not_depend_on_the_way() {
    let model = head();
    let mut face = model.face();
    for (i, control) in model.parts().controls.iter().enumerate() {
        face.set(&control.name, (i as f64 * 0.37).fract()).unwrap();
    }
    let straight = model.from_code(&face.code()).unwrap();
    assert_eq!(straight.positions(), face.positions());
    assert_eq!(straight.normals(), face.normals());
}

#[wasm_bindgen_test]
fn randomness_comes_from_the_platform() {
    let mut face = sheet_model().face();
    let seed = face.randomize(&Randomize::default()).unwrap();
    assert!(
        seed < 1 << 53,
        "{seed} would not survive as a JavaScript number"
    );
    assert_ne!(seed, face.randomize(&Randomize::default()).unwrap());
}

/// Counts are 32 bits wide here, so products of numbers in a header can wrap; every one of these
/// would on the way to a small section.
#[wasm_bindgen_test]
fn counts_that_wrap_in_32_bits_are_refused() {
    let blob = sheet_blob();
    let sizes = |corners, triangles, quantiles| {
        let counts = [48, corners, triangles, quantiles].map(u32::to_le_bytes);
        [text("mm"), counts.concat()].concat()
    };
    let modes = |count| [text("nose"), n(1), text("nose"), n(count)].concat();
    let right = sizes(54, 70, 21);
    for (from, to) in [
        (&right, sizes(2_147_483_702, 70, 21)),
        (&right, sizes(54, 1_431_655_836, 21)),
        (&right, sizes(54, 70, 429_496_751)),
        (&modes(3), modes(1_431_655_768)),
    ] {
        let bytes = common::with_header(&blob, from, &to);
        assert!(FaceModel::parse(&bytes).is_err(), "{to:?} was taken");
    }
}
