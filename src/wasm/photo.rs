//! The bindings of the module that fits photos, and changes them ([`edit::PhotoEdit`]).
//!
//! It is built by itself (feature `photo`) and loaded when a photo is there, so that pages which only
//! show faces do not carry it. It has a memory of its own, in which it reads the model's blob again;
//! what it finds goes to the main module as a code.

mod edit;

use std::collections::BTreeMap;

use glam::DVec2;
use js_sys::{Function, Uint8Array};
use serde::Serialize;
use wasm_bindgen::prelude::*;

use crate::photo::{Camera, Image, Light, POINTS, Photo};
use crate::{Expressions, FaceModel};

fn error(why: impl std::fmt::Display) -> JsError {
    JsError::new(&why.to_string())
}

/// As `PhotoCamera` of `index.d.ts`.
#[derive(Serialize)]
struct CameraInfo {
    focal: f64,
    centre: [f64; 2],
    rotation: Vec<f64>,
    translation: [f64; 3],
    angles: [f64; 3],
}

impl From<Camera> for CameraInfo {
    fn from(camera: Camera) -> Self {
        Self {
            focal: camera.focal,
            centre: camera.centre.to_array(),
            rotation: camera.rotation.transpose().to_cols_array().to_vec(),
            translation: camera.translation.to_array(),
            angles: camera.angles(),
        }
    }
}

/// As `PhotoQuality` of `index.d.ts`.
#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct QualityInfo {
    rms_px: f64,
    rms_mm: f64,
    unusual: f64,
    determined: f64,
    refusal: Option<String>,
}

/// As `PhotoLight` of `index.d.ts`.
#[derive(Serialize)]
struct LightInfo {
    coefficients: [Vec<f64>; 3],
    rms: f64,
}

impl From<Light> for LightInfo {
    fn from(light: Light) -> Self {
        Self {
            coefficients: light.coefficients.map(|c| c.to_vec()),
            rms: light.rms,
        }
    }
}

/// As `PhotoFit` of `index.d.ts`.
#[derive(Serialize)]
struct FitInfo<'a> {
    code: String,
    camera: CameraInfo,
    expression: BTreeMap<&'a str, f64>,
    residuals: Vec<[f64; 2]>,
    quality: QualityInfo,
    appearance: Option<AppearanceInfo>,
    light: Option<LightInfo>,
    others: Vec<ShotInfo<'a>>,
}

/// As `PhotoShot` of `index.d.ts`.
#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct ShotInfo<'a> {
    camera: CameraInfo,
    expression: BTreeMap<&'a str, f64>,
    residuals: Vec<[f64; 2]>,
    rms_px: f64,
    rms_mm: f64,
    light: Option<LightInfo>,
}

/// As `PhotoAppearance` of `index.d.ts`.
#[derive(Serialize)]
struct AppearanceInfo {
    rms: f64,
    patches: usize,
}

/// Numbers of one of several photos.
const OTHER: usize = 9 + 2 * POINTS;

fn view<'a>(numbers: &'a [f64], others: &'a [Photo<'a>]) -> Option<Photo<'a>> {
    let ([width, height, focal, noise, jaw], rest) = numbers.split_first_chunk()?;
    let (irises, points) = rest.split_first_chunk::<4>()?;
    let [right_x, right_y, left_x, left_y] = *irises;
    let known = |value: f64| (!value.is_nan()).then_some(value);
    Some(Photo {
        width: *width as u32,
        height: *height as u32,
        points: points.as_chunks::<2>().0,
        focal: known(*focal),
        noise: known(*noise),
        jaw: known(*jaw),
        irises: known(right_x).map(|x| [[x, right_y], [left_x, left_y]]),
        others,
        image: None,
    })
}

/// Weights of expressions below this are not told: no vertex moves by a tenth of a mm.
const SHOWN: f64 = 2e-3;

/// Fits faces of a model to photos.
#[wasm_bindgen]
pub struct Fitter {
    fitter: crate::photo::Fitter,
    expressions: Option<Expressions>,
}

#[wasm_bindgen]
impl Fitter {
    /// For the model of a blob, and its expressions' blob if there is one. All that fits need is prepared
    /// here, so that the first takes what the others take.
    pub fn parse(model: &[u8], expressions: Option<Vec<u8>>) -> Result<Fitter, JsError> {
        let model = FaceModel::parse(model).map_err(error)?;
        let expressions = expressions
            .map(|bytes| Expressions::parse(&bytes, &model))
            .transpose()
            .map_err(error)?;
        let fitter = crate::photo::Fitter::new(&model, expressions.as_ref()).map_err(error)?;
        fitter.prepare();
        Ok(Self {
            fitter,
            expressions,
        })
    }

