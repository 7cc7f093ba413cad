//! `phiz-fit sample`.

use std::path::PathBuf;

use clap::Args;
use clap::error::ErrorKind;
use indicatif::{ProgressBar, ProgressStyle};

use phiz::fit::FitResult;
use phiz::fit::sample::{Target, write};

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
    /// A folder for PLY files; or a name in it that ends in `.obj`, `.ply` or `.glb`, with which
    /// files start; or a file that ends in `.npy`, an array of faces x vertices x 3. A JSON beside
    /// them has each one's seed and code. A new folder with a dot in its name needs a slash at its end.
    #[arg(short, value_name = "DIR")]
    output: PathBuf,
}

pub fn run(args: &SampleArgs) -> FitResult<()> {
    let target = Target::parse(&args.output)
        .unwrap_or_else(|cause| super::refuse("sample", ErrorKind::ValueValidation, cause));
    let model = super::read_model(&args.model)?;
    if args.count > 1 {
        super::check_varies(&args.model, &model)?;
    }
    let style = ProgressStyle::with_template("{bar:30} {pos} of {len} faces, {eta} left");
    let bar = ProgressBar::new(args.count.into());
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    write(&model, args.count, args.seed, &target, |n| bar.inc(n))?;
    bar.finish_and_clear();
    println!("{}: {} faces", args.output.display(), args.count);
    Ok(())
}
