//! Registering every scan of a folder: on all cores, resumable, and one bad scan does not stop the
//! others. A face that is there, of the scan and the landmarks as they are, stays, and all faces of
//! a folder are made in one way ([`Recipe`]).

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use glam::DVec3;
use rayon::prelude::*;

use super::{Registered, Registrar, Settings, TOLD};
use crate::fit::detect::{Detection, Detector};
use crate::fit::format::files::{files_of, place, write_atomically};
use crate::fit::format::ply;
use crate::fit::head::people::RegisteredFace;
use crate::fit::head::template::Template;
use crate::fit::scan::{ENDINGS, Scan, Unit, check, landmarks, off_hair};
use crate::fit::{FitError, FitResult};

/// A scan of a folder and what will become of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Job {
    /// The scan.
    pub scan: PathBuf,
    /// Its landmarks: the JSON or text file of its name, with an ending in any case; without one they are found.
    pub landmarks: Option<PathBuf>,
    /// The registered face.
    pub output: PathBuf,
}

impl Job {
    /// The files that it writes or takes away: the face, its landmarks and its picture.
    fn written(&self) -> [PathBuf; 3] {
        let beside = |ending: &str| self.output.with_extension(ending);
        [self.output.clone(), beside("json"), beside("png")]
    }

    /// Takes away the picture that a former face had, where this one has none.
    ///
    /// # Errors
    /// When it is there and stays.
    pub fn remove_picture(&self) -> FitResult<()> {
        let picture = self.output.with_extension("png");
        match std::fs::remove_file(&picture) {
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(FitError::file(&picture, e)),
            _ => Ok(()),
        }
    }

    /// Where it is kept what the face was made of: hidden, since it is for nobody else.
    fn made(&self) -> PathBuf {
        let mut name = std::ffi::OsString::from(".");
        name.push(self.output.file_stem().unwrap_or_default());
        name.push(".made");
        self.output.with_file_name(name)
    }

    /// Whether its face is there, and made of the scan and the landmarks as they are, with the scan's other files where
    /// they matter: its buffers, and if a picture is beside the face, all. Where nobody kept what it was made of: whether it
    /// is not older than they.
    pub fn is_done(&self) -> bool {
        self.standing() == Standing::Done
    }

    fn standing(&self) -> Standing {
        if !self.output.is_file() {
            return Standing::Missing;
        }
        let Some(now) = Made::of(self) else {
            return Standing::Unknown;
        };
        if let Ok(bytes) = std::fs::read(self.made()) {
            // Dates are not put in order: what is copied keeps its own, and clocks are wrong.
            let Ok(Kept {
                made: Some(made),
                parts,
                ..
            }) = serde_json::from_slice(&bytes)
            else {
                return Standing::Unknown;
            };
            // Of all but glTF the mesh is in the scan's own file, and the others matter to a picture alone.
            let ending = self.scan.extension();
            let matter = ending.is_some_and(|e| e.eq_ignore_ascii_case("gltf"))
                || self.output.with_extension("png").is_file();
            let is_other = made != now || matter && parts.iter().any(Part::is_changed);
            return match is_other {
                true => Standing::Changed,
                false => Standing::Done,
            };
        }
        let written = |path: &Path| path.metadata().and_then(|m| m.modified()).ok();
        let newest = [Some(&self.scan), self.landmarks.as_ref()]
            .into_iter()
            .flatten();
        let newest = newest.filter_map(|path| written(path)).max();
        let is_current =
            written(&self.output).is_some_and(|at| newest.is_none_or(|newest| newest <= at));
        match is_current {
            true => Standing::Done,
            false => Standing::Changed,
        }
    }
}

/// How a job's face stands to the files that it is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Standing {
    /// There is none.
    Missing,
    /// It is there, made of these.
    Done,
    /// It is there, made of others: one of them was changed, put there or taken away.
    Changed,
    /// It is there, and what it was made of, or what is there now, cannot be seen: a link that leads nowhere, a disk
    /// that is not connected.
    Unknown,
}

/// What a face was made of.
#[derive(Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
struct Made {
    scan: Version,
    landmarks: Option<Version>,
}

/// What is kept of a face that was made.
#[derive(Debug, serde::Serialize, serde::Deserialize)]
struct Kept {
    /// Nothing where it could not be seen.
    #[serde(flatten)]
    made: Option<Made>,
    /// Nothing of a face that an earlier version made.
    #[serde(default)]
    account: Option<Account>,
    /// The other files that belong to the scan.
    #[serde(default)]
    parts: Vec<Part>,
}

