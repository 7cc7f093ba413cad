//! Mouths and eyes that open and shut in a photo.
//!
//! What a photo shows of them does not go along with a surface: nobody saw the inside of a mouth that was
//! shut, nor the skin of a lid that was folded away. An open mouth has the upper teeth where they were, as
//! they hang on the skull, and dark below what was seen of it. A shut eye is a lid of the skin around it, over
//! an eyeball that stays.

use glam::{DVec2, DVec3};

use crate::FaceModel;
use crate::anatomy::Landmark;
use crate::photo::Camera;

/// Of the lips' inner edges, upper and lower, from the corner that is left in a photo to the other.
const LIPS: [&[&str]; 2] = [
    &["ibug_60", "ibug_61", "ibug_62", "ibug_63", "ibug_64"],
    &["ibug_60", "ibug_67", "ibug_66", "ibug_65", "ibug_64"],
];
/// The same of both eyes' lids.
const EYES: [[&[&str]; 2]; 2] = [
    [
        &["ibug_36", "ibug_37", "ibug_38", "ibug_39"],
        &["ibug_36", "ibug_41", "ibug_40", "ibug_39"],
    ],
    [
        &["ibug_42", "ibug_43", "ibug_44", "ibug_45"],
        &["ibug_42", "ibug_47", "ibug_46", "ibug_45"],
    ],
];
/// Lips that part by less than the first of these move as on any other face; from the second on they open, mm.
const PARTING: [f64; 2] = [2.0, 5.0];
/// How much of what was seen of the inside of a mouth stays as it was; the rest is drawn out.
const KEPT: f64 = 0.75;
/// What is drawn out to more than this is nearly as dark as it becomes, mm.
const DARK_WITHIN: f64 = 2.5;
/// The logarithm of the light deep in an open mouth.
const DARKEST: f64 = -3.0;
/// Eyes that stay open by more than the first part of what they were are as on any other face; below the second they
/// shut.
const SHUTTING: [f64; 2] = [0.9, 0.6];
/// Nor do they shut whose lids come nearer by less than the first of these, mm; from the second on all of that counts.
/// An open eye has some 9, of which a tenth is the second; what an edit does to lids that are shut is below the first.
const NEARER: [f64; 2] = [0.3, 0.9];
/// Nor those that were open by less than the first, mm: what is shut has its lashes in the photo.
const OPENED: [f64; 2] = [1.0, 2.0];
/// Nor those whose corners are seen less far apart than the first, mm, or the other way round: the far eye of a head
/// from the side, of whose lids a photo tells nothing.
const ACROSS: [f64; 2] = [1.0, 4.0];
/// What is so near to the middle of an eye is lids, mm.
const LID: f64 = 17.0;
/// Lids that shut are read from so far beyond their edges at the least, mm: a fit is off by as much.
const BEYOND: f64 = 1.5;
/// And from so far beyond, mm, where more of them than that is seen.
const SKIN: f64 = 4.0;
/// Half the width of the line in which lids meet, cells: what is read jumps there from the one to the other.
const LINE: f64 = 0.9;
/// The logarithm of the light in it.
const LASHES: f64 = -1.6;

