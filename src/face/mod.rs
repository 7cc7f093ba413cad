//! A face: a model and coefficients; everything else of it is computed.

mod anchor;
pub(crate) mod code;
mod evaluate;
mod measured;
mod probable;

use std::ops::Range;
use std::sync::Arc;

use glam::Vec3;

use crate::Random;
use crate::error::range;
use crate::model::{Block, FaceModel, LIMIT, Reach, Surround};
use crate::quantise::{PER_SIGMA, coarse, grid, micrometres, sigmas};
use crate::{Error, Result};
use anchor::{Anchor, Regions};

/// Far beyond any face; every point of the grid up to here is an f32.
pub(crate) const FARTHEST: f32 = 255.0;

/// A face of a model.
///
/// vertices = mean + sum over blocks of (modes x coefficients), each block spread to its surround,
/// and where regions were locked, what those took back of it ([`Face::lock`]). Positions and normals
/// are brought up to date by every call that changes the face. They depend only on what the
/// [`Face::code`] holds, never on the way that led to it: all sums are exact.
#[derive(Debug, Clone)]
pub struct Face {
    model: FaceModel,
    /// Coefficients in units of 1/65536 sigma.
    state: Vec<i32>,
    /// Those that positions and normals are of.
    shown: Vec<i32>,
    locked: Vec<bool>,
    /// Measures that are held, and the length of each, mm.
    held: Vec<(usize, f64)>,
    /// What locked regions took back, by the regions.
    anchors: Vec<Anchor>,
    /// How far each vertex stays while some regions are locked.
    masks: Vec<(Regions, Arc<[f32]>)>,
    reach: Arc<Reach>,
    /// Positions as they are summed, mm; see [`crate::kernel`]. Empty until a change is added to them:
    /// a face that is only drawn, one of a crowd, takes half of the memory.
    sums: Vec<[f64; 3]>,
    /// One more than there are vertices, as of normals; see [`crate::kernel::Patch::normals`].
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    changed: Range<u32>,
    /// Which computation they are of; faces that share one are alike.
    revision: u64,
}

/// What [`Face::randomize`] may be told.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Randomize {
    /// The same seed gives the same face; without one, the system's randomness is asked.
    pub seed: Option<u64>,
    /// How unusual: 1 (the default) samples the population, 0 gives its mean.
    pub spread: Option<f64>,
    /// The regions to change; all when absent.
    pub regions: Option<Vec<String>>,
    /// What attributes of the face shall read, by their names; all others are left to chance.
    pub attributes: Vec<(String, f64)>,
}

impl FaceModel {
    /// A face: the median person of the population.
    pub fn face(&self) -> Face {
        Face::new(self)
    }

    /// The face of a code that [`Face::code`] made.
    ///
    /// # Errors
    /// [`Error::Code`] when the code is damaged or of another model.
    pub fn from_code(&self, code: &str) -> Result<Face> {
        let mut face = self.face();
        face.set_code(code)?;
        Ok(face)
    }
}

impl Face {
    fn new(model: &FaceModel) -> Self {
        let parts = model.parts();
        let padded = parts.mean.len() + 1;
        let mut face = Self {
            state: model.derived.median.clone(),
            shown: Vec::new(),
            locked: vec![false; parts.blocks.len()],
            held: Vec::new(),
            anchors: Vec::new(),
            masks: Vec::new(),
            reach: model.derived.reach.clone(),
            sums: Vec::new(),
            positions: vec![Vec3::ZERO; padded],
            normals: vec![Vec3::ZERO; padded],
            changed: 0..0,
            revision: 0,
            model: model.clone(),
        };
        // The first is computed, others are copies.
        let [positions, normals] = model.derived.start.get_or_init(|| {
            face.evaluate_all();
            [face.positions.clone(), face.normals.clone()]
        });
        face.positions.clone_from(positions);
        face.normals.clone_from(normals);
        face.changed = face.all();
        face.is_shown();
        face
    }

    /// The model that the face belongs to.
    pub fn model(&self) -> &FaceModel {
        &self.model
    }

    /// Vertex positions, mm.
    pub fn positions(&self) -> &[Vec3] {
        &self.positions[..self.positions.len() - 1]
    }

    /// Unit vertex normals, each triangle counting by its area; empty while none are kept
    /// ([`Face::keep_normals`]).
    pub fn normals(&self) -> &[Vec3] {
        &self.normals[..self.normals.len().saturating_sub(1)]
    }

