//! The binding of changes to a photo.

use glam::{DMat3, DVec2, DVec3, Vec3};
use js_sys::{Float32Array, Object, Reflect};
use serde::Serialize;
use wasm_bindgen::prelude::*;

use super::{Fitter, error};
use crate::photo::{Camera, Detail, Edit, Field, HARMONICS, Image, Light, Looks, View};
use crate::{Error, Expressions, Face, Performance};

/// How many numbers tell a camera: the focal length, the centre, the rotation row by row, the
/// translation.
const CAMERA: usize = 15;

/// A photo whose face can be changed.
#[wasm_bindgen]
pub struct PhotoEdit {
    face: Worn,
    edit: Edit,
    size: [u32; 2],
    others: Vec<Other>,
}

/// Another photo of the same person.
struct Other {
    camera: Camera,
    light: Light,
    positions: Vec<DVec3>,
    normals: Vec<Vec3>,
    size: [u32; 2],
    rgba: Vec<u8>,
    detail: Option<Finer>,
}

/// Finer pixels of a part of a photo.
struct Finer {
    size: [u32; 2],
    rgba: Vec<u8>,
    corner: DVec2,
    scale: f64,
}

impl Finer {
    /// Of its pixels, and its width and height, where its upper left corner is in the photo, and how many of its pixels
    /// are one of the photo's.
    fn new(rgba: Option<Vec<u8>>, place: &[f64]) -> Result<Option<Self>, JsError> {
        match (rgba, place) {
            (Some(rgba), &[width, height, left, top, scale]) => Ok(Some(Self {
                size: [width as u32, height as u32],
                rgba,
                corner: DVec2::new(left, top),
                scale,
            })),
            (Some(_), _) => Err(error("finer pixels have a size, a corner and a scale")),
            (None, _) => Ok(None),
        }
    }

    fn detail(&self) -> crate::Result<Detail<'_>> {
        let [width, height] = self.size;
        Ok(Detail {
            image: Image::new(width, height, &self.rgba)?,
            corner: self.corner,
            scale: self.scale,
        })
    }
}

impl Other {
    fn view(&self) -> crate::Result<View<'_>> {
        let [width, height] = self.size;
        Ok(View {
            camera: &self.camera,
            light: &self.light,
            positions: &self.positions,
            normals: &self.normals,
            image: Image::new(width, height, &self.rgba)?,
            detail: self.detail.as_ref().map(Finer::detail).transpose()?,
        })
    }
}

/// A face and its expression.
pub(super) struct Worn {
    pub face: Face,
    performance: Option<Performance>,
}

impl Worn {
    pub fn new(face: Face, expressions: Option<&Expressions>) -> Self {
        Self {
            face,
            performance: expressions.map(Performance::new),
        }
    }

    /// Takes weights of all expressions, in their order; none are none.
    pub fn express(&mut self, weights: &[f64]) -> crate::Result<()> {
        let Some(performance) = &mut self.performance else {
            return match weights {
                [] => Ok(()),
                _ => Err(Error::Mismatch(
                    "the photo was opened before its model had expressions".into(),
                )),
            };
        };
        performance.rest();
        let names: Vec<String> = (performance.expressions().list().iter())
            .map(|e| e.name.clone())
            .collect();
        for (name, &weight) in names.iter().zip(weights) {
            performance.set(name, weight)?;
        }
        performance.perform(&self.face)
    }

    /// Becomes the face with a code, with weights as of `express`.
    fn take(&mut self, code: &str, weights: &[f64]) -> crate::Result<()> {
        self.face.set_code(code)?;
        self.express(weights)
    }

    /// Positions and normals.
    pub fn mesh(&self) -> [&[Vec3]; 2] {
        match &self.performance {
            Some(p) if !p.is_at_rest() => [p.positions(), p.normals()],
            _ => [self.face.positions(), self.face.normals()],
        }
    }
}

/// As `PhotoLooks` of `index.d.ts`.
#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct LooksInfo {
    skin: [f64; 3],
    irises: Option<[f64; 3]>,
    beard: f64,
    beard_colour: Option<[f64; 3]>,
    hair: Option<HairInfo>,
}

/// As `PhotoHair` of `index.d.ts`.
#[derive(Serialize)]
struct HairInfo {
    colour: [f64; 3],
    cover: f64,
    off: f64,
    hangs: f64,
    forehead: f64,
    aside: f64,
    lean: f64,
}

