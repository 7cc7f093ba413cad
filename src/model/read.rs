//! Reading a model, at once or while its bytes come in.

use std::sync::{Arc, OnceLock};

use glam::{Vec3, Vec4};
use nalgebra::DMatrix;
use wide::i32x4;

use super::attribute::{Attribute, along};
use super::header::{BlockHeader, ControlHeader, Header, SurroundHeader};
use super::{
    Blending, Block, Control, Derived, FaceModel, LIMIT, ModelParts, Modes, Reach, Rigid, SOURCES,
    Surround,
};
use crate::blob::{Blob, Kind, MAX_BYTES};
use crate::error::Number;
use crate::kernel::Patch;
use crate::mesh::Topology;
use crate::predict::{Walk, fours};
use crate::quantise::{COORDINATES, CORRELATIONS, DISTANCES, sound_step};
use crate::{Error, Result};

const LARGEST_COORDINATE: f32 = 1e4;
const MAX_VERTICES: u32 = 1 << 20;
pub(crate) const MAX_COEFFICIENTS: usize = 1024;
/// What is locked is told by a bit each.
const MAX_BLOCKS: usize = 63;
/// Each is compared with all others.
const MAX_ATTRIBUTES: usize = 256;
/// Of a landmark. A measure may ask for one often.
const MAX_STENCIL: usize = 64;
/// Blending farther than a head is high means nothing, and up to here a whole micrometre survives
/// f32.
const FARTHEST_REACH: f32 = 1e3;

/// A model whose bytes come in one after the other: what can be read of it before the last is there is
/// read by then.
#[derive(Debug, Default)]
pub struct IncomingModel {
    bytes: Vec<u8>,
    reading: Option<Reading>,
    /// What came is not what was expected: all is read when all is there, which tells why.
    stopped: bool,
}

impl IncomingModel {
    /// Takes the next bytes of a blob, which is not packed.
    pub fn push(&mut self, bytes: Vec<u8>) {
        match self.bytes.is_empty() {
            true => self.bytes = bytes,
            // What is too long by then is refused for it, and what else comes is let go.
            false if self.bytes.len() > MAX_BYTES => return,
            false => self.bytes.extend_from_slice(&bytes),
        }
        if !self.stopped && self.read_on().is_err() {
            (self.reading, self.stopped) = (None, true);
        }
    }

    /// Reads what comes before each block whose modes are there: all before those is there, too.
    fn read_on(&mut self) -> Result<()> {
        // The table is among the first bytes.
        let Ok(blob) = Blob::first_bytes(&self.bytes, Kind::Model) else {
            return Ok(());
        };
        loop {
            let next = self.reading.as_ref().map_or(0, |r| r.blocks.len() + 1);
            if !blob.has(&format!("modes.{next}")) {
                return Ok(());
            }
            match &mut self.reading {
                Some(reading) => reading.block(&blob)?,
                none => *none = Some(Reading::start(&blob)?),
            }
        }
    }

    /// The model, once all bytes are there, and these; nothing has come in then.
    ///
    /// # Errors
    /// As [`FaceModel::parse`].
    pub fn finish(&mut self) -> Result<(FaceModel, Vec<u8>)> {
        let Self { bytes, reading, .. } = std::mem::take(self);
        let blob = Blob::parse(&bytes, Kind::Model)?;
        Ok((model(&blob, reading)?, bytes))
    }
}

