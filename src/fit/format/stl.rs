//! STL files: loose triangles, binary or in text.

use std::path::Path;

use glam::DVec3;

use super::text::{decoded, lines, plain};
use crate::fit::{FitError, FitResult};

/// Bytes before the triangles of a binary file: a comment and how many they are.
const HEADER: usize = 84;
/// Bytes of a triangle: its normal, its corners, and two that mean nothing.
const RECORD: usize = 50;

/// Reads the triangles of a file, in its units; normals are passed over.
///
/// # Errors
/// When the file is neither kind of STL, ends early, or has numbers that are none, with the line.
pub fn read(path: &Path) -> FitResult<Vec<[DVec3; 3]>> {
    let bytes = std::fs::read(path).map_err(|e| FitError::unread(path, e))?;
    parse(&bytes).map_err(|cause| FitError::file(path, cause))
}

fn parse(bytes: &[u8]) -> Result<Vec<[DVec3; 3]>, String> {
    let said = bytes.get(HEADER - 4..HEADER).map(|count| {
        let count = u32::from_le_bytes([count[0], count[1], count[2], count[3]]);
        count as usize
    });
    let held = bytes.len().saturating_sub(HEADER) / RECORD;
    // Binary files may begin with `solid` too, but their count has a zero in it, or is right.
    let binary = bytes.iter().take(HEADER).any(|&b| b == 0) || said == Some(held);
    let begins = bytes.trim_ascii_start().get(..5);
    if !binary && begins.is_some_and(|word| word.eq_ignore_ascii_case(b"solid")) {
        return in_text(bytes);
    }
    match said {
        None => Err("neither `solid` nor a header: no STL file".into()),
        // Who writes triangle by triangle may not have known how many there would be.
        Some(0) if bytes[HEADER..].len() == held * RECORD => {
            let records = bytes[HEADER..].chunks_exact(RECORD);
            Ok(records.map(corners).collect())
        }
        Some(said) if said > held => Err(format!("ends after {held} of {said} triangles")),
        Some(said) => {
            let records = bytes[HEADER..].chunks_exact(RECORD).take(said);
            Ok(records.map(corners).collect())
        }
    }
}

fn corners(record: &[u8]) -> [DVec3; 3] {
    let float = |at: usize| {
        let at = 12 + 4 * at;
        let bytes = [record[at], record[at + 1], record[at + 2], record[at + 3]];
        f64::from(f32::from_le_bytes(bytes))
    };
    [0, 3, 6].map(|at| DVec3::new(float(at), float(at + 1), float(at + 2)))
}

fn in_text(bytes: &[u8]) -> Result<Vec<[DVec3; 3]>, String> {
    let mut corners = Vec::new();
    for (number, line) in lines(&plain(bytes)?) {
        let line = decoded(line);
        let mut words = line.split_whitespace();
        if !words
            .next()
            .is_some_and(|word| word.eq_ignore_ascii_case("vertex"))
        {
            continue;
        }
        let mut coordinate = || {
            let word = words.next().unwrap_or_default();
            let value = word.parse().ok().filter(|value: &f64| value.is_finite());
            value.ok_or_else(|| format!("line {number}: `{word:.24}` is no number"))
        };
        corners.push(DVec3::new(coordinate()?, coordinate()?, coordinate()?));
    }
    let (triangles, left) = corners.as_chunks();
    match left {
        [] => Ok(triangles.to_vec()),
        _ => Err("ends in the middle of a triangle".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_did_not_know_how_many_there_would_be_wrote_none() {
        let mut bytes = vec![0; HEADER];
        for x in 0..2 {
            let numbers = [[0.0; 3], [0.0; 3], [1.0, x as f32, 0.0], [0.0, 1.0, 0.0]];
            bytes.extend(numbers.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
            bytes.extend([0; 2]);
        }
        assert_eq!(parse(&bytes).unwrap().len(), 2);
        assert_eq!(parse(&bytes[..HEADER]).unwrap().len(), 0);
        bytes.push(0);
        assert_eq!(parse(&bytes).unwrap().len(), 0);
    }

    #[test]
    fn text_may_be_in_capitals() {
        let text = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n\
                    vertex 0 1 0\nendloop\nendfacet\nendsolid a\n";
        let read = parse(text.as_bytes()).unwrap();
        assert_eq!(read, [[DVec3::ZERO, DVec3::X, DVec3::Y]]);
        assert_eq!(parse(text.to_uppercase().as_bytes()).unwrap(), read);
    }
}