/// A file that belongs to a scan, and which of those that it has been.
#[derive(Debug, serde::Serialize, serde::Deserialize)]
struct Part {
    path: String,
    version: Version,
}

impl Part {
    /// Of a file as it is; nothing where it cannot be seen.
    fn of(path: &Path) -> Option<Self> {
        let path = place(path);
        Some(Part {
            path: path.to_str()?.to_owned(),
            version: Version::of(&path)?,
        })
    }

    /// Whether it is there, and another.
    fn is_changed(&self) -> bool {
        Version::of(Path::new(&self.path)).is_some_and(|now| now != self.version)
    }
}

/// What was decided and found on the way from a scan to its face.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Account {
    /// The part of the head's skin that the scan shows, 0..=1: the rest is carried by what is known of people.
    pub seen: f64,
    /// The expressions that it shows, each with its strength.
    pub shows: Vec<(String, f64)>,
    /// A line each, as [`Prepared::notes`].
    pub notes: Vec<String>,
}

impl Account {
    fn of(template: &Template, prepared: &Prepared, face: &Registered) -> FitResult<Self> {
        let skin = template.part_vertices("skin")?;
        let seen = skin.iter().filter(|&&v| face.covered[v as usize]).count();
        let told = face.expressions.iter().filter(|e| e.1 >= TOLD);
        Ok(Self {
            seen: seen as f64 / skin.len().max(1) as f64,
            shows: told
                .map(|(name, strength)| (name.to_string(), *strength))
                .collect(),
            notes: prepared.notes.clone(),
        })
    }
}

/// The table of what was decided and found of each scan, beside their faces.
pub const ACCOUNTS: &str = "register.csv";

/// Its columns.
const COLUMNS: [&str; 5] = ["name", "scan", "seen (%)", "shows", "notes"];

/// Writes [`ACCOUNTS`] of the faces that are there, by name: also of those that were there before. What other file has
/// that name is not written over.
///
/// # Errors
/// When it cannot be written, or is something else's.
pub fn write_accounts(jobs: &[Job], folder: &Path) -> FitResult<()> {
    let path = folder.join(ACCOUNTS);
    let fail = |e: csv::Error| FitError::file(&path, e);
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(COLUMNS).map_err(fail)?;
    for job in jobs.iter().filter(|job| job.output.is_file()) {
        let name = job.output.file_stem().unwrap_or_default();
        let kept = std::fs::read(job.made()).ok();
        let kept = kept.and_then(|bytes| serde_json::from_slice::<Kept>(&bytes).ok());
        let account = kept.and_then(|kept| kept.account);
        let [seen, shows, notes] = account.map_or_else(Default::default, |account| {
            let shows = account.shows.iter();
            let shows: Vec<_> = shows
                .map(|(name, strength)| format!("{name} {strength:.2}"))
                .collect();
            let seen = format!("{:.1}", 100.0 * account.seen);
            [seen, shows.join(", "), account.notes.join("; ")]
        });
        let scan = job.scan.file_name().unwrap_or_default();
        let row = [
            name.to_string_lossy(),
            scan.to_string_lossy(),
            seen.into(),
            shows.into(),
            notes.into(),
        ];
        table
            .write_record(row.each_ref().map(|cell| cell.as_bytes()))
            .map_err(fail)?;
    }
    let bytes = table
        .into_inner()
        .map_err(|e| FitError::file(&path, e.error()))?;
    let head = bytes
        .split_inclusive(|&b| b == b'\n')
        .next()
        .unwrap_or_default();
    match std::fs::read(&path) {
        Ok(there) if !there.starts_with(head) => Err(FitError::file(
            &path,
            "is no table of what was registered: it stays, and there is none",
        )),
        _ => write_atomically(&path, &bytes),
    }
}

/// A file, and which of those that it has been.
#[derive(Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
struct Version {
    name: String,
    bytes: u64,
    /// Nanoseconds since 1970, where the system tells.
    modified: Option<i64>,
}

impl Made {
    /// Of a job's files as they are; nothing where one of them cannot be seen.
    fn of(job: &Job) -> Option<Self> {
        let landmarks = job.landmarks.as_deref().map(Version::of);
        Some(Made {
            scan: Version::of(&job.scan)?,
            landmarks: match landmarks {
                Some(version) => Some(version?),
                None => None,
            },
        })
    }
}