/// The model in a blob, of which some may have been read.
#[inline(never)]
pub(super) fn model(blob: &Blob, begun: Option<Reading>) -> Result<FaceModel> {
    let mut reading = match begun {
        Some(reading) => reading,
        None => Reading::start(blob)?,
    };
    while reading.blocks.len() < reading.header.blocks.len() {
        reading.block(blob)?;
    }
    let (mut parts, whole, reach) = reading.finish(blob)?;
    let population = parts.population();
    let correlation = DMatrix::from_row_iterator(
        population,
        population,
        parts.correlation.iter().map(|&r| f64::from(r)),
    );
    let mut fingerprint = blob.fingerprint();
    if let Some(read) = read_attributes(blob, population)? {
        (fingerprint, parts.attributes) = read;
    }
    let mut changes = Vec::new();
    for attribute in &parts.attributes {
        let (change, variance) = along(&correlation, &attribute.reading);
        if variance.is_nan() || variance < 1e-12 {
            return Err(unsound(attribute));
        }
        changes.push((change, variance));
    }
    let Some(cholesky) = correlation.clone().cholesky() else {
        return Err(Error::Blob(
            "its correlation matrix is not positive definite".into(),
        ));
    };
    let mut median = vec![0.0_f32; parts.coefficients()];
    for control in parts.controls.iter().filter(|c| c.measure.is_none()) {
        let amount = (control.median() - control.read(&median)) / control.gain();
        for &(i, change) in &control.direction {
            median[i as usize] += amount * change;
        }
    }
    if let Some(i) = median.iter().position(|m| !(m.abs() <= LIMIT)) {
        return Err(Error::Blob(format!(
            "its median person has {} sigmas of coefficient {i}",
            Number(median[i].into())
        )));
    }
    let median = median.into_iter().map(crate::quantise::grid).collect();
    Ok(FaceModel {
        derived: Arc::new(Derived {
            reach: Arc::new(reach),
            whole,
            median,
            start: OnceLock::new(),
            correlation,
            cholesky: cholesky.l(),
            along: changes,
            fingerprint,
        }),
        parts: Arc::new(parts),
    })
}

/// What has been read of a model. Sections are written in the order in which they are read.
#[derive(Debug)]
pub(super) struct Reading {
    /// But for what is in the topology.
    header: Header,
    topology: Topology,
    walk: Walk,
    whole: Patch,
    mean: Vec<Vec3>,
    /// The first of the header's.
    blocks: Vec<Block>,
    /// Of these, at the model's own fall-off distance: three quarters of what there would be to do after the
    /// last bytes.
    reach: Reach,
}

impl Reading {
    /// All that comes before the blocks.
    #[inline(never)]
    fn start(blob: &Blob) -> Result<Self> {
        let mut header: Header = blob.header()?;
        let bad = |why: String| Err(Error::Blob(why));
        if header.units != "mm" {
            return bad(format!("its unit is \"{}\", not mm", header.units));
        }
        if header.vertices == 0 || header.vertices > MAX_VERTICES {
            return bad(format!("{} vertices", header.vertices));
        }
        // Twice what Euler's formula allows for so many vertices. It keeps the products of these
        // numbers within 32 bits, which is what wasm counts in, and what is derived from each
        // block's part of the mesh a small multiple of the block's own bytes.
        let most = 4 * header.vertices;
        if header.corners > most || header.triangles > most {
            return bad(format!(
                "{} texture corners and {} triangles",
                header.corners, header.triangles
            ));
        }
        if header.regions.len() > usize::from(u8::MAX) {
            return bad(format!("{} regions", header.regions.len()));
        }
        let Blending {
            alpha,
            limits: [least, most],
        } = header.blending;
        let exact = [least, alpha, most]
            .iter()
            .all(|&mm| crate::quantise::micrometres(mm) == mm);
        if !(exact && least > 0.0 && least <= alpha && alpha <= most && most <= FARTHEST_REACH) {
            let [least, alpha, most] = [least, alpha, most].map(|mm| Number(mm.into()));
            return bad(format!(
                "a blending distance of {alpha} mm in {least} to {most}"
            ));
        }
        let n = header.vertices as usize;
        let (topology, walk, around) = Topology::read(
            blob,
            n,
            header.corners as usize,
            header.triangles as usize,
            std::mem::take(&mut header.regions),
            std::mem::take(&mut header.parts),
        )?;
        let total: u64 = header.blocks.iter().map(|b| u64::from(b.modes)).sum();
        let empty = header.blocks.iter().any(|b| b.modes == 0);
        if empty || total > MAX_COEFFICIENTS as u64 || header.blocks.len() > MAX_BLOCKS {
            return bad(format!(
                "{total} coefficients in {} blocks",
                header.blocks.len()
            ));
        }
        let whole = sides(blob, &header)?[0] > 0;
        let mean = read_mean(blob, &walk, &topology.mirror, whole)?;
        Ok(Self {
            blocks: Vec::new(),
            reach: Reach::of_none(alpha),
            whole: Patch::new(&around),
            header,
            topology,
            walk,
            mean,
        })
    }

