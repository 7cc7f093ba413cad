//! Expressions of people of ICT, whose meshes have none here.
//!
//! A person's skin has the template's vertices by [`Binding`]; there the model's expressions are carried
//! to that face as [`crate::Performance`] does, and from there to ICT's own vertices. Of what a fit
//! assumes this differs twice: a fit takes expressions as they are on the mean head, and ICT's vertices
//! take means of the template's.

use glam::{DVec3, Vec3};

use super::ict::Ict;
use crate::fit::mesh::align::Rigid;
use crate::fit::truth::binding::Binding;
use crate::{Expressions, FaceModel, Random};

/// So many of the expressions are shown, at least and at most; those of the left and of the right are
/// one.
const SHOWN: [usize; 2] = [1, 3];
/// Their weights.
const WEIGHTS: [f64; 2] = [0.3, 0.9];
/// By how much the two sides differ (one standard deviation), as a part.
const UNEVEN: f64 = 0.1;
/// What no point shows: where eyes look. It is left out.
const UNSEEN: &str = "eyeLook";

/// What people show.
pub(super) struct Mood<'a> {
    model: &'a FaceModel,
    expressions: &'a Expressions,
    /// Expressions that are shown together: one of the middle, or those of both sides.
    pairs: Vec<Vec<usize>>,
    /// For each of ICT's vertices, the places in the binding that it moves with, and their weights, which
    /// sum to 1.
    moved_by: Vec<Vec<(usize, f64)>>,
}

impl<'a> Mood<'a> {
    pub fn new(
        model: &'a FaceModel,
        expressions: &'a Expressions,
        binding: &Binding,
        ict: &Ict,
    ) -> Self {
        let mut pairs: Vec<Vec<usize>> = Vec::new();
        let mut stems: Vec<&str> = Vec::new();
        for (e, expression) in expressions.list().iter().enumerate() {
            let name = &expression.name;
            let stem = name.strip_suffix("Left").or(name.strip_suffix("Right"));
            // The jaw and the mouth go to one side or to the other.
            let is_pair = stem.is_some_and(|stem| !["jaw", "mouth"].contains(&stem));
            let stem = if is_pair { stem.unwrap_or(name) } else { name };
            if stem.starts_with(UNSEEN) {
                continue;
            }
            match stems.iter().position(|s| *s == stem) {
                Some(at) => pairs[at].push(e),
                None => {
                    stems.push(stem);
                    pairs.push(vec![e]);
                }
            }
        }
        Self {
            model,
            expressions,
            pairs,
            moved_by: moved_by(binding, ict),
        }
    }

    /// Moves a person (ICT's vertices, mm, whose skin has the places of the binding at `neutral`) by an
    /// expression that is drawn from a seed; its weights.
    pub fn show(
        &self,
        seed: u64,
        binding: &Binding,
        neutral: &[DVec3],
        person: &mut [DVec3],
    ) -> Vec<f64> {
        // Streams up to 9 are the scans', the points' and the pixels'.
        let mut random = Random::stream(seed, 10);
        let list = self.expressions.list();
        let mut weights = vec![0.0; list.len()];
        let [least, most] = SHOWN;
        let count = least + (random.uniform() * (most - least + 1) as f64) as usize;
        for _ in 0..count {
            let pair = &self.pairs[(random.uniform() * self.pairs.len() as f64) as usize];
            let weight = WEIGHTS[0] + (WEIGHTS[1] - WEIGHTS[0]) * random.uniform();
            for &e in pair {
                weights[e] = (weight * (1.0 + UNEVEN * random.normal())).clamp(0.0, 1.0);
            }
        }
        // In the pose of the model's mean, in which expressions are.
        let mean = &self.model.parts().mean;
        let places = 0..binding.vertices.len();
        let own: Vec<u32> = places
            .filter(|&i| binding.bound[i])
            .map(|i| i as u32)
            .collect();
        let of_mean: Vec<DVec3> = binding
            .vertices
            .iter()
            .map(|&v| mean[v as usize].as_dvec3())
            .collect();
        let even = vec![1.0; neutral.len()];
        let align = Rigid::fit(neutral, &of_mean, &own, &even);
        let mut face: Vec<Vec3> = mean.clone();
        for (&v, &p) in binding.vertices.iter().zip(neutral) {
            face[v as usize] = align.apply(p).as_vec3();
        }
        let mut moved = face.clone();
        let as_f32: Vec<f32> = weights.iter().map(|&w| w as f32).collect();
        let landmarks = &self.model.parts().landmarks;
        let maps = self.expressions.maps(&face);
        // Everybody is in a mood of their own: nothing is kept for the next.
        let none = &mut Default::default();
        self.expressions
            .carry(&maps, none, &as_f32, landmarks, &face, &mut moved);
        let back = align.rotation.transpose();
        let moves: Vec<DVec3> = (binding.vertices.iter())
            .map(|&v| back * (moved[v as usize] - face[v as usize]).as_dvec3())
            .collect();
        for (p, by) in person.iter_mut().zip(&self.moved_by) {
            *p += by
                .iter()
                .map(|&(i, weight)| moves[i] * weight)
                .sum::<DVec3>();
        }
        weights
    }
}

/// What each of ICT's vertices moves with: the vertices that are bound to a triangle of its own, each as
/// near as it is; where there is none, what its neighbours move with.
fn moved_by(binding: &Binding, ict: &Ict) -> Vec<Vec<(usize, f64)>> {
    let mut all: Vec<Vec<(usize, f64)>> = vec![Vec::new(); ict.neutral.len()];
    for (i, spot) in binding.spots.iter().enumerate() {
        if !binding.bound[i] {
            continue;
        }
        for (&v, weight) in ict.triangles[spot.triangle as usize]
            .iter()
            .zip(spot.weights)
        {
            // Whoever is at the far side of a triangle has nothing to say.
            if weight > 1e-3 {
                all[v as usize].push((i, weight));
            }
        }
    }
    let mut empty: Vec<usize> = (0..all.len()).filter(|&v| all[v].is_empty()).collect();
    while !empty.is_empty() {
        let mut found: Vec<(usize, Vec<(usize, f64)>)> = Vec::new();
        for &v in &empty {
            let own = ict.triangles.iter().filter(|t| t.contains(&(v as u32)));
            let around: Vec<(usize, f64)> = own
                .flatten()
                .flat_map(|&u| all[u as usize].iter().copied())
                .collect();
            if !around.is_empty() {
                found.push((v, around));
            }
        }
        if found.is_empty() {
            break;
        }
        for (v, around) in found {
            all[v] = around;
        }
        empty.retain(|&v| all[v].is_empty());
    }
    for each in &mut all {
        let total: f64 = each.iter().map(|e| e.1).sum();
        each.iter_mut().for_each(|e| e.1 /= total);
    }
    all
}
