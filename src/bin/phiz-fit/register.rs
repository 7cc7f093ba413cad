//! `phiz-fit register`.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use clap::Args;
use clap::error::ErrorKind;
use indicatif::{ProgressBar, ProgressStyle};

use phiz::blob::{Blob, Kind};
use phiz::fit::format::files;
use phiz::fit::format::ply;
use phiz::fit::head::template::Template;
use phiz::fit::learn::about;
use phiz::fit::learn::labels::Told;
use phiz::fit::picture::pictures;
use phiz::fit::register::batch::{self, Job, Jobs, Prepared, Recipe, Tally};
use phiz::fit::register::texture;
use phiz::fit::register::{Registered, Registrar, Settings};
use phiz::fit::scan::{Scan, Texture, Unit};
use phiz::fit::{FitError, FitResult, counted};

#[derive(Args)]
#[command(after_help = super::landmarks::NAMES)]
#[command(group(clap::ArgGroup::new("what").required(true).args(["scan", "scans"])))]
pub struct RegisterArgs {
    /// The generic head.
    #[arg(long, value_name = "FILE")]
    template: PathBuf,
    /// One scan: OBJ, PLY, GLB, glTF or STL.
    #[arg(long, value_name = "FILE")]
    scan: Option<PathBuf>,
    /// Its landmarks, JSON, or 68 lines of text (.txt, .pts), or menpo's .ljson, or MeshLab's .pp; without them they are
    /// found.
    #[arg(long, value_name = "FILE", conflicts_with = "scans")]
    landmarks: Option<PathBuf>,
    /// Every scan of a folder, with landmarks in NAME.json (or .txt, .pts, .ljson, .pp, or NAME_picked_points.pp) beside
    /// NAME.ply. Faces that are there already, of both as they are, stay. about.json and labels.json go beside the faces,
    /// where others do not lie there already, and register.csv, which says what was decided and found of each scan. As many
    /// are under way as the machine has cores, or RAYON_NUM_THREADS says, where their scans are too large for its memory.
    #[arg(long, value_name = "DIR")]
    scans: Option<PathBuf>,
    /// The scans' unit: mm, cm, m, inch, or how many mm it has; without it, it is guessed and said.
    #[arg(long)]
    unit: Option<Unit>,
    /// Start from the landmarks alone, not from what the template knows of faces.
    #[arg(long)]
    no_prior: bool,
    /// Write faces without the expression that they show: what a model of people is trained from.
    #[arg(long, conflicts_with = "no_prior")]
    neutral: bool,
    /// Bake the scan's colours into the template's texture layout: the PNG to write.
    #[arg(long, value_name = "FILE", conflicts_with = "scans")]
    texture: Option<PathBuf>,
    /// Draw the scan, the registered head and the distance between them: the PNG to write.
    #[arg(long, value_name = "FILE", conflicts_with = "scans")]
    picture: Option<PathBuf>,
    /// Bake NAME.png beside each face registered now, where the scan has colours; otherwise a former one goes. Faces that
    /// are there already get none, which is said.
    #[arg(long, conflicts_with = "scan")]
    textures: bool,
    /// The PLY to write, or the folder of them.
    #[arg(short, value_name = "PATH")]
    output: PathBuf,
}

pub fn run(args: &RegisterArgs) -> FitResult<()> {
    let ply = args.output.extension();
    if args.scan.is_some() && !ply.is_some_and(|e| e.eq_ignore_ascii_case("ply")) {
        let cause = format!(
            "{}: a registered face is a PLY: a name that ends in .ply is needed",
            args.output.display()
        );
        super::refuse("register", ErrorKind::ValueValidation, cause);
    }
    if let Some(scan) = &args.scan {
        let read = [
            ("the template", Some(&args.template)),
            ("the scan", Some(scan)),
            ("the scan's landmarks", args.landmarks.as_ref()),
        ];
        let read = read
            .into_iter()
            .filter_map(|(what, path)| Some((what, path?.as_path())));
        files::check_apart(&written(args), &read.collect::<Vec<_>>())?;
        written(args)
            .into_iter()
            .try_for_each(files::check_writable)?;
    }
    let template = super::read_template(&args.template)?;
    if args.neutral && template.expressions.is_empty() {
        let cause = "knows no expressions, which --neutral takes off: `phiz-fit template` makes one \
                     that does";
        return Err(FitError::file(&args.template, cause));
    }
    let registrar = super::step("preparing the template", || Registrar::new(&template))?;
    let settings = Settings {
        prior: !args.no_prior,
        neutral: args.neutral,
        pictures: args.textures || args.texture.is_some() || args.picture.is_some(),
        ..Settings::default()
    };
    match (&args.scan, &args.scans) {
        (Some(scan), _) => one(args, &template, &registrar, &settings, scan),
        (None, Some(folder)) => many(args, &template, &registrar, &settings, folder),
        (None, None) => Err(FitError::Input("--scan or --scans is needed".into())),
    }
}

