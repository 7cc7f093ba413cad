//! Wavefront OBJ files and the materials beside them, in the file's own numbering.
//!
//! `tobj` reads OBJ too, but it renumbers vertices, does not say in which line a file is wrong,
//! takes the last texture coordinate for one that is missing, and panics on a texture index below
//! the first (`f 1/-9 2 3`): hence this reader.

use std::collections::HashMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};

use super::colours;
use super::files::write_atomically;
use super::text::{decoded, lines, named, not_finite, plain};
use crate::Face;
use crate::fit::{FitError, FitResult};

/// Stands for a texture coordinate that a corner does not have.
pub const NONE: u32 = u32::MAX;

/// Stands, while a file is read, for the colour of a vertex without one.
const BARE: DVec3 = DVec3::NAN;

/// Writes a face in mm, with texture coordinates and a group a part. Numbers are written in full:
/// what is read is the same f32.
///
/// # Errors
/// When the file cannot be written.
pub fn write_face(path: &Path, face: &Face) -> FitResult<()> {
    use std::fmt::Write;
    let topology = &face.model().parts().topology;
    let mut text = format!("# phiz {}, millimetres\n", env!("CARGO_PKG_VERSION"));
    // Writing into a string cannot fail.
    for p in face.positions() {
        let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z);
    }
    for [u, v] in &topology.uvs {
        let _ = writeln!(text, "vt {u} {v}");
    }
    for part in &topology.parts {
        // A space would begin another group.
        let _ = writeln!(text, "g {}", part.name.replace(' ', "_"));
        let first = part.first as usize;
        for corners in &topology.uv_triangles[first..first + part.count as usize] {
            let [a, b, c] = corners.map(|corner| {
                let vertex = topology.uv_vertices[corner as usize] + 1;
                format!("{vertex}/{}", corner + 1)
            });
            let _ = writeln!(text, "f {a} {b} {c}");
        }
    }
    write_atomically(path, text.as_bytes())
}

/// What an OBJ file says.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Obj {
    /// `v`: positions in the file's units.
    pub positions: Vec<DVec3>,
    /// The colours that some programs write after each position, sRGB 0 to 1; all or none: of those without
    /// one in a file with some, white.
    pub colours: Vec<DVec3>,
    /// `vt`: texture coordinates, (0, 0) at the lower left; NaN where the file has no number.
    pub uvs: Vec<DVec2>,
    /// `f`: the corners of all polygons, one after the other: position and texture coordinate,
    /// counted from 0, the latter perhaps [`NONE`].
    pub corners: Vec<[u32; 2]>,
    /// Polygon `i` has the corners `starts[i]..starts[i + 1]`; `starts.len()` is polygons + 1.
    pub starts: Vec<u32>,
    /// Where a group or a material begins, in the order of the file.
    pub runs: Vec<Run>,
    /// `mtllib`: the files with the materials, a line each. Names may have spaces, and a line several of them.
    pub libraries: Vec<String>,
    /// What was decided on the way, a line each.
    pub notes: Vec<String>,
}

/// Consecutive polygons of one group and material.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Run {
    /// The first polygon; the run ends where the next begins.
    pub first: usize,
    /// `g` or `o`, empty before the first.
    pub group: String,
    /// `usemtl`, empty before the first.
    pub material: String,
}

impl Obj {
    /// Reads a file. Normals, lines, points and curves are passed over.
    ///
    /// # Errors
    /// With the line: numbers that are none or not finite, corners that refer to nothing.
    pub fn read(path: &Path) -> FitResult<Obj> {
        let bytes = std::fs::read(path).map_err(|e| FitError::unread(path, e))?;
        Self::parse(&bytes).map_err(|cause| FitError::file(path, cause))
    }

    /// The corners of a polygon.
    pub fn polygon(&self, index: usize) -> &[[u32; 2]] {
        &self.corners[self.starts[index] as usize..self.starts[index + 1] as usize]
    }

    /// How many polygons there are.
    pub fn polygons(&self) -> usize {
        self.starts.len() - 1
    }

    /// The runs, each with its polygons.
    pub fn polygons_of_runs(&self) -> impl Iterator<Item = (&Run, Range<usize>)> {
        let ends = self.runs.iter().skip(1).map(|next| next.first);
        let ends = ends.chain([self.polygons()]);
        self.runs
            .iter()
            .zip(ends)
            .map(|(run, end)| (run, run.first..end))
    }

