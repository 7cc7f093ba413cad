//! What a model says of itself, as plain JavaScript objects.
//!
//! By hand: a serialiser for these few types, made for each of them anew, takes more of the module than
//! everything here.

use js_sys::{Array, Object, Reflect};
use wasm_bindgen::prelude::*;

use crate::anatomy::{Landmark, Measure, Part};
use crate::model::{About, Blending, FaceModel};

/// A plain object of these fields.
#[inline(never)]
fn object(fields: &[(&str, JsValue)]) -> JsValue {
    let object = Object::new();
    for (name, value) in fields {
        // What was made a moment ago is not frozen, and cannot refuse.
        let _ = Reflect::set(&object, &JsValue::from_str(name), value);
    }
    object.into()
}

/// An array of what `each` makes of the items.
fn array<T>(items: &[T], each: fn(&T) -> JsValue) -> JsValue {
    let array = Array::new();
    for item in items {
        array.push(&each(item));
    }
    array.into()
}

fn string(text: &str) -> JsValue {
    JsValue::from_str(text)
}

fn number(number: impl Into<f64>) -> JsValue {
    JsValue::from_f64(number.into())
}

fn pair<T: Into<f64> + Copy>([a, b]: [T; 2]) -> JsValue {
    Array::of2(&number(a), &number(b)).into()
}

fn about(about: &About) -> JsValue {
    object(&[
        ("title", string(&about.title)),
        ("population", string(&about.population)),
        ("caveat", string(&about.caveat)),
        ("faces", number(about.faces)),
        ("made_by", string(&about.made_by)),
        (
            "licences",
            array(&about.licences, |licence| {
                object(&[
                    ("source", string(&licence.source)),
                    ("by", string(&licence.by)),
                    ("licence", string(&licence.licence)),
                ])
            }),
        ),
    ])
}

fn part(part: &Part) -> JsValue {
    object(&[
        ("name", string(&part.name)),
        ("first", number(part.first)),
        ("count", number(part.count)),
    ])
}

fn landmark(landmark: &Landmark) -> JsValue {
    let stencil = array(&landmark.stencil, |&(vertex, weight)| {
        pair([f64::from(vertex), weight])
    });
    object(&[("name", string(&landmark.name)), ("stencil", stencil)])
}

fn measure(measure: &Measure) -> JsValue {
    object(&[
        ("name", string(&measure.name)),
        ("description", string(&measure.description)),
        ("unit", JsValue::from_str(Measure::UNIT)),
    ])
}

fn blending(blending: Blending) -> JsValue {
    object(&[
        ("alpha", number(blending.alpha)),
        ("limits", pair(blending.limits)),
    ])
}

/// As `ModelInfo` of `index.d.ts`.
pub(super) fn info(model: &FaceModel) -> JsValue {
    let parts = model.parts();
    let regions = Array::new();
    for block in parts.blocks.iter().filter(|b| b.local_to.is_none()) {
        regions.push(&string(&block.name));
    }
    let names = &parts.topology.region_names;
    let groups = Array::new();
    for region in 0..names.len() as u8 {
        let mut blocks = parts.blocks.iter();
        let group = blocks.position(|b| b.regions.contains(&region));
        groups.push(&group.map_or(JsValue::NULL, |g| number(g as u32)));
    }
    let controls = Array::new();
    for control in &parts.controls {
        let measure = control.measure.map(|m| &parts.measures[m as usize].name);
        controls.push(&object(&[
            ("name", string(&control.name)),
            ("group", string(&control.group)),
            ("description", string(&control.description)),
            ("unit", JsValue::from_str("percentile")),
            ("limits", pair(control.limits)),
            ("measure", measure.map_or(JsValue::NULL, |m| string(m))),
        ]));
    }
    let attributes = Array::new();
    for (attribute, (_, variance)) in parts.attributes.iter().zip(&model.derived.along) {
        attributes.push(&object(&[
            ("name", string(&attribute.name)),
            ("description", string(&attribute.description)),
            ("unit", string(&attribute.unit)),
            ("limits", pair(attribute.limits)),
            ("explained", number(attribute.explained)),
            ("deviation", JsValue::from_f64(variance.sqrt())),
        ]));
    }
    object(&[
        ("about", about(&parts.about)),
        ("regions", regions.into()),
        ("regionNames", array(names, |name| string(name))),
        ("regionGroups", groups.into()),
        ("parts", array(&parts.topology.parts, part)),
        ("landmarks", array(&parts.landmarks, landmark)),
        ("measures", array(&parts.measures, measure)),
        ("controls", controls.into()),
        ("attributes", attributes.into()),
        ("blending", blending(parts.blending)),
    ])
}