    /// Whether normals are kept up to date from now on: whoever wants only positions, or shows the face
    /// with an expression on it, need not wait for them.
    pub fn keep_normals(&mut self, kept: bool) {
        if kept != self.normals.is_empty() {
            return;
        }
        self.normals = vec![Vec3::ZERO; if kept { self.positions.len() } else { 0 }];
        let whole = &self.model.derived.whole;
        whole.normals(&self.positions, &mut self.normals);
    }

    /// The smallest range of vertices outside of which the last change touched neither position
    /// nor normal.
    pub fn changed(&self) -> Range<u32> {
        self.changed.clone()
    }

    /// A number that another face, or this one after a change, does not have: two that have it are of
    /// the same positions and normals.
    pub(crate) fn revision(&self) -> u64 {
        self.revision
    }

    /// The coefficients in sigmas, block after block.
    pub fn coefficients(&self) -> Vec<f32> {
        self.state.iter().map(|&c| sigmas(c)).collect()
    }

    /// Replaces all coefficients (sigmas), those of locked regions, too. Limits do not apply. It is a change like any
    /// other: what the coefficients of other regions would move in a locked one is taken back, what earlier locks took
    /// back stays so ([`Face::reset`] lets it go), and held measures are held.
    ///
    /// # Errors
    /// When their number is wrong, one is not a number or beyond 255 sigmas, or a held measure cannot be held; the face
    /// then stays as it was.
    pub fn set_coefficients(&mut self, coefficients: &[f32]) -> Result<()> {
        if coefficients.len() != self.state.len() {
            return Err(Error::Mismatch(format!(
                "{} coefficients were given, the model has {}",
                coefficients.len(),
                self.state.len()
            )));
        }
        let before = self.before();
        self.change(coefficients)?;
        self.hold_without(&[], before)
    }

    /// Where the face stands on a control: the part of the population below it, 0..=1.
    ///
    /// # Errors
    /// When no control has that name.
    pub fn get(&self, control: &str) -> Result<f64> {
        let control = self.model.control(control)?;
        let reading = match control.measure {
            Some(measure) => self.measured(measure as usize) as f32,
            None => control.read(&self.coefficients()),
        };
        Ok(f64::from(control.percentile(reading)))
    }

    /// Where the face stands on an attribute, in its unit. Edits by semantic controls do not count,
    /// nor does what locks took back.
    ///
    /// # Errors
    /// When no attribute has that name.
    pub fn attribute(&self, name: &str) -> Result<f64> {
        let attribute = self.model.attribute(name)?;
        Ok(self.model.parts().attributes[attribute].read(&self.sigmas()))
    }

    /// Makes attributes read values, in their units, by the most probable change of the coefficients that
    /// are not locked: the face stays as like itself as it can. All other attributes read what they did.
    /// Each coefficient stays within 3 sigmas, or where it was, if farther out: what no person of the
    /// population is like is approached, not met. Where regions are locked, the others go their own part of
    /// the way. Held measures are held.
    ///
    /// Shares of one whole depend on each other: whoever asks for one asks for all of them.
    ///
    /// # Errors
    /// When no attribute has a name, a value is outside of the attribute's limits, or a held measure
    /// cannot be held; the face then stays as it was.
    pub fn set_attributes(&mut self, asked: &[(String, f64)]) -> Result<()> {
        let model = self.model.clone();
        let present = self.sigmas();
        for (name, value) in asked {
            model.asked(name, *value)?;
        }
        let wanted: Vec<(usize, f64)> = (model.parts().attributes.iter().enumerate())
            .map(|(i, attribute)| {
                let named = asked.iter().find(|(name, _)| *name == attribute.name);
                let value = named.map_or_else(|| attribute.read(&present), |&(_, value)| value);
                (i, value)
            })
            .collect();
        let free = self.free(None)?;
        let mut steered = present;
        model.steer(&mut steered, &free, &wanted);
        let before = self.before();
        let mut coefficients = self.coefficients();
        for &i in &free {
            coefficients[i] = steered[i] as f32;
        }
        self.change(&coefficients)?;
        self.hold(&[free], before)
    }

