//! The points that come with a scan.
//!
//! Four forms are read, in the scan's units: a JSON object, name -> [x, y, z], or [x, y, z, error] where it is known
//! how far a point is off; plain text of 68 lines "x y z", the iBUG points in their order, also with what a `.pts` file
//! has around them; those points as menpo writes them, `.ljson`; and points as MeshLab saves those that were picked, `.pp`,
//! with their names, or with the numbers of the iBUG points.

use std::collections::HashMap;
use std::path::Path;

use glam::DVec3;
use roxmltree::{Document, Node, ParsingOptions};

use super::check::{Placement, spread};
use super::unit::LARGEST_FACE;
use super::{Scan, Unit, extent};
use crate::fit::format::files::write_atomically;
use crate::fit::format::text::{Members, decoded, lines, plain};
use crate::fit::head::template::Template;
use crate::fit::{FitError, FitResult};

/// Who may be off by so much or more says nothing of where a point is, mm.
const ANYWHERE: f64 = 100.0;

/// Points of the iBUG scheme, which a text file has all of.
const IBUG: usize = 68;
/// The fewest points that place a head and tell it from its mirror image.
const FEWEST: usize = 4;

/// The points of a scan.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Landmarks {
    /// `(index in the template's landmarks, point)`, in the order of the template, mm.
    pub points: Vec<(usize, DVec3)>,
    /// How far each is from where it belongs, as a standard deviation, mm: of all of the template's landmarks, 0 of those of
    /// which nobody knows; empty when nobody knows of any.
    pub errors: Vec<f64>,
    /// Whether brows are marked on their hair, as people and detectors mark them, and not above it, where the template has its
    /// points: so they are in files of other programs, all but the JSON that this one writes.
    pub on_hair: bool,
}

/// Reads the landmarks of a scan, without those that may be anywhere.
///
/// A unit of the scan that was guessed is settled by the landmarks, which tell it better than the
/// size of the mesh; where no unit makes them those of a face, the scan has units of its own
/// ([`Unit::Own`]). Positions, scale and notes of the scan then follow.
///
/// # Errors
/// When the file is in none of the forms, a name is unknown or there twice, numbers are missing or not
/// finite, there are fewer than four points or they do not span space, or they are of no face's
/// size in the unit that was asked for, or beside the scan: with the file and the name or line.
pub fn read(path: &Path, scan: &mut Scan, template: &Template) -> FitResult<Landmarks> {
    let mut read = read_file(path, template)?;
    settle_unit(path, scan, &read.points, template)?;
    read.points.iter_mut().for_each(|(_, p)| *p *= scan.scale);
    read.errors.iter_mut().for_each(|e| *e *= scan.scale);
    // To the last place but one, as JSON's numbers are read.
    let is_known = |l: usize| read.errors.get(l).is_none_or(|e| *e < ANYWHERE - 1e-6);
    read.points.retain(|&(l, _)| is_known(l));
    if read.points.len() < FEWEST {
        let cause = format!(
            "{} landmarks that are not off by {ANYWHERE} mm or more, and {FEWEST} are the fewest that place a face",
            read.points.len()
        );
        return Err(FitError::file(path, cause));
    }
    Ok(read)
}

/// Writes landmarks as a JSON object, in the units of the scan: points and `errors`, as in [`Landmarks`], are in mm, one
/// unit of the scan has `scale` mm. A point that is nowhere near the scan, whose error is infinite, which JSON has no word
/// for, is written with one by which it may be anywhere: until a hand sets it, [`read`] leaves it out. The file appears
/// whole or not at all.
///
/// # Errors
/// When the file cannot be written.
pub fn write(
    path: &Path,
    points: &[(usize, DVec3)],
    errors: &[f64],
    scale: f64,
    template: &Template,
) -> FitResult<()> {
    let mut text = String::from("{");
    for (i, &(index, p)) in points.iter().enumerate() {
        let name = serde_json::Value::from(template.landmarks[index].name.as_str());
        let [x, y, z] = (p / scale).to_array();
        text += if i > 0 { ",\n  " } else { "\n  " };
        let error = match errors.get(index) {
            Some(error) if *error > 0.0 => format!(", {}", error.min(ANYWHERE) / scale),
            _ => String::new(),
        };
        text += &format!("{name}: [{x}, {y}, {z}{error}]");
    }
    text += "\n}\n";
    write_atomically(path, text.as_bytes())
}