impl Version {
    fn of(path: &Path) -> Option<Self> {
        let about = path.metadata().ok()?;
        let name = path.file_name()?.to_string_lossy().into_owned();
        Some(Version {
            name,
            bytes: about.len(),
            modified: about.modified().ok().map(nanoseconds),
        })
    }
}

fn nanoseconds(time: SystemTime) -> i64 {
    let whole = |apart: std::time::Duration| i64::try_from(apart.as_nanos()).unwrap_or(i64::MAX);
    match time.duration_since(SystemTime::UNIX_EPOCH) {
        Ok(after) => whole(after),
        Err(before) => -whole(before.duration()),
    }
}

/// How the faces of a folder were made: what would make other faces of the same scans.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Recipe {
    /// The program that made them, with its version; empty where that was not kept.
    #[serde(default)]
    pub made_by: String,
    /// The template's identity ([`Blob::fingerprint`](crate::blob::Blob::fingerprint)).
    pub template: u32,
    /// As in [`Settings`].
    pub prior: bool,
    /// As in [`Settings`].
    pub neutral: bool,
    /// The unit that was asked for; none where each scan's is guessed.
    pub unit: Option<String>,
}

/// Where a folder of faces says how they were made.
const RECIPE: &str = "recipe.json";

/// Files beside the faces that are of no single face, without their ending.
const OF_ALL: [&str; 3] = ["about", "labels", "recipe"];

impl Recipe {
    /// Writes it beside the faces in `folder`, where it is not yet, or where there are no faces. Another version of the
    /// program may make other faces of the same scans, or the same: which made those that are there is returned, where
    /// it is known and not this one.
    ///
    /// # Errors
    /// When the faces there were made in another way, which would mix two kinds, with what differs;
    /// when what is there cannot be read, and when nothing can be written.
    pub fn keep(&self, folder: &Path) -> FitResult<Option<String>> {
        let path = folder.join(RECIPE);
        let bytes = match std::fs::read(&path) {
            Ok(bytes) if ply::has_faces(folder)? => bytes,
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => {
                return Err(FitError::file(&path, e));
            }
            _ => {
                let bytes =
                    serde_json::to_vec_pretty(self).map_err(|e| FitError::file(&path, e))?;
                write_atomically(&path, &bytes)?;
                return Ok(None);
            }
        };
        let there: Self = serde_json::from_slice(&bytes).map_err(|e| FitError::file(&path, e))?;
        let was = if there.template != self.template {
            "with another template"
        } else if there.prior != self.prior {
            ["without its prior", "with its prior"][usize::from(there.prior)]
        } else if there.neutral != self.neutral {
            [
                "with the expressions they show",
                "without their expressions",
            ][usize::from(there.neutral)]
        } else if there.unit != self.unit {
            "in another unit"
        } else {
            let other = !there.made_by.is_empty() && there.made_by != self.made_by;
            return Ok(other.then_some(there.made_by));
        };
        let cause =
            format!("the faces there were registered {was}: others go to a folder of their own");
        Err(FitError::file(&path, cause))
    }
}

/// What is to be done of a folder.
#[derive(Debug, Default)]
pub struct Jobs {
    /// The jobs, by name.
    pub jobs: Vec<Job>,
    /// Scans that make none, by name: one that has the same name as another but for its ending, or one
    /// that is taken, or several files of landmarks, or whose face would be written over a file of the folder.
    pub refused: Vec<FitError>,
    /// Files like landmarks that have no scan's name.
    pub unclaimed: Vec<PathBuf>,
    /// Folders in the folder that hold scans, which make no jobs.
    pub deeper: Vec<PathBuf>,
}

impl Jobs {
    /// The faces in a folder that no scan has the name of, as when a scan was taken away.
    ///
    /// # Errors
    /// When the folder cannot be read.
    pub fn strays(&self, output: &Path) -> FitResult<Vec<PathBuf>> {
        let mut faces = ply::faces(output)?;
        // Of scans that are refused, former faces may be there: what is wrong is said of the scan.
        let is_refused = |face: &Path| {
            let scans = self.refused.iter().filter_map(|error| match error {
                FitError::File { path, .. } | FitError::Unread { path, .. } => path.file_stem(),
                _ => None,
            });
            scans.into_iter().any(|name| Some(name) == face.file_stem())
        };
        let is_made = |face: &Path| self.jobs.iter().any(|job| job.output == face);
        faces.retain(|face| !is_made(face) && !is_refused(face));
        faces.sort();
        Ok(faces)
    }
}

