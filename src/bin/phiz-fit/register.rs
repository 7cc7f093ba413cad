//! `phiz-fit register`.

use std::path::{Path, PathBuf};

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};

use phiz::fit::register::batch::{self, Job};
use phiz::fit::register::{Registrar, Settings};
use phiz::fit::scan::Unit;
use phiz::fit::{FitError, FitResult, files, ply};

#[derive(Args)]
#[command(group(clap::ArgGroup::new("what").required(true).args(["scan", "scans"])))]
pub struct RegisterArgs {
    /// The generic head.
    #[arg(long, value_name = "FILE")]
    template: PathBuf,
    /// One scan: OBJ, PLY or GLB.
    #[arg(long, value_name = "FILE")]
    scan: Option<PathBuf>,
    /// Its landmarks, JSON or 68 lines of text; without them they are found.
    #[arg(long, value_name = "FILE", requires = "scan")]
    landmarks: Option<PathBuf>,
    /// Every scan of a folder, with landmarks in NAME.json or NAME.txt beside NAME.ply.
    #[arg(long, value_name = "DIR")]
    scans: Option<PathBuf>,
    /// The scans' unit: mm, cm, m or inch; without it, it is guessed and said.
    #[arg(long)]
    unit: Option<Unit>,
    /// Start from the landmarks alone, not from what the template knows of faces.
    #[arg(long)]
    no_prior: bool,
    /// The PLY to write, or the folder of them.
    #[arg(short, value_name = "PATH")]
    output: PathBuf,
}

pub fn run(args: &RegisterArgs) -> FitResult<()> {
    let template = super::read_template(&args.template)?;
    let registrar = super::step("preparing the template", || Registrar::new(&template))?;
    let settings = Settings {
        prior: !args.no_prior,
        ..Settings::default()
    };
    match (&args.scan, &args.scans) {
        (Some(scan), _) => one(args, &registrar, &settings, scan),
        (None, Some(folder)) => many(args, &registrar, &settings, folder),
        (None, None) => Err(FitError::Input("--scan or --scans is needed".into())),
    }
}

fn one(
    args: &RegisterArgs,
    registrar: &Registrar<'_>,
    settings: &Settings,
    scan: &Path,
) -> FitResult<()> {
    let job = Job {
        scan: scan.to_owned(),
        landmarks: args.landmarks.clone(),
        output: args.output.clone(),
    };
    let (prepared, registered) = super::step("registering", || {
        batch::register_scan(registrar, &job, args.unit, settings)
    })?;
    ply::write_mesh(&job.output, &registered.positions, registrar.triangles())?;
    for note in prepared.notes {
        println!("{note}");
    }
    println!("{}: {}", args.output.display(), registered.summary());
    Ok(())
}

fn many(
    args: &RegisterArgs,
    registrar: &Registrar<'_>,
    settings: &Settings,
    folder: &Path,
) -> FitResult<()> {
    let output = &args.output;
    std::fs::create_dir_all(output).map_err(|e| FitError::file(output, e))?;
    let jobs = batch::jobs(folder, output)?;
    let there = jobs.iter().filter(|job| job.output.exists()).count();
    let bar = ProgressBar::new((jobs.len() - there) as u64);
    let style = ProgressStyle::with_template("{bar:30} {pos} of {len} scans, {eta} left");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let failed = batch::run(registrar, &jobs, args.unit, settings, |_, _| bar.inc(1));
    bar.finish_and_clear();
    // Whose scans they are is whose faces they become.
    let about = folder.join("about.json");
    if about.is_file() {
        let bytes = super::read(&about)?;
        files::write_atomically(&output.join("about.json"), &bytes)?;
    }
    println!(
        "{}: {} faces registered, {there} were there, {} failed",
        output.display(),
        jobs.len() - there - failed.len(),
        failed.len()
    );
    if failed.is_empty() {
        return Ok(());
    }
    for error in &failed {
        eprintln!("phiz-fit: {error}");
    }
    Err(FitError::Input(format!(
        "{} of {} scans could not be registered",
        failed.len(),
        jobs.len()
    )))
}
