//! PLY files: meshes of any kind are read; registered faces, the template's vertices in their
//! order in mm, are read and written.

use std::borrow::Cow;
use std::collections::HashSet;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};

use super::colours;
use super::files::{files_of, write_atomically};
use super::text::{decoded, not_finite, plain};
use crate::fit::{FitError, FitResult};

/// Writes a mesh as binary little-endian PLY: f32 positions and triangles. The file appears
/// whole or not at all.
pub fn write_mesh(path: &Path, positions: &[DVec3], triangles: &[[u32; 3]]) -> FitResult<()> {
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\n\
         property float y\nproperty float z\nelement face {}\n\
         property list uchar int vertex_indices\nend_header\n",
        positions.len(),
        triangles.len()
    )
    .into_bytes();
    bytes.reserve(12 * positions.len() + 13 * triangles.len());
    for p in positions {
        for value in p.as_vec3().to_array() {
            bytes.extend(value.to_le_bytes());
        }
    }
    bytes.extend(records(triangles));
    write_atomically(path, &bytes)
}

/// Triangles as [`write_mesh`] writes them, at the end of a file.
fn records(triangles: &[[u32; 3]]) -> Vec<u8> {
    let one = |triangle: &[u32; 3]| {
        let corners = triangle.map(u32::to_le_bytes);
        std::iter::once(3).chain(corners.into_iter().flatten())
    };
    triangles.iter().flat_map(one).collect()
}

/// What a PLY file says of a mesh; other elements and properties are passed over.
#[derive(Debug, Clone, Default)]
pub struct PlyMesh {
    /// Vertices in the file's units. Those of faces are finite: where depth cameras see nothing, some
    /// programs write vertices of NaN that no face has.
    pub positions: Vec<DVec3>,
    /// Texture coordinates of the vertices (`s t`, `u v` or `texture_u texture_v`), or none; some may not be finite.
    pub uvs: Vec<DVec2>,
    /// sRGB colours of the vertices (`red green blue`, `diffuse_red` ... or `r g b`), or none; where only polygons have
    /// colours, the mean of those around each.
    pub colours: Vec<[u8; 3]>,
    /// Polygons (`face`) and what strips (`tristrips`) consist of; their vertices exist.
    pub faces: Vec<Face>,
    /// Images named in comments (`TextureFile NAME`), in order.
    pub images: Vec<String>,
    /// What was decided on the way, a line each.
    pub notes: Vec<String>,
}

/// A polygon of a [`PlyMesh`].
#[derive(Debug, Clone, Default)]
pub struct Face {
    /// Its corners (`vertex_indices` or `vertex_index`).
    pub vertices: Vec<u32>,
    /// The corners' texture coordinates, u and v in turn (`texcoord`), or none.
    pub uvs: Vec<f64>,
    /// Which of the images they belong to (`texnumber`).
    pub image: i64,
    /// Its colour as the vertices have theirs, 0 to 1, or what a file has in place of that; black where it has none.
    colour: DVec3,
}

/// Reads a mesh from a PLY file, ascii or binary of either endianness.
///
/// # Errors
/// When the file is no PLY, ends early, or has vertices without x, y and z, numbers that are not
/// finite, or faces of vertices that do not exist: with the element and its number.
pub fn read_mesh(path: &Path) -> FitResult<PlyMesh> {
    read(path, true)
}

/// Reads the vertex positions of a PLY file, ascii or binary of either endianness.
pub fn read_positions(path: &Path) -> FitResult<Vec<DVec3>> {
    Ok(read(path, false)?.positions)
}

