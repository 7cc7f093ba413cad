//! `phiz-fit sample`.

use std::path::PathBuf;

use clap::Args;
use clap::error::ErrorKind;
use indicatif::{ProgressBar, ProgressStyle};

use phiz::fit::sample::{Target, write};
use phiz::fit::{FitError, FitResult, counted};
use phiz::{FaceModel, Randomize};

#[derive(Args)]
pub struct SampleArgs {
    /// The model.
    model: PathBuf,
    /// How many people.
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..))]
    count: u32,
    /// The first person's seed; the next person has the next one.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(..1 << 52))]
    seed: u64,
    /// What labels are to say of all of them, such as sex=1,age=60 (`inspect` has a model's attributes); the rest is left
    /// to chance.
    #[arg(long, value_name = "NAME=VALUE,...", value_delimiter = ',', value_parser = named)]
    attributes: Vec<(String, f64)>,
    /// How unusual they are: 1 is people, 0 their mean.
    #[arg(long, default_value_t = 1.0, value_parser = super::within(0.0..=3.0))]
    spread: f64,
    /// Only these features are drawn, such as nose,mouth; the others are the median person's.
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', value_parser = super::word)]
    regions: Option<Vec<String>>,
    /// A folder for PLY files; or a name in it that ends in `.obj`, `.ply` or `.glb`, with which
    /// files start; or a file that ends in `.npy`, an array of faces x vertices x 3. A JSON beside
    /// them has each one's seed and code. There may be files of a former run of no more than these. A new folder with a dot in its name needs a slash at its end.
    #[arg(short, value_name = "DIR")]
    output: PathBuf,
}

/// Reads a name with its value.
fn named(word: &str) -> Result<(String, f64), String> {
    let pair = word.split_once('=').and_then(|(name, value)| {
        let value: f64 = value.trim().parse().ok()?;
        value.is_finite().then(|| (name.trim().to_owned(), value))
    });
    pair.ok_or_else(|| "a name with a number is meant, as age=60".into())
}

/// Refuses what the model has no name for, with the names that it has, and what is beyond an attribute's limits.
fn check_names(args: &SampleArgs, model: &FaceModel) -> FitResult<()> {
    let parts = model.parts();
    let refuse = |cause: String| Err(FitError::Input(cause));
    let listed = |names: &[&str]| match names {
        [] => "it has none".into(),
        _ => format!("there are {}", names.join(", ")),
    };
    let attributes: Vec<&str> = parts.attributes.iter().map(|a| &*a.name).collect();
    for (name, value) in &args.attributes {
        let Some(attribute) = parts.attributes.iter().find(|a| a.name == *name) else {
            let there = listed(&attributes);
            return refuse(format!("no attribute is called {name:?}; {there}"));
        };
        let [least, most] = attribute.limits;
        if !(f64::from(least)..=f64::from(most)).contains(value) {
            return refuse(format!(
                "{name} goes from {least} to {most}, not to {value}"
            ));
        }
    }
    let own = parts.blocks.iter().filter(|b| b.local_to.is_none());
    let regions: Vec<&str> = own.map(|b| &*b.name).collect();
    let mut asked = args.regions.iter().flatten();
    match asked.find(|name| !regions.contains(&name.as_str())) {
        Some(name) => {
            let there = listed(&regions);
            refuse(format!("no feature is called {name:?}; {there}"))
        }
        None => Ok(()),
    }
}

pub fn run(args: &SampleArgs) -> FitResult<()> {
    let target = Target::parse(&args.output)
        .unwrap_or_else(|cause| super::refuse("sample", ErrorKind::ValueValidation, cause));
    for (i, (name, _)) in args.attributes.iter().enumerate() {
        if args.attributes[..i].iter().any(|before| before.0 == *name) {
            let cause = format!("{name} is asked for twice");
            super::refuse("sample", ErrorKind::ArgumentConflict, cause);
        }
    }
    let model = super::read_model(&args.model)?;
    check_names(args, &model).map_err(|e| e.of(&args.model))?;
    if args.count > 1 {
        super::check_varies(&args.model, &model)?;
    }
    let style = ProgressStyle::with_template("{bar:30} {pos} of {len} faces, {eta} left");
    let bar = ProgressBar::new(args.count.into());
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let like = Randomize {
        seed: None,
        spread: Some(args.spread),
        regions: args.regions.clone(),
        attributes: args.attributes.clone(),
    };
    // What cannot be drawn is said before anything is written.
    model.face().randomize(&Randomize {
        seed: Some(args.seed),
        ..like.clone()
    })?;
    write(&model, args.count, args.seed, &like, &target, |n| {
        bar.inc(n)
    })?;
    bar.finish_and_clear();
    let said = counted(args.count as usize);
    println!("{}: {said}", args.output.display());
    Ok(())
}
