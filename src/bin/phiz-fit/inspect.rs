//! `phiz-fit inspect`.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use phiz::fit::{FitResult, counted};

#[derive(Args)]
pub struct InspectArgs {
    /// The model.
    model: PathBuf,
    /// As JSON.
    #[arg(long)]
    json: bool,
}

pub fn run(args: &InspectArgs) -> FitResult<()> {
    let model = super::read_model(&args.model)?;
    let parts = model.parts();
    if args.json {
        let blocks: Vec<_> = parts
            .blocks
            .iter()
            .map(|b| {
                json!({
                    "name": b.name, "modes": b.sigmas.len(), "vertices": b.support.len(),
                    "step_mm": b.modes.step(), "sigmas_mm": b.sigmas,
                    "surround": b.surround.as_ref().map(|s| s.targets.len()),
                })
            })
            .collect();
        let attributes: Vec<_> = (parts.attributes.iter())
            .map(|a| {
                json!({
                    "name": a.name, "description": a.description, "unit": a.unit, "limits": a.limits, "mean": a.mean,
                    "explained": a.explained,
                })
            })
            .collect();
        let report = json!({
            "about": parts.about, "vertices": parts.mean.len(),
            "triangles": parts.topology.uv_triangles.len(), "coefficients": parts.coefficients(),
            "blocks": blocks, "controls": parts.controls.iter().map(|c| &c.name).collect::<Vec<_>>(),
            "landmarks": parts.landmarks, "measures": parts.measures, "attributes": attributes,
            "blending": parts.blending,
        });
        println!("{report:#}");
        return Ok(());
    }
    println!(
        "{}\n{}\n{}",
        parts.about.title, parts.about.population, parts.about.caveat
    );
    for licence in &parts.about.licences {
        println!(
            "from {} by {}, {}",
            licence.source, licence.by, licence.licence
        );
    }
    println!(
        "learned from {} by {}; {} vertices, {} triangles, {} coefficients, {} controls",
        counted(parts.about.faces as usize),
        parts.about.made_by,
        parts.mean.len(),
        parts.topology.uv_triangles.len(),
        parts.coefficients(),
        parts.controls.len()
    );
    for block in &parts.blocks {
        println!(
            "{:10} {:3} modes on {:5} vertices, {:5} around follow; step {} mm",
            block.name,
            block.sigmas.len(),
            block.support.len(),
            block.surround.as_ref().map_or(0, |s| s.targets.len()),
            block.modes.step()
        );
    }
    let measures: Vec<&str> = parts.measures.iter().map(|m| &*m.name).collect();
    println!("{} measures: {}", measures.len(), measures.join(", "));
    for attribute in &parts.attributes {
        println!(
            "{}: {} to {} {}, {:.0} % explained; {}",
            attribute.name,
            attribute.limits[0],
            attribute.limits[1],
            attribute.unit,
            100.0 * attribute.explained,
            attribute.description
        );
    }
    Ok(())
}
