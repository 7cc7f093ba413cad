//! The bindings: the core's [`crate::FaceModel`] and [`crate::Face`] for JavaScript.
//!
//! They are thin and mirror the core name for name; the package's `index.js` makes them pleasant
//! (views on memory, option objects). Metadata crosses as plain objects ([`info`]), vertices never
//! do: JavaScript looks at them in wasm memory by address. Errors become `Error` objects; nothing
//! panics.

mod info;

/// Less than half of the code of Rust's own for wasm, and as fast.
#[global_allocator]
static ALLOCATOR: rlsf::SmallGlobalTlsf = rlsf::SmallGlobalTlsf::new();

use std::arch::wasm32::memory_size;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::Vec3;
use wasm_bindgen::prelude::*;

use crate::{Performance, Randomize};

#[cold]
fn error(why: crate::Error) -> JsError {
    JsError::new(&why.to_string())
}

/// Where a face has made memory grow, it grows by a part of what it is: there are more to come. Whenever it
/// grows, V8 looks through all of a program's objects, for it takes all of memory for new: that would take longer
/// than a face.
fn leave_room() {
    /// Of memory, as of what room there is when it grows.
    const PART: usize = 8;
    const PAGE: usize = 65_536;
    static SEEN: AtomicUsize = AtomicUsize::new(0);
    if memory_size::<0>() > SEEN.load(Ordering::Relaxed) {
        let mut room: Vec<u8> = Vec::new();
        // Where there is none left, nothing is lost.
        let _ = room.try_reserve_exact(memory_size::<0>() * (PAGE / PART));
        drop(std::hint::black_box(room));
        SEEN.store(memory_size::<0>(), Ordering::Relaxed);
    }
}

/// Names and a value for each.
fn named(names: Vec<String>, values: &[f32]) -> Vec<(String, f64)> {
    let values = values.iter().map(|&value| value.into());
    names.into_iter().zip(values).collect()
}

/// A face model.
#[wasm_bindgen]
pub struct FaceModel {
    model: crate::FaceModel,
    /// The blob, where it is kept.
    blob: Vec<u8>,
}

/// A model blob whose bytes come in one after the other.
#[wasm_bindgen]
#[derive(Default)]
pub struct IncomingModel(crate::IncomingModel);

#[wasm_bindgen]
impl IncomingModel {
    /// Of which nothing is there yet.
    #[wasm_bindgen(constructor)]
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes the next bytes.
    pub fn push(&mut self, bytes: Vec<u8>) {
        self.0.push(bytes);
    }

    /// The model, once all bytes are there; it keeps them if that is wanted.
    pub fn finish(&mut self, keep: bool) -> Result<FaceModel, JsError> {
        let (model, bytes) = self.0.finish().map_err(error)?;
        let blob = if keep { bytes } else { Vec::new() };
        Ok(FaceModel { model, blob })
    }
}

#[wasm_bindgen]
impl FaceModel {
    /// The blob that was kept, a copy.
    pub fn blob(&self) -> Vec<u8> {
        self.blob.clone()
    }

    /// Names, units and provenance, as a plain object.
    pub fn info(&self) -> JsValue {
        info::info(&self.model)
    }

    /// The median person.
    pub fn face(&self) -> Face {
        self.model.face().into()
    }

    /// The face of a code.
    // JavaScript calls it on a model, as the core does.
    #[expect(clippy::wrong_self_convention)]
    pub fn from_code(&self, code: &str) -> Result<Face, JsError> {
        Ok(self.model.from_code(code).map_err(error)?.into())
    }

    /// How many vertices a face has.
    pub fn vertex_count(&self) -> usize {
        self.model.parts().mean.len()
    }

    /// Triangles as texture corners, part by part.
    pub fn uv_triangles(&self) -> Vec<u32> {
        bytemuck::cast_slice(&self.model.parts().topology.uv_triangles).to_vec()
    }

    /// Texture coordinates, two a corner.
    pub fn uvs(&self) -> Vec<f32> {
        bytemuck::cast_slice(&self.model.parts().topology.uvs).to_vec()
    }

    /// The vertex of each corner.
    pub fn uv_vertices(&self) -> Vec<u32> {
        self.model.parts().topology.uv_vertices.clone()
    }

    /// sRGB colours, three bytes a vertex.
    pub fn colours(&self) -> Vec<u8> {
        self.model.parts().topology.colours.as_flattened().to_vec()
    }

    /// The region of each vertex, an index into `info().regionNames`.
    pub fn region_of(&self) -> Vec<u8> {
        self.model.parts().topology.regions.clone()
    }

