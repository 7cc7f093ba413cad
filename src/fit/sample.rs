//! People drawn from a model, as files: for crowds, for data sets, for other programs.

use std::collections::BTreeSet;
use std::io::Write;
use std::path::{Path, PathBuf};

use glam::Vec3;
use npyz::WriterBuilder;
use rayon::prelude::*;
use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::fit::format::files::{files_of, write_atomically, write_through};
use crate::fit::format::glb;
use crate::fit::format::obj;
use crate::fit::format::ply;
use crate::fit::{FitError, FitResult};
use crate::model::About;
use crate::{Face, FaceModel, Randomize};

/// Faces that are computed before they are written to a common file.
const BATCH: u32 = 256;

/// Numbers in names of files have so many digits at least.
const DIGITS: usize = 4;

/// What faces are written as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// A Wavefront OBJ a face, mm, with texture coordinates and a group a part.
    Obj,
    /// A binary PLY a face, mm: positions and triangles.
    Ply,
    /// A binary glTF a face, in metres as glTF has it, with normals, texture coordinates and
    /// colours.
    Glb,
    /// One NumPy array of all faces: faces x vertices x 3, f32, mm.
    Npy,
}

/// Where faces go.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Target {
    folder: PathBuf,
    /// What files of single faces start with, or the name of the file of all.
    stem: String,
    format: Format,
}

impl Target {
    /// What a path means: `DIR` is PLY files in it, `DIR/NAME.obj` (`.ply`, `.glb`) files of that
    /// format whose names start with `NAME`, `DIR/NAME.npy` one file. What has another ending is a folder
    /// where it is there, or where a slash says so.
    ///
    /// # Errors
    /// When it ends in something else, or has no name.
    pub fn parse(path: &Path) -> FitResult<Self> {
        let last = path.as_os_str().as_encoded_bytes().last();
        let slash = last.is_some_and(|&b| std::path::is_separator(b.into()));
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        let ending = ending.filter(|_| !slash && !path.is_dir());
        let format = match ending.as_deref() {
            None => {
                return Ok(Self {
                    folder: path.into(),
                    stem: "face".into(),
                    format: Format::Ply,
                });
            }
            Some("obj") => Format::Obj,
            Some("ply") => Format::Ply,
            Some("glb") => Format::Glb,
            Some("npy") => Format::Npy,
            Some(_) => {
                let cause = "ends in none of obj, ply, glb, npy; a folder's name ends in a slash";
                return Err(FitError::file(path, cause));
            }
        };
        let stem = path.file_stem().and_then(|s| s.to_str());
        Ok(Self {
            folder: path.parent().unwrap_or(Path::new("")).into(),
            stem: stem
                .ok_or_else(|| FitError::file(path, "has no name that is text"))?
                .into(),
            format,
        })
    }
}

/// Refuses a folder that files of a former run would stay in beside `count` new ones, with the same names but for the number:
/// nobody could tell them apart.
fn check_folder(target: &Target, own: &BTreeSet<String>, ending: &str) -> FitResult<()> {
    let is_other = |path: &PathBuf| {
        let name = path.file_name().and_then(|name| name.to_str());
        let Some((stem, end)) = name.and_then(|name| name.rsplit_once('.')) else {
            return false;
        };
        let number = stem.strip_prefix(&*target.stem);
        let number = number.and_then(|rest| rest.strip_prefix('_'));
        number.is_some_and(|n| n.len() >= DIGITS && n.bytes().all(|b| b.is_ascii_digit()))
            && end.eq_ignore_ascii_case(ending)
            && !name.is_some_and(|name| own.contains(name))
    };
    let folder = match target.folder.as_os_str().is_empty() {
        true => Path::new("."),
        false => &target.folder,
    };
    match files_of(folder)?.into_iter().filter(is_other).min() {
        Some(other) => {
            let count = own.len();
            let cause =
                format!("a face that is none of these {count}: they go to a folder of their own");
            Err(FitError::file(&other, cause))
        }
        None => Ok(()),
    }
}

/// What [`write`] says of faces beside them.
#[derive(Deserialize)]
struct Beside {
    #[serde(rename = "model")]
    _model: About,
    #[serde(rename = "faces")]
    _faces: Vec<IgnoredAny>,
}

/// Refuses to write what is said of the faces over another file of that name, such as the landmarks of a registered face.
fn check_beside(path: &Path) -> FitResult<()> {
    match std::fs::read(path) {
        Ok(bytes) if serde_json::from_slice::<Beside>(&bytes).is_err() => {
            let cause = "is of no former run, and would be lost: faces go by another name, or to a folder of their own";
            Err(FitError::file(path, cause))
        }
        _ => Ok(()),
    }
}

