//! `phiz-fit`: the offline program.

mod attributes;
mod basis;
mod describe;
mod evaluate;
mod export;
mod expressions;
mod head;
mod inspect;
mod landmarks;
mod measure;
mod photograph;
mod register;
mod sample;
mod simulate;
mod validate;

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::error::ErrorKind;
use clap::{Args, CommandFactory, Parser, Subcommand, ValueEnum};
use glam::DVec3;
use indicatif::ProgressBar;

use phiz::blob::{Blob, Kind, pack, unpack};
use phiz::fit::format::files::{check_apart, check_writable, files_of, folder, write_atomically};
use phiz::fit::format::ply;
use phiz::fit::head::expression;
use phiz::fit::head::generic_head;
use phiz::fit::head::people::People;
use phiz::fit::head::template::Template;
use phiz::fit::learn::about;
use phiz::fit::learn::labels::Told;
use phiz::fit::learn::persons::Persons;
use phiz::fit::learn::semantic::{Method, Table};
use phiz::fit::learn::{FaceReport, Learned, Settings, doubled, far_beyond, learn};
use phiz::fit::picture::pictures;
use phiz::fit::register::batch;
use phiz::fit::truth::ict::Ict;
use phiz::fit::truth::population;
use phiz::fit::{FitError, FitResult, counted};
use phiz::{Expressions, FaceModel};

/// Builds generic heads, populations and face models. Lengths are millimetres.
#[derive(Parser)]
#[command(name = "phiz-fit", version)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    /// Build the generic head from the base mesh.
    Template(TemplateArgs),
    /// Fit the generic head to scans.
    Register(register::RegisterArgs),
    /// Sample registered synthetic faces from the base mesh's targets.
    Population(PopulationArgs),
    /// Find the landmarks of a scan.
    Landmarks(landmarks::LandmarksArgs),
    /// Make scan-like, unregistered meshes of people of ICT-FaceKit, with the truth kept aside.
    Simulate(simulate::SimulateArgs),
    /// Register simulated people and measure against the truth.
    Evaluate(evaluate::EvaluateArgs),
    /// Fit a model to simulated photos of people and measure against the truth.
    Photograph(photograph::PhotographArgs),
    /// Align, learn and bake: from registered faces to a model.
    Train(TrainArgs),
    /// Learn from labelled faces what labels tell of a model's faces, and put it into the model.
    Attributes(attributes::AttributesArgs),
    /// Say in words what each control of a model does, anew.
    Describe(describe::DescribeArgs),
    /// Measure what a population is like and how well a model of it describes other faces.
    Validate(validate::ValidateArgs),
    /// Learn a sparse basis of local components from registered faces.
    Basis(basis::BasisArgs),
    /// Put the base mesh's expressions on the mean head of a model.
    Expressions(expressions::ExpressionsArgs),
    /// Take the median face out of a model, to be shown while the model loads.
    Head(head::HeadArgs),
    /// Measure registered faces: lengths, percentiles and coefficients as a table, and the faces as the page opens them.
    Measure(measure::MeasureArgs),
    /// Draw people from a model, as files.
    Sample(sample::SampleArgs),
    /// Write a model as arrays for numpy.
    Export(export::ExportArgs),
    /// Say what is in a model.
    Inspect(inspect::InspectArgs),
    /// Draw a template (regions, points) or a model (modes at +-3 sigma, random faces).
    Pictures(PicturesArgs),
}

#[derive(Args)]
struct TemplateArgs {
    /// The unpacked data folder of the base mesh (holds `mpfb2`).
    #[arg(long, value_name = "DIR")]
    base_mesh: PathBuf,
    /// Leave the rest pose at the base mesh's average adult, without what comes with the program:
    /// people's mean, how they vary, and where they set landmarks.
    #[arg(long)]
    plain: bool,
    /// Learn that from these registered faces instead (PLY, with landmarks beside them as
    /// `register --scans` leaves them).
    #[arg(
        long,
        value_name = "DIR",
        conflicts_with = "plain",
        requires = "registered_to"
    )]
    faces: Option<PathBuf>,
    /// The template that the faces were registered to.
    #[arg(long, value_name = "FILE", requires = "faces")]
    registered_to: Option<PathBuf>,
    /// Write what was learned from the faces here too; the program's own is `src/fit/head/people.phiz`.
    #[arg(long, value_name = "FILE", requires = "faces")]
    people: Option<PathBuf>,
    /// The template to write.
    #[arg(short, value_name = "FILE")]
    output: PathBuf,
}

