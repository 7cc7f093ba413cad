//! `phiz-fit evaluate`.

use std::path::PathBuf;

use clap::Args;
use glam::DVec3;
use indicatif::{ProgressBar, ProgressStyle};

use phiz::fit::evaluate::{Evaluator, Report, evaluate, exchange};
use phiz::fit::head::expression::Expressions;
use phiz::fit::head::template::Template;
use phiz::fit::register::{Registrar, Settings as Registration, batch};
use phiz::fit::scan::Scan;
use phiz::fit::truth::ict::Ict;
use phiz::fit::truth::simulate::{self, Settings, Simulated, Simulator};
use phiz::fit::{FitError, FitResult};

#[derive(Args)]
pub struct EvaluateArgs {
    /// The folder of ICT-FaceKit (holds `FaceXModel`).
    #[arg(long, value_name = "DIR")]
    ict: PathBuf,
    /// The generic head.
    #[arg(long, value_name = "FILE")]
    template: PathBuf,
    /// The base mesh's data folder, whose jawOpen and eyeBlink are then tried on fitted heads.
    #[arg(long, value_name = "DIR")]
    base_mesh: Option<PathBuf>,
    /// How many people.
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..))]
    count: u32,
    /// The first person's seed; the next person has the next one.
    #[arg(long, default_value_t = 9000)]
    seed: u64,
    /// Only these settings.
    #[arg(long, value_name = "NAME", value_delimiter = ',', value_parser = SETTINGS.map(|s| s.0))]
    only: Vec<String>,
    /// Write the scans, and what else another program needs to register them, into this folder:
    /// SETTING/person_SEED.ply with landmarks, mean.ply and the template's skin.ply.
    #[arg(long, value_name = "DIR")]
    save: Option<PathBuf>,
    /// Measure another program's registrations of what --save wrote: this folder has files of the
    /// same names with the vertices of skin.ply.
    #[arg(long, value_name = "DIR", conflicts_with = "save")]
    registered: Option<PathBuf>,
    /// Find the landmarks, as for a scan without any, instead of taking those that were simulated.
    #[arg(long, conflicts_with_all = ["save", "registered"])]
    found: bool,
    /// As JSON.
    #[arg(long)]
    json: bool,
}

