//! Scans: unregistered meshes of one person, as other programs write them.
//!
//! A reader a format ([`obj`](crate::fit::format::obj), [`ply`](crate::fit::format::ply),
//! [`stl`](crate::fit::format::stl), glTF) says what a file says;
//! what is the same for all of them, from units to welding, is done here. [`landmarks`] reads the
//! points that come with a scan, [`check`](fn@check) says whether the two belong together.

use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};

use crate::fit::format::files::check_apart;
use crate::fit::{FitError, FitResult};

pub mod landmarks;

mod brows;
mod check;
mod glb;
mod mesh_file;
mod polygon;
mod unit;

pub(in crate::fit) use brows::off_hair;
pub use check::check;
pub(in crate::fit) use check::{Placement, spread};
use unit::EXTENTS;
pub use unit::Unit;

/// The endings of files that are read as scans, in lower case.
pub const ENDINGS: [&str; 5] = ["obj", "ply", "glb", "gltf", "stl"];

/// [`ENDINGS`] in words.
pub(in crate::fit) fn endings() -> String {
    let [first @ .., last] = ENDINGS.map(|ending| format!(".{ending}"));
    format!("{} and {last}", first.join(", "))
}

/// A scan: one person's surface, in mm.
#[derive(Debug, Clone, Default)]
pub struct Scan {
    /// Vertices, mm, in the scan's own pose; no two at the same place, all of them used.
    pub positions: Vec<DVec3>,
    /// Triangles, counter-clockwise from outside; none without area.
    pub triangles: Vec<[u32; 3]>,
    /// sRGB colours of the vertices where the file has them, or none.
    pub colours: Vec<[u8; 3]>,
    /// Texture coordinates and image, where the file has both.
    pub texture: Option<Texture>,
    /// Millimetres in one unit of the file: what its landmarks are multiplied with too.
    pub scale: f64,
    /// Whether the unit was guessed from the size, so that landmarks may tell better.
    pub unit_guessed: bool,
    /// What the reader decided by itself, a line each ("units: metres, by the size of ...").
    pub notes: Vec<String>,
    /// The file, for messages.
    pub path: PathBuf,
    /// The other files that belong to it: materials, images, buffers, also those that could not be read.
    pub beside: Vec<PathBuf>,
}

/// How the note begins that says which unit was guessed.
const UNITS: &str = "units: ";

/// The note that triangles were turned by the sign of the volume, which is only likely: a floor below a
/// head, or a wall behind it, may have the other sign and more of it.
const TURNED: &str = "triangles: all turned, because the surface was inside out";

/// The note that the face on a scan told what the volume had not.
const TURNED_BY_FACE: &str = "triangles: all turned, because there then is a face";

/// The note that its landmarks did.
const TURNED_BY_POINTS: &str =
    "triangles: all turned, because by its landmarks the surface was inside out";

/// A picture on a mesh.
#[derive(Debug, Clone, Default)]
pub struct Texture {
    /// Texture coordinates, (0, 0) at the lower left of the picture.
    pub uvs: Vec<DVec2>,
    /// The texture coordinates of each triangle's corners; [`Texture::BARE`] for a triangle that
    /// the picture does not cover.
    pub triangles: Vec<[u32; 3]>,
    /// Pixels a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// sRGB, row by row from the top.
    pub pixels: Vec<[u8; 3]>,
}

impl Texture {
    /// The corners of a triangle without texture.
    pub const BARE: [u32; 3] = [u32::MAX; 3];
}

impl Scan {
    /// Reads a scan by its ending, one of [`ENDINGS`]; an OBJ with its MTL file and image.
    ///
    /// Polygons are cut into triangles, vertices at the same place become one, triangles without
    /// area and vertices without triangles go, a surface with two sides keeps one,
    /// several images become one, and a surface that is inside out is turned. A unit
    /// that is not given is guessed by the size of the mesh. All of this is said in
    /// [`Scan::notes`], as is an image that is missing or broken.
    ///
    /// # Errors
    /// When the file cannot be read as its ending says, with the place in it, has no triangle
    /// with an area, or is too small or large for a head.
    pub fn read(path: &Path, unit: Option<Unit>) -> FitResult<Scan> {
        Self::read_with(path, unit, true)
    }

    /// The same without its images: to open them may take longer than all else, and a gigabyte.
    ///
    /// # Errors
    /// Those of [`Scan::read`].
    pub fn read_shape(path: &Path, unit: Option<Unit>) -> FitResult<Scan> {
        Self::read_with(path, unit, false)
    }

    fn read_with(path: &Path, unit: Option<Unit>, pictures: bool) -> FitResult<Scan> {
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        let about = std::fs::metadata(path).map_err(|e| FitError::unread(path, e))?;
        if about.is_dir() {
            return Err(FitError::file(path, "a folder, not a scan"));
        }
        if about.len() == 0 {
            return Err(FitError::file(path, "the file is empty"));
        }
        let file = match ending.as_deref() {
            Some("obj") => mesh_file::obj(path, pictures)?,
            Some("ply") => mesh_file::ply(path, pictures)?,
            Some("glb" | "gltf") => glb::read(path, pictures)?,
            Some("stl") => mesh_file::stl(path)?,
            _ => {
                let cause = format!("not a scan's ending: {} are read", endings());
                return Err(FitError::file(path, cause));
            }
        };
        let mut scan = file.weld(path)?;
        if !pictures {
            scan.notes.retain(|note| !note.starts_with("texture: "));
        }
        let extent = extent(&scan.positions);
        if extent == 0.0 {
            return Err(FitError::file(path, "all vertices are at one place"));
        }
        scan.unit_guessed = unit.is_none();
        let unit = unit.unwrap_or_else(|| Unit::of_extent(extent));
        if scan.unit_guessed {
            scan.say_unit(unit, &format!("because the mesh is {extent:.3} across"));
        }
        scan.rescale(unit.millimetres());
        scan.plausible(unit)
            .map_err(|error| scan.doubting_unit(error))?;
        if volume(&scan.positions, &scan.triangles) < 0.0 {
            scan.turn_inside_out();
            scan.notes.push(TURNED.into());
        }
        Ok(scan)
    }

