//! `phiz-fit validate`.

use std::path::{Path, PathBuf};

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};

use phiz::fit::evaluate::{self, Evaluator};
use phiz::fit::format::files::check_writable;
use phiz::fit::learn::about;
use phiz::fit::learn::labels::Told;
use phiz::fit::truth::ict::Ict;
use phiz::fit::truth::population::Labels;
use phiz::fit::validate::bases;
use phiz::fit::validate::held_out::Interval;
use phiz::fit::validate::{Drift, Population, STEPS, page, validate};
use phiz::fit::{FitError, FitResult};

/// How persons are told, for `--help`.
const PERSONS: &str = r#"labels.json or labels.csv beside the faces, if it is there, may tell which are scans of one person ("person", see
`phiz-fit attributes --help`): these are held out together, and count once in errors. Each scan that is learned from
counts as one face."#;

#[derive(Args)]
#[command(after_help = PERSONS)]
pub struct ValidateArgs {
    /// The generic head.
    #[arg(long, value_name = "FILE")]
    template: PathBuf,
    /// The folder of registered faces (PLY).
    #[arg(long, value_name = "DIR")]
    faces: PathBuf,
    /// The scans that the faces were registered to, as `simulate` wrote them with their truth:
    /// drift is measured too. Needs --ict.
    #[arg(long, value_name = "DIR", requires = "ict")]
    scans: Option<PathBuf>,
    /// The folder of ICT-FaceKit (holds `FaceXModel`).
    #[arg(long, value_name = "DIR", requires = "scans")]
    ict: Option<PathBuf>,
    /// Compare sparse bases with principal components too, over so many splits of the faces, one of each person; takes
    /// some minutes, and 45 people at least.
    #[arg(long, value_name = "COUNT", default_value_t = 0)]
    splits: u64,
    /// Learn from the faces as they are, without the mirror image of each, as `train --one-sided` does. (Sparse bases
    /// are compared in both ways anyway.)
    #[arg(long)]
    one_sided: bool,
    /// Write a short copy, README.md with its pictures, into this folder; a README.md that is no former copy is not
    /// written over.
    #[arg(long, value_name = "DIR")]
    short: Option<PathBuf>,
    /// The folder to write: `index.html` and `report.json`; an index.html that is no former report is not written over.
    #[arg(short, value_name = "DIR")]
    output: PathBuf,
}