    /// Moves a control to a percentile, 0..=1.
    ///
    /// # Errors
    /// When no control has that name, the value is outside 0..=1, or the control's measure or one
    /// that is held cannot be had; the face then stays as it was.
    pub fn set(&mut self, control: &str, value: f64) -> Result<()> {
        let model = self.model.clone();
        let control = model.control(control)?;
        let wanted = control.quantile(value)?;
        if let Some(measure) = control.measure {
            return self.set_along(control, measure as usize, f64::from(wanted));
        }
        // A copy for nothing would be felt: this is what a slider does.
        let before = (!self.held.is_empty()).then(|| self.before());
        let mut coefficients = self.coefficients();
        let amount = (wanted - control.read(&coefficients)) / control.gain();
        for &(i, change) in &control.direction {
            coefficients[i as usize] += amount * change;
        }
        self.change(&coefficients)?;
        before.map_or(Ok(()), |before| self.hold_beside(control, before))
    }

    /// Puts a region, or everything, back to the median person: everything with the model's fall-off distance of
    /// blending, unless something is locked or held. Locked regions stay, and what is held is held.
    ///
    /// # Errors
    /// When no region has that name, or a held measure cannot be held.
    pub fn reset(&mut self, region: Option<&str>) -> Result<()> {
        let mut state = self.state.clone();
        let only = region.map(|name| self.model.region(name)).transpose()?;
        for (b, block) in self.model.parts().blocks.iter().enumerate() {
            if only.as_ref().is_none_or(|only| only[b]) && !self.locked[b] {
                let own = block.coefficients();
                state[own.clone()].copy_from_slice(&self.model.derived.median[own]);
            }
        }
        let before = self.before();
        let regions = region.map(|name| [name.to_owned()]);
        let gone = self.let_go(regions.as_ref().map(|r| &r[..]))?;
        self.replace(state);
        self.hold(&[self.free(None)?], before)?;
        self.note(gone);
        match region {
            None => self.spread(self.model.derived.reach.alpha),
            Some(_) => Ok(()),
        }
    }

    /// Moves the face, or the named regions of it, towards `other`: 0 leaves it, 1 takes it over. All of a face moves
    /// with its fall-off distance of blending, unless something is locked or held here; regions have none.
    /// Locked regions stay, and what is held is held.
    ///
    /// # Errors
    /// When the faces are of two models, a region is unknown, `t` is not in 0..=1, or a held measure
    /// cannot be held.
    pub fn blend(&mut self, other: &Face, t: f64, regions: Option<&[String]>) -> Result<()> {
        // A file says its fingerprint itself.
        let [ours, theirs] = [self.model.parts(), other.model.parts()];
        let [own, its] = [ours, theirs].map(|parts| parts.blocks.iter().map(Block::coefficients));
        if other.model.derived.fingerprint != self.model.derived.fingerprint
            || ours.blending != theirs.blending
            || !own.eq(its)
        {
            return Err(Error::Mismatch(
                "faces of two models cannot be blended".into(),
            ));
        }
        if !(0.0..=1.0).contains(&t) {
            return Err(Error::Value {
                what: "the amount of a blend",
                wanted: "from 0 to 1".into(),
                got: t,
            });
        }
        let (free, edits) = (self.free(regions)?, self.edits(regions)?);
        let before = self.before();
        let mut state = self.state.clone();
        for &i in free.iter().chain(&edits) {
            let (from, to) = (f64::from(self.state[i]), f64::from(other.state[i]));
            state[i] = match t {
                0.0 => self.state[i],
                1.0 => other.state[i],
                _ => coarse(from + (to - from) * t),
            };
        }
        self.replace(state);
        let whole = regions.is_none() && !self.locked.contains(&true);
        let anchored = whole && !(self.anchors.is_empty() && other.anchors.is_empty());
        if anchored {
            self.blend_anchors(other, t);
        }
        self.hold(&[free, self.free(None)?], before)?;
        self.note(anchored);
        let [from, to] = [self.alpha(), other.alpha()].map(f64::from);
        match regions {
            None if t == 1.0 => self.spread(other.alpha()),
            None => self.spread((from + t * (to - from)) as f32),
            Some(_) => Ok(()),
        }
    }

    /// Takes a fall-off distance (mm) with all of a face; what is locked or held would move with it.
    fn spread(&mut self, alpha: f32) -> Result<()> {
        let stays = self.locked.contains(&true) || !self.held.is_empty();
        match stays || alpha == self.alpha() {
            true => Ok(()),
            false => self.set_alpha(alpha),
        }
    }

