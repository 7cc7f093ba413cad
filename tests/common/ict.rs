//! Where ICT-FaceKit is, for tests that need it.

use std::path::PathBuf;
use std::sync::OnceLock;

use phiz::fit::truth::ict::Ict;

/// The mean and the modes, read once, from the folder that `ICT_FACEKIT` names (it holds
/// `FaceXModel`). Where there is none the test has nothing to work on and says so; in CI that is a
/// failure.
pub fn ict() -> Option<&'static Ict> {
    static ICT: OnceLock<Option<Ict>> = OnceLock::new();
    ICT.get_or_init(|| {
        let folder = std::env::var_os("ICT_FACEKIT").map(PathBuf::from);
        match folder {
            Some(folder) => Some(Ict::read(&folder).expect("reads")),
            None => {
                let ci = std::env::var_os("CI").is_some_and(|ci| ci == "true");
                assert!(!ci, "no ICT_FACEKIT");
                println!("skipped: ICT_FACEKIT names no folder of ICT-FaceKit");
                None
            }
        }
    })
    .as_ref()
}