/// The jobs of a folder: every scan in it (not in its subfolders), by its ending.
///
/// # Errors
/// When the folder cannot be read or holds no scan, and when the output folder is the scans' own.
pub fn jobs(scans: &Path, output: &Path) -> FitResult<Jobs> {
    let files = files_of(scans)?;
    if let (Ok(a), Ok(b)) = (scans.canonicalize(), output.canonicalize())
        && a == b
    {
        let cause = "holds the scans: registered faces go to a folder of their own";
        return Err(FitError::file(output, cause));
    }
    let mut found: BTreeMap<String, Vec<PathBuf>> = BTreeMap::new();
    let mut points: BTreeMap<String, Vec<PathBuf>> = BTreeMap::new();
    // Where the files of the folder are, which a link may have elsewhere.
    let mut kept: HashMap<PathBuf, PathBuf> = files
        .iter()
        .map(|path| (place(path), path.clone()))
        .collect();
    for path in &files {
        let ending = path.extension().unwrap_or_default();
        let ending = &*ending.to_string_lossy().to_lowercase();
        let (of_name, name) = if ENDINGS.contains(&ending) {
            let name = path.file_stem().unwrap_or_default().to_string_lossy();
            (&mut found, name.into_owned())
        } else if landmarks::ENDINGS.contains(&ending) {
            (&mut points, landmarks::scan_name(path))
        } else {
            continue;
        };
        of_name.entry(name).or_default().push(path.clone());
    }
    let deeper = folders_of_scans(scans, output);
    if found.is_empty() {
        let none = ENDINGS.map(|ending| format!(".{ending}")).join(", ");
        let mut cause = format!("no scans in it ({none})");
        if let [first, ..] = &deeper[..] {
            let name = first.file_name().unwrap_or_default().display();
            cause += &format!(
                ", but in {} of its folders, as {name}: scans are to lie in one, each with a name of its own",
                deeper.len()
            );
        }
        return Err(FitError::file(scans, cause));
    }
    let mut all = Jobs {
        deeper,
        ..Jobs::default()
    };
    for (name, mut paths) in found {
        paths.sort();
        let mut points = points.remove(&name).unwrap_or_default();
        points.sort();
        let refused = match &paths[..] {
            // Its landmarks would take the place of what is said of all faces.
            [scan, ..] if OF_ALL.contains(&name.as_str()) => {
                FitError::file(scan, "has a name that is taken: call it otherwise")
            }
            [scan, other, ..] => {
                let cause = format!("has the same name as {}", other.display());
                FitError::file(scan, cause)
            }
            // Which of them was set by hand, only a person knows.
            [scan] if points.len() > 1 => {
                let names = points.iter().filter_map(|path| path.file_name());
                let names: Vec<_> = names.map(|name| name.display().to_string()).collect();
                let cause = format!("has landmarks in {}: one is to stay", names.join(" and "));
                FitError::file(scan, cause)
            }
            _ => {
                let jobs = paths.into_iter().map(|scan| Job {
                    landmarks: points.pop(),
                    output: output.join(format!("{name}.ply")),
                    scan,
                });
                for job in jobs {
                    match written_over(&job, &kept) {
                        Some(error) => all.refused.push(error),
                        None => {
                            // Nor is one face written over another's.
                            kept.extend(job.written().map(|path| (place(&path), path)));
                            all.jobs.push(job);
                        }
                    }
                }
                continue;
            }
        };
        all.refused.push(refused);
    }
    // Text may be anything, and so may be what is said of all scans.
    let points = points
        .into_iter()
        .filter(|(name, _)| !OF_ALL.contains(&name.as_str()));
    let is_text = |path: &PathBuf| {
        path.extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("txt"))
    };
    all.unclaimed = points
        .flat_map(|(_, paths)| paths)
        .filter(|path| !is_text(path))
        .collect();
    all.unclaimed.sort();
    Ok(all)
}

/// The folders in a folder that hold scans, by name, but for that of their faces. One that cannot be read holds none.
fn folders_of_scans(folder: &Path, output: &Path) -> Vec<PathBuf> {
    let is_scan = |path: &PathBuf| {
        let ending = path.extension().unwrap_or_default().to_string_lossy();
        ENDINGS.contains(&&*ending.to_lowercase())
    };
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut folders: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    folders.retain(|path| place(path) != place(output));
    folders.retain(|path| files_of(path).is_ok_and(|files| files.iter().any(is_scan)));
    folders.sort();
    folders
}