    /// Draws a face from the population and returns the seed that was used.
    ///
    /// The coefficients are drawn from the joint normal distribution with the population's
    /// correlations, *given* those of locked regions and of regions that are not named: the rest
    /// fits what is kept. Each coefficient stays within 3 sigmas. Edits by semantic controls are
    /// undone in what is drawn. Held measures are held as the population would have it: to first
    /// order the draw is then also given their lengths (Matheron's rule).
    ///
    /// # Errors
    /// When a region is unknown, the spread is not in 0..=3, the system has no randomness, or a held
    /// measure cannot be held.
    pub fn randomize(&mut self, options: &Randomize) -> Result<u64> {
        let spread = options.spread.unwrap_or(1.0);
        if !(0.0..=3.0).contains(&spread) {
            return Err(Error::Value {
                what: "the spread",
                wanted: "from 0 to 3".into(),
                got: spread,
            });
        }
        let free = self.free(options.regions.as_deref())?;
        let model = self.model.clone();
        let mut asked: Vec<(usize, f64)> = Vec::new();
        for (name, value) in &options.attributes {
            asked.push((model.asked(name, *value)?, *value));
        }
        let seed = match options.seed {
            Some(seed) => seed,
            // 53 bits, so that the seed survives as a JavaScript number.
            None => {
                let nothing =
                    |_| Error::Mismatch("nothing random is to be had: give a seed".into());
                getrandom::u64().map_err(nothing)? >> 11
            }
        };
        let before = self.before();
        let mut random = Random::new(seed);
        let drawn: Vec<f64> = (0..self.model.parts().population())
            .map(|_| random.normal() * spread)
            .collect();
        let gone = self.let_go(options.regions.as_deref())?;
        let mut drawn = model.conditional_sample(&drawn, &self.sigmas(), &free);
        free.iter()
            .for_each(|&i| drawn[i] = probable::within(drawn[i]));
        model.steer(&mut drawn, &free, &asked);
        let mut coefficients = self.coefficients();
        for &i in &free {
            coefficients[i] = drawn[i] as f32;
        }
        for i in self.edits(options.regions.as_deref())? {
            coefficients[i] = 0.0;
        }
        self.change(&coefficients)?;
        self.hold(&[free, self.free(None)?], before)?;
        self.note(gone);
        Ok(seed)
    }

    /// Moves a vertex to `target` (mm) by the most probable change of the coefficients that are
    /// not locked. Each coefficient stays within 3 sigmas (or where it was, if farther out), so a
    /// target that no person of the population reaches is approached, not met. So is one that asks
    /// for other held measures.
    ///
    /// # Errors
    /// When there is no such vertex, the target is not finite, or a held measure cannot be held.
    pub fn drag(&mut self, vertex: u32, target: Vec3) -> Result<()> {
        let Some(&position) = self.positions().get(vertex as usize) else {
            return Err(Error::Unknown {
                kind: "vertex",
                name: vertex.to_string(),
            });
        };
        if !target.is_finite() {
            return Err(Error::Value {
                what: "a target",
                wanted: "finite".into(),
                got: f64::from(target.element_sum()),
            });
        }
        let free = self.free(None)?;
        let change = self.model.probable_change(
            &self.jacobian(vertex),
            (target - position).as_dvec3(),
            &free,
        );
        let before = self.before();
        let mut coefficients = self.coefficients();
        for (&i, change) in free.iter().zip(change) {
            let limit = LIMIT.max(coefficients[i].abs());
            // Not `clamp`, which prints its limits when they cross: these never do, and printing
            // floats is a twentieth of the module.
            coefficients[i] = (coefficients[i] + change as f32).max(-limit).min(limit);
        }
        self.change(&coefficients)?;
        self.hold(&[free], before)
    }

    /// Keeps a region where and as it is, until it is unlocked. [`Face::randomize`],
    /// [`Face::blend`], [`Face::drag`] and [`Face::reset`] leave its coefficients alone, and what
    /// other coefficients change there is taken back, around it less and less: its vertices stay
    /// within 0.0001 mm. Its own sliders still move it. Unlocking moves nothing; what was taken back
    /// goes when the region is reset or drawn again.
    ///
    /// # Errors
    /// When no region has that name.
    pub fn lock(&mut self, region: &str) -> Result<()> {
        self.set_lock(region, true)
    }

    /// Undoes [`Face::lock`].
    ///
    /// # Errors
    /// When no region has that name.
    pub fn unlock(&mut self, region: &str) -> Result<()> {
        self.set_lock(region, false)
    }