#[derive(Args)]
struct PopulationArgs {
    /// The generic head.
    #[arg(long, value_name = "FILE")]
    template: PathBuf,
    /// The unpacked data folder of the base mesh (holds `mpfb2`).
    #[arg(long, value_name = "DIR")]
    base_mesh: PathBuf,
    /// How many faces.
    #[arg(long, default_value_t = 400, value_parser = clap::value_parser!(u32).range(1..))]
    count: u32,
    /// The same seed gives the same faces.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The folder to write: a PLY a face, and `labels.json`. It may hold faces of a former run of no more than these.
    #[arg(short, value_name = "DIR")]
    output: PathBuf,
}

/// What is read beside faces, for `--help`.
const BESIDE: &str = r#"about.json beside the faces, if it is there, says who they are, and goes into the model:
  {"title": "...", "population": "...", "caveat": "...",
   "licences": [{"source": "...", "by": "...", "licence": "..."}]}
labels.json, what is known of each, is for `phiz-fit attributes`, which puts it into the model; its --help says how it
is written. Each scan counts as one face, also where it tells that several are of one person: who has many then counts
for more in the mean, the modes and the percentiles."#;

#[derive(Args)]
#[command(after_help = BESIDE)]
struct TrainArgs {
    /// The generic head.
    #[arg(long, value_name = "FILE")]
    template: PathBuf,
    /// The folder of registered faces (PLY).
    #[arg(long, value_name = "DIR")]
    faces: PathBuf,
    /// The part of the variance that the modes of a region keep.
    #[arg(long, default_value_t = 0.95, value_parser = part)]
    tau: f64,
    /// How the directions of semantic controls are found.
    #[arg(long, value_enum, default_value_t = Directions::Constrained)]
    semantic: Directions,
    /// Learn from the faces as they are, without the mirror image of each: for people who differ on one side only.
    #[arg(long)]
    one_sided: bool,
    /// The model to write.
    #[arg(short, value_name = "FILE")]
    output: PathBuf,
}

#[derive(Clone, Copy, ValueEnum)]
enum Directions {
    /// Regression on the components' weights, made orthogonal one after another.
    Regression,
    /// The mean change with one measure while the others stay.
    InverseCovariance,
    /// The most probable change that moves one measure and no other.
    Constrained,
}

impl From<Directions> for Method {
    fn from(directions: Directions) -> Self {
        match directions {
            Directions::Regression => Method::Regression,
            Directions::InverseCovariance => Method::InverseCovariance,
            Directions::Constrained => Method::Constrained,
        }
    }
}

#[derive(Args)]
struct PicturesArgs {
    /// The template or the model.
    file: PathBuf,
    /// Draw people of ICT-FaceKit (this folder holds `FaceXModel`) beside faces of the model, and
    /// nothing else.
    #[arg(long, value_name = "DIR")]
    ict: Option<PathBuf>,
    /// Draw these expressions on faces of the model, and nothing else.
    #[arg(long, value_name = "FILE", conflicts_with = "ict")]
    expressions: Option<PathBuf>,
    /// The folder to write.
    #[arg(short, value_name = "DIR")]
    output: PathBuf,
}

/// Lets who reads the output go before its end (`| head`): the program then ends without a word, as others
/// do. Rust's programs ignore the signal of it, and `println!` panics.
#[cfg(unix)]
fn end_with_the_reader() {
    #[allow(unsafe_code)]
    // SAFETY: nothing runs yet that could handle a signal.
    unsafe {
        libc::signal(libc::SIGPIPE, libc::SIG_DFL);
    }
}