/// Why a job is not done that would write over a file of the scans' folder or another's face, by way of a link: `kept`
/// are those, by where they are.
fn written_over(job: &Job, kept: &HashMap<PathBuf, PathBuf>) -> Option<FitError> {
    job.written().iter().find_map(|path| {
        let lost = kept.get(&place(path))?;
        let cause = format!(
            "its face would be written to {}, which is {}: each needs a place of its own",
            path.display(),
            lost.display()
        );
        Some(FitError::file(&job.scan, cause))
    })
}

/// Found landmarks less sure than this are left out.
pub const CONFIDENT: f64 = 0.3;

/// Finds landmarks as [`Detector::find_on`] does; where there is no face and the scan's unit was guessed,
/// that is said.
///
/// # Errors
/// When there is no face on the scan.
pub fn find(detector: &Detector, scan: &mut Scan, template: &Template) -> FitResult<Detection> {
    let found = detector.find_on(scan, template);
    found.map_err(|error| scan.doubting_unit(error))
}

/// A scan as read, with its landmarks in mm.
pub struct Prepared {
    /// The scan, turned outside out where it had to be.
    pub scan: Scan,
    /// Its landmarks: place in the template's list, position in mm.
    pub points: Vec<(usize, DVec3)>,
    /// Their errors as [`Settings::point_errors`] has them; none of those of which nobody told.
    pub errors: Vec<f64>,
    /// What was decided on the way, a line each.
    pub notes: Vec<String>,
}

/// Faces are written as f32; coarser steps than this are said, mm.
const COARSE: f64 = 0.01;

/// Coarser than this a face is no face, mm.
const TOO_COARSE: f64 = 1.0;

/// How coarse a face becomes that is written where the scan is, if that is far from the origin, mm, and that in words.
fn rounding(scan: &Scan) -> Option<(f64, String)> {
    let coordinates = scan.positions.iter().map(|p| p.abs().max_element());
    let farthest = coordinates.fold(0.0, f64::max) as f32;
    let step = f64::from(farthest.next_up() - farthest);
    (step > COARSE).then(|| {
        let words = format!(
            "place: {farthest:.0} mm from the origin, where a PLY has steps of {step:.2} mm: move the scan there"
        );
        (step, words)
    })
}

/// Which landmarks were left out, in words.
fn astray(face: &Registered) -> Option<String> {
    let strays = face.strays.iter();
    let strays: Vec<String> = strays
        .map(|(name, far)| format!("`{name}` by {far:.0} mm"))
        .collect();
    (!strays.is_empty()).then(|| {
        format!(
            "landmarks: left out, as the surface and the others have them elsewhere: {}",
            strays.join(", ")
        )
    })
}

/// Reads a scan and its landmarks, or finds them, and looks at both.
///
/// # Errors
/// Those of the readers, of [`check`] and of the [`Detector`], and when a face would be written with steps of more than a
/// millimetre, which f32 have that far from the origin.
pub fn prepare(
    registrar: &Registrar<'_>,
    scan: &Path,
    points: Option<&Path>,
    unit: Option<Unit>,
) -> FitResult<Prepared> {
    prepare_read(registrar, Scan::read(scan, unit)?, points)
}

/// The same of a scan that was read.
fn prepare_read(
    registrar: &Registrar<'_>,
    mut scan: Scan,
    points: Option<&Path>,
) -> FitResult<Prepared> {
    let template = registrar.template;
    let coarse = rounding(&scan);
    if let Some((_, why)) = coarse.as_ref().filter(|coarse| coarse.0 > TOO_COARSE) {
        return Err(FitError::Input(why.clone()));
    }
    let mut said = Vec::new();
    let mut on_hair = false;
    let (mut points, errors) = match points {
        Some(path) => {
            let read = landmarks::read(path, &mut scan, template)?;
            on_hair = read.on_hair;
            (read.points, read.errors)
        }
        None => {
            let found = find(registrar.detector()?, &mut scan, template)?;
            let points = found.landmarks(CONFIDENT);
            let sure: f64 = points.iter().map(|&(l, _)| found.confidences[l]).sum();
            said.push(format!(
                "landmarks: {} of {} found without a hand, mean confidence {:.2}",
                points.len(),
                template.landmarks.len(),
                sure / points.len().max(1) as f64
            ));
            (points, found.errors)
        }
    };
    let checked = check(&mut scan, &points, template)?;
    if on_hair {
        off_hair(&mut points, &scan, template);
    }
    let mut notes = scan.notes.clone();
    notes.extend(said);
    notes.extend(checked);
    notes.extend(coarse.map(|coarse| coarse.1));
    Ok(Prepared {
        scan,
        points,
        errors,
        notes,
    })
}