    /// The vertex on the other side of the head.
    pub fn mirror(&self) -> Vec<u32> {
        self.model.parts().topology.mirror.clone()
    }
}

/// The expressions of a model.
#[wasm_bindgen]
pub struct Expressions {
    expressions: crate::Expressions,
}

#[wasm_bindgen]
impl Expressions {
    /// Reads a blob of expressions for a model.
    pub fn parse(bytes: &[u8], model: &FaceModel) -> Result<Expressions, JsError> {
        let expressions = crate::Expressions::parse(bytes, &model.model).map_err(error)?;
        Ok(Self { expressions })
    }

    /// Their names, in the order of weights.
    pub fn names(&self) -> Vec<String> {
        let list = self.expressions.list().iter();
        list.map(|e| e.name.clone()).collect()
    }
}

/// A face.
#[wasm_bindgen]
pub struct Face {
    face: crate::Face,
    /// The expressions on it, once there have been any.
    performance: Option<Performance>,
}

impl From<crate::Face> for Face {
    fn from(face: crate::Face) -> Self {
        leave_room();
        Self {
            face,
            performance: None,
        }
    }
}

impl Face {
    /// The face with its expressions, up to date; none when there never were any.
    fn performed(&mut self) -> Result<Option<&Performance>, JsError> {
        if let Some(performance) = &mut self.performance {
            self.face.keep_normals(performance.is_at_rest());
            performance.perform(&self.face).map_err(error)?;
        }
        Ok(self.performance.as_ref())
    }

    /// What the last change touched; of a face that has had expressions, in what is different from
    /// what was shown before.
    fn changed(&mut self) -> Result<Range<u32>, JsError> {
        let shown = self.performed()?.map(Performance::changed);
        Ok(shown.unwrap_or(self.face.changed()))
    }
}

#[wasm_bindgen]
impl Face {
    /// Moves a control to a percentile, 0..=1.
    pub fn set(&mut self, control: &str, value: f64) -> Result<(), JsError> {
        self.face.set(control, value).map_err(error)
    }

    /// Where the face stands on a control, 0..=1.
    pub fn get(&self, control: &str) -> Result<f64, JsError> {
        self.face.get(control).map_err(error)
    }

    /// Back to the median person, wholly or in one region.
    pub fn reset(&mut self, region: Option<String>) -> Result<(), JsError> {
        self.face.reset(region.as_deref()).map_err(error)
    }

    /// Moves towards another face of the same model, wholly or in the named regions.
    pub fn blend(
        &mut self,
        other: &Face,
        t: f64,
        regions: Option<Vec<String>>,
    ) -> Result<(), JsError> {
        self.face
            .blend(&other.face, t, regions.as_deref())
            .map_err(error)
    }

    /// Where the face stands on an attribute, in its unit.
    pub fn attribute(&self, name: &str) -> Result<f64, JsError> {
        self.face.attribute(name).map_err(error)
    }

    /// Makes attributes read values by the most probable change of the face.
    pub fn set_attributes(&mut self, names: Vec<String>, values: &[f32]) -> Result<(), JsError> {
        (self.face.set_attributes(&named(names, values))).map_err(error)
    }

    /// Draws from the population, given some attributes and a value for each, and gives the seed.
    pub fn randomize(
        &mut self,
        seed: Option<f64>,
        spread: Option<f64>,
        regions: Option<Vec<String>>,
        attributes: Vec<String>,
        values: &[f32],
    ) -> Result<f64, JsError> {
        // Larger integers are not all numbers of JavaScript.
        let whole = |s: &f64| *s >= 0.0 && *s < 9_007_199_254_740_992.0 && s.trunc() == *s;
        if seed.is_some_and(|s| !whole(&s)) {
            return Err(JsError::new("a seed is a whole number from 0 to 2^53 - 1"));
        }
        let options = Randomize {
            seed: seed.map(|s| s as u64),
            spread,
            regions,
            attributes: named(attributes, values),
        };
        let seed = self.face.randomize(&options).map_err(error)?;
        Ok(seed as f64)
    }

    /// Keeps a region from being randomised, blended, dragged or reset.
    pub fn lock(&mut self, region: &str) -> Result<(), JsError> {
        self.face.lock(region).map_err(error)
    }

    /// Undoes `lock`.
    pub fn unlock(&mut self, region: &str) -> Result<(), JsError> {
        self.face.unlock(region).map_err(error)
    }

    /// The locked regions.
    pub fn locked(&self) -> Vec<String> {
        self.face.locked().map(str::to_owned).collect()
    }