/// The same in the file's units.
pub(in crate::fit) fn read_file(path: &Path, template: &Template) -> FitResult<Landmarks> {
    let bytes = std::fs::read(path).map_err(|e| FitError::unread(path, e))?;
    let fail = |cause: String| FitError::file(path, cause);
    let bytes = plain(&bytes).map_err(fail)?;
    let is = |ending: &str| {
        path.extension()
            .is_some_and(|e| e.eq_ignore_ascii_case(ending))
    };
    let mut on_hair = true;
    let named = if is("ljson") {
        let file = serde_json::from_slice(&bytes);
        let file = file.map_err(|e| fail(format!("no landmarks: {e}")))?;
        from_menpo(&file).map_err(fail)?
    } else if is("pp") {
        from_meshlab(&decoded(&bytes)).map_err(fail)?
    } else if is("json") || bytes.trim_ascii_start().starts_with(b"{") {
        let read = serde_json::from_slice(&bytes);
        let Members(named) = read.map_err(|e| {
            fail(format!(
                "no landmarks, name -> [x, y, z] or [x, y, z, error]: {e}"
            ))
        })?;
        on_hair = false;
        named
    } else {
        from_lines(&bytes).map_err(fail)?
    };
    let known: HashMap<&str, usize> = template
        .landmarks
        .iter()
        .enumerate()
        .map(|(index, landmark)| (landmark.name.as_str(), index))
        .collect();
    let mut points = Vec::with_capacity(named.len());
    let mut errors = Vec::new();
    for (name, numbers) in &named {
        let Some(&index) = known.get(name.as_str()) else {
            let near = template
                .landmarks
                .iter()
                .min_by_key(|l| strsim::damerau_levenshtein(&l.name, name))
                .map(|l| format!("; the nearest name is `{}`", l.name));
            let cause = format!("no landmark is called `{name}`{}", near.unwrap_or_default());
            return Err(fail(cause));
        };
        let (&[x, y, z], error) = (match &numbers[..] {
            [place @ .., error] if place.len() == 3 => (place, *error),
            place => (place, 0.0),
        }) else {
            let cause = format!(
                "landmark `{name}` has {} numbers, not x, y and z",
                numbers.len()
            );
            return Err(fail(cause));
        };
        let p = DVec3::new(x, y, z);
        if !p.is_finite() {
            return Err(fail(format!("landmark `{name}` is not finite")));
        }
        if points.iter().any(|&(other, _)| other == index) {
            return Err(fail(format!("landmark `{name}` is there twice")));
        }
        if !(error.is_finite() && error >= 0.0) {
            return Err(fail(format!("landmark `{name}` has an error of {error}")));
        }
        if error > 0.0 {
            errors.resize(template.landmarks.len(), 0.0);
            errors[index] = error;
        }
        points.push((index, p));
    }
    if points.len() < FEWEST {
        return Err(fail(format!(
            "{} landmarks, and {FEWEST} are the fewest that place a face",
            points.len()
        )));
    }
    spread(&points).map_err(fail)?;
    points.sort_by_key(|&(index, _)| index);
    Ok(Landmarks {
        points,
        errors,
        on_hair,
    })
}

/// The endings of files of landmarks, the likeliest first.
pub const ENDINGS: [&str; 5] = ["json", "txt", "pts", "ljson", "pp"];

/// What MeshLab puts behind a scan's name for a file of its points.
const PICKED: &str = "_picked_points";

/// The name of the scan that a file of landmarks is of: its own without its ending, and without what MeshLab puts behind
/// the scan's.
pub fn scan_name(path: &Path) -> String {
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let is_picked = path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("pp"));
    let scan = name.strip_suffix(PICKED).filter(|_| is_picked);
    scan.unwrap_or(&name).to_owned()
}

/// The name of an iBUG point.
fn ibug(number: usize) -> String {
    format!("ibug_{number:02}")
}

/// The iBUG points of a file of menpo's: of its first group, without those that are not set.
fn from_menpo(file: &serde_json::Value) -> Result<Vec<(String, Vec<f64>)>, String> {
    let group = file["groups"].as_object().and_then(|g| g.values().next());
    let points = group.unwrap_or(file)["landmarks"]["points"].as_array();
    let points = points.ok_or("no landmarks: neither `landmarks` nor `groups` with `points`")?;
    if points.len() != IBUG {
        let cause = format!("{} points, not the {IBUG} iBUG points", points.len());
        return Err(cause);
    }
    let number = |x: &serde_json::Value| x.as_f64();
    Ok((points.iter().enumerate())
        .filter_map(|(i, point)| {
            let numbers = point.as_array()?.iter().map(number);
            Some((ibug(i), numbers.collect::<Option<_>>()?))
        })
        .collect())
}