/// What is written of one scan.
fn written(args: &RegisterArgs) -> Vec<&Path> {
    let files = [
        Some(&args.output),
        args.texture.as_ref(),
        args.picture.as_ref(),
    ];
    files.into_iter().flatten().map(PathBuf::as_path).collect()
}

/// A side of a baked image, texels. A face takes a quarter of it.
const TEXELS: usize = 2048;

fn bake(template: &Template, scan: &Scan, face: &Registered) -> FitResult<Texture> {
    texture::bake(template, &face.positions, &face.covered, scan, TEXELS)
        .map_err(|e| e.of(&scan.path))
}

fn coloured(scan: &Scan) -> bool {
    scan.texture.is_some() || !scan.colours.is_empty()
}

fn one(
    args: &RegisterArgs,
    template: &Template,
    registrar: &Registrar<'_>,
    settings: &Settings,
    scan: &Path,
) -> FitResult<()> {
    let job = Job {
        scan: scan.to_owned(),
        landmarks: args.landmarks.clone(),
        output: args.output.clone(),
    };
    let scan = super::step("reading the scan", || match settings.pictures {
        true => Scan::read(scan, args.unit),
        false => Scan::read_shape(scan, args.unit),
    })?;
    scan.check_beside(&written(args))?;
    let notes = scan.notes.clone();
    let done = super::step("registering", || {
        batch::register_read(registrar, scan, &job, settings)
    });
    let (prepared, registered) = super::explained(done, &notes)?;
    // A texture that is asked for and cannot be had is known before anything is written.
    let baked = args.texture.is_some() || args.picture.is_some() && coloured(&prepared.scan);
    let texture = baked
        .then(|| bake(template, &prepared.scan, &registered))
        .transpose();
    let texture = super::explained(texture, &prepared.notes)?;
    let written = match settings.neutral {
        true => &registered.neutral(),
        false => &registered.positions,
    };
    ply::write_mesh(&job.output, written, registrar.triangles())?;
    if let (Some(texture), Some(file)) = (&texture, &args.texture) {
        texture.save(file)?;
    }
    if let Some(file) = &args.picture {
        let Registered {
            positions, covered, ..
        } = &registered;
        let scan = &prepared.scan;
        pictures::of_registration(template, scan, positions, covered, texture.as_ref(), file)?;
    }
    for note in prepared.notes {
        println!("{note}");
    }
    println!("{}: {}", args.output.display(), registered.summary());
    Ok(())
}