    /// A measure, mm.
    pub fn measure(&self, name: &str) -> Result<f64, JsError> {
        self.face.measure(name).map_err(error)
    }

    /// Gives a measure a length, mm.
    pub fn set_measure(&mut self, name: &str, mm: f64) -> Result<(), JsError> {
        self.face.set_measure(name, mm).map_err(error)
    }

    /// Undoes what a control did.
    pub fn clear(&mut self, control: &str) -> Result<(), JsError> {
        self.face.clear(control).map_err(error)
    }

    /// Holds a measure where it is.
    pub fn lock_measure(&mut self, name: &str) -> Result<(), JsError> {
        self.face.lock_measure(name).map_err(error)
    }

    /// Undoes `lock_measure`.
    pub fn unlock_measure(&mut self, name: &str) -> Result<(), JsError> {
        self.face.unlock_measure(name).map_err(error)
    }

    /// The measures that are held.
    pub fn locked_measures(&self) -> Vec<String> {
        self.face.locked_measures().map(str::to_owned).collect()
    }

    /// Moves a vertex to a place (mm) by the most probable change.
    pub fn drag(&mut self, vertex: u32, x: f32, y: f32, z: f32) -> Result<(), JsError> {
        let mut target = Vec3::new(x, y, z);
        // A face is dragged by what is seen of it; what moves is the face at rest.
        let rest = self.face.positions().get(vertex as usize).copied();
        if let (Some(shown), Some(rest)) = (self.performed()?, rest) {
            target += rest - shown.positions()[vertex as usize];
        }
        self.face.drag(vertex, target).map_err(error)
    }

    /// Shows so much of an expression, 0..=1.
    pub fn express(
        &mut self,
        expressions: &Expressions,
        name: &str,
        weight: f64,
    ) -> Result<(), JsError> {
        let new = || Performance::new(&expressions.expressions);
        let performance = self.performance.get_or_insert_with(new);
        performance.set(name, weight).map_err(error)
    }

    /// How much of each expression is shown; empty when none ever was.
    pub fn weights(&self) -> Vec<f32> {
        let performance = self.performance.as_ref();
        performance.map_or(Vec::new(), |p| p.weights().to_vec())
    }

    /// Takes all expressions away.
    pub fn relax(&mut self) {
        if let Some(performance) = &mut self.performance {
            performance.rest();
        }
    }

    /// The face as a short string.
    pub fn code(&self) -> String {
        self.face.code()
    }

    /// Takes the coefficients of a code.
    pub fn set_code(&mut self, code: &str) -> Result<(), JsError> {
        self.face.set_code(code).map_err(error)
    }

    /// The coefficients in sigmas, a copy.
    pub fn coefficients(&self) -> Vec<f32> {
        self.face.coefficients()
    }

    /// Replaces all coefficients.
    pub fn set_coefficients(&mut self, coefficients: &[f32]) -> Result<(), JsError> {
        self.face.set_coefficients(coefficients).map_err(error)
    }

    /// The fall-off distance of blending, mm.
    pub fn alpha(&self) -> f32 {
        self.face.alpha()
    }

    /// Sets the fall-off distance of blending, mm.
    pub fn set_alpha(&mut self, alpha: f32) -> Result<(), JsError> {
        self.face.set_alpha(alpha).map_err(error)
    }

    /// The address of the positions in wasm memory, with any expression: three f32 a vertex, mm.
    pub fn positions_ptr(&mut self) -> Result<usize, JsError> {
        let shown = self.performed()?.map(|p| p.positions().as_ptr());
        Ok(shown.unwrap_or(self.face.positions().as_ptr()).addr())
    }

    /// The address of the unit normals in wasm memory: three f32 a vertex.
    pub fn normals_ptr(&mut self) -> Result<usize, JsError> {
        let shown = self.performed()?.map(|p| p.normals().as_ptr());
        Ok(shown.unwrap_or(self.face.normals().as_ptr()).addr())
    }

    /// The first vertex that the last change touched.
    pub fn changed_first(&mut self) -> Result<u32, JsError> {
        Ok(self.changed()?.start)
    }

    /// One past the last vertex that the last change touched.
    pub fn changed_end(&mut self) -> Result<u32, JsError> {
        Ok(self.changed()?.end)
    }

    /// A copy with its own coefficients, locks and vertices.
    pub fn duplicate(&self) -> Face {
        Face {
            face: self.face.clone(),
            performance: self.performance.clone(),
        }
    }
}

/// The version of the package.
#[wasm_bindgen]
pub fn version() -> String {
    env!("CARGO_PKG_VERSION").to_owned()
}