/// The points of a file of MeshLab's without those that are not active, which nobody has picked. Where all are called by
/// numbers, as MeshLab calls them by itself, they are the iBUG points, from 0 or from 1.
fn from_meshlab(text: &str) -> Result<Vec<(String, Vec<f64>)>, String> {
    // Each begins with a document type.
    let options = ParsingOptions {
        allow_dtd: true,
        ..ParsingOptions::default()
    };
    let file = Document::parse_with_options(text, options);
    let file = file.map_err(|e| format!("no landmarks: {e}"))?;
    let root = file.root_element();
    if !root.has_tag_name("PickedPoints") {
        let name = root.tag_name().name();
        return Err(format!("no landmarks: <{name}>, not <PickedPoints>"));
    }
    let points = root.children().filter(|node| node.has_tag_name("point"));
    let points: Vec<Node> = points.collect();
    let name = |point: &Node| {
        point
            .attribute("name")
            .unwrap_or_default()
            .trim()
            .to_owned()
    };
    let numbers = points.iter().map(|point| name(point).parse().ok());
    let numbers: Option<Vec<usize>> = numbers.collect();
    let first = numbers.as_deref().and_then(|n| n.iter().min().copied());
    if let (Some(numbers), Some(first)) = (&numbers, first) {
        let last = numbers.iter().max().copied().unwrap_or(first);
        if numbers.len() != IBUG || first > 1 || last != first + IBUG - 1 {
            return Err(format!(
                "{} points called {first} to {last}: points have names, or the {IBUG} iBUG points their numbers",
                numbers.len()
            ));
        }
    }
    let named = |(i, point): (usize, &Node)| {
        let name = match (&numbers, first) {
            (Some(numbers), Some(first)) => ibug(numbers[i] - first),
            _ => name(point),
        };
        let number = |axis: &str| {
            let place = || {
                let line = file.text_pos_at(point.range().start).row;
                format!("line {line}: landmark `{name}`")
            };
            let word = point.attribute(axis);
            let word = word.ok_or_else(|| format!("{} has no {axis}", place()))?;
            let value = word.trim().parse::<f64>();
            value.map_err(|_| format!("{}: `{word}` is no number", place()))
        };
        let [x, y, z] = ["x", "y", "z"].map(number);
        let numbers = vec![x?, y?, z?];
        Ok((name, numbers))
    };
    let all = points.iter().enumerate();
    all.filter(|(_, point)| point.attribute("active") != Some("0"))
        .map(named)
        .collect()
}

/// The iBUG points from lines "x y z"; commas may stand between the numbers, `#` begins a comment. What a
/// `.pts` file says of itself and the braces around its points are passed over.
fn from_lines(bytes: &[u8]) -> Result<Vec<(String, Vec<f64>)>, String> {
    // What is no text has no lines either.
    if bytes.contains(&0) {
        return Err("no text".into());
    }
    let mut points = Vec::new();
    for (line, content) in lines(bytes) {
        let content = decoded(content);
        let content = content.split('#').next().unwrap_or_default().trim();
        let about = ["version:", "n_points:"];
        if ["{", "}"].contains(&content) || about.iter().any(|word| content.starts_with(word)) {
            continue;
        }
        let words: Vec<&str> = content
            .split(|c: char| c.is_whitespace() || c == ',')
            .filter(|word| !word.is_empty())
            .collect();
        if words.is_empty() {
            continue;
        }
        let place = format!("line {line}");
        if words.len() != 3 {
            return Err(format!("{place}: {} words, not x, y and z", words.len()));
        }
        let numbers = words
            .iter()
            .map(|word| match word.parse::<f64>() {
                Ok(value) if value.is_finite() => Ok(value),
                Ok(_) => Err(format!("{place}: `{word}` is not finite")),
                Err(_) => Err(format!("{place}: `{word}` is no number")),
            })
            .collect::<Result<_, _>>()?;
        points.push((ibug(points.len()), numbers));
    }
    match points.len() {
        IBUG => Ok(points),
        count => Err(format!(
            "{count} points; a text file has the {IBUG} iBUG points, one a line"
        )),
    }
}

/// Takes the unit by which the landmarks are those of a face.
fn settle_unit(
    path: &Path,
    scan: &mut Scan,
    points: &[(usize, DVec3)],
    template: &Template,
) -> FitResult<()> {
    let placement = Placement::of(points, template, false);
    let Some(scale) = placement.map(|p| 1.0 / p.scale).filter(|s| s.is_finite()) else {
        return Ok(());
    };
    let likely = Unit::of_scale(scale);
    let unit = match scan.unit_guessed {
        true => likely.millimetres(),
        false => scan.scale,
    };
    if matches!(likely, Unit::Own(_)) && scan.unit_guessed && !scan.surrounds(points) {
        let size = Unit::nearest(scale).millimetres() / scale;
        let cause = format!("its landmarks are {size:.3} times as far apart as a face's");
        return Err(FitError::file(path, cause));
    }
    let size = unit / scale;
    if !(1.0 / LARGEST_FACE..=LARGEST_FACE).contains(&size) {
        let cause = format!(
            "in the scan's units its landmarks are {size:.3} times as far apart as a face's; they \
             fit in {likely}"
        );
        return Err(FitError::file(path, cause));
    }
    if scan.unit_guessed && unit != scan.scale {
        scan.rescale(unit);
        if scan.plausible(likely).is_err() {
            let points: Vec<DVec3> = points.iter().map(|&(_, p)| p).collect();
            let cause = format!(
                "its landmarks are {:.4} across and the scan {:.4}: not in the same units",
                extent(&points),
                extent(&scan.positions) / scan.scale
            );
            return Err(FitError::file(path, cause));
        }
        scan.say_unit(likely, "because the landmarks then are a face's");
    }
    Ok(())
}