pub fn run(args: &ValidateArgs) -> FitResult<()> {
    one_arena();
    page::check_report(&args.output)?;
    if let Some(short) = &args.short {
        page::check_short(short)?;
    }
    let written = [Some(&args.output), args.short.as_ref()]
        .into_iter()
        .flatten();
    let written: Vec<PathBuf> = written.map(|folder| folder.join("report.json")).collect();
    let written: Vec<&Path> = written.iter().map(PathBuf::as_path).collect();
    super::check_apart_from(&args.faces, &written)?;
    let template = super::read_template(&args.template)?;
    let (names, faces) = super::read_faces(&args.faces, &template)?;
    let persons = super::persons_of(&args.faces, &names)?;
    super::say_scans(&args.faces, &persons, "the mean is learned from");
    let named: Vec<_> = names.into_iter().zip(faces).collect();
    for folder in [Some(&args.output), args.short.as_ref()]
        .into_iter()
        .flatten()
    {
        std::fs::create_dir_all(folder).map_err(|e| FitError::file(folder, e))?;
        check_writable(&folder.join("report.json"))?;
    }
    let labels = labels(&args.faces, &named)?.unwrap_or_default();
    let about = about::read(&args.faces)?;
    let drift = match (&args.scans, &args.ict) {
        (Some(scans), Some(ict)) => Some(super::step("measuring drift", || {
            let ict = Ict::read(ict)?;
            let reference = super::evaluate::reference(&template, &ict)?;
            let expressions = Default::default();
            let evaluator = Evaluator::new(&template, &reference, &ict, &expressions)?;
            drift(&evaluator, scans, &named)
        })?),
        _ => None,
    };
    let style = ProgressStyle::with_template("{bar:30} {pos} of {len}, {msg}, {eta} left");
    let style = style.unwrap_or_else(|_| ProgressStyle::default_bar());
    let people = if args.splits > 0 { persons.count() } else { 0 };
    let steps = args.splits.saturating_mul(bases::steps(people));
    let bar = ProgressBar::new(steps).with_style(style.clone());
    bar.set_message("sparse bases");
    // One of each person, so that nobody is learned from and tried.
    let one_each = persons.one_each().into_iter().take(people);
    let faces: Vec<_> = one_each.map(|i| named[i].1.clone()).collect();
    if args.splits > 0 {
        for line in bases::too_few(people) {
            println!("{}: {line}", args.faces.display());
        }
    }
    let compared = bases::bases(&template, &faces, args.splits, || bar.inc(1))
        .map_err(|e| e.of(&args.faces))?;
    bar.finish_and_clear();
    drop(faces);
    let bar = ProgressBar::new(STEPS + 1);
    bar.set_style(style);
    let (names, faces): (Vec<String>, Vec<_>) = (named.into_iter())
        .map(|(name, face)| (name, face.iter().map(|p| p.as_vec3()).collect()))
        .unzip();
    let population = Population {
        template: &template,
        names,
        both_sides: !args.one_sided,
        faces,
        persons,
        labels,
        about,
        drift,
    };
    let mut validated = validate(population, |what| {
        bar.inc(1);
        bar.set_message(what);
    })
    .map_err(|e| e.of(&args.faces))?;
    validated.report.bases = compared;
    bar.set_message("drawing");
    page::write(&validated, &args.output, args.short.as_deref())?;
    bar.finish_and_clear();
    for part in &validated.report.held_out {
        println!(
            "held out at {:.0} %, {:.0} coefficients: RMS mm (whole-face PCA)",
            100.0 * part.tau,
            part.coefficients
        );
        for (own, whole) in part.regions.iter().zip(&part.whole_face) {
            println!(
                "  {:14} {:.3} ({:.3})",
                own.area, own.rms.mean, whole.rms.mean
            );
        }
    }
    for person in validated.report.people.iter().filter(|p| p.far.is_some()) {
        println!(
            "{}: far beyond the others, {:.2} mm RMS from the mean, {:.1} mm RMS in size",
            person.name, person.face.alignment, person.face.size
        );
    }
    println!("{}", args.output.join("index.html").display());
    Ok(())
}

/// Has all threads allocate from one arena. Models are learned one after the other, each hundreds of
/// MB, and what one thread freed of the last would not be given to another: with an arena a thread
/// 300 faces take 0.94 to 1.02 GB, with one 0.87, in the same time.
fn one_arena() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        // SAFETY: any value of this parameter is valid, and no other thread runs yet.
        #[allow(unsafe_code)]
        unsafe {
            libc::mallopt(libc::M_ARENA_MAX, 1);
        }
    }
}

/// What `labels.json` beside the faces says of each of them; nothing where there is none, or what is told is not counted.
fn labels(folder: &Path, faces: &[(String, Vec<glam::DVec3>)]) -> FitResult<Option<Vec<Labels>>> {
    let Some(told) = Told::beside(folder)? else {
        return Ok(None);
    };
    let names: Vec<&str> = faces.iter().map(|(name, _)| name.as_str()).collect();
    let labels = match told.path() == folder.join(Told::FILES[0]) {
        true => Labels::read(told.path(), &names)?,
        false => None,
    };
    if labels.is_none() && told.has_labels() {
        println!(
            "{}: other labels than those of a synthetic population are not counted",
            told.path().display()
        );
    }
    Ok(labels)
}

/// How far the faces' vertices are from where they belong.
fn drift(
    evaluator: &Evaluator,
    scans: &Path,
    faces: &[(String, Vec<glam::DVec3>)],
) -> FitResult<Drift> {
    let mut means = Vec::new();
    let mut all = Vec::new();
    for (name, face) in faces {
        let path = scans.join("truth").join(format!("{name}.json"));
        let truth =
            serde_json::from_slice(&super::read(&path)?).map_err(|e| FitError::file(&path, e))?;
        let lengths = evaluator.drift(&truth, face);
        means.push(lengths.iter().sum::<f64>() / lengths.len().max(1) as f64);
        all.extend(lengths);
    }
    let lengths = evaluate::Lengths::of(all);
    Ok(Drift {
        faces: means.len(),
        mean: Interval::of(&means),
        percentile_95: lengths.percentile_95,
    })
}
