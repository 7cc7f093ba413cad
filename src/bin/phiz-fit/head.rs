//! `phiz-fit head`.

use std::path::PathBuf;

use clap::Args;

use phiz::blob::pack;
use phiz::fit::FitResult;
use phiz::fit::format::files::{check_apart, check_writable, write_atomically};

#[derive(Args)]
pub struct HeadArgs {
    /// The model.
    model: PathBuf,
    /// The file to write.
    #[arg(short, value_name = "FILE")]
    output: PathBuf,
}

/// Writes a model without blocks, controls and attributes, whose one face is the median person of the other: a
/// seventh of the bytes, for a page to show while the rest is on its way.
pub fn run(args: &HeadArgs) -> FitResult<()> {
    check_apart(&[&args.output], &[("the model", &args.model)])?;
    check_writable(&args.output)?;
    let model = super::read_model(&args.model)?;
    let mut parts = model.parts().clone();
    parts.mean = model.face().positions().to_vec();
    parts.blocks.clear();
    parts.controls.clear();
    parts.correlation.clear();
    parts.attributes.clear();
    let bytes = pack(&parts.write()?)?;
    write_atomically(&args.output, &bytes)?;
    println!(
        "{}: {} vertices, {} bytes",
        args.output.display(),
        parts.mean.len(),
        bytes.len()
    );
    Ok(())
}