    /// The next block.
    #[inline(never)]
    fn block(&mut self, blob: &Blob) -> Result<()> {
        let bad = |why: String| Err(Error::Blob(why));
        // Whoever has modes of more blocks has more than there is to read.
        let Some(header) = self.header.blocks.get(self.blocks.len()) else {
            return bad("modes of no block".into());
        };
        let block = read_block(blob, header, self)?;
        let blocks = &mut self.blocks;
        if blocks.iter().any(|other: &Block| other.name == block.name) {
            return bad(format!("two blocks are called \"{}\"", block.name));
        }
        let local = |block: &Block| block.local_to.is_some();
        if !local(&block) && blocks.last().is_some_and(local) {
            return bad(format!("block \"{}\" follows a local one", block.name));
        }
        let edited = |region: &String| {
            let mut others = blocks.iter().filter(|other| !local(other));
            others.any(|other| other.name == *region)
        };
        if !block.local_to.as_ref().is_none_or(edited) {
            return bad(format!("block \"{}\" is local to none", block.name));
        }
        self.reach.add(&block);
        blocks.push(block);
        Ok(())
    }

    /// All that comes after the blocks; all vertices, for normals; and how far the blocks reach.
    fn finish(self, blob: &Blob) -> Result<(ModelParts, Patch, Reach)> {
        let Self {
            header,
            topology,
            mean,
            blocks,
            reach,
            whole: patch,
            ..
        } = self;
        let bad = |why: String| Err(Error::Blob(why));
        let n = mean.len();
        let people = blocks.iter().filter(|b| b.local_to.is_none());
        let correlation = read_correlation(blob, people.map(|b| b.sigmas.len()).sum())?;
        let counts = Counts {
            coefficients: blocks.iter().map(|b| b.sigmas.len()).sum(),
            measures: header.measures.len(),
        };
        let controls = read_controls(blob, header.controls, header.quantiles, counts)?;
        for landmark in &header.landmarks {
            let sum: f64 = landmark.stencil.iter().map(|s| s.1).sum();
            let sound = landmark
                .stencil
                .iter()
                .all(|s| (s.0 as usize) < n && s.1.abs() <= 2.0)
                && landmark.stencil.len() <= MAX_STENCIL;
            if !sound || !((sum - 1.0).abs() < 1e-3) {
                return bad(format!("landmark \"{}\" is not on the head", landmark.name));
            }
        }
        let landmarks = header.landmarks.len();
        let mut measures = header.measures.iter();
        if let Some(m) = measures.find(|m| !m.quantity.is_sound(landmarks)) {
            return bad(format!("measure \"{}\" has no landmarks", m.name));
        }
        let parts = ModelParts {
            about: header.about,
            mean,
            topology,
            blocks,
            controls,
            correlation,
            attributes: Vec::new(),
            landmarks: header.landmarks,
            measures: header.measures,
            blending: header.blending,
        };
        Ok((parts, patch, reach))
    }
}

/// The inverse of [`super::differences`] for vertices in order: increasing and below `n`.
pub(crate) fn vertices(blob: &Blob, name: &str, length: u32, n: usize) -> Result<Vec<u32>> {
    let mut next = 0_u32;
    let numbers: Vec<u32> = (blob.planes(name, length as usize)?.into_iter())
        .map(|step| {
            next = next.wrapping_add(step as u32);
            next
        })
        .collect();
    let increasing = numbers.windows(2).all(|w| w[0] < w[1]);
    match increasing && numbers.last().is_none_or(|&v| (v as usize) < n) {
        true => Ok(numbers),
        false => Err(Error::Blob(format!("section \"{name}\" is not in order"))),
    }
}

/// How the mean looks in the mirror, and each mode, and three numbers more.
#[inline(never)]
fn sides(blob: &Blob, header: &Header) -> Result<Vec<i32>> {
    let modes: u32 = header.blocks.iter().map(|b| b.modes).sum();
    blob.planes("sides", 4 + modes as usize)
}

fn read_mean(blob: &Blob, walk: &Walk, mirror: &[u32], whole: bool) -> Result<Vec<Vec3>> {
    let all: Vec<u32> = (0..mirror.len() as u32).collect();
    let odd = [0, -1, -1, 0]; // of x, y, z
    let walk = walk.on(&all, mirror, whole);
    let mean = walk.restore(blob.in_planes("mean", 3 * walk.count())?, 3, 1, &[odd]);
    let most = COORDINATES.index(LARGEST_COORDINATE.into()).unsigned_abs();
    let numbers = mean
        .iter()
        .flat_map(|four| four.to_array().into_iter().take(3));
    if let Some((at, x)) = numbers.enumerate().find(|(_, x)| x.unsigned_abs() > most) {
        return Err(Error::Blob(format!(
            "number {at} of section \"mean\" is {}, outside +-{}",
            Number(COORDINATES.point(x)),
            Number(LARGEST_COORDINATE.into())
        )));
    }
    let point =
        |p: &i32x4| Vec4::from(p.to_array().map(|i| COORDINATES.point(i) as f32)).truncate();
    Ok(mean.iter().map(point).collect())
}