/// Coordinates as the bits of little-endian f32.
fn little_endian(positions: &[Vec3]) -> Vec<u32> {
    let numbers: &[f32] = bytemuck::cast_slice(positions);
    numbers.iter().map(|x| x.to_bits().to_le()).collect()
}

/// Draws `count` people as `like` has it, the first with `seed` and each next one with the next seed, and writes
/// them; `done` is called as often. Beside them goes `NAME.json`, which has each one's seed and code
/// ([`Face::code`]) by the name of its file, or its place in the array.
///
/// The same seed is the same face that [`Face::randomize`] draws, on one thread or many.
///
/// # Errors
/// When the model has no such attribute or region, or cannot draw what is asked, when other faces of that name are there, or
/// another JSON, and when a file cannot be written.
pub fn write(
    model: &FaceModel,
    count: u32,
    seed: u64,
    like: &Randomize,
    target: &Target,
    done: impl Fn(u64) + Sync,
) -> FitResult<()> {
    let beside = target.folder.join(format!("{}.json", target.stem));
    check_beside(&beside)?;
    std::fs::create_dir_all(&target.folder).map_err(|e| FitError::file(&target.folder, e))?;
    let digits = count.to_string().len().max(DIGITS);
    let name = |i: u32| format!("{}_{:0digits$}", target.stem, i + 1);
    let draw = |face: &mut Face, i: u32| -> FitResult<String> {
        face.randomize(&Randomize {
            seed: Some(seed.wrapping_add(i.into())),
            ..like.clone()
        })?;
        Ok(face.code())
    };
    let codes: Vec<String> = if target.format == Format::Npy {
        let path = target.folder.join(format!("{}.npy", target.stem));
        let vertices = model.parts().mean.len() as u64;
        let mut codes = Vec::new();
        write_through(&path, |file| {
            let fail = |e: std::io::Error| FitError::file(&path, e);
            // Its header; the numbers follow as they lie in memory, where its writer takes one by one.
            npyz::WriteOptions::<f32>::new()
                .dtype(npyz::DType::Plain("<f4".parse().expect("a type")))
                .shape(&[u64::from(count), vertices, 3])
                .writer(&mut *file)
                .begin_nd()
                .map_err(fail)?;
            for first in (0..count).step_by(BATCH as usize) {
                let batch: Vec<(String, Vec<u32>)> = (first..count.min(first + BATCH))
                    .into_par_iter()
                    .map_init(
                        || {
                            let mut face = model.face();
                            face.keep_normals(false);
                            face
                        },
                        |face, i| Ok((draw(face, i)?, little_endian(face.positions()))),
                    )
                    .collect::<FitResult<_>>()?;
                for (code, positions) in batch {
                    file.write_all(bytemuck::cast_slice(&positions))
                        .map_err(fail)?;
                    codes.push(code);
                    done(1);
                }
            }
            Ok(())
        })?;
        codes
    } else {
        let ending = match target.format {
            Format::Obj => "obj",
            Format::Glb => "glb",
            Format::Ply | Format::Npy => "ply",
        };
        let file = |i: u32| format!("{}.{ending}", name(i));
        check_folder(target, &(0..count).map(file).collect(), ending)?;
        let path = |i: u32| target.folder.join(file(i));
        let triangles = model.parts().topology.triangles();
        (0..count)
            .into_par_iter()
            .map_init(
                || model.face(),
                |face, i| {
                    let code = draw(face, i)?;
                    match target.format {
                        Format::Obj => obj::write_face(&path(i), face)?,
                        Format::Glb => glb::write_face(&path(i), face)?,
                        Format::Ply | Format::Npy => {
                            let wide: Vec<_> =
                                face.positions().iter().map(|p| p.as_dvec3()).collect();
                            ply::write_mesh(&path(i), &wide, &triangles)?;
                        }
                    }
                    done(1);
                    Ok(code)
                },
            )
            .collect::<FitResult<_>>()?
    };
    let list: Vec<serde_json::Value> = (0..count)
        .zip(&codes)
        .map(|(i, code)| {
            serde_json::json!({ "name": name(i), "seed": seed.wrapping_add(i.into()), "code": code })
        })
        .collect();
    let about = serde_json::json!({ "model": model.parts().about, "faces": list });
    let text = serde_json::to_vec_pretty(&about).map_err(|e| FitError::file(&beside, e))?;
    write_atomically(&beside, &text)
}