fn read(path: &Path, faces: bool) -> FitResult<PlyMesh> {
    let bytes = std::fs::read(path).map_err(|e| FitError::unread(path, e))?;
    let bytes = plain(&bytes).map_err(|cause| FitError::file(path, cause))?;
    if !bytes.starts_with(b"ply") {
        return Err(FitError::file(
            path,
            "does not start with `ply`: no PLY file",
        ));
    }
    let bytes = readable(bytes);
    let mut reader = Reader::new(Cursor::new(&bytes[..]));
    let header = Parser::<Vertex>::new()
        .read_header(&mut reader)
        .map_err(|e| FitError::file(path, format!("header: {}", one_line(&e))))?;
    let mut mesh = PlyMesh {
        images: header.comments.iter().filter_map(|c| image(c)).collect(),
        ..PlyMesh::default()
    };
    let mut found = false;
    let mut faces_coloured = false;
    for (name, element) in &header.elements {
        let fail = |cause: String| FitError::file(path, format!("element `{name}`: {cause}"));
        // A record takes a byte at the very least: no file can hold more of them.
        if element.count > bytes.len() {
            return Err(fail(format!(
                "{} of them in a file of {} bytes",
                element.count,
                bytes.len()
            )));
        }
        let has = |property: &str| element.properties.iter().any(|(name, _)| name == property);
        let coloured = CHANNELS.iter().all(|names| names.iter().any(|c| has(c)));
        if (name == "face" || name == "tristrips") && faces {
            faces_coloured |= coloured && name == "face";
            let read = Parser::<Face>::new()
                .read_payload_for_element(&mut reader, element, &header)
                .map_err(|e| fail(one_line(&e)))?;
            match name == "face" {
                true => mesh.faces.extend(read),
                false => mesh.faces.extend(read.iter().flat_map(Face::triangles)),
            }
            continue;
        }
        let vertices = Parser::<Vertex>::new()
            .read_payload_for_element(&mut reader, element, &header)
            .map_err(|e| fail(one_line(&e)))?;
        if name == "vertex" {
            if let Some(axis) = ["x", "y", "z"].iter().find(|axis| !has(axis)) {
                return Err(fail(format!("no property `{axis}`")));
            }
            let bad = vertices.iter().position(|v| !v.position.is_finite());
            if let Some(bad) = bad.filter(|_| !faces) {
                return Err(fail(format!("vertex {bad} is not finite")));
            }
            // Vertices without a place in the picture may have no number there.
            let textured = vertices.iter().any(|v| v.uv.is_finite());
            if textured {
                mesh.uvs = vertices.iter().map(|v| v.uv).collect();
            }
            if coloured {
                let mut colours: Vec<DVec3> = vertices.iter().map(|v| v.colour).collect();
                mesh.notes.extend(colours::to_unit(&mut colours));
                mesh.colours = colours.into_iter().map(colours::bytes).collect();
            }
            mesh.positions = vertices.iter().map(|v| v.position).collect();
            found = true;
            if !faces {
                break;
            }
        }
    }
    if !found {
        return Err(FitError::file(path, "no element `vertex`"));
    }
    for (index, face) in mesh.faces.iter().enumerate() {
        let count = mesh.positions.len();
        if let Some(&bad) = face.vertices.iter().find(|&&v| v as usize >= count) {
            // A negative index reads as one beyond all that a file can hold.
            let cause = format!("face {index} has vertex {}, of {count}", bad as i32);
            return Err(FitError::file(path, cause));
        }
        let at = |v: u32| mesh.positions[v as usize];
        if let Some(bad) = face.vertices.iter().find(|&&v| !at(v).is_finite()) {
            let cause = format!("element `vertex`: vertex {bad} is not finite");
            return Err(FitError::file(path, cause));
        }
    }
    if faces_coloured && mesh.colours.is_empty() {
        mesh.colours_of_faces();
    }
    Ok(mesh)
}

impl PlyMesh {
    /// Gives each vertex the mean colour of the faces around it.
    fn colours_of_faces(&mut self) {
        let mut sums = vec![(DVec3::ZERO, 0.0); self.positions.len()];
        for face in &self.faces {
            for &v in &face.vertices {
                let (sum, count) = &mut sums[v as usize];
                *sum += face.colour;
                *count += 1.0;
            }
        }
        let mean = |(sum, count): (DVec3, f64)| sum / count.max(1.0);
        let mut colours: Vec<DVec3> = sums.into_iter().map(mean).collect();
        self.notes.extend(colours::to_unit(&mut colours));
        self.colours = colours.into_iter().map(colours::bytes).collect();
        let note = "colours: of faces, so that a vertex has the mean of those around it";
        self.notes.push(note.into());
    }
}

