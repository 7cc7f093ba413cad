//! `phiz-fit describe`.

use std::path::PathBuf;

use clap::Args;

use phiz::FaceModel;
use phiz::blob::pack;
use phiz::fit::FitResult;
use phiz::fit::format::files::{check_writable, write_atomically};
use phiz::fit::learn::describe::describe;

#[derive(Args)]
pub struct DescribeArgs {
    /// The model.
    model: PathBuf,
    /// The file to write: the model, with these words on its controls.
    #[arg(short, value_name = "FILE")]
    output: PathBuf,
}

pub fn run(args: &DescribeArgs) -> FitResult<()> {
    check_writable(&args.output)?;
    let model = super::read_model(&args.model)?;
    let mut parts = model.parts().clone();
    describe(&mut parts)?;
    for control in &parts.controls {
        println!("{:24} {}", control.name, control.description);
    }
    let bytes = pack(&model.rewritten(&parts)?)?;
    FaceModel::parse(&bytes)?;
    write_atomically(&args.output, &bytes)?;
    println!("{}: {} bytes", args.output.display(), bytes.len());
    Ok(())
}