    fn parse(bytes: &[u8]) -> Result<Obj, String> {
        let mut obj = Obj {
            starts: vec![0],
            runs: vec![Run::default()],
            ..Obj::default()
        };
        let bytes = plain(bytes)?;
        let mut lines = lines(&bytes);
        let mut joined = Vec::new();
        let mut broken: HashMap<u32, String> = HashMap::new();
        while let Some((number, mut line)) = lines.next() {
            // A path in a comment or a name may end with the sign that continues a line of numbers.
            let commented = || {
                line.windows(2)
                    .any(|pair| pair[0].is_ascii_whitespace() && pair[1] == b'#')
            };
            if matches!(line.trim_ascii(), [b'v' | b'f', .., b'\\']) && !commented() {
                joined.clear();
                while let Some(part) = line.trim_ascii_end().strip_suffix(b"\\") {
                    joined.extend_from_slice(part);
                    joined.push(b' ');
                    line = lines.next().map_or(&[], |(_, next)| next);
                }
                joined.extend_from_slice(line);
                line = &joined;
            }
            let fail = |cause: String| format!("line {number}: {cause}");
            let before = obj.positions.len();
            obj.line(line).map_err(fail)?;
            let new = obj.positions.get(before).filter(|p| !p.is_finite());
            if new.is_some() {
                // It is named as it is written there.
                let word = words(line).skip(1).find(|word| number_of(word).is_none());
                let cause = format!("`{}` is not finite", shown(word.unwrap_or_default()));
                broken.insert(before as u32, fail(cause));
            }
        }
        // What sees nothing in a place writes a vertex there all the same; it is no harm where no face has it.
        if !broken.is_empty()
            && let Some(cause) = obj.corners.iter().find_map(|[v, _]| broken.get(v))
        {
            return Err(cause.clone());
        }
        if !obj.colours.is_empty() {
            obj.colours.resize(obj.positions.len(), BARE);
        }
        obj.notes.extend(colours::to_unit(&mut obj.colours));
        let mut bare = 0;
        for colour in obj.colours.iter_mut().filter(|c| c.is_nan()) {
            *colour = DVec3::ONE;
            bare += 1;
        }
        obj.notes.extend((bare > 0).then(|| colours::white(bare)));
        Ok(obj)
    }

    fn line(&mut self, line: &[u8]) -> Result<(), String> {
        let line = line.trim_ascii();
        let end = line
            .iter()
            .position(u8::is_ascii_whitespace)
            .unwrap_or(line.len());
        let (keyword, rest) = line.split_at(end);
        let rest = rest.trim_ascii_start();
        match keyword {
            b"v" => {
                let mut words = words(rest);
                let [x, y, z] = [(); 3].map(|()| coordinate(words.next()));
                self.positions.push(DVec3::new(x?, y?, z?));
                // A fourth number alone is a weight; three more are a colour.
                let more: Vec<&[u8]> = words.collect();
                if let [r, g, b] = more[..] {
                    let [r, g, b] = [r, g, b].map(|word| coordinate(Some(word)));
                    self.colours.resize(self.positions.len() - 1, BARE);
                    self.colours.push(DVec3::new(r?, g?, b?));
                }
            }
            b"vt" => {
                let mut words = words(rest);
                // Where a program had none it may have written that: of the triangles there alone the picture is missing.
                let u = coordinate(words.next())?;
                let v = words
                    .next()
                    .map_or(Ok(0.0), |word| coordinate(Some(word)))?;
                self.uvs.push(DVec2::new(u, v));
            }
            b"f" => {
                for word in words(rest) {
                    let mut parts = word.split(|&b| b == b'/');
                    let vertex = index(parts.next(), self.positions.len(), "vertex")?
                        .ok_or("a corner without a vertex")?;
                    let uv = index(parts.next(), self.uvs.len(), "texture coordinate")?;
                    self.corners.push([vertex, uv.unwrap_or(NONE)]);
                }
                self.starts.push(self.corners.len() as u32);
            }
            b"g" | b"o" => {
                let group = text(rest);
                self.run(|run| run.group = group);
            }
            b"usemtl" => {
                let material = text(rest);
                self.run(|run| run.material = material);
            }
            b"mtllib" => self.libraries.push(text(rest)),
            _ if self.positions.is_empty() && line.contains(&0) => {
                return Err("binary data: this is no OBJ file".into());
            }
            _ => {}
        }
        Ok(())
    }

    fn run(&mut self, change: impl FnOnce(&mut Run)) {
        let first = self.polygons();
        let mut run = self.runs.last().cloned().unwrap_or_default();
        run.first = first;
        change(&mut run);
        self.runs.push(run);
    }
}

/// The words of a line of numbers, up to a comment.
fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty())
        .take_while(|word| !word.starts_with(b"#"))
}

fn text(bytes: &[u8]) -> String {
    decoded(bytes).into_owned()
}