fn many(
    args: &RegisterArgs,
    template: &Template,
    registrar: &Registrar<'_>,
    settings: &Settings,
    folder: &Path,
) -> FitResult<()> {
    let output = &args.output;
    let found = batch::jobs(folder, output)?;
    // Whose scans they are is whose faces they become: what is no use then is told before the work.
    about::read(folder)?;
    let labels = Told::beside(folder)?;
    if let Some(line) = labels.as_ref().and_then(Told::in_words) {
        println!("{line}");
    }
    let told = [about::FILE].into_iter().chain(Told::FILES);
    let told = told.filter(|name| folder.join(name).is_file());
    let told = told.map(|name| Ok((name, super::read(&folder.join(name))?)));
    let told = told.collect::<FitResult<Vec<_>>>()?;
    std::fs::create_dir_all(output).map_err(|e| FitError::file(output, e))?;
    files::check_writable(&output.join(batch::ACCOUNTS))?;
    let Jobs {
        jobs,
        refused,
        unclaimed,
        deeper,
    } = &found;
    let all = jobs.len() + refused.len();
    let bytes = super::read(&args.template)?;
    let recipe = Recipe {
        template: Blob::parse(&bytes, Kind::Template)?.fingerprint(),
        prior: settings.prior,
        neutral: settings.neutral,
        unit: args.unit.map(|unit| unit.to_string()),
        made_by: about::PROGRAM.into(),
    };
    if let Some(other) = recipe.keep(output)? {
        println!(
            "{}: the faces there were made by {other}, others will be by {}",
            output.display(),
            recipe.made_by
        );
    }
    for path in unclaimed {
        println!("{}: belongs to no scan there", path.display());
    }
    if let [first, others @ ..] = &deeper[..] {
        let those = match others.len() {
            0 => "is a folder with scans, which is left out".into(),
            _ => format!(
                "it and others, {} in all, are folders with scans, which are left out",
                deeper.len()
            ),
        };
        println!(
            "{}: {those}: scans are to lie in one folder",
            first.display()
        );
    }
    let (mut there, mut bare_before) = (0, 0);
    for job in jobs.iter().filter(|job| job.is_done()) {
        there += 1;
        bare_before += usize::from(args.textures && !job.output.with_extension("png").is_file());
    }
    let bar = ProgressBar::new((jobs.len() - there) as u64);
    let style = ProgressStyle::with_template("{bar:30} {pos} of {len} scans, {eta} left");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let bare = Mutex::new(Vec::new());
    let tally = Mutex::new(Tally::default());
    let also = |job: &Job, prepared: &Prepared, face: &Registered| {
        let mut counted = tally.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(said) = counted.count(&prepared.scan, face) {
            let name = job.output.file_stem().unwrap_or_default().display();
            bar.suspend(|| println!("{name}: {said}"));
        }
        drop(counted);
        if args.textures && coloured(&prepared.scan) {
            let file = job.output.with_extension("png");
            return bake(template, &prepared.scan, face)?.save(&file);
        }
        job.remove_picture()?;
        if args.textures {
            let mut bare = bare.lock().unwrap_or_else(PoisonError::into_inner);
            let notes = prepared.scan.notes.iter();
            let why = notes.filter(|note| note.starts_with("no ")).cloned();
            bare.push((job.scan.clone(), why.collect::<Vec<_>>()));
        }
        Ok(())
    };
    let done = |_: &Job, _: &FitResult<()>| bar.inc(1);
    let now = batch::run(registrar, jobs, args.unit, settings, also, done);
    let failed: Vec<&FitError> = refused.iter().chain(&now).collect();
    bar.finish_and_clear();
    let mut bare = bare.into_inner().unwrap_or_else(PoisonError::into_inner);
    bare.sort_unstable();
    for (scan, why) in bare {
        let why: String = why.iter().map(|note| format!("; {note}")).collect();
        println!(
            "{}: it has no colours, so there is no PNG{why}",
            scan.display()
        );
    }
    if bare_before > 0 {
        println!(
            "{bare_before} of the faces that were there have no PNG, and get none: what is taken away is made again \
             with --textures"
        );
    }
    // What goes wrong with these keeps nobody from hearing of the scans.
    let beside = tell(told, output).and(batch::write_accounts(jobs, output));
    let tally = tally.into_inner().unwrap_or_else(PoisonError::into_inner);
    if let Some(said) = tally.summary(settings.neutral) {
        println!("{said}");
    }
    println!(
        "{}: {} registered, {there} {} there, {} failed",
        output.display(),
        counted(all - there - failed.len()),
        if there == 1 { "was" } else { "were" },
        failed.len()
    );
    for error in &failed {
        eprintln!("phiz-fit: {error}");
    }
    for path in found.strays(output)? {
        println!(
            "{}: of no scan there: it stays, and is learned from",
            path.display()
        );
    }
    beside?;
    if failed.is_empty() {
        return Ok(());
    }
    Err(FitError::Input(format!(
        "{} of {} scans could not be registered",
        failed.len(),
        all
    )))
}

/// Puts what is told of scans beside their faces, where nothing else is told there.
fn tell(told: Vec<(&str, Vec<u8>)>, output: &Path) -> FitResult<()> {
    for (name, bytes) in told {
        // Of the two that labels may be in, one is to be there.
        let same_kind = Told::FILES.iter().filter(|_| Told::FILES.contains(&name));
        let mut there = std::iter::once(&name)
            .chain(same_kind)
            .map(|name| output.join(name));
        let path = output.join(name);
        match there.find(|there| there.is_file()) {
            Some(other) if other != path || super::read(&path)? != bytes => println!(
                "{}: is not what lies beside the scans, and stays: it may have been made better since",
                other.display()
            ),
            _ => files::write_atomically(&path, &bytes)?,
        }
    }
    Ok(())
}