/// So many are told of one scan.
const STRONGEST: usize = 3;

/// What was decided or found of the scans of a folder.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Tally {
    /// How many scans are in a unit that was guessed, by the unit's name.
    pub guessed: BTreeMap<String, usize>,
    /// How many show an expression.
    pub expressive: usize,
}

impl Tally {
    /// Counts a scan. In a few words, what whose scan it is would want to know: a unit that is not
    /// millimetres and was guessed, landmarks that were left out, the expressions that the face shows, and a place far
    /// from the origin.
    pub fn count(&mut self, scan: &Scan, face: &Registered) -> Option<String> {
        let mut words = Vec::new();
        if scan.unit_guessed {
            let (unit, size) = match scan.unit() {
                Unit::Own(_) => (
                    "units of their own",
                    "in units of its own, made average size",
                ),
                Unit::Millimetre => ("millimetres", ""),
                Unit::Centimetre => ("centimetres", "in centimetres, guessed"),
                Unit::Inch => ("inches", "in inches, guessed"),
                Unit::Metre => ("metres", "in metres, guessed"),
            };
            *self.guessed.entry(unit.into()).or_default() += 1;
            words.extend((!size.is_empty()).then(|| size.to_owned()));
        }
        words.extend(astray(face));
        let mut told: Vec<_> = face.expressions.iter().filter(|e| e.1 >= TOLD).collect();
        told.sort_by(|a, b| b.1.total_cmp(&a.1));
        if !told.is_empty() {
            self.expressive += 1;
            let told = told.iter().take(STRONGEST);
            let told: Vec<String> = told.map(|(n, s)| format!("{n} {s:.1}")).collect();
            words.push(format!("shows {}", told.join(", ")));
        }
        words.extend(rounding(scan).map(|coarse| coarse.1));
        (!words.is_empty()).then(|| words.join("; "))
    }

    /// All that were counted, in one line, and the options that change it.
    pub fn summary(&self, neutral: bool) -> Option<String> {
        let mut words = Vec::new();
        if !self.guessed.is_empty() {
            let each = self
                .guessed
                .iter()
                .map(|(unit, n)| format!("{n} in {unit}"));
            let each: Vec<String> = each.collect();
            words.push(format!("units guessed: {} (see --unit)", each.join(", ")));
        }
        if self.expressive > 0 {
            let what = match neutral {
                true => "taken off",
                false => "see --neutral",
            };
            words.push(format!("{} with expressions ({what})", self.expressive));
        }
        (!words.is_empty()).then(|| words.join("; "))
    }
}

/// Registers one scan.
///
/// # Errors
/// Those of [`prepare`] and of [`Registrar::register`].
pub fn register_scan(
    registrar: &Registrar<'_>,
    job: &Job,
    unit: Option<Unit>,
    settings: &Settings,
) -> FitResult<(Prepared, Registered)> {
    let scan = read_scan(&job.scan, unit, settings)?;
    register_read(registrar, scan, job, settings)
}

/// Registers one scan that was read.
///
/// # Errors
/// Those of [`prepare`] and of [`Registrar::register`].
pub fn register_read(
    registrar: &Registrar<'_>,
    scan: Scan,
    job: &Job,
    settings: &Settings,
) -> FitResult<(Prepared, Registered)> {
    let mut prepared = prepare_read(registrar, scan, job.landmarks.as_deref())
        .map_err(|error| error.of(&job.scan))?;
    let settings = Settings {
        point_errors: prepared.errors.clone(),
        ..settings.clone()
    };
    let registered = registrar
        .register(&prepared.scan, &prepared.points, &settings)
        .map_err(|e| e.of(&job.scan))?;
    prepared.notes.extend(astray(&registered));
    let is_stray = |l: usize| {
        let name = &registrar.template.landmarks[l].name;
        registered.strays.iter().any(|(stray, _)| stray == name)
    };
    prepared.points.retain(|&(l, _)| !is_stray(l));
    Ok((prepared, registered))
}

