//! `phiz-fit expressions`.

use std::path::{Path, PathBuf};

use clap::Args;

use phiz::blob::pack;
use phiz::expression;
use phiz::fit::format::files::{check_apart, check_writable, write_atomically};
use phiz::fit::{FitError, FitResult};

#[derive(Args)]
pub struct ExpressionsArgs {
    /// The generic head.
    #[arg(long, value_name = "FILE")]
    template: PathBuf,
    /// The unpacked data folder of the base mesh (holds `faceunits01`).
    #[arg(long, value_name = "DIR")]
    base_mesh: PathBuf,
    /// The model for whose faces they are.
    model: PathBuf,
    /// The file to write.
    #[arg(short, value_name = "FILE")]
    output: PathBuf,
}

pub fn run(args: &ExpressionsArgs) -> FitResult<()> {
    let read: [(&str, &Path); 2] = [("the template", &args.template), ("the model", &args.model)];
    check_apart(&[&args.output], &read)?;
    check_writable(&args.output)?;
    let template = super::read_template(&args.template)?;
    let model = super::read_model(&args.model)?;
    let baked = super::step("expressions on the mean head", || {
        phiz::fit::head::expression::bake(&template, &model, &args.base_mesh)
    })
    .map_err(|e| e.of(&args.model))?;
    let bytes = expression::write(&model, &baked).and_then(|blob| pack(&blob));
    let bytes = bytes.map_err(|e| FitError::file(&args.output, e))?;
    write_atomically(&args.output, &bytes)?;
    println!(
        "{}: {} expressions, {} bytes",
        args.output.display(),
        baked.len(),
        bytes.len()
    );
    Ok(())
}