/// The value of a word, if that is finite.
fn number_of(word: &[u8]) -> Option<f64> {
    let value: f64 = std::str::from_utf8(word).ok()?.parse().ok()?;
    value.is_finite().then_some(value)
}

/// A number, NaN where it is not finite.
fn coordinate(word: Option<&[u8]>) -> Result<f64, String> {
    match not_finite(word.unwrap_or_default()) {
        true => Ok(f64::NAN),
        false => number(word),
    }
}

fn number(word: Option<&[u8]>) -> Result<f64, String> {
    let word = word.ok_or("too few numbers")?;
    let value: f64 = std::str::from_utf8(word)
        .ok()
        .and_then(|word| word.parse().ok())
        .ok_or_else(|| format!("`{}` is no number", shown(word)))?;
    match value.is_finite() {
        true => Ok(value),
        false => Err(format!("`{}` is not finite", shown(word))),
    }
}

/// An index from 1, or from the end when negative; nothing for an empty word.
fn index(word: Option<&[u8]>, count: usize, what: &str) -> Result<Option<u32>, String> {
    let Some(word) = word.filter(|word| !word.is_empty()) else {
        return Ok(None);
    };
    let value: i64 = std::str::from_utf8(word)
        .ok()
        .and_then(|word| word.parse().ok())
        .ok_or_else(|| format!("`{}` is no {what}", shown(word)))?;
    let found = match value {
        1.. => Some(value - 1),
        _ => (count as i64).checked_add(value).filter(|_| value != 0),
    };
    found
        .filter(|&at| at >= 0 && at < count as i64)
        .and_then(|at| u32::try_from(at).ok())
        .map(Some)
        .ok_or_else(|| format!("{what} {value}, and there are {count} so far"))
}

/// As much of a word as fits in a message.
fn shown(word: &[u8]) -> String {
    String::from_utf8_lossy(word).chars().take(24).collect()
}

/// The images of the materials of an MTL file: `(material, file)`, of each material first its colours, then, as many a
/// scan is to be seen without any light but its own, those of ambient light and of what it gives off, in the order of
/// the file; the image's path is taken from the folder of the MTL file. Of a picture in tiles (`skin.<UDIM>.png`) it is
/// the image of the first, from which [`tile_image`] knows the others.
///
/// # Errors
/// When the file cannot be read.
pub fn read_images(path: &Path) -> FitResult<Vec<(String, PathBuf)>> {
    let bytes = std::fs::read(path).map_err(|e| FitError::unread(path, e))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut material = String::new();
    let mut images: [Vec<_>; MAPS.len()] = Default::default();
    let bytes = plain(&bytes).map_err(|cause| FitError::file(path, cause))?;
    for (_, line) in lines(&bytes) {
        let line = decoded(line);
        let Some((keyword, rest)) = line.trim().split_once(char::is_whitespace) else {
            continue;
        };
        let keyword = keyword.to_ascii_lowercase();
        if keyword == "newmtl" {
            rest.trim().clone_into(&mut material);
        } else if let Some(kind) = MAPS.iter().position(|map| *map == keyword) {
            let name = without_options(rest).replace("<UDIM>", FIRST_TILE);
            images[kind].push((material.clone(), named(folder, &name)));
        }
    }
    Ok(images.into_iter().flatten().collect())
}

/// What the name of an image has where it is the first of several tiles (UDIM).
const FIRST_TILE: &str = "1001";

/// How many tiles are beside each other, and how many of such rows have a number of four digits.
const TILES: [i64; 2] = [10, 899];

/// The image of a tile, so many to the right of the first and above it, by the name of the first's; nothing where that has
/// no number of a first tile, or there is no such tile.
pub fn tile_image(first: &Path, [right, up]: [i64; 2]) -> Option<PathBuf> {
    let name = first.file_name()?.to_str()?;
    let (before, after) = name.rsplit_once(FIRST_TILE)?;
    if !(0..TILES[0]).contains(&right) || !(0..TILES[1]).contains(&up) {
        return None;
    }
    let number = 1001 + right + TILES[0] * up;
    let folder = first.parent().unwrap_or(Path::new(""));
    Some(named(folder, &format!("{before}{number}{after}")))
}

/// What may be the picture on a material, the likeliest first.
const MAPS: [&str; 3] = ["map_kd", "map_ka", "map_ke"];