fn read_correlation(blob: &Blob, total: usize) -> Result<Vec<f32>> {
    let below = blob.planes("correlation", total * total.saturating_sub(1) / 2)?;
    let mut correlation = vec![1.0; total * total];
    let pairs = (0..total).flat_map(|i| (0..i).map(move |j| (i, j)));
    for ((i, j), index) in pairs.zip(below) {
        let r = CORRELATIONS.point(index) as f32;
        if !(r.abs() <= 1.0) {
            return Err(Error::Blob(format!(
                "row {i} of its correlation matrix has a correlation of {}",
                Number(r.into())
            )));
        }
        correlation[i * total + j] = r;
        correlation[j * total + i] = r;
    }
    Ok(correlation)
}

fn read_block(blob: &Blob, header: &BlockHeader, before: &Reading) -> Result<Block> {
    let Reading {
        topology,
        walk,
        mean,
        blocks,
        ..
    } = before;
    let b = blocks.len();
    let first_coefficient: usize = blocks.iter().map(|b| b.sigmas.len()).sum();
    let bad = |why: String| Err(Error::Blob(format!("block \"{}\": {why}", header.name)));
    let n = mean.len();
    let mut regions = Vec::new();
    for name in &header.regions {
        match topology.region_names.iter().position(|r| r == name) {
            Some(region) => regions.push(region as u8),
            None => return bad(format!("no region is called \"{name}\"")),
        }
    }
    if header.local_to.is_some() && header.surround.is_some() {
        return bad("it is local and has a surround".into());
    }
    let support: Vec<u32> = match header.surround.is_some() || header.local_to.is_some() {
        true => vertices(blob, &format!("support.{b}"), header.support, n)?,
        false => (0..n as u32).collect(),
    };
    if support.is_empty() || support.len() != header.support as usize {
        return bad(format!("a support of {} vertices", header.support));
    }
    let modes = header.modes as usize;
    let all = sides(blob, &before.header)?;
    let own = &all[1 + first_coefficient..];
    let whole = own[..modes].iter().any(|&side| side > 0);
    // In fours, of which the last may have what is another block's: there it has no mode.
    let odd = &own.as_chunks().0[..fours(modes)];
    let walk_on = walk.on(&support, &topology.mirror, whole);
    let residuals = blob.in_planes(&format!("modes.{b}"), 3 * walk_on.count() * modes)?;
    let rows = walk_on.restore(residuals, modes, 3, odd);
    let (modes, fit) = Modes::of_rows(sound_step(header.step)?, modes, &rows);
    if !fit {
        return bad("a mode of more steps than 16 bits hold".into());
    }
    // Many more bytes than all that is left.
    drop(rows);
    let sigmas = blob.floats(&format!("sigmas.{b}"), modes.count(), 1e9)?;
    let surround = match header.surround {
        None => None,
        Some(SurroundHeader { targets, rigid }) => {
            let targets = vertices(blob, &format!("targets.{b}"), targets, n)?;
            let distances = blob.in_planes(&format!("distances.{b}"), targets.len())?;
            let distances: Vec<f32> = (walk.on(&targets, &topology.mirror, true))
                .restore(distances, 1, 1, &[])
                .iter()
                .map(|d| DISTANCES.point(d.to_array()[0]) as f32)
                .collect();
            if distances.iter().any(|&d| d > LARGEST_COORDINATE) {
                return bad("a distance beyond all heads".into());
            }
            let rigid = read_rigid(blob, &format!("rigid.{b}"), rigid)?;
            match Surround::new(mean, topology, &support, targets, distances, rigid) {
                Ok(surround) => Some(surround),
                Err(why) => return bad(why.to_string()),
            }
        }
    };
    Ok(Block {
        modes,
        name: header.name.clone(),
        regions,
        support,
        sigmas,
        first_coefficient,
        surround,
        local_to: header.local_to.clone(),
    })
}