/// How scans are made: name, noise and landmark errors in mm, holes.
type Setting = (&'static str, f64, f64, bool);

/// The settings that are measured.
const SETTINGS: [Setting; 6] = [
    ("clean", 0.0, 0.0, false),
    ("usual", 0.2, 0.5, false),
    ("noisy", 0.3, 1.5, false),
    ("clean-holes", 0.0, 0.0, true),
    ("usual-holes", 0.2, 0.5, true),
    ("noisy-holes", 0.3, 1.5, true),
];

/// The expressions that are tried on fitted heads, with the targets that each is the sum of.
const EXPRESSIONS: [(&str, &[&str]); 2] = [
    ("jawOpen", &["jawOpen"]),
    ("eyeBlink", &["eyeBlinkLeft", "eyeBlinkRight"]),
];

pub fn run(args: &EvaluateArgs) -> FitResult<()> {
    let chosen = chosen(&args.only);
    if let Some(folder) = &args.save {
        for setting in &chosen {
            let folder = folder.join(setting.0);
            simulate::check_folder(&folder, args.seed, args.count, &made(setting))?;
        }
    }
    let template = super::read_template(&args.template)?;
    let ict = super::step("reading ICT-FaceKit", || Ict::read(&args.ict))?;
    if let Some(folder) = &args.save {
        exchange::write(&template, &ict, folder)?;
    }
    let registrar = Registrar::new(&template)?;
    let places = places(&template)?;
    let ours = |scan: &Scan, landmarks: &[DVec3]| match args.found {
        true => by_found(&registrar, scan),
        false => registered(&registrar, &places, scan, landmarks),
    };
    let reference = match &args.registered {
        Some(folder) => exchange::read(&folder.join("mean.ply"), &template)?,
        None => reference(&template, &ict)?,
    };
    let expressions = match &args.base_mesh {
        Some(folder) => Expressions::read(&EXPRESSIONS, &template, folder)?,
        None => Expressions::default(),
    };
    let evaluator = Evaluator::new(&template, &reference, &ict, &expressions)?;
    let simulator = Simulator::new(&ict);
    let style = ProgressStyle::with_template("{bar:30} {pos} of {len} registrations, {eta} left");
    let bar = ProgressBar::new(u64::from(args.count) * chosen.len() as u64);
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let mut reports = Vec::new();
    for setting in chosen {
        let (name, settings) = (setting.0, made(setting));
        if let Some(folder) = &args.save {
            let folder = folder.join(name);
            simulate::write(
                &simulator,
                args.seed,
                args.count,
                &settings,
                false,
                &folder,
                || (),
            )?;
        }
        let register = |person: &Simulated| match &args.registered {
            Some(folder) => {
                let file = format!("{}.ply", simulate::name(person.truth.seed));
                exchange::read(&folder.join(name).join(file), &template)
            }
            None => ours(&person.scan, &person.landmarks),
        };
        reports.push(evaluate(
            &evaluator,
            &simulator,
            (name, &settings),
            args.seed,
            args.count as usize,
            register,
            || bar.inc(1),
        )?);
    }
    bar.finish_and_clear();
    if args.json {
        println!(
            "{:#}",
            serde_json::json!({ "seed": args.seed, "settings": reports })
        );
    } else {
        println!("{}", table(&reports));
    }
    Ok(())
}

/// The template registered to ICT's mean head, from which the truth is told: all vertices, mm, in
/// ICT's pose.
pub fn reference(template: &Template, ict: &Ict) -> FitResult<Vec<DVec3>> {
    let mean = Scan {
        positions: ict.neutral.clone(),
        triangles: ict.triangles.clone(),
        scale: 1.0,
        ..Scan::default()
    };
    let landmarks = ict.landmarks.map(|v| ict.neutral[v as usize]);
    let registrar = Registrar::new(template)?;
    registered(&registrar, &places(template)?, &mean, &landmarks)
}

/// The template's vertices registered to a scan by its landmarks, which are at `places` in the
/// template's list.
fn registered(
    registrar: &Registrar,
    places: &[usize],
    scan: &Scan,
    landmarks: &[DVec3],
) -> FitResult<Vec<DVec3>> {
    let points: Vec<_> = (places.iter().copied())
        .zip(landmarks.iter().copied())
        .collect();
    Ok(registrar
        .register(scan, &points, &Registration::default())?
        .positions)
}

/// The template's vertices registered to a scan by landmarks that are found.
fn by_found(registrar: &Registrar, scan: &Scan) -> FitResult<Vec<DVec3>> {
    let found = (registrar.detector()?).find(&scan.positions, &scan.triangles)?;
    let points = found.landmarks(batch::CONFIDENT);
    let settings = Registration {
        point_errors: found.errors,
        ..Registration::default()
    };
    Ok(registrar.register(scan, &points, &settings)?.positions)
}

/// How the scans of a setting are made.
fn made(&(_, noise, jitter, holes): &Setting) -> Settings {
    Settings {
        noise,
        jitter,
        holes,
    }
}

/// The settings of these names; all for none.
fn chosen(only: &[String]) -> Vec<&'static Setting> {
    let wanted = |s: &&Setting| only.is_empty() || only.iter().any(|only| only == s.0);
    SETTINGS.iter().filter(wanted).collect()
}

/// Where the 68 landmarks are in the template's list.
fn places(template: &Template) -> FitResult<Vec<usize>> {
    (0..68)
        .map(|i| {
            let name = format!("ibug_{i:02}");
            let place = template.landmarks.iter().position(|l| l.name == name);
            place.ok_or_else(|| FitError::Input(format!("the template has no landmark {name}")))
        })
        .collect()
}

/// A row of the table: what it says, its value, and what the value must be at most, where
/// something was asked for.
type Row<'a> = (String, Box<dyn Fn(&Report) -> (f64, Option<f64>) + 'a>);