impl From<Looks> for LooksInfo {
    fn from(looks: Looks) -> Self {
        Self {
            skin: looks.skin.to_array(),
            irises: looks.irises.map(|i| i.to_array()),
            beard: looks.beard,
            beard_colour: looks.beard_colour.map(|c| c.to_array()),
            hair: looks.hair.map(|hair| HairInfo {
                colour: hair.colour.to_array(),
                cover: hair.cover,
                off: hair.off,
                hangs: hair.hangs,
                forehead: hair.forehead,
                aside: hair.aside,
                lean: hair.lean,
            }),
        }
    }
}

#[wasm_bindgen]
impl PhotoEdit {
    /// Of the face with a code and an expression (the weights of all, or none) in a photo of `width` x
    /// `height` px, which a camera of [`CAMERA`] numbers took, in a light of 27 numbers or none.
    pub fn open(
        fitter: &Fitter,
        size: &[u32],
        camera: &[f64],
        light: &[f64],
        code: &str,
        weights: &[f64],
    ) -> Result<PhotoEdit, JsError> {
        let &[width, height] = size else {
            return Err(error("a photo has a width and a height"));
        };
        let model = fitter.fitter.model();
        let mut face = Worn::new(model.face(), fitter.expressions.as_ref());
        face.take(code, weights).map_err(error)?;
        let camera = camera_of(camera)?;
        let light = match light {
            [] => None,
            numbers => Some(light_of(numbers)?),
        };
        let [positions, normals] = face.mesh();
        let edit = Edit::new(model, &camera, [width, height], light, positions, normals);
        Ok(Self {
            edit: edit.map_err(error)?,
            face,
            size: [width, height],
            others: Vec::new(),
        })
    }