    fn set_lock(&mut self, region: &str, locked: bool) -> Result<()> {
        let own = self.model.region(region)?;
        let all = self.locked.iter_mut().zip(own);
        all.filter(|(_, own)| *own).for_each(|(l, _)| *l = locked);
        self.mask();
        Ok(())
    }

    /// The names of the locked regions.
    pub fn locked(&self) -> impl Iterator<Item = &str> {
        let blocks = &self.model.parts().blocks;
        blocks
            .iter()
            .zip(&self.locked)
            .filter(|b| *b.1 && b.0.local_to.is_none())
            .map(|b| b.0.name.as_str())
    }

    /// The fall-off distance of blending, mm.
    pub fn alpha(&self) -> f32 {
        self.reach.alpha
    }

    /// Sets the fall-off distance of blending (region morphing, eq. 12), mm.
    ///
    /// # Errors
    /// When it is outside the model's limits.
    pub fn set_alpha(&mut self, alpha: f32) -> Result<()> {
        let [least, most] = self.model.parts().blending.limits;
        if !(least..=most).contains(&alpha) {
            return Err(Error::Value {
                what: "the blending distance",
                wanted: range([least.into(), most.into()], " mm"),
                got: f64::from(alpha),
            });
        }
        let alpha = micrometres(alpha);
        let own = &self.model.derived.reach;
        self.reach = match alpha == own.alpha {
            true => own.clone(),
            false => {
                let blocks = self.model.parts().blocks.iter();
                (blocks.flat_map(|b| &b.surround)).for_each(Surround::keep);
                Arc::new(Reach::new(self.model.parts(), alpha))
            }
        };
        self.evaluate_all();
        Ok(())
    }

    /// The coefficients that a change of the person may touch: those of the named regions (all,
    /// when absent) that are not locked, but for edits.
    fn free(&self, regions: Option<&[String]>) -> Result<Vec<usize>> {
        self.unlocked(regions, false)
    }

    /// The edits that are in the named regions (all, when absent) that are not locked: the
    /// coefficients of local blocks.
    fn edits(&self, regions: Option<&[String]>) -> Result<Vec<usize>> {
        self.unlocked(regions, true)
    }

    fn unlocked(&self, regions: Option<&[String]>, local: bool) -> Result<Vec<usize>> {
        let blocks = &self.model.parts().blocks;
        let mut named = vec![regions.is_none(); blocks.len()];
        for region in regions.unwrap_or_default() {
            let own = self.model.region(region)?;
            named.iter_mut().zip(own).for_each(|(n, own)| *n |= own);
        }
        Ok((0..blocks.len())
            .filter(|&b| named[b] && !self.locked[b] && blocks[b].local_to.is_some() == local)
            .flat_map(|b| blocks[b].coefficients())
            .collect())
    }

    #[cfg(feature = "bench")]
    pub(crate) fn state(&self) -> &[i32] {
        &self.state
    }

    fn sigmas(&self) -> Vec<f64> {
        self.state
            .iter()
            .map(|&c| f64::from(c) / PER_SIGMA)
            .collect()
    }

    fn change(&mut self, coefficients: &[f32]) -> Result<()> {
        let mut state = on_grid(coefficients)?;
        // What was found on a finer grid, and is meant to stay, stays as it is.
        for ((new, &old), &c) in state.iter_mut().zip(&self.state).zip(coefficients) {
            if sigmas(old) == c {
                *new = old;
            }
        }
        self.replace(state);
        Ok(())
    }

    /// Takes a new state, but for what locked regions take back of it, and computes the blocks in
    /// which it differs.
    fn replace(&mut self, state: Vec<i32>) {
        self.take_back(&state);
        self.adopt(state);
        self.tidy();
    }

    /// Takes a new state and computes the blocks in which it differs.
    fn adopt(&mut self, state: Vec<i32>) {
        self.state = state;
        self.evaluate();
    }

    /// After a call whose last step is not all that it did.
    fn note(&mut self, everything: bool) {
        if everything {
            self.changed = self.all();
        }
    }
}

/// The grid points nearest to coefficients in sigmas.
fn on_grid(coefficients: &[f32]) -> Result<Vec<i32>> {
    if let Some(&far) = coefficients.iter().find(|c| !(c.abs() <= FARTHEST)) {
        return Err(Error::Value {
            what: "a coefficient",
            wanted: "within 255 sigmas".into(),
            got: f64::from(far),
        });
    }
    Ok(coefficients.iter().map(|&c| grid(c)).collect())
}