fn read_rigid(blob: &Blob, name: &str, count: u32) -> Result<Vec<Rigid>> {
    let numbers = blob.planes(name, (1 + 2 * SOURCES).saturating_mul(count as usize))?;
    let rigid = numbers.chunks_exact(1 + 2 * SOURCES).map(|row| Rigid {
        part: row[0] as u32,
        sources: std::array::from_fn(|i| row[1 + i] as u32),
        weights: std::array::from_fn(|i| row[1 + SOURCES + i] as u16),
    });
    Ok(rigid.collect())
}

/// The attributes, if there are any, and the fingerprint of the model as it was first written, without them: they
/// and the words on controls change no face, so that a face's code stays good when these are learned or said anew.
fn read_attributes(blob: &Blob, population: usize) -> Result<Option<(u32, Vec<Attribute>)>> {
    let Some((fingerprint, words)) = blob.record::<(u32, Vec<String>)>("attributes")? else {
        return Ok(None);
    };
    let each = 4 + population;
    let numbers = blob.floats("read-outs", words.len() / 3 * each, 1e6)?;
    let mut attributes: Vec<Attribute> = Vec::new();
    for (words, numbers) in words.chunks_exact(3).zip(numbers.chunks_exact(each)) {
        let attribute = Attribute {
            name: words[0].clone(),
            description: words[1].clone(),
            unit: words[2].clone(),
            limits: [numbers[0], numbers[1]],
            mean: numbers[2],
            explained: numbers[3],
            reading: numbers[4..].to_vec(),
        };
        let twice = attributes.iter().any(|a| a.name == attribute.name);
        let is_one_more = !twice && attributes.len() < MAX_ATTRIBUTES;
        let is_part = (0.0..=1.0).contains(&attribute.explained);
        if !is_one_more || !is_part || numbers[0] >= numbers[1] {
            return Err(unsound(&attribute));
        }
        attributes.push(attribute);
    }
    Ok(Some((fingerprint, attributes)))
}

fn unsound(attribute: &Attribute) -> Error {
    let name = &attribute.name;
    Error::Blob(format!("attribute \"{name}\" is not sound"))
}

/// How many there are of what controls name by number.
struct Counts {
    coefficients: usize,
    measures: usize,
}

fn read_controls(
    blob: &Blob,
    headers: Vec<ControlHeader>,
    quantiles: u32,
    counts: Counts,
) -> Result<Vec<Control>> {
    let q = quantiles as usize;
    if !(2..=4096).contains(&q) || headers.len() > 4096 {
        return Err(Error::Blob(format!(
            "{} controls of {q} quantiles",
            headers.len()
        )));
    }
    let table = blob.floats("quantiles", headers.len() * (2 + q), 1e6)?;
    let mut controls: Vec<Control> = Vec::with_capacity(headers.len());
    for (header, row) in headers.into_iter().zip(table.chunks_exact(2 + q)) {
        let (limits, quantiles) = row.split_first_chunk().unwrap_or((&[0.0; 2], row));
        let control = Control {
            name: header.name,
            group: header.group,
            description: header.description,
            direction: header.direction,
            reading: header.reading,
            measure: header.measure,
            quantiles: quantiles.to_vec(),
            limits: *limits,
        };
        let bad = |why: &str| Err(Error::Blob(format!("control \"{}\": {why}", control.name)));
        let terms = || control.direction.iter().chain(&control.reading);
        let in_order = |terms: &[(u32, f32)]| terms.windows(2).all(|w| w[0].0 < w[1].0);
        if terms().any(|t| t.0 as usize >= counts.coefficients || !(t.1.abs() <= 1e6))
            || !in_order(&control.direction)
            || !in_order(&control.reading)
        {
            return bad("its coefficients are unknown, or not in order");
        }
        let [least, most] = control.limits;
        let limited = 0.0 <= least && least < most && most <= 1.0;
        if !limited || quantiles.windows(2).any(|w| w[0] >= w[1]) {
            return bad("its quantiles or limits do not increase");
        }
        if controls.iter().any(|c| c.name == control.name) {
            return bad("there are two of that name");
        }
        match control.measure {
            None if !(control.gain().abs() >= 1e-6) => {
                return bad("it does not move its own read-out");
            }
            Some(m) if m as usize >= counts.measures => return bad("its measure is not there"),
            Some(_) if !control.reading.is_empty() || control.direction.is_empty() => {
                return bad("it measures and reads coefficients, or moves none");
            }
            _ => {}
        }
        controls.push(control);
    }
    Ok(controls)
}