    /// Another photo of the same person, whose colours count in [`PhotoEdit::texture`] from then on: the face with a code and
    /// an expression as a camera saw it, its pixels, and finer ones as there. Whether they do: of a face on which no light is
    /// told nobody knows the colours.
    #[expect(
        clippy::too_many_arguments,
        reason = "what wasm takes has no structure"
    )]
    pub fn also(
        &mut self,
        size: &[u32],
        camera: &[f64],
        code: &str,
        weights: &[f64],
        rgba: Vec<u8>,
        finer: Option<Vec<u8>>,
        place: &[f64],
    ) -> Result<bool, JsError> {
        let &[width, height] = size else {
            return Err(error("a photo has a width and a height"));
        };
        self.face.take(code, weights).map_err(error)?;
        let camera = camera_of(camera)?;
        let detail = Finer::new(finer, place)?;
        let image = Image::new(width, height, &rgba).map_err(error)?;
        let mesh = self.face.mesh();
        let Ok(light) = Light::on(self.face.face.model(), mesh, &camera, &image) else {
            return Ok(false);
        };
        let [positions, normals] = mesh;
        self.others.push(Other {
            camera,
            light,
            positions: positions.iter().map(|p| p.as_dvec3()).collect(),
            normals: normals.to_vec(),
            size: [width, height],
            rgba,
            detail,
        });
        Ok(true)
    }

    /// Tells what is background, by pixels of the size that the photo was opened with.
    pub fn set_background(&mut self, rgba: &[u8]) -> Result<(), JsError> {
        let [width, height] = self.size;
        let image = Image::new(width, height, rgba).map_err(error)?;
        self.edit.set_background(&image).map_err(error)
    }

    /// How the photo changes for another face and expression, as `PhotoField` of `index.d.ts`; null when
    /// it does not.
    pub fn field(&mut self, code: &str, weights: &[f64]) -> Result<JsValue, JsError> {
        let Some(field) = self.change(code, weights)? else {
            return Ok(JsValue::NULL);
        };
        let object = Object::new();
        let set = |name: &str, value: JsValue| {
            // A fresh object takes everything.
            Reflect::set(&object, &name.into(), &value)
                .map_err(|_| error("no object takes a field"))
        };
        set("left", field.origin.x.into())?;
        set("top", field.origin.y.into())?;
        set("step", field.step.into())?;
        set("columns", (field.columns as u32).into())?;
        set("rows", (field.rows as u32).into())?;
        set(
            "motion",
            Float32Array::from(field.motion.as_flattened()).into(),
        )?;
        set("gain", Float32Array::from(field.gain.as_flattened()).into())?;
        Ok(object.into())
    }

    /// The colours of the head in the photo, of pixels of the size that it was opened with: sRGB and
    /// how much of it is the photo's, with a side of `size` texels. Finer pixels of a part of the photo come with
    /// their width and height, where their upper left corner is in the photo, and how many of them are one of its.
    pub fn texture(
        &self,
        rgba: &[u8],
        size: u32,
        finer: Option<Vec<u8>>,
        place: &[f64],
    ) -> Result<Vec<u8>, JsError> {
        let [width, height] = self.size;
        let image = Image::new(width, height, rgba).map_err(error)?;
        let finer = Finer::new(finer, place)?;
        let detail = finer.as_ref().map(Finer::detail).transpose();
        let detail = detail.map_err(error)?;
        let others: crate::Result<Vec<View>> = self.others.iter().map(Other::view).collect();
        let others = others.map_err(error)?;
        let texture = (self.edit).texture_with(&image, detail.as_ref(), &others, size as usize);
        Ok(texture.map_err(error)?.rgba)
    }

    /// What the photo tells of the person beside the shape, of pixels of the size that it was opened
    /// with, as `PhotoLooks` of `index.d.ts`; `irises` are the middles of two as x, y, x, y, px, or none.
    pub fn looks(&self, rgba: &[u8], irises: &[f64]) -> Result<JsValue, JsError> {
        let [width, height] = self.size;
        let image = Image::new(width, height, rgba).map_err(error)?;
        let irises = match *irises {
            [] => None,
            [a, b, c, d] if irises.iter().all(|x| x.is_finite()) => {
                Some([DVec2::new(a, b), DVec2::new(c, d)])
            }
            _ => {
                return Err(JsError::new(
                    "irises are the middles of two, as x, y, x, y in px",
                ));
            }
        };
        let looks = LooksInfo::from(self.edit.looks(&image, irises).map_err(error)?);
        let serializer = serde_wasm_bindgen::Serializer::json_compatible();
        looks.serialize(&serializer).map_err(error)
    }

    /// The albedo at mixes of three vertices, and how well it is seen, of pixels of the size that the photo was opened with:
    /// four numbers a place, of three `corners` and three `shares` each.
    pub fn albedos(
        &self,
        rgba: &[u8],
        corners: &[u32],
        shares: &[f32],
    ) -> Result<Vec<f32>, JsError> {
        let [width, height] = self.size;
        let image = Image::new(width, height, rgba).map_err(error)?;
        let (triples, rest) = corners.as_chunks::<3>();
        let (mixes, more) = shares.as_chunks::<3>();
        if triples.len() != mixes.len() || !rest.is_empty() || !more.is_empty() {
            return Err(error("a place has three corners and three shares"));
        }
        let places = triples
            .iter()
            .zip(mixes)
            .map(|(&c, s)| (c, s.map(f64::from)));
        let places: Vec<_> = places.collect();
        let albedos = self.edit.albedos(&image, &places).map_err(error)?;
        Ok(albedos.as_flattened().iter().map(|&x| x as f32).collect())
    }

    /// The photo of another face and expression, of pixels of the size that it was opened with.
    pub fn render(
        &mut self,
        mut rgba: Vec<u8>,
        code: &str,
        weights: &[f64],
    ) -> Result<Vec<u8>, JsError> {
        let [width, height] = self.size;
        Image::new(width, height, &rgba).map_err(error)?;
        if let Some(field) = self.change(code, weights)? {
            let done = field.render_in_place(self.size, &mut rgba, 1.0);
            done.map_err(error)?;
        }
        Ok(rgba)
    }
}

impl PhotoEdit {
    fn change(&mut self, code: &str, weights: &[f64]) -> Result<Option<Field>, JsError> {
        self.face.take(code, weights).map_err(error)?;
        let [positions, normals] = self.face.mesh();
        self.edit.field(positions, normals).map_err(error)
    }
}

fn camera_of(numbers: &[f64]) -> Result<Camera, JsError> {
    let &[focal, x, y, a, b, c, d, e, f, g, h, i, tx, ty, tz] = numbers else {
        return Err(error(format!(
            "{} numbers are no camera: {CAMERA} are",
            numbers.len()
        )));
    };
    Ok(Camera {
        rotation: DMat3::from_cols_array(&[a, d, g, b, e, h, c, f, i]),
        translation: DVec3::new(tx, ty, tz),
        focal,
        centre: DVec2::new(x, y),
    })
}

fn light_of(numbers: &[f64]) -> Result<Light, JsError> {
    let (channels, rest) = numbers.as_chunks::<HARMONICS>();
    let coefficients = <[[f64; HARMONICS]; 3]>::try_from(channels);
    match coefficients {
        Ok(coefficients) if rest.is_empty() => Ok(Light {
            coefficients,
            rms: 0.0,
        }),
        _ => Err(error(format!(
            "{} numbers are no light: 27 are",
            numbers.len()
        ))),
    }
}
