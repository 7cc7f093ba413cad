//! `phiz-fit attributes`.

use std::path::PathBuf;

use clap::Args;

use phiz::FaceModel;
use phiz::blob::pack;
use phiz::fit::format::files::{check_apart, check_writable, write_atomically};
use phiz::fit::learn::about;
use phiz::fit::learn::attributes::learn;
use phiz::fit::learn::labels::{FORMAT, Labels, Told};
use phiz::fit::{FitError, FitResult};
use phiz::model::Attribute;

#[derive(Args)]
#[command(after_help = FORMAT)]
pub struct AttributesArgs {
    /// The generic head.
    #[arg(long, value_name = "FILE")]
    template: PathBuf,
    /// The folder of labelled registered faces (PLY) with their `labels.json` or `labels.csv`.
    #[arg(long, value_name = "DIR")]
    faces: PathBuf,
    /// Learn these labels alone, as age,sex; the three shares are ethnicity.
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = super::word)]
    labels: Vec<String>,
    /// The model, of these people or of others.
    model: PathBuf,
    /// The file to write: the model, with these attributes and no others.
    #[arg(short, value_name = "FILE")]
    output: PathBuf,
}

pub fn run(args: &AttributesArgs) -> FitResult<()> {
    // The model may be written over: it is what is written, with more.
    check_apart(&[&args.output], &[("the template", &args.template)])?;
    super::check_apart_from(&args.faces, &[&args.output])?;
    check_writable(&args.output)?;
    let model = super::read_model(&args.model)?;
    super::check_varies(&args.model, &model)?;
    let template = super::read_template(&args.template)?;
    let (names, faces) = super::read_faces(&args.faces, &template)?;
    let told = Told::beside(&args.faces)?
        .ok_or_else(|| FitError::file(&args.faces, "no labels.json or labels.csv there"))?;
    if let Some(line) = told.of_no_face(&args.faces)? {
        println!("{line}");
    }
    if let Some(line) = told.in_words() {
        println!("{line}");
    }
    let mut labels = Labels::of(&told, &names);
    if !args.labels.is_empty() {
        (labels.only(&args.labels)).map_err(|e| e.of(told.path()))?;
    }
    let persons = &labels.persons;
    let source = about::read(&args.faces)?.title;
    let learned = super::step("learning", || {
        learn(&template, &model, &faces, &labels, &source)
    })
    .map_err(|e| e.of(&args.faces))?;
    println!(
        "{}, of whose skin the model leaves {:.2} mm RMS; held out:",
        persons.said("people"),
        learned.left
    );
    let mut parts = model.parts().clone();
    parts.attributes = learned.attributes().cloned().collect();
    for (names, why) in &learned.skipped {
        println!("{:10} skipped: {why}", names.join(", "));
    }
    for told in &learned.told {
        let Attribute {
            name,
            unit,
            limits: [least, most],
            ..
        } = &told.attribute;
        println!(
            "{name:10} {:4.1} % of the variance explained, {:.2} {unit} off in {least:.2} to \
             {most:.2}; a standard deviation is {:.2} sigmas{}{}",
            100.0 * told.attribute.explained,
            told.error,
            told.length,
            match told.people == persons.count() {
                true => String::new(),
                false => format!("; known of {} people", told.people),
            },
            match parts.attributes.contains(&told.attribute) {
                true => "",
                false => "; not told by these faces, left out",
            }
        );
    }
    let bytes = pack(&model.rewritten(&parts)?)?;
    FaceModel::parse(&bytes)?;
    write_atomically(&args.output, &bytes)?;
    println!("{}: {} bytes", args.output.display(), bytes.len());
    Ok(())
}
