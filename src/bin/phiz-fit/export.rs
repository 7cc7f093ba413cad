//! `phiz-fit export`.

use std::path::PathBuf;

use clap::Args;
use clap::error::ErrorKind;

use phiz::fit::FitResult;
use phiz::fit::export::{ARRAYS, write};
use phiz::fit::format::files::{check_apart, check_writable};

#[derive(Args)]
#[command(after_help = ARRAYS)]
pub struct ExportArgs {
    /// The model.
    model: PathBuf,
    /// The file to write: an .npz, which numpy.load reads.
    #[arg(short, value_name = "FILE")]
    output: PathBuf,
}

/// Writes a model's arrays.
pub fn run(args: &ExportArgs) -> FitResult<()> {
    let is_npz = |ending: &std::ffi::OsStr| ending.eq_ignore_ascii_case("npz");
    if !args.output.extension().is_some_and(is_npz) {
        let cause = format!(
            "{}: a name that ends in .npz is needed",
            args.output.display()
        );
        super::refuse("export", ErrorKind::ValueValidation, cause);
    }
    check_apart(&[&args.output], &[("the model", &args.model)])?;
    check_writable(&args.output)?;
    let model = super::read_model(&args.model)?;
    super::step("writing", || write(&model, &args.output))?;
    let parts = model.parts();
    println!(
        "{}: {} modes of {} vertices",
        args.output.display(),
        parts.coefficients(),
        parts.mean.len()
    );
    Ok(())
}