/// Reads a scan, with its pictures where somebody looks at them.
fn read_scan(path: &Path, unit: Option<Unit>, settings: &Settings) -> FitResult<Scan> {
    match settings.pictures {
        true => Scan::read(path, unit),
        false => Scan::read_shape(path, unit),
    }
}

/// Reads a folder that [`run`] wrote, by name.
///
/// # Errors
/// When a face is not registered to `template`, or a file cannot be understood.
pub fn read_registered(
    dir: &Path,
    template: &Template,
) -> FitResult<Vec<(String, RegisteredFace)>> {
    ply::read_faces(dir, &template.positions, &template.triangles())?
        .into_iter()
        .map(|(name, positions)| {
            let path = dir.join(format!("{name}.json"));
            let points = match path.is_file() {
                true => landmarks::read_file(&path, template)?.points,
                false => Vec::new(),
            };
            Ok((name, RegisteredFace { positions, points }))
        })
        .collect()
}

/// Takes away the face that was made of a scan before it changed, where the scan now fails: a model would be
/// trained on it. Where the scan is not known to have changed, or cannot be read, the face is all that there is of the
/// person, and stays. The error says which.
fn without_former(job: &Job, standing: Standing, error: FitError) -> FitError {
    let is_unread = matches!(error, FitError::Unread { .. });
    match standing {
        Standing::Missing | Standing::Done => return error,
        Standing::Changed if !is_unread => {}
        _ => return error.of(&job.scan).and("its former face stays"),
    }
    if std::fs::remove_file(&job.output).is_err() {
        return error;
    }
    // Its landmarks and its picture are of no use without it, and may not be there.
    let _ = std::fs::remove_file(job.output.with_extension("json"));
    let _ = job.remove_picture();
    let _ = std::fs::remove_file(job.made());
    let gone = "the face of what it was before is taken away";
    error.of(&job.scan).and(gone)
}

/// Registers the jobs that are not done, on all cores, each with its landmarks in mm
/// beside it; `also` may write more of each, `done` is told of each. Returns what failed, in the
/// order of the jobs. Where a scan that has changed cannot be understood or registered, its former face goes; where a file
/// cannot be read or written that stays, for the next time.
pub fn run(
    registrar: &Registrar<'_>,
    jobs: &[Job],
    unit: Option<Unit>,
    settings: &Settings,
    also: impl Fn(&Job, &Prepared, &Registered) -> FitResult<()> + Sync,
    done: impl Fn(&Job, &FitResult<()>) + Sync,
) -> Vec<FitError> {
    jobs.par_iter()
        // A core takes the next scan when it is free: they take unequal time.
        .with_max_len(1)
        .map(|job| (job, job.standing()))
        .filter(|(_, standing)| *standing != Standing::Done)
        .filter_map(|(job, standing)| {
            let work = || -> FitResult<()> {
                let without_former = |error| without_former(job, standing, error);
                // Before they are read: what takes their place meanwhile is another.
                let made = Made::of(job);
                let scan = read_scan(&job.scan, unit, settings).map_err(without_former)?;
                // Nothing goes that may be the scan's own.
                let written = job.written();
                scan.check_beside(&written.each_ref().map(PathBuf::as_path))?;
                let parts = scan
                    .beside
                    .iter()
                    .filter_map(|path| Part::of(path))
                    .collect();
                let (prepared, face) =
                    register_read(registrar, scan, job, settings).map_err(without_former)?;
                also(job, &prepared, &face)?;
                let template = registrar.template;
                let (positions, points) = match settings.neutral {
                    true => (
                        &face.neutral(),
                        &face.neutral_points(template, &prepared.points),
                    ),
                    false => (&face.positions, &prepared.points),
                };
                // The face after what is beside it, and what it was made of last: so that is never said of a former one.
                let file = job.output.with_extension("json");
                landmarks::write(&file, points, &prepared.errors, 1.0, template)?;
                ply::write_mesh(&job.output, positions, &registrar.triangles)?;
                let kept = Kept {
                    made,
                    account: Some(Account::of(template, &prepared, &face)?),
                    parts,
                };
                let kept = serde_json::to_vec(&kept).map_err(|e| FitError::file(&job.made(), e))?;
                write_atomically(&job.made(), &kept)
            };
            let result = work();
            done(job, &result);
            result.err()
        })
        .collect()
}
