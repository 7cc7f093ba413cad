//! Where a real scan is, for tests that need one: `james.obj` with its image, and 68 points in
//! `james_ibug68.txt`.

use std::path::{Path, PathBuf};

/// Its folder, from `PHIZ_JAMES` or beside the checkout. The scan is not ours to commit; where
/// there is none the test has nothing to work on and says so; in CI that is a failure.
pub fn james() -> Option<PathBuf> {
    let folder = std::env::var_os("PHIZ_JAMES").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/james"),
        PathBuf::from,
    );
    if folder.join("james.obj").is_file() {
        return Some(folder);
    }
    let why = format!(
        "skipped: no james.obj in {}; set PHIZ_JAMES",
        folder.display()
    );
    assert!(std::env::var_os("CI").is_none(), "{why}");
    println!("{why}");
    None
}