/// The file as the library takes it: its header in UTF-8, in comments too, without lines that are empty, with names of
/// properties as [`named_apart`] has them; and numbers in text as [`with_plain_numbers`] has them.
fn readable(bytes: Cow<'_, [u8]>) -> Cow<'_, [u8]> {
    const END: &[u8] = b"end_header";
    let end = bytes.windows(END.len()).position(|word| word == END);
    let (header, rest) = bytes.split_at(end.unwrap_or(0));
    let text = decoded(header);
    let lines = text
        .split_inclusive('\n')
        .filter(|line| !line.trim().is_empty());
    let is_text = lines.clone().any(|line| line.starts_with("format ascii"));
    let mut taken = HashSet::new();
    let new: String = lines.map(|line| named_apart(line, &mut taken)).collect();
    let data = rest.iter().position(|&b| b == b'\n').map_or(0, |at| at + 1);
    let (end, data) = rest.split_at(data);
    let numbers = match is_text {
        true => with_plain_numbers(data),
        false => data.into(),
    };
    match (new.as_bytes() == header, &numbers) {
        (true, Cow::Borrowed(_)) => bytes,
        _ => [new.as_bytes(), end, &*numbers].concat().into(),
    }
}

/// A line of a header in which the name of a property has letters, digits, `_` and `-` alone, and is that of no other of
/// its element, of which `taken` are. The library takes no `scalar_Roughness_(0.1)`, and of two of one name but the last,
/// so that all that follows would be read from the wrong place.
fn named_apart<'a>(line: &'a str, taken: &mut HashSet<String>) -> Cow<'a, str> {
    let text = line.trim_end();
    let mut words = text.split_whitespace();
    match words.next() {
        Some("element") => taken.clear(),
        Some("property") => {
            let kind = match words.next() {
                Some("list") => format!(
                    "list {} {}",
                    words.next().unwrap_or_default(),
                    words.next().unwrap_or_default()
                ),
                kind => kind.unwrap_or_default().to_owned(),
            };
            let own: Vec<&str> = words.collect();
            let mut name = own.join("_").replace(
                |c: char| !(c.is_ascii_alphanumeric() || matches!(c, '_' | '-')),
                "_",
            );
            if !name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') {
                name.insert(0, '_');
            }
            while !taken.insert(name.clone()) {
                name.push('_');
            }
            if !own.is_empty() && own != [&*name] {
                let end = &line[text.len()..];
                return format!("property {kind} {name}{end}").into();
            }
        }
        _ => {}
    }
    line.into()
}

/// Rows of numbers in text as the library takes them: none is empty, and a number is finite, with digits on both sides of
/// its point. What is not finite becomes a number that is too large to be.
fn with_plain_numbers(data: &[u8]) -> Cow<'_, [u8]> {
    let digit = |at: usize| data.get(at).is_some_and(u8::is_ascii_digit);
    let is_odd = |(at, &byte): (usize, &u8)| match byte {
        b'.' => at == 0 || !digit(at - 1) || !digit(at + 1),
        b'\n' => {
            let before = data[..at].strip_suffix(b"\r").unwrap_or(&data[..at]);
            before.is_empty() || before.ends_with(b"\n")
        }
        _ => byte.is_ascii_alphabetic() && !byte.eq_ignore_ascii_case(&b'e'),
    };
    if !data.iter().enumerate().any(is_odd) {
        return data.into();
    }
    let mut plain = Vec::with_capacity(data.len());
    for row in data.split(|&b| b == b'\n') {
        let words = row.split(u8::is_ascii_whitespace);
        let mut words = words.filter(|word| !word.is_empty()).peekable();
        let is_row = words.peek().is_some();
        for word in words {
            let value = std::str::from_utf8(word).ok().map(str::parse::<f64>);
            match value {
                _ if not_finite(word) => plain.extend(b"1e999"),
                Some(Ok(value)) if value.is_finite() => plain.extend(value.to_string().bytes()),
                _ => plain.extend(word),
            }
            plain.push(b' ');
        }
        plain.extend(is_row.then_some(b'\n'));
    }
    plain.into()
}

