//! A model as arrays that numpy alone reads, for who computes with it in another program.

use std::path::Path;

use glam::Vec3;

use crate::FaceModel;
use crate::anatomy::Part;
use crate::fit::format::files::write_atomically;
use crate::fit::format::npz::Npz;
use crate::fit::{FitError, FitResult};

/// What is in the file, for `--help`: n vertices, c corners, t triangles, k coefficients of which the first p are the
/// population's, s controls, q quantiles.
pub const ARRAYS: &str = "\
What is in it (n vertices, t triangles, k coefficients, of which the first p are the population's and the others those
of named controls, s sliders):
  mean         n x 3, mm: y up, z out of the face, x to the subject's left
  modes        k x n x 3, mm for a coefficient of 1, with what follows them at the model's blending distance:
               a face is mean + sum over i of coefficients[i] modes[i]
  sigmas       k, mm: the standard deviation of each mode's amount along its unit direction in its block
               (of named controls, of their measure)
  block        k, the block of each mode; odd, k, whether it is the opposite of its mirror image
  correlation  p x p, of the population's coefficients, whose variances are 1
  triangles    t x 3, vertices; uv_triangles, t x 3, corners; uv, corners x 2; uv_vertices, the vertex of each corner
  mirror       n, the vertex on the other side; regions, n, places in region_names
  controls     s, names; quantiles, s x q: equally spaced percentiles of what each slider reads, sigmas, or mm of those
               that are named
  landmarks    names; the point is the sum over entries of landmark_weights times landmark_vertices, those whose
               landmark_of is its place
  measures     names, and measure_about, what they are (`phiz-fit inspect --json` has of which landmarks)
  attributes   names; attribute_means and attribute_readings, x p: it reads mean + sum over i of readings[i] coefficients[i]
  parts        names (skin, eyeballs ...); part_of, t, the part of each triangle
  about        what the model says of itself: title, population, caveat, program, and sources with their licences";

/// Writes a model's arrays ([`ARRAYS`]) as `.npz`.
///
/// # Errors
/// When the file cannot be written.
pub fn write(model: &FaceModel, path: &Path) -> FitResult<()> {
    let parts = model.parts();
    let topology = &parts.topology;
    let (n, k, p) = (parts.mean.len(), parts.coefficients(), parts.population());
    let flat = |points: &[Vec3]| points.iter().flat_map(Vec3::to_array).collect::<Vec<f32>>();
    // A row a vertex; what is written has a mode after the other.
    let face = model.face();
    let rows: Vec<Vec<Vec3>> = (0..n as u32).map(|v| face.jacobian(v)).collect();
    let modes = (0..k).flat_map(|i| rows.iter().flat_map(move |row| row[i].to_array()));
    let blocks = || {
        let own = parts.blocks.iter();
        own.flat_map(|block| block.sigmas.iter().map(|&sigma| (&*block.name, sigma)))
    };
    let corners = |triangles: &[[u32; 3]]| triangles.as_flattened().to_vec();
    let triangles = topology.triangles();
    let t = triangles.len();
    let controls = &parts.controls;
    let steps = controls.first().map_or(0, |c| c.quantiles.len());
    let about = &parts.about;
    let sources = about.licences.iter();
    let sources = sources.map(|l| format!("from {} by {}, {}", l.source, l.by, l.licence));
    let sources: Vec<String> = sources.collect();
    let said = [
        &about.title,
        &about.population,
        &about.caveat,
        &about.made_by,
    ];
    let arrays = || -> std::io::Result<Vec<u8>> {
        let mut npz = Npz::default();
        npz.f32("mean", &[n, 3], flat(&parts.mean))?;
        npz.f32("modes", &[k, n, 3], modes)?;
        npz.f32("sigmas", &[k], blocks().map(|b| b.1))?;
        npz.words("block", blocks().map(|b| b.0))?;
        npz.bools("odd", &parts.odd())?;
        npz.f32("correlation", &[p, p], parts.correlation.iter().copied())?;
        npz.u32("triangles", &[t, 3], corners(&triangles))?;
        npz.u32("uv_triangles", &[t, 3], corners(&topology.uv_triangles))?;
        let uvs = topology.uvs.as_flattened().iter().copied();
        npz.f32("uv", &[topology.uvs.len(), 2], uvs)?;
        let vertices = topology.uv_vertices.iter().copied();
        npz.u32("uv_vertices", &[topology.uv_vertices.len()], vertices)?;
        npz.u32("mirror", &[n], topology.mirror.iter().copied())?;
        npz.u32("regions", &[n], topology.regions.iter().map(|&r| r.into()))?;
        npz.words("region_names", topology.region_names.iter().map(|r| &**r))?;
        npz.words("controls", controls.iter().map(|c| &*c.name))?;
        let quantiles = controls.iter().flat_map(|c| c.quantiles.iter().copied());
        npz.f32("quantiles", &[controls.len(), steps], quantiles)?;
        npz.words("landmarks", parts.landmarks.iter().map(|l| &*l.name))?;
        let entries = || {
            let each = parts.landmarks.iter().zip(0_u32..);
            each.flat_map(|(landmark, l)| {
                landmark
                    .stencil
                    .iter()
                    .map(move |&(v, weight)| (l, v, weight as f32))
            })
        };
        let count = [entries().count()];
        npz.u32("landmark_of", &count, entries().map(|e| e.0))?;
        npz.u32("landmark_vertices", &count, entries().map(|e| e.1))?;
        npz.f32("landmark_weights", &count, entries().map(|e| e.2))?;
        npz.words("measures", parts.measures.iter().map(|m| &*m.name))?;
        npz.words(
            "measure_about",
            parts.measures.iter().map(|m| &*m.description),
        )?;
        let attributes = &parts.attributes;
        npz.words("attributes", attributes.iter().map(|a| &*a.name))?;
        npz.f32(
            "attribute_means",
            &[attributes.len()],
            attributes.iter().map(|a| a.mean),
        )?;
        let readings = attributes.iter().flat_map(|a| a.reading.iter().copied());
        npz.f32("attribute_readings", &[attributes.len(), p], readings)?;
        npz.words("parts", topology.parts.iter().map(|part| &*part.name))?;
        // What is in no part comes after all of them.
        let part_of = (0..t as u32).map(|triangle| {
            let here = |part: &Part| (part.first..part.first + part.count).contains(&triangle);
            topology
                .parts
                .iter()
                .position(here)
                .unwrap_or(topology.parts.len()) as u32
        });
        npz.u32("part_of", &[t], part_of)?;
        npz.words(
            "about",
            said.into_iter().chain(&sources).map(|words| &**words),
        )?;
        npz.finish()
    };
    write_atomically(path, &arrays().map_err(|e| FitError::file(path, e))?)
}