    /// Refuses to write over what belongs to the scan, before the work on it.
    ///
    /// # Errors
    /// When one of the files to be written is one of [`Scan::beside`].
    pub fn check_beside(&self, written: &[&Path]) -> FitResult<()> {
        let what = "a material, an image or a buffer of the scan";
        let beside = self.beside.iter().map(|path| (what, path.as_path()));
        check_apart(written, &beside.collect::<Vec<_>>())
    }

    /// The unit of the file that is in use.
    pub fn unit(&self) -> Unit {
        let used = |unit: &Unit| unit.millimetres() == self.scale;
        let known = Unit::ALL.into_iter().find(used);
        known.unwrap_or(Unit::Own(self.scale))
    }

    /// Puts the guess of the unit into an error that it may be the cause of, and how to do without.
    pub(in crate::fit) fn doubting_unit(&self, error: FitError) -> FitError {
        let guess = self.notes.iter().find_map(|note| note.strip_prefix(UNITS));
        match (error, guess) {
            (FitError::File { path, cause }, Some(guess)) => {
                let guess = guess.split(';').next().unwrap_or_default();
                let cause = format!("{cause}; its unit is guessed ({guess}): --unit gives another");
                FitError::File { path, cause }
            }
            (error, _) => error,
        }
    }

    /// Takes another unit for the one that is in use.
    pub(in crate::fit) fn rescale(&mut self, scale: f64) {
        let factor = scale / if self.scale > 0.0 { self.scale } else { 1.0 };
        self.positions.iter_mut().for_each(|p| *p *= factor);
        self.scale = scale;
    }

    /// Says which unit was guessed and why, in place of what was said before.
    pub(in crate::fit) fn say_unit(&mut self, unit: Unit, why: &str) {
        self.notes.retain(|note| !note.starts_with(UNITS));
        self.notes.push(match unit {
            Unit::Own(millimetres) => format!(
                "{UNITS}its own, of {millimetres:.4} mm, {why}; how large it was, is not known"
            ),
            _ => format!("{UNITS}{unit}, {why}"),
        });
    }

    /// Whether points in the file's units lie in the box of the scan, or a fifth of its size around it.
    fn surrounds(&self, points: &[(usize, DVec3)]) -> bool {
        let (low, high) = bounds(&self.positions);
        let around = DVec3::splat(0.2 * (high - low).max_element());
        (points.iter().map(|(_, p)| *p * self.scale))
            .all(|p| p.cmpge(low - around).all() && p.cmple(high + around).all())
    }

    fn plausible(&self, unit: Unit) -> FitResult<()> {
        let extent = extent(&self.positions);
        if EXTENTS.contains(&extent) {
            return Ok(());
        }
        let what = match extent < *EXTENTS.start() {
            true => "small for a head",
            false => "large for a head: if that is its unit, it is to be cut to the head",
        };
        let cause = format!("in {unit} the mesh is {extent:.4} mm across: too {what}");
        Err(FitError::file(&self.path, cause))
    }

    /// Says that the face on it is found the other way round than the volume told. What was turned as
    /// a whole is then as in its file, of which nothing is to be said.
    pub(in crate::fit) fn say_turned_by_face(&mut self) {
        self.say_turned(TURNED_BY_FACE);
    }

    fn say_turned(&mut self, why: &str) {
        let before = self.notes.len();
        self.notes.retain(|note| note != TURNED);
        if self.notes.len() == before {
            self.notes.push(why.into());
        }
    }

    pub(in crate::fit) fn turn_inside_out(&mut self) {
        self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        if let Some(texture) = &mut self.texture {
            texture.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
    }
}

/// The corners of the box around some points.
fn bounds(points: &[DVec3]) -> (DVec3, DVec3) {
    let low = points.iter().fold(DVec3::INFINITY, |a, &p| a.min(p));
    let high = points.iter().fold(DVec3::NEG_INFINITY, |a, &p| a.max(p));
    (low, high)
}

/// The longest side of the box around some points.
pub(in crate::fit) fn extent(points: &[DVec3]) -> f64 {
    let (low, high) = bounds(points);
    (high - low).max_element().max(0.0)
}

/// Six times the volume of the cones from the surface's centre of area over its triangles: for a
/// closed surface its volume, and positive too for any open one that is mostly convex.
fn volume(positions: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
    let (mut centre, mut area) = (DVec3::ZERO, 0.0);
    let corners = |t: &[u32; 3]| t.map(|v| positions[v as usize]);
    for [a, b, c] in triangles.iter().map(corners) {
        let size = (b - a).cross(c - a).length();
        centre += (a + b + c) / 3.0 * size;
        area += size;
    }
    let centre = centre / area;
    triangles
        .iter()
        .map(corners)
        .map(|[a, b, c]| (a - centre).dot((b - centre).cross(c - centre)))
        .sum()
}