    /// What a photo's points tell, and its pixels (sRGB and alpha) if they are given, which tell more of the shape, and
    /// the light; as a plain object. `photo` is its width and height, the focal length, the noise of the points and of the
    /// jaw's (px), the middles of two irises (NaN where they are not known), then the points, pairs of x and y, px; so are each of `others`, one after
    /// another, which are photos of the same person, with `images` for their pixels, empty where they are not given. `told`
    /// is called with the part of the steps that are done; what it throws is dropped.
    pub fn fit(
        &self,
        photo: &[f64],
        others: &[f64],
        rgba: Option<Vec<u8>>,
        images: Vec<Uint8Array>,
        told: Option<Function>,
    ) -> Result<JsValue, JsError> {
        let none = || {
            error("a photo is a width, a height, a focal length, two noises, two irises and points")
        };
        let (others, _) = others.as_chunks::<OTHER>();
        let others: Option<Vec<Photo>> = others.iter().map(|other| view(other, &[])).collect();
        let mut others = others.ok_or_else(none)?;
        let images: Vec<Vec<u8>> = images.iter().map(Uint8Array::to_vec).collect();
        for (other, rgba) in others.iter_mut().zip(&images).filter(|o| !o.1.is_empty()) {
            other.image = Some(Image::new(other.width, other.height, rgba).map_err(error)?);
        }
        let photo = view(photo, &others).ok_or_else(none)?;
        let image = rgba
            .as_deref()
            .map(|rgba| Image::new(photo.width, photo.height, rgba))
            .transpose()
            .map_err(error)?;
        let mut tell = |part: f64| {
            if let Some(told) = &told {
                let _ = told.call1(&JsValue::NULL, &part.into());
            }
        };
        let fit = match &image {
            Some(image) => self.fitter.fit_pixels_telling(&photo, image, &mut tell),
            None => self.fitter.fit(&photo),
        };
        let fit = fit.map_err(error)?;
        let quality = &fit.quality;
        let refusal = quality.refusal();
        // Points that are no face's have no light, nor has a face of which no pixel is the person's: what the
        // points tell stands without it.
        let image = image.filter(|_| refusal.is_none());
        let coefficients = &fit.coefficients;
        let light = match &image {
            Some(image) => self.light(coefficients, &fit.expression, &fit.camera, image)?,
            None => None,
        };
        let list = self.expressions.as_ref().map_or(&[][..], |e| e.list());
        let named = |weights: &[f64]| {
            let weights = list.iter().zip(weights).filter(|w| *w.1 > SHOWN);
            weights
                .map(|(e, &weight)| (e.name.as_str(), weight))
                .collect()
        };
        let pairs = |residuals: &[DVec2]| residuals.iter().map(|r| r.to_array()).collect();
        let mut shots = Vec::with_capacity(fit.others.len());
        for (shot, other) in fit.others.iter().zip(&others) {
            let light = match other.image.as_ref().filter(|_| refusal.is_none()) {
                Some(image) => self.light(coefficients, &shot.expression, &shot.camera, image)?,
                None => None,
            };
            shots.push(ShotInfo {
                camera: shot.camera.into(),
                expression: named(&shot.expression),
                residuals: pairs(&shot.residuals),
                rms_px: shot.rms_px,
                rms_mm: shot.rms_mm,
                light: light.map(Into::into),
            });
        }
        let info = FitInfo {
            code: fit.code,
            camera: fit.camera.into(),
            expression: named(&fit.expression),
            others: shots,
            residuals: pairs(&fit.residuals),
            quality: QualityInfo {
                rms_px: quality.rms_px,
                rms_mm: quality.rms_mm,
                unusual: quality.unusual,
                determined: quality.determined,
                refusal,
            },
            appearance: fit.appearance.map(|a| AppearanceInfo {
                rms: a.rms,
                patches: a.patches,
            }),
            light: light.map(Into::into),
        };
        let serializer = serde_wasm_bindgen::Serializer::json_compatible();
        info.serialize(&serializer).map_err(error)
    }
}

impl Fitter {
    /// The light on a fitted face; none where the photo does not show it.
    fn light(
        &self,
        coefficients: &[f32],
        expression: &[f64],
        camera: &Camera,
        image: &Image,
    ) -> Result<Option<Light>, JsError> {
        let model = self.fitter.model();
        let mut worn = edit::Worn::new(model.face(), self.expressions.as_ref());
        worn.face.set_coefficients(coefficients).map_err(error)?;
        worn.express(expression).map_err(error)?;
        Ok(Light::on(model, worn.mesh(), camera, image).ok())
    }
}