fn main() -> ExitCode {
    #[cfg(unix)]
    end_with_the_reader();
    // faer would split sums by the number of threads, on which no result may depend.
    faer::set_global_parallelism(faer::Par::Seq);
    let done = match Cli::parse().verb {
        Verb::Template(args) => template(&args),
        Verb::Register(args) => register::run(&args),
        Verb::Population(args) => synthetic(&args),
        Verb::Landmarks(args) => landmarks::run(&args),
        Verb::Evaluate(args) => evaluate::run(&args),
        Verb::Photograph(args) => photograph::run(&args),
        Verb::Simulate(args) => simulate::run(&args),
        Verb::Train(args) => train(&args),
        Verb::Attributes(args) => attributes::run(&args),
        Verb::Describe(args) => describe::run(&args),
        Verb::Validate(args) => validate::run(&args),
        Verb::Basis(args) => basis::run(&args),
        Verb::Expressions(args) => expressions::run(&args),
        Verb::Head(args) => head::run(&args),
        Verb::Measure(args) => measure::run(&args),
        Verb::Sample(args) => sample::run(&args),
        Verb::Export(args) => export::run(&args),
        Verb::Inspect(args) => inspect::run(&args),
        Verb::Pictures(args) => draw(&args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("phiz-fit: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Refuses what was asked of a verb as clap refuses it, where only the verb knows what goes together.
fn refuse(verb: &str, kind: ErrorKind, cause: impl std::fmt::Display) -> ! {
    let mut cli = Cli::command();
    cli.build();
    let command = cli.find_subcommand_mut(verb);
    command.expect("a verb").error(kind, cause).exit()
}

/// Reads an argument that is a number in a range.
fn within(range: RangeInclusive<f64>) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |word| match word.parse() {
        Ok(value) if range.contains(&value) => Ok(value),
        Ok(_) | Err(_) => Err(format!(
            "a number from {} to {} is meant",
            range.start(),
            range.end()
        )),
    }
}

/// Reads an argument that is a part of 1, and not nothing of it.
fn part(word: &str) -> Result<f64, String> {
    match word.parse() {
        Ok(value) if value > 0.0 && value <= 1.0 => Ok(value),
        Ok(_) | Err(_) => Err("a number above 0, 1 at most, is meant".into()),
    }
}

/// Reads one of the names in an argument, which may stand after commas with spaces.
fn word(word: &str) -> Result<String, String> {
    match word.trim() {
        "" => Err("a name is meant".into()),
        name => Ok(name.into()),
    }
}

fn read(path: &Path) -> FitResult<Vec<u8>> {
    std::fs::read(path).map_err(|e| FitError::file(path, e))
}

fn read_template(path: &Path) -> FitResult<Template> {
    let bytes = read(path)?;
    Template::from_bytes(&bytes).map_err(|e| match FaceModel::parse(&bytes) {
        Ok(_) => FitError::file(
            path,
            "a model, not a template: `phiz-fit template` makes one",
        ),
        Err(_) => FitError::file(path, e),
    })
}

fn read_model(path: &Path) -> FitResult<FaceModel> {
    let bytes = read(path)?;
    FaceModel::parse(&bytes).map_err(|e| {
        let is = |kind| unpack(&bytes).is_ok_and(|bytes| Blob::parse(&bytes, kind).is_ok());
        match [Kind::Template, Kind::Expressions].map(is) {
            [true, _] => {
                let cause = "a template, not a model: `phiz-fit train` makes one";
                FitError::file(path, cause)
            }
            [_, true] => FitError::file(path, "a model's expressions, not a model"),
            _ => FitError::file(path, e),
        }
    })
}

/// Refuses a model that has one face and no other, as `head` writes it.
fn check_varies(path: &Path, model: &FaceModel) -> FitResult<()> {
    match model.parts().population() {
        0 => Err(FitError::file(
            path,
            "a model of one face, which does not vary",
        )),
        _ => Ok(()),
    }
}

/// The names and the vertices of the faces of a folder, without those that are there before, which is said: they would
/// count twice, and be held out from themselves.
fn read_faces(folder: &Path, template: &Template) -> FitResult<(Vec<String>, Vec<Vec<DVec3>>)> {
    let read = step("reading faces", || {
        ply::read_faces(folder, &template.positions, &template.triangles())
    })?;
    Ok(once(read, |face| face).into_iter().unzip())
}

/// Whose the named faces of a folder are, by what is told beside them. Where persons are told there, what is told of no
/// face is said: a name that is written otherwise would leave a scan to be another's.
fn persons_of(folder: &Path, names: &[String]) -> FitResult<Persons> {
    let Some(told) = Told::beside(folder)? else {
        return Ok(Persons::each(names.len()));
    };
    if told.has_persons()
        && let Some(line) = told.of_no_face(folder)?
    {
        println!("{line}");
    }
    Ok(Persons::told(names, &told))
}

/// Says where some faces are scans of one person what of them is `taken`.
fn say_scans(folder: &Path, persons: &Persons, taken: &str) {
    if !persons.are_single() {
        let (folder, all) = (folder.display(), persons.said("faces"));
        println!("{folder}: {all}, of each of whom {taken}");
    }
}

/// Leaves each face once, and says which were there before by another name.
fn once<T>(named: Vec<(String, T)>, positions: impl Fn(&T) -> &Vec<DVec3>) -> Vec<(String, T)> {
    let faces: Vec<&Vec<DVec3>> = named.iter().map(|(_, face)| positions(face)).collect();
    let doubled = doubled(&faces);
    let is_doubled = |i: usize| doubled.iter().find(|&&(face, _)| face == i);
    for &(face, before) in &doubled {
        let (face, before) = (&named[face].0, &named[before].0);
        println!("{face}.ply is the same face as {before}.ply: counted once");
    }
    let kept = named.into_iter().enumerate();
    kept.filter(|&(i, _)| is_doubled(i).is_none())
        .map(|(_, face)| face)
        .collect()
}

/// Says what was decided of a scan before an error that may come of it.
fn explained<T>(result: FitResult<T>, notes: &[String]) -> FitResult<T> {
    result.inspect_err(|_| notes.iter().for_each(|note| eprintln!("{note}")))
}

/// Refuses to write over a face, or what is told of the faces, that is to be read from a folder; and to write what would
/// be read there as told of them.
fn check_apart_from(faces: &Path, written: &[&Path]) -> FitResult<()> {
    // A folder that cannot be read is told of where its faces are; and one face may be given in place of a folder.
    let (own, files) = match faces.is_file() {
        true => (folder(faces), vec![faces.to_owned()]),
        false => (faces, files_of(faces).unwrap_or_default()),
    };
    let told = ["ply", "json"];
    let is_read = |path: &&PathBuf| {
        let ending = path.extension().unwrap_or_default();
        let name = path.file_name().unwrap_or_default();
        // Other tables than that of labels may be written there.
        told.iter().any(|end| ending.eq_ignore_ascii_case(end))
            || Told::FILES
                .iter()
                .any(|file| name.eq_ignore_ascii_case(file))
    };
    let read = files.iter().filter(is_read);
    let read = read.map(|path| ("one of the files of the faces", path.as_path()));
    check_apart(written, &read.collect::<Vec<_>>())?;
    let is_told = |path: &&&Path| {
        let name = path.file_name().unwrap_or_default();
        let mut told = Told::FILES.into_iter().chain([about::FILE]);
        let there = [folder(path), own].map(|folder| folder.canonicalize().ok());
        told.any(|told| name.eq_ignore_ascii_case(told))
            && there[0].is_some()
            && there[0] == there[1]
    };
    match written.iter().find(is_told) {
        Some(path) => {
            let cause =
                "would be read as what is told of the faces there: it is written to another file";
            Err(FitError::file(path, cause))
        }
        None => Ok(()),
    }
}

/// Does one step of a verb and says so while it lasts, where a person watches.
fn step<T>(what: &'static str, work: impl FnOnce() -> FitResult<T>) -> FitResult<T> {
    let spinner = ProgressBar::new_spinner().with_message(what);
    spinner.enable_steady_tick(std::time::Duration::from_millis(100));
    let done = work();
    spinner.finish_and_clear();
    done
}

fn template(args: &TemplateArgs) -> FitResult<()> {
    let written = [Some(&args.output), args.people.as_ref()]
        .into_iter()
        .flatten();
    let former = args.registered_to.iter();
    let former = former.map(|path| {
        (
            "the template that the faces were registered to",
            path.as_path(),
        )
    });
    let written: Vec<&Path> = written.map(PathBuf::as_path).collect();
    check_apart(&written, &former.collect::<Vec<_>>())?;
    if let Some(faces) = &args.faces {
        check_apart_from(faces, &written)?;
    }
    check_writable(&args.output)?;
    args.people.as_deref().map_or(Ok(()), check_writable)?;
    let plain = step("building the generic head", || {
        generic_head::build(&args.base_mesh)
    })?;
    let mut template = match (&args.faces, &args.registered_to) {
        (Some(faces), Some(registered_to)) => {
            let former = read_template(registered_to)?;
            let read = step("reading faces", || batch::read_registered(faces, &former))?;
            let (_, once): (Vec<_>, Vec<_>) =
                once(read, |face| &face.positions).into_iter().unzip();
            let people = step("learning from people", || {
                People::learn(&former, &plain, &once)
            })
            .map_err(|e| e.of(faces))?;
            let bytes = people.to_bytes()?;
            if let Some(path) = &args.people {
                write_atomically(path, &bytes)?;
            }
            // What the program will read later is what is given now, rounding and all.
            People::from_bytes(&bytes)?.give(&plain)?
        }
        _ if args.plain => plain,
        _ => People::bundled()?.give(&plain)?,
    };
    if template.prior.is_some() {
        template.expressions = step("carrying expressions to it", || {
            expression::visible(&template, &args.base_mesh)
        })?;
    }
    write_atomically(&args.output, &template.to_bytes()?)?;
    println!(
        "{}: {} vertices, {} triangles, {} points",
        args.output.display(),
        template.positions.len(),
        template.topology.uv_triangles.len(),
        template.landmarks.len()
    );
    Ok(())
}

fn synthetic(args: &PopulationArgs) -> FitResult<()> {
    let template = read_template(&args.template)?;
    std::fs::create_dir_all(&args.output).map_err(|e| FitError::file(&args.output, e))?;
    population::check_folder(&args.output, args.count as usize)?;
    let people = step("sampling faces", || {
        population::sample(&template, &args.base_mesh, args.count as usize, args.seed)
    })?;
    step("writing faces", || {
        population::write(&people, &template, &args.output)
    })?;
    let count = people.faces.len();
    println!("{}: {}", args.output.display(), counted(count));
    Ok(())
}

fn train(args: &TrainArgs) -> FitResult<()> {
    check_apart(&[&args.output], &[("the template", &args.template)])?;
    check_apart_from(&args.faces, &[&args.output])?;
    check_writable(&args.output)?;
    let template = read_template(&args.template)?;
    let (names, faces) = read_faces(&args.faces, &template)?;
    let about = about::read(&args.faces)?;
    let persons = persons_of(&args.faces, &names)?;
    say_scans(&args.faces, &persons, "the mean is learned from");
    let settings = Settings {
        tau: args.tau,
        semantic: args.semantic.into(),
        both_sides: !args.one_sided,
        ..Settings::default()
    };
    let learned = step("learning", || {
        learn(&template, faces, &persons, about, &settings)
    })
    .map_err(|e| e.of(&args.faces))?;
    let bytes = pack(&learned.parts.write()?)?;
    // What is written is read once before it replaces anything.
    FaceModel::parse(&bytes)?;
    write_atomically(&args.output, &bytes)?;
    for (face, far, what) in far_beyond(&learned.faces) {
        let FaceReport { alignment, size } = learned.faces[face];
        eprintln!(
            "phiz-fit: warning: {}.ply: far beyond the others in {what}, by {far:.1} robust standard deviations \
             ({alignment:.2} mm RMS from the mean, {size:.1} mm RMS in size): was it registered well, in the right unit?",
            names[face]
        );
    }
    print!("{}", summary(&learned, &names));
    println!("{}: {} bytes", args.output.display(), bytes.len());
    Ok(())
}

fn summary(learned: &Learned, names: &[String]) -> String {
    let mut text = format!("alignment left {:.2} mm RMS", learned.alignment);
    let worst = learned.faces.iter().zip(names);
    let worst = worst.max_by(|(a, _), (b, _)| a.alignment.total_cmp(&b.alignment));
    if let Some((face, name)) = worst {
        text += &format!(", at most {:.2} ({name}.ply)", face.alignment);
    }
    text.push('\n');
    for block in &learned.blocks {
        text += &format!(
            "{:10} {:3} modes, {:4.1} % of the variance; smoothing kept {:.0} % of the motion\n",
            block.name,
            block.modes,
            100.0 * block.variance,
            100.0 * block.kept_by_smoothing
        );
    }
    learned
        .tables
        .iter()
        .for_each(|table| text += &cross_talk(table));
    text
}

/// A table of cross-talk as text: what +1 of each control does to all measures, in hundredths of a
/// standard deviation.
fn cross_talk(table: &Table) -> String {
    let (worst, control, measure) = table.worst();
    let mut text = format!(
        "semantic controls by {:?}: {}; of other measures than their own they change {:.3} standard \
         deviations RMS",
        table.method,
        table.controls.len(),
        table.rms()
    );
    if let (Some(control), Some(measure)) =
        (table.controls.get(control), table.controls.get(measure))
    {
        text += &format!(", at most {worst:.2} ({control}: {measure})");
    }
    text.push('\n');
    for (i, row) in table.moved[0].1.iter().enumerate() {
        let cells: String = row.iter().map(|x| format!(" {:4.0}", 100.0 * x)).collect();
        let (name, length, sigma) = (&table.controls[i], table.lengths[i], table.sigmas[i]);
        text += &format!("  {name:27}{cells}  {sigma:.2} mm, unusual by {length:.1}\n");
    }
    text
}

fn draw(args: &PicturesArgs) -> FitResult<()> {
    let bytes = read(&args.file)?;
    let template = Template::from_bytes(&bytes);
    if template.is_err() && args.ict.is_none() && args.expressions.is_none() {
        let drawn = pictures::of_model(&read_model(&args.file)?, &args.output);
        return drawn.map_err(|e| e.of(&args.file));
    }
    std::fs::create_dir_all(&args.output).map_err(|e| FitError::file(&args.output, e))?;
    if let Some(ict) = &args.ict {
        let ict = step("reading ICT-FaceKit", || Ict::read(ict))?;
        return pictures::of_people(&read_model(&args.file)?, &ict, &args.output);
    }
    if let Some(path) = &args.expressions {
        let model = read_model(&args.file)?;
        let expressions = Expressions::parse(&read(path)?, &model);
        let expressions = expressions.map_err(|e| FitError::file(path, e))?;
        return pictures::of_expressions(&model, &expressions, &args.output);
    }
    pictures::of_template(&template?, &args.output)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where a control changes another measure by more than its own, too.
    #[test]
    fn numbers_of_a_table_stand_apart() {
        let rows = vec![vec![1.0, -1.15], vec![-123.456, 1.0]];
        let table = Table {
            method: Method::Regression,
            controls: vec!["nose width".into(), "nose height".into()],
            moved: vec![(1.0, rows)],
            sigmas: vec![2.0, 3.0],
            lengths: vec![1.0, 2.0],
            tied: vec![Vec::new(), Vec::new()],
        };
        let text = cross_talk(&table);
        let rows = text.lines().skip(1).map(|line| {
            let words: Vec<&str> = line.split_whitespace().collect();
            words[2..4].join(" ")
        });
        assert_eq!(rows.collect::<Vec<_>>(), ["100 -115", "-12346 100"]);
    }
}