/// What follows the options (`-s 1 1 1`, `-clamp on`) of a map: the file's name, which may have
/// spaces.
fn without_options(rest: &str) -> &str {
    let mut rest = rest.trim();
    let mut option = false;
    loop {
        let (word, more) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
        let value = word.parse::<f64>().is_ok() || matches!(word, "on" | "off");
        if more.is_empty() || !(word.starts_with('-') || (option && value)) {
            return rest;
        }
        option = true;
        rest = more.trim_start();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_count_from_one_or_from_the_end() {
        let obj = Obj::parse(
            b"v 0 0 0\nv 1 0 0 0.5 0.25 1\r\nv 0 1 0\nvt 0.5 0.25\nusemtl skin\n\
              f 1/1 2//7 -1/-1/2\nf -3 -2 -1\n",
        )
        .expect("parses");
        assert_eq!(obj.polygon(0), [[0, 0], [1, NONE], [2, 0]]);
        assert_eq!(obj.polygon(1), [[0, NONE], [1, NONE], [2, NONE]]);
        assert_eq!(obj.runs[1].material, "skin");
        let white = DVec3::ONE;
        assert_eq!(obj.colours, [white, DVec3::new(0.5, 0.25, 1.0), white]);
        assert_eq!(obj.notes, ["colours: 2 vertices without one are white"]);
    }

    #[test]
    fn a_line_of_numbers_goes_on_after_a_backslash() {
        let obj = Obj::parse(
            b"# from C:\\scans\\\nv 0 0 \\\n0\nv 1 0 0\rv 0 1 0\r\nv 1 1 0\nf 1 \\\r\n2 \\\r\n3 4\n",
        )
        .expect("parses");
        assert_eq!(obj.positions.len(), 4);
        assert_eq!(obj.polygon(0).len(), 4);
        let wrong = Obj::parse(b"v 0 0 \\\n0\nf 1 1 2\n").expect_err("no vertex 2");
        assert!(wrong.starts_with("line 3: "), "{wrong}");
        assert!(Obj::parse(b"v 0 0 0\nf 1 1 1 \\").is_ok(), "at the end");
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line() {
        for (text, cause) in [
            ("v 0 0\n", "line 1: too few numbers"),
            ("v 0 0 x\n", "line 1: `x` is no number"),
            (
                "v 0 0 0\n\nv 0 nan 0\nf 1 1 2\n",
                "line 3: `nan` is not finite",
            ),
            (
                "v -1.#IND 0 0\nf 1 1 1\n",
                "line 1: `-1.#IND` is not finite",
            ),
            (
                "v 0 0 0\nf 1 1 2\n",
                "line 2: vertex 2, and there are 1 so far",
            ),
            ("v 0 0 0\nf 1 1 -2\n", "line 2: vertex -2"),
            ("v 0 0 0\nf 1 1 0\n", "line 2: vertex 0"),
            ("v 0 0 0\nf 1/-1 1 1\n", "line 2: texture coordinate -1"),
            ("v 0 0 0\nf /1 1 1\n", "line 2: a corner without a vertex"),
        ] {
            let found = Obj::parse(text.as_bytes()).expect_err(text);
            assert!(found.starts_with(cause), "{found}");
        }
    }

    #[test]
    fn comments_end_a_line_and_vertices_without_a_face_may_be_anything() {
        let obj = Obj::parse(
            b"v 0 0 0 # C:\\scans\\\nv 1 0 0\nv 0 1 0 #\nv nan nan nan\nv -1.#IND 0 1.#QNAN\n\
              v -nan(ind) 0 0\nf 1 2 3 # comment 9\n",
        )
        .expect("parses");
        assert_eq!(obj.positions.len(), 6);
        assert_eq!(obj.polygon(0), [[0, NONE], [1, NONE], [2, NONE]]);
        assert!(obj.colours.is_empty());
    }

    #[test]
    fn tiles_are_numbered_to_the_right_and_then_upwards() {
        let of = |first: &str, tile: [i64; 2]| tile_image(Path::new(first), tile);
        let skin = |number: u32| Some(PathBuf::from(format!("a/skin.{number}.png")));
        assert_eq!(of("a/skin.1001.png", [0, 0]), skin(1001));
        assert_eq!(of("a/skin.1001.png", [9, 0]), skin(1010));
        assert_eq!(of("a/skin.1001.png", [2, 1]), skin(1013));
        for (first, tile) in [
            ("a/skin.png", [0, 0]),
            ("1001/skin.png", [0, 0]),
            ("a/skin.1001.png", [10, 0]),
            ("a/skin.1001.png", [-1, 0]),
            ("a/skin.1001.png", [0, 899]),
        ] {
            assert_eq!(of(first, tile), None, "{first}, {tile:?}");
        }
    }

    #[test]
    fn an_image_is_what_follows_the_options() {
        for (rest, name) in [
            ("james.jpg", "james.jpg"),
            ("-s 1 1 1 -clamp on my face.png", "my face.png"),
            ("-bm 0.3 12.png", "12.png"),
        ] {
            assert_eq!(without_options(rest), name);
        }
    }
}