/// 0 below the first, 1 above the second, smooth in between; they may be in any order.
fn smoothstep([from, to]: [f64; 2], x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The edges of an opening of a model, upper and lower.
type Edges = [Vec<Landmark>; 2];

/// Mouth and eyes of a model.
#[derive(Debug, Clone)]
pub(super) struct Openings {
    /// None where the model does not tell where they are.
    lips: Option<Edges>,
    eyes: Vec<Edges>,
    /// Of each vertex whether it is of lids.
    pub lids: Vec<bool>,
}

impl Openings {
    pub fn of(model: &FaceModel) -> Self {
        let parts = model.parts();
        let named = |name: &&str| parts.landmarks.iter().find(|l| l.name == *name).cloned();
        let edges = |names: &[&[&str]; 2]| -> Option<Edges> {
            let all = |names: &[&str]| names.iter().map(named).collect::<Option<Vec<_>>>();
            Some([all(names[0])?, all(names[1])?])
        };
        let eyes: Vec<Edges> = EYES.iter().filter_map(edges).collect();
        let mut lids = vec![false; parts.mean.len()];
        for [upper, _] in &eyes {
            let [a, b] = [0, upper.len() - 1].map(|i| upper[i].place(&parts.mean));
            let middle = (a + b) / 2.0;
            for (lid, p) in lids.iter_mut().zip(&parts.mean) {
                *lid |= p.as_dvec3().distance(middle) < LID;
            }
        }
        Self {
            lips: edges(&LIPS),
            eyes,
            lids,
        }
    }

    /// The mouth of a face that was one and becomes another, in the pixels of a camera.
    pub fn mouth(&self, camera: &Camera, before: &[DVec3], after: &[DVec3]) -> Option<Mouth> {
        let change = Change::of(self.lips.as_ref()?, camera, before, after);
        let parting = (change.after.gap(0.5) - change.before.gap(0.5)) / change.scale;
        Some(Mouth {
            open: smoothstep(PARTING, parting),
            change,
        })
    }

    /// The eyes.
    pub fn eyes(&self, camera: &Camera, before: &[DVec3], after: &[DVec3]) -> Vec<Eye> {
        let each = self.eyes.iter().map(|edges| {
            let change = Change::of(edges, camera, before, after);
            let [before, after] = [&change.before, &change.after].map(|slit| slit.gap(0.5));
            let wide = change
                .after
                .across
                .dot(change.before.across.normalize_or_zero());
            let told = [
                smoothstep(NEARER, (before - after) / change.scale),
                smoothstep(OPENED, before / change.scale),
                smoothstep(ACROSS, wide / change.scale),
            ];
            Eye {
                shut: smoothstep(SHUTTING, after / before.max(1e-9)) * told.iter().product::<f64>(),
                change,
            }
        });
        each.collect()
    }
}

/// An opening of a face that becomes another.
#[derive(Debug, Clone)]
struct Change {
    before: Slit,
    after: Slit,
    /// Cells a mm.
    scale: f64,
}

impl Change {
    fn of(edges: &Edges, camera: &Camera, before: &[DVec3], after: &[DVec3]) -> Self {
        let corner = place(&edges[0][0], before);
        Self {
            scale: camera.focal / camera.to_camera(corner).z,
            before: Slit::of(edges, camera, before),
            after: Slit::of(edges, camera, after),
        }
    }
}

/// An eye of a face that becomes another.
#[derive(Debug, Clone)]
pub(super) struct Eye {
    /// How much its lids hide the eyeball that they did not, 0 to 1.
    pub shut: f64,
    change: Change,
}

impl Eye {
    /// Where its corners' middle is.
    pub fn middle(&self) -> DVec2 {
        self.change.after.between()
    }

    /// From there to where it was.
    pub fn motion(&self) -> DVec2 {
        self.change.before.between() - self.middle()
    }

    /// What a place on a lid that shuts is read from, whatever the surface says: skin. And the logarithm of its gain: where
    /// lids meet there is a line of lashes, in which what they hide is too narrow to be seen.
    pub fn lid(&self, here: DVec2, motion: DVec2) -> (DVec2, f64) {
        let Change {
            before,
            after,
            scale,
        } = &self.change;
        let (along, height) = after.own(here);
        if self.shut <= 0.0 || !(0.0..=1.0).contains(&along) {
            return (motion, 0.0);
        }
        let (from, depth) = before.own(here + motion);
        let meet = (after.edge(0, along) + after.edge(1, along)) / 2.0;
        let (which, outwards) = if height < meet { (0, -1.0) } else { (1, 1.0) };
        let beyond = outwards * (height - after.edge(which, along));
        let least = beyond.max(BEYOND * scale).min(SKIN * scale);
        let missing = least - outwards * (depth - before.edge(which, from));
        let motion = motion + before.down() * (outwards * missing.max(0.0) * self.shut);
        let off = (height - meet) / LINE;
        let ends = 1.0 - (2.0 * along - 1.0).powi(4);
        (motion, LASHES * self.shut * ends * (-off * off).exp())
    }
}

/// A mouth of a face that becomes another.
#[derive(Debug, Clone)]
pub(super) struct Mouth {
    /// How much it opens, 0 to 1.
    pub open: f64,
    change: Change,
}

impl Mouth {
    /// How its inside moves as a whole: as the middle of the lips' inner edges.
    pub fn hold(&self) -> DVec2 {
        self.change.before.middle - self.change.after.middle
    }

    /// What a place inside of the lips as they become is read from when they open: how far from it, and the logarithm of
    /// its gain.
    pub fn read(&self, here: DVec2) -> (DVec2, f64) {
        let Change {
            before,
            after,
            scale,
        } = &self.change;
        let (along, height) = after.own(here);
        let below = height - after.edge(0, along);
        let gap = before.gap(along);
        let kept = KEPT * gap;
        let rest = (gap - kept).max(1e-9);
        let old = match below > kept {
            true => kept + rest * (1.0 - ((kept - below) / rest).exp()),
            false => below,
        };
        let from = before.place(along, before.edge(0, along) + old);
        let made_up = (below - old).max(0.0) / (scale * DARK_WITHIN);
        (from - here, DARKEST * (1.0 - (-made_up).exp()))
    }
}

fn place(landmark: &Landmark, positions: &[DVec3]) -> DVec3 {
    let each = landmark.stencil.iter();
    each.map(|&(v, weight)| positions[v as usize] * weight)
        .sum()
}

/// The edges of an opening in a photo, told from the line between its corners.
#[derive(Debug, Clone)]
struct Slit {
    corner: DVec2,
    /// To the other corner.
    across: DVec2,
    /// Of all points of the edges.
    middle: DVec2,
    /// Of the points of each edge the part of the way across, and how far below the line.
    edges: [Vec<(f64, f64)>; 2],
}

impl Slit {
    fn of(edges: &Edges, camera: &Camera, positions: &[DVec3]) -> Self {
        let points = edges.each_ref().map(|edge| -> Vec<DVec2> {
            let each = edge.iter().map(|l| camera.project(place(l, positions)));
            each.collect()
        });
        let [upper, lower] = &points;
        let last = upper.len() - 1;
        // Each corner is of both edges.
        let all = upper.iter().chain(&lower[1..last]);
        let mut slit = Self {
            corner: upper[0],
            across: upper[last] - upper[0],
            middle: all.sum::<DVec2>() / (2 * last) as f64,
            edges: [Vec::new(), Vec::new()],
        };
        slit.edges = points.map(|edge| edge.into_iter().map(|p| slit.own(p)).collect());
        slit
    }

    /// The middle between the corners.
    fn between(&self) -> DVec2 {
        self.corner + self.across / 2.0
    }

    fn down(&self) -> DVec2 {
        self.across.perp().normalize_or_zero()
    }

    /// The part of the way across, and how far below the line between the corners.
    fn own(&self, p: DVec2) -> (f64, f64) {
        let by = p - self.corner;
        let along = by.dot(self.across) / self.across.length_squared().max(1e-9);
        (along, by.dot(self.down()))
    }

    fn place(&self, along: f64, below: f64) -> DVec2 {
        self.corner + self.across * along + self.down() * below
    }

    /// How far below that line an edge is at a part of the way across.
    fn edge(&self, which: usize, along: f64) -> f64 {
        let points = &self.edges[which];
        let next = points.iter().position(|p| p.0 > along);
        let next = next.unwrap_or(points.len() - 1).max(1);
        let [from, to] = [points[next - 1], points[next]];
        let part = ((along - from.0) / (to.0 - from.0).max(1e-9)).clamp(0.0, 1.0);
        from.1 + part * (to.1 - from.1)
    }

    /// How far the edges are apart.
    fn gap(&self, along: f64) -> f64 {
        (self.edge(1, along) - self.edge(0, along)).max(0.0)
    }
}