/// The library's errors span lines, and what follows `String:` is its own state.
fn one_line(error: &dyn std::fmt::Display) -> String {
    let text = error.to_string();
    if text.contains("failed to fill whole buffer") {
        return "the file ends in the middle of it".into();
    }
    let text = text.split("String:").next().unwrap_or_default();
    let text = text.replace("Couldn't read element line.", "no row of numbers");
    let text = text.replace("Line ", "line ");
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The file that a comment such as `TextureFile face.png` names.
fn image(comment: &str) -> Option<String> {
    let (keyword, name) = comment.trim().split_once(char::is_whitespace)?;
    keyword
        .eq_ignore_ascii_case("texturefile")
        .then(|| name.trim().to_owned())
}

/// Heads are of sizes well between this many times the template's and a part of as many; units lie farther apart.
const OTHER_UNIT: f64 = 3.0;

/// The root mean square distance of vertices from their middle.
fn size(positions: &[DVec3]) -> f64 {
    let count = positions.len().max(1) as f64;
    let middle = positions.iter().sum::<DVec3>() / count;
    let squares = positions.iter().map(|p| p.distance_squared(middle));
    (squares.sum::<f64>() / count).sqrt()
}

/// Reads every `.ply` of a folder, or one file, as a face registered to a template that has its vertices at `rest` (mm)
/// and these triangles, sorted by name. The name is the file's without its ending.
///
/// Which triangles come first, and which corner of each, does not matter. A file without any, of vertices alone, is
/// taken for one of the template's.
///
/// # Errors
/// When a file cannot be read, has another number of vertices or other triangles, whose vertices then are in another
/// order, or is so large or small that it is not in millimetres, and when there are no faces.
pub fn read_faces(
    dir: &Path,
    rest: &[DVec3],
    triangles: &[[u32; 3]],
) -> FitResult<Vec<(String, Vec<DVec3>)>> {
    let (vertices, usual) = (rest.len(), size(rest));
    let ends = records(triangles);
    let wanted = in_order(triangles.iter().copied());
    let mut paths = match dir.is_file() {
        true => vec![dir.to_owned()],
        false => faces(dir)?,
    };
    if paths.is_empty() {
        return Err(FitError::file(dir, "no .ply files"));
    }
    paths.sort();
    paths
        .iter()
        .map(|path| {
            let positions = read_positions(path)?;
            if positions.len() != vertices {
                let cause = format!(
                    "{} vertices where the template has {vertices}: not registered to this template",
                    positions.len()
                );
                return Err(FitError::file(path, cause));
            }
            // Most are as they were written. To read triangles takes ten times as long as vertices.
            let bytes = std::fs::read(path).map_err(|e| FitError::unread(path, e))?;
            if !bytes.ends_with(&ends) {
                let faces = read_mesh(path)?.faces;
                let corners = |face: &Face| <[u32; 3]>::try_from(&face.vertices[..]).ok();
                let there: Option<Vec<[u32; 3]>> = faces.iter().map(corners).collect();
                let same = there.is_some_and(|there| in_order(there) == wanted);
                if !faces.is_empty() && !same {
                    let cause = "its triangles are not the template's, so its vertices may be in another order: not \
                                 registered to this template, or changed by another program";
                    return Err(FitError::file(path, cause));
                }
            }
            let own = size(&positions);
            if !(usual / OTHER_UNIT..=usual * OTHER_UNIT).contains(&own) {
                let cause = format!(
                    "its vertices are {own:.3e} RMS from their middle, where the template's are {usual:.1} mm: registered \
                     faces are in millimetres"
                );
                return Err(FitError::file(path, cause));
            }
            let name = path.file_stem().unwrap_or_default().to_string_lossy();
            Ok((name.into_owned(), positions))
        })
        .collect()
}

/// Triangles in an order that does not depend on which comes first, nor which corner of each; their sense is kept.
fn in_order(triangles: impl IntoIterator<Item = [u32; 3]>) -> Vec<[u32; 3]> {
    let mut all: Vec<[u32; 3]> = (triangles.into_iter())
        .map(|mut corners| {
            let least = (0..3).min_by_key(|&i| corners[i]).unwrap_or_default();
            corners.rotate_left(least);
            corners
        })
        .collect();
    all.sort_unstable();
    all
}

/// Whether there is any `.ply` in a folder.
///
/// # Errors
/// When the folder cannot be read.
pub fn has_faces(dir: &Path) -> FitResult<bool> {
    Ok(!faces(dir)?.is_empty())
}

/// Every `.ply` of a folder, in no order.
pub(in crate::fit) fn faces(dir: &Path) -> FitResult<Vec<PathBuf>> {
    let mut paths = files_of(dir)?;
    paths.retain(|path| {
        let ending = path.extension();
        ending.is_some_and(|e| e.eq_ignore_ascii_case("ply"))
    });
    Ok(paths)
}

/// A vertex; what its element does not have stays NaN or black.
struct Vertex {
    position: DVec3,
    uv: DVec2,
    /// 0 to 1, or what a file has in place of that.
    colour: DVec3,
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Vertex {
            position: DVec3::NAN,
            uv: DVec2::NAN,
            colour: DVec3::ZERO,
        }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let place = match name {
            "x" => &mut self.position.x,
            "y" => &mut self.position.y,
            "z" => &mut self.position.z,
            "s" | "u" | "texture_u" => &mut self.uv.x,
            "t" | "v" | "texture_v" => &mut self.uv.y,
            _ => return set_channel(&mut self.colour, name, &property),
        };
        match scalar(&property) {
            Some(value) => *place = value,
            None => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

/// What programs call the channels of a colour.
const CHANNELS: [[&str; 3]; 3] = [
    ["red", "diffuse_red", "r"],
    ["green", "diffuse_green", "g"],
    ["blue", "diffuse_blue", "b"],
];

/// Sets the channel of a colour that a property is, if it is one: 0 to 1, or what a file has in place of that.
fn set_channel(colour: &mut DVec3, name: &str, property: &Property) -> PropertyAccessResult {
    let Some(channel) = CHANNELS.iter().position(|names| names.contains(&name)) else {
        return PropertyAccessResult::Ignored;
    };
    let value = scalar(property).unwrap_or(0.0);
    colour[channel] = match property {
        Property::Float(_) | Property::Double(_) => value,
        Property::UShort(_) => value / 65535.0,
        // Integers of any other size count as bytes do.
        _ => value.clamp(0.0, 255.0) / 255.0,
    };
    PropertyAccessResult::Set
}

/// Ends a strip of triangles in a list of them: -1.
const NO_VERTEX: u32 = u32::MAX;

impl Face {
    /// The triangles of strips: each vertex makes one with the two before it, every other one turned.
    fn triangles(&self) -> impl Iterator<Item = Face> {
        let strips = self.vertices.split(|&v| v == NO_VERTEX);
        let turned = |(i, t): (usize, &[u32])| match i % 2 {
            0 => [t[0], t[1], t[2]],
            _ => [t[1], t[0], t[2]],
        };
        strips
            .flat_map(move |strip| strip.windows(3).enumerate().map(turned))
            // A strip turns a corner by going through a vertex twice.
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .map(|corners| Face {
                vertices: corners.to_vec(),
                ..Face::default()
            })
    }
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Face::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        match name {
            "vertex_indices" | "vertex_index" => {
                self.vertices = match property {
                    Property::ListInt(list) => list.into_iter().map(|v| v as u32).collect(),
                    Property::ListUInt(list) => list,
                    Property::ListUShort(list) => list.into_iter().map(u32::from).collect(),
                    Property::ListShort(list) => list.into_iter().map(|v| v as u32).collect(),
                    Property::ListUChar(list) => list.into_iter().map(u32::from).collect(),
                    Property::ListChar(list) => list.into_iter().map(|v| v as u32).collect(),
                    _ => return PropertyAccessResult::Ignored,
                };
            }
            "texcoord" => {
                self.uvs = match property {
                    Property::ListFloat(list) => list.into_iter().map(f64::from).collect(),
                    Property::ListDouble(list) => list,
                    _ => return PropertyAccessResult::Ignored,
                };
            }
            "texnumber" => self.image = scalar(&property).map_or(0, |number| number as i64),
            _ => return set_channel(&mut self.colour, name, &property),
        }
        PropertyAccessResult::Set
    }
}

/// The value of a property that is no list.
fn scalar(property: &Property) -> Option<f64> {
    Some(match *property {
        Property::Float(value) => value.into(),
        Property::Double(value) => value,
        Property::Char(value) => value.into(),
        Property::UChar(value) => value.into(),
        Property::Short(value) => value.into(),
        Property::UShort(value) => value.into(),
        Property::Int(value) => value.into(),
        Property::UInt(value) => value.into(),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_of_other_triangles_are_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let positions = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let own = [[0, 1, 2], [0, 2, 3]];
        let write = |triangles: &[[u32; 3]]| {
            let path = folder.path().join("anna.ply");
            write_mesh(&path, &positions, triangles).unwrap();
            read_faces(folder.path(), &positions, &own)
        };
        // In any order, from any corner, or none.
        let same: [&[[u32; 3]]; 3] = [&own, &[[2, 3, 0], [1, 2, 0]], &[]];
        for triangles in same {
            assert_eq!(write(triangles).unwrap()[0].1, positions);
        }
        let others: [&[[u32; 3]]; 4] = [
            &[[0, 1, 3], [1, 2, 3]],
            &[[0, 2, 1], [0, 3, 2]],
            &[[0, 1, 2]],
            &[[0, 1, 2], [0, 2, 3], [0, 1, 3]],
        ];
        for triangles in others {
            let error = write(triangles).unwrap_err().to_string();
            let said = "anna.ply: its triangles are not the template's";
            assert!(error.contains(said), "{error}");
        }
    }

    #[test]
    fn a_header_may_have_empty_lines() {
        for end in ["\n", "\r\n"] {
            let header = "ply\nformat ascii 1.0\n\ncomment a\n  \nelement vertex 1\nproperty float x\n\
                          property float y\nproperty float z\n\nend_header\n1 2 3\n";
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("a.ply");
            std::fs::write(&path, header.replace('\n', end)).unwrap();
            let read = read_positions(&path).unwrap();
            assert_eq!(read, [DVec3::new(1.0, 2.0, 3.0)]);
        }
    }
}
