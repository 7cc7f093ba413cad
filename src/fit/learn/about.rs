//! Whose faces are learned from: the `about.json` beside them, which who made the faces wrote.

use std::path::Path;

use serde_json::{Map, Value};

use crate::fit::format::text::json;
use crate::fit::{FitError, FitResult};
use crate::model::About;

/// The program and its version, as what it makes names it.
pub const PROGRAM: &str = concat!("phiz-fit ", env!("CARGO_PKG_VERSION"));

/// The file that says it.
pub const FILE: &str = "about.json";

/// What `about.json` in a folder says of its faces. All of it may be missing, or any part.
///
/// # Errors
/// When it is there and no JSON, or a part of it is no text where text is meant: with the file.
pub fn read(faces: &Path) -> FitResult<About> {
    let path = faces.join(FILE);
    let fail = |e: serde_json::Error| FitError::file(&path, e);
    let said: Map<String, Value> = match path.exists() {
        true => json(&path)?,
        false => Map::new(),
    };
    let missing = About {
        title: "unnamed".into(),
        population: format!("The faces of {}; no about.json said more.", faces.display()),
        ..About::default()
    };
    let mut about = serde_json::to_value(missing).map_err(fail)?;
    for (name, value) in said {
        about[name] = value;
    }
    let mut about: About = serde_json::from_value(about).map_err(fail)?;
    about.made_by = PROGRAM.into();
    Ok(about)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_said_of_the_faces_is_told_so() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("about.json");
        let none = read(folder.path()).unwrap();
        assert_eq!(none.title, "unnamed");
        assert!(none.population.contains("no about.json said more"));
        // As Windows writes text: with a mark, or in UTF-16.
        let text =
            r#"{"title": "Us", "licences": [{"source": "s", "by": "we", "licence": "MIT"}]}"#;
        let marked = [b"\xef\xbb\xbf", text.as_bytes()].concat();
        let wide = [0xfeff].into_iter().chain(text.encode_utf16());
        let wide: Vec<u8> = wide.flat_map(u16::to_le_bytes).collect();
        for bytes in [text.as_bytes(), &marked, &wide] {
            std::fs::write(&path, bytes).unwrap();
            let about = read(folder.path()).unwrap();
            assert_eq!(about.title, "Us");
            assert_eq!(about.licences[0].by, "we");
            assert_eq!(about.population, none.population);
            assert_eq!(about.made_by, none.made_by);
        }
        for bad in ["{", "[]", r#"{"title": 1}"#, r#"{"licences": [{}]}"#] {
            std::fs::write(&path, bad).unwrap();
            let error = read(folder.path()).unwrap_err().to_string();
            assert!(error.contains("about.json: "), "{error}");
            assert_eq!(error.lines().count(), 1, "{error}");
        }
    }
}
