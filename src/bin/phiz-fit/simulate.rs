//! `phiz-fit simulate`.

use std::path::PathBuf;

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};

use phiz::fit::FitResult;
use phiz::fit::truth::ict::Ict;
use phiz::fit::truth::simulate::{Settings, Simulator, check_folder, write};

#[derive(Args)]
pub struct SimulateArgs {
    /// The folder of ICT-FaceKit (holds `FaceXModel`).
    #[arg(long, value_name = "DIR")]
    ict: PathBuf,
    /// How many people.
    #[arg(long, default_value_t = 300, value_parser = clap::value_parser!(u32).range(1..))]
    count: u32,
    /// The first person's seed; the next person has the next one.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Standard deviation of the surface noise.
    #[arg(long, default_value_t = 0.0, value_name = "MM", value_parser = crate::within(0.0..=10.0))]
    noise: f64,
    /// Mean error of the landmarks.
    #[arg(long, default_value_t = 0.5, value_name = "MM", value_parser = crate::within(0.0..=10.0))]
    jitter: f64,
    /// Leave holes: nostrils, behind the ears, the crown, the neck, small ones.
    #[arg(long)]
    holes: bool,
    /// Write all of the template's points, not the 68 iBUG points alone.
    #[arg(long)]
    all_points: bool,
    /// The folder to write: a PLY and a JSON of landmarks a person, `truth/` and `about.json`. It may hold others of the
    /// same noise, errors and holes.
    #[arg(short, value_name = "DIR")]
    output: PathBuf,
}

pub fn run(args: &SimulateArgs) -> FitResult<()> {
    let settings = Settings {
        noise: args.noise,
        jitter: args.jitter,
        holes: args.holes,
    };
    check_folder(&args.output, args.seed, args.count, &settings)?;
    let ict = super::step("reading ICT-FaceKit", || Ict::read(&args.ict))?;
    let simulator = Simulator::new(&ict);
    let style = ProgressStyle::with_template("{bar:30} {pos} of {len} scans, {eta} left");
    let bar = ProgressBar::new(args.count.into());
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    write(
        &simulator,
        args.seed,
        args.count,
        &settings,
        args.all_points,
        &args.output,
        || bar.inc(1),
    )?;
    bar.finish_and_clear();
    println!("{}: {} scans", args.output.display(), args.count);
    Ok(())
}