/// The reports side by side. A value is followed by `<=` and its limit; what is over its limit is
/// marked with `!`.
fn table(reports: &[Report]) -> String {
    let noisy = |r: &Report| r.setting.starts_with("noisy");
    let clean = |r: &Report| r.setting.starts_with("clean");
    let either = |r: &Report, if_clean: Option<f64>, if_noisy: Option<f64>| match () {
        () if clean(r) => if_clean,
        () if noisy(r) => if_noisy,
        () => None,
    };
    let mut rows: Vec<Row> = vec![
        ("people".into(), Box::new(|r| (r.people as f64, None))),
        (
            "failed".into(),
            Box::new(|r| (r.failed.len() as f64, Some(0.0))),
        ),
        (
            "drift, face: mean, mm".into(),
            Box::new(|r| (r.drift.mean, either(r, Some(0.45), Some(0.7)))),
        ),
        ("  RMS".into(), Box::new(|r| (r.drift.rms, None))),
        ("  95 %".into(), Box::new(|r| (r.drift.percentile_95, None))),
        ("  max".into(), Box::new(|r| (r.drift.max, None))),
        (
            "  mean of the worst person".into(),
            Box::new(|r| (r.worst_person_drift, None)),
        ),
        (
            "scatter of spots, face: mean, mm".into(),
            Box::new(|r| (r.scatter.mean, either(r, Some(0.45), Some(0.7)))),
        ),
        (
            "  95 %".into(),
            Box::new(|r| (r.scatter.percentile_95, None)),
        ),
        (
            "face to scan: mean, mm".into(),
            Box::new(|r| (r.face_to_scan.mean, either(r, Some(0.06), None))),
        ),
        (
            "  RMS".into(),
            Box::new(|r| (r.face_to_scan.rms, either(r, Some(0.2), None))),
        ),
        (
            "  95 %".into(),
            Box::new(|r| (r.face_to_scan.percentile_95, None)),
        ),
        ("  max".into(), Box::new(|r| (r.face_to_scan.max, None))),
        (
            "face to clean skin: mean, mm".into(),
            Box::new(|r| (r.face_to_skin.mean, either(r, None, Some(0.18)))),
        ),
        ("  RMS".into(), Box::new(|r| (r.face_to_skin.rms, None))),
        (
            "head to scan: mean, mm".into(),
            Box::new(|r| (r.head_to_scan.mean, either(r, Some(0.12), None))),
        ),
        ("  RMS".into(), Box::new(|r| (r.head_to_scan.rms, None))),
        ("  max".into(), Box::new(|r| (r.head_to_scan.max, None))),
        (
            "folded pairs, face, all people".into(),
            Box::new(|r| (r.folds as f64, Some(0.0))),
        ),
        (
            "  people with any".into(),
            Box::new(|r| (r.people_with_folds as f64, None)),
        ),
        (
            "crossing pairs, lips and lids".into(),
            Box::new(|r| (r.crossings as f64, Some(0.0))),
        ),
        (
            "  people with any".into(),
            Box::new(|r| (r.people_with_crossings as f64, None)),
        ),
    ];
    let expressions = reports.first().map_or(&[][..], |r| &r.expressions);
    for (i, (name, _)) in expressions.iter().enumerate() {
        rows.push((
            format!("folded pairs, skin, {name}"),
            Box::new(move |r| (r.expressions[i].1 as f64, Some(0.0))),
        ));
    }
    rows.push((
        "seconds a scan, one thread".into(),
        Box::new(|r| (r.seconds, Some(0.4))),
    ));

    let mut text = format!("{:34}", "");
    for report in reports {
        text += &format!("{:>18}", report.setting);
    }
    for (name, value) in &rows {
        text += &format!("\n{name:34}");
        for report in reports {
            let (value, limit) = value(report);
            let digits = if value.fract() == 0.0 { 0 } else { 3 };
            let mark = if limit.is_some_and(|limit| value > limit) {
                "!"
            } else {
                ""
            };
            let limit = limit.map_or(String::new(), |limit| format!(" <={limit}"));
            text += &format!("{:>18}", format!("{mark}{value:.digits$}{limit}"));
        }
    }
    for report in reports {
        for (seed, cause) in &report.failed {
            text += &format!("\n{}, person {seed}: {cause}", report.setting);
        }
    }
    text
}
