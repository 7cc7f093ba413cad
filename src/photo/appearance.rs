//! What the pixels tell of a face: E_c.
use glam::{DVec2, DVec3};
use nalgebra::{DMatrix, DVector};

use super::albedo::Albedo;
use super::camera::{POSE, Pose};
use super::knob;
use super::light::{HARMONICS, Image, Shown, harmonics};
use super::pixels::Pixels;
use super::solver::{self, Normal, Observed, State, Terms};
use super::surface::Surface;
use crate::expression::Expression;
use crate::model::FaceModel;
use crate::Face;

/// What is prepared of a model.
#[derive(Debug, Clone)]
pub(super) struct Prepared {
    pub surface: Surface,
    pub albedo: Albedo,
    pub triangles: Vec<[u32; 3]>,
}

impl Prepared {
    pub fn new(model: &FaceModel) -> Self {
        let surface = Surface::new(model);
        let places = surface.places();
        Self {
            albedo: Albedo::new(&places, knob("MODES", 150.0) as usize),
            surface,
            triangles: model.parts().topology.triangles(),
        }
    }
}

pub(super) struct Job<'a> {
    pub model: &'a FaceModel,
    pub prepared: &'a Prepared,
    pub observed: &'a Observed<'a>,
    pub terms: &'a Terms,
    pub basis: &'a DMatrix<f64>,
    pub list: &'a [Expression],
    pub image: &'a Image<'a>,
}

/// A sample that is seen.
struct Seen {
    sample: usize,
    /// Unit normal and how long the sum of facets is.
    normal: DVec3,
    length: f64,
    light: DVec3,
    gradient: [DVec3; 2],
    by_point: [DVec2; 3],
    by_pose: [DVec2; POSE],
    at: DVec2,
}

const GREY3: f64 = 0.577_350_269_189_625_8;

struct Nuisance {
    light: Vec<[f64; HARMONICS]>,
    q: Vec<DVector<f64>>,
}

fn shade(l: &[f64; HARMONICS], n: DVec3) -> f64 {
    harmonics(n).iter().zip(l).map(|(a, b)| a * b).sum()
}

fn slope(l: &[f64; HARMONICS], n: DVec3) -> DVec3 {
    let DVec3 { x, y, z } = n;
    DVec3::new(
        l[1] + l[4] * y + l[6] * z + 2.0 * l[7] * x,
        l[2] + l[4] * x + l[5] * z - 2.0 * l[7] * y,
        l[3] + l[5] * y + l[6] * x + 6.0 * l[8] * z,
    )
}

impl Job<'_> {
    fn coefficients(&self, state: &State) -> Vec<f64> {
        let z = DVector::from_column_slice(&state.unknowns[..self.terms.coefficients]);
        (self.basis * z).iter().copied().collect()
    }

    fn active(&self, state: &State) -> Vec<usize> {
        let e = &state.unknowns[self.terms.coefficients..];
        (0..e.len()).filter(|&i| e[i] > 2e-3).collect()
    }

    fn face(&self, coefficients: &[f64]) -> Option<Face> {
        let mut face = self.model.face();
        let mut all = vec![0.0_f32; self.model.parts().coefficients()];
        for (to, from) in all.iter_mut().zip(coefficients) {
            *to = *from as f32;
        }
        face.set_coefficients(&all).ok()?;
        Some(face)
    }

    fn look(&self, state: &State, visible: &[usize], pixels: &Pixels, half_mm: f64, active: &[usize]) -> (Vec<DVec3>, Vec<Seen>) {
        let s = &self.prepared.surface;
        let c = self.coefficients(state);
        let e: Vec<(&Expression, f64)> = active.iter().map(|&i| (&self.list[i], state.unknowns[self.terms.coefficients + i])).collect();
        let positions = s.positions(&c, &e);
        let pose = &state.pose;
        let mut all = Vec::new();
        for &i in visible {
            let sample = &s.samples[i];
            let p = positions[sample.own];
            let count = sample.ring.len();
            let normal: DVec3 = (0..count)
                .map(|j| (positions[sample.ring[j]] - p).cross(positions[sample.ring[(j + 1) % count]] - p))
                .sum();
            let length = normal.length();
            let Some(look) = pose.see(p) else { continue };
            let scale = (pose.log_focal - pose.log_depth).exp();
            let Some(mut patch) = pixels.patch(look.at, half_mm * scale) else { continue };
            let mut wide = pixels.patch(look.at, half_mm.max(knob("GHALF", 2.0)) * scale);
            if knob("LUMA", 1.0) > 0.0 {
                let w = DVec3::new(knob("WR", 0.2126), knob("WG", 0.7152), knob("WB", 0.0722));
                for p in [Some(&mut patch), wide.as_mut()].into_iter().flatten() {
                    for v in [&mut p.light, &mut p.right, &mut p.down] { *v = DVec3::splat(v.dot(w)); }
                }
            }
            let g = wide.as_ref().unwrap_or(&patch);
            all.push(Seen {
                sample: i,
                normal: normal / length.max(1e-12),
                length,
                light: patch.light,
                gradient: [g.right, g.down],
                by_point: look.by_point,
                by_pose: look.by_pose,
                at: look.at,
            });
        }
        (positions, all)
    }

    pub fn refine(&self, start: &State) -> Option<(State, Vec<[f64; HARMONICS]>)> {
        let debug = std::env::var_os("DBG").is_some();
        let p = self.prepared;
        let mut state = start.clone();
        let active = self.active(&state);
        let all_modes = p.albedo.modes.nrows();
        let mut nuisance: Option<Nuisance> = None;
        let mut pixels: Option<Pixels> = None;
        let mut grey = false;
        let levels = knob("LEVELS", 3.0) as usize;
        let halves = [knob("H0", 1.2), knob("H1", 0.8), knob("H2", 0.6)];
        let parts = [knob("N0", 0.3), knob("N1", 0.6), knob("N2", 1.0)];
        for level in 3 - levels..3 {
            let c = self.coefficients(&state);
            let face = self.face(&c)?;
            let mut positions: Vec<DVec3> = face.positions().iter().map(|p| p.as_dvec3()).collect();
            for &e in &active {
                let x = &self.list[e];
                for (v, d) in x.support.iter().zip(&x.displacements) {
                    positions[*v as usize] += d.as_dvec3() * state.unknowns[self.terms.coefficients + e];
                }
            }
            let camera = state.pose.camera();
            let shown = Shown::new(&camera, &positions, &p.triangles)?;
            let s = &p.surface;
            let _ = parts;
            let samples = s.samples.len();
            let visible: Vec<usize> = (0..samples).filter(|&i| {
                let v = s.vertices[s.samples[i].own] as usize;
                shown.is_seen(positions[v], face.normals()[v].as_dvec3())
            }).collect();
            if pixels.is_none() {
                let [low, high] = shown.box_;
                pixels = Some(Pixels::new(self.image, low - 10.0, high + 10.0, 1024)?);
            }
            let pixels = pixels.as_ref()?;
            for iteration in 0..knob("ITER", 3.0) as usize {
                let (positions, seen) = self.look(&state, &visible, pixels, halves[level], &active);
                if seen.len() < 100 { return None; }
                if nuisance.is_none() {
                    grey = seen.iter().all(|s| (s.light.max_element() - s.light.min_element()) < 0.004);
                    let channels = if grey { 1 } else { 3 };
                    let mean = seen.iter().map(|s| s.light).sum::<DVec3>() / seen.len() as f64;
                    let mut start = Nuisance {
                        light: (0..channels).map(|c| { let mut l = [0.0; HARMONICS]; l[0] = mean[c].max(1e-4); l }).collect(),
                        q: vec![DVector::zeros(all_modes); channels],
                    };
                    // The light alone, albedo as noise.
                    for _ in 0..6 {
                        let b = self.bordered(&state, &positions, &seen, &start, &[], true)?;
                        let d = b.curvature.cholesky()?.solve(&-b.gradient);
                        for (c, l) in start.light.iter_mut().enumerate() {
                            for h in 0..HARMONICS { l[h] += d[c * HARMONICS + h]; }
                        }
                    }
                    nuisance = Some(start);
                }
                let nu = nuisance.as_mut()?;
                let b = self.bordered(&state, &positions, &seen, nu, &active, false)?;
                let lights = nu.light.len() * HARMONICS;
                let count = self.terms.count() + POSE;
                // Light out
                let factor = b.curvature.view((0, 0), (lights, lights)).into_owned().cholesky()?;
                let cross = b.curvature.view((0, lights), (lights, count)).into_owned();
                let solved = factor.solve(&cross);
                let own = b.gradient.rows(0, lights).into_owned();
                let normal = Normal {
                    curvature: b.curvature.view((lights, lights), (count, count)) - cross.tr_mul(&solved),
                    gradient: b.gradient.rows(lights, count) - solved.tr_mul(&own),
                };
                let infl = knob("INFL", 1.0);
                let normal = Normal { curvature: normal.curvature / infl, gradient: normal.gradient / infl };
                let (there, step) = solver::step_with(self.observed, self.terms, &state, &normal, knob("MOST", 1.0))?;
                let dl = factor.solve(&-own) - &solved * &step;
                for (c, l) in nu.light.iter_mut().enumerate() {
                    for h in 0..HARMONICS { l[h] += dl[c * HARMONICS + h]; }
                }
                let mut whole = DVector::zeros(lights + count);
                whole.rows_mut(0, lights).copy_from(&dl);
                whole.rows_mut(lights, count).copy_from(&step);
                for (u, e) in b.eliminated.iter().enumerate() {
                    let right = &e.right + &e.cross * &whole;
                    nu.q[u] -= e.factor.solve(&right) * e.root;
                }
                if debug {
                    let rms = |u: usize| b.residual_rms[u];
                    println!("  level {level} it {iteration} seen {} rms {:.4} step {:.3} det {:.1} |q| {:.3} wmean {:.3}", seen.len(), rms(0), step.amax(), there.determined, nu.q[0].norm_squared() / all_modes as f64, b.weight);
                }
                state = there;
            }
        }
        let _ = grey;
        Some((state, nuisance?.light))
    }

    /// Normal equations for light (first), unknowns and pose with the albedo eliminated.
    fn bordered(&self, state: &State, positions: &[DVec3], seen: &[Seen], nu: &Nuisance, active: &[usize], only_light: bool) -> Option<Bordered> {
        let p = self.prepared;
        let channels = nu.light.len();
        let lights = channels * HARMONICS;
        let mut groups: Vec<Vec<usize>> = vec![Vec::new(); p.surface.places.len()];
        for (i, s) in seen.iter().enumerate() { groups[p.surface.samples[s.sample].patch].push(i); }
        let kept: Vec<usize> = (0..groups.len()).filter(|&g| !groups[g].is_empty()).collect();
        let n = kept.len();
        let m = p.albedo.modes.nrows();
        let k = self.basis.nrows();
        let raw = if only_light { lights } else { lights + k + active.len() + POSE };
        let anchors: DMatrix<f64> = DMatrix::from_columns(&kept.iter().map(|&g| p.albedo.modes.column(g)).collect::<Vec<_>>());
        // Colour axes: shared first.
        let axes: Vec<Vec<f64>> = if channels == 1 { vec![vec![1.0]] } else {
            let (a, b) = (1.0 / 2f64.sqrt(), 1.0 / 6f64.sqrt());
            vec![vec![GREY3; 3], vec![a, 0.0, -a], vec![b, -2.0 * b, b]]
        };
        let rho = knob("RHO", 0.7);
        let lambda: Vec<f64> = if channels == 1 { vec![1.0] } else { vec![1.0 + 2.0 * rho, 1.0 - rho, 1.0 - rho] };
        let told: Vec<DVector<f64>> = nu.q.iter().map(|q| anchors.tr_mul(q)).collect();
        let mean: Vec<f64> = (0..channels).map(|c| seen.iter().map(|s| shade(&nu.light[c], s.normal)).sum::<f64>() / seen.len() as f64).collect();
        let sigma = knob("SIGMA", 0.07);
        let infl = knob("LEFT", 1.0);
        let mut rows: Vec<DMatrix<f64>> = vec![DMatrix::zeros(raw, n); channels];
        let mut residuals: Vec<DVector<f64>> = vec![DVector::zeros(n); channels];
        let mut roots = DVector::zeros(n);
        let variance0 = knob("S1", 0.10).powi(2) + knob("S2", 0.05).powi(2);
        let dof = knob("DOF", 4.0);
        let with_gradient = knob("GRAD", 1.0);
        let usual = knob("AREA", 16.0);
        let nsd = knob("NSD", 0.0).powi(2);
        let mut wsum = 0.0;
        for (i, &g) in kept.iter().enumerate() {
            let area: f64 = groups[g].iter().map(|&s| p.surface.samples[seen[s].sample].area).sum();
            let mut square = 0.0;
            let mut tilts = 0.0;
            let mut group_r = [0.0; 3];
            for &member in &groups[g] {
            let s = &seen[member];
            let sample = &p.surface.samples[s.sample];
            let share = sample.area / area;
            let mut by_channel: Vec<(f64, DVec3, DVec2, f64, f64)> = Vec::with_capacity(3);
            for c in 0..channels {
                let own = shade(&nu.light[c], s.normal);
                let scale = own.max(0.15 * mean[c]) / share;
                let stain: f64 = 1.0 + axes.iter().zip(&told).map(|(a, t)| a[c] * t[i]).sum::<f64>();
                let r = (s.light[c] - own * stain) / scale;
                let sl = slope(&nu.light[c], s.normal);
                let tangent = (sl - s.normal * sl.dot(s.normal)) * (stain / (s.length * scale));
                let g = DVec2::new(s.gradient[0][c], s.gradient[1][c]) * (with_gradient / scale);
                group_r[c] += r;
                tilts += (tangent * s.length).length_squared() / share;
                by_channel.push((r, tangent, g, stain / scale, own));
            }
            let h = harmonics(s.normal);
            for u in 0..channels {
                let mut row = rows[u].column_mut(i);
                let row = row.as_mut_slice();
                let mut r = 0.0;
                let mut tangent = DVec3::ZERO;
                let mut g = DVec2::ZERO;
                for (c, b) in by_channel.iter().enumerate() {
                    let a = axes[u][c];
                    r += a * b.0;
                    tangent += b.1 * a;
                    g += b.2 * a;
                    for t in 0..HARMONICS { row[c * HARMONICS + t] -= a * h[t] * b.3; }
                }
                residuals[u][i] += r;
                if only_light { continue; }
                // How the residual moves with each vertex.
                let by_own = DVec3::new(s.by_point[0].dot(g), s.by_point[1].dot(g), s.by_point[2].dot(g));
                let count = sample.ring.len();
                let mut add = |place: usize, a: DVec3| {
                    let a32 = a.as_vec3();
                    for (to, r) in row[lights..lights + k].iter_mut().zip(p.surface.rates(place)) {
                        *to += f64::from(r.dot(a32));
                    }
                    let v = p.surface.vertices[place];
                    for (to, &e) in row[lights + k..].iter_mut().zip(active) {
                        let x = &self.list[e];
                        if let Ok(slot) = x.support.binary_search(&v) {
                            *to += x.displacements[slot].as_dvec3().dot(a);
                        }
                    }
                };
                add(sample.own, by_own);
                for j in 0..count {
                    let before = positions[sample.ring[(j + count - 1) % count]];
                    let after = positions[sample.ring[(j + 1) % count]];
                    // d(sum p_i x p_i+1) = dp_j x (p_j+1 - p_j-1); what is taken off: -tangent.
                    add(sample.ring[j], -(after - before).cross(tangent));
                }
                for (to, d) in row[lights + k + active.len()..].iter_mut().zip(&s.by_pose) {
                    *to += d.dot(g);
                }
            }
            }
            tilts /= channels as f64;
            let base = if only_light { variance0 } else { (sigma * sigma + nsd * tilts) * (usual / area).max(0.5) + infl * p.albedo.left[g] };
            for u in 0..channels {
                let r: f64 = (0..channels).map(|c| axes[u][c] * group_r[c]).sum();
                square += r * r / (base * lambda[u]);
            }
            let weight = (dof + channels as f64) / (dof + square);
            wsum += weight;
            roots[i] = (weight / base).sqrt();
        }
        let _ = state;
        let mut weighted = anchors;
        for (mut column, root) in weighted.column_iter_mut().zip(roots.iter()) { column *= *root; }
        let square = if only_light { DMatrix::zeros(0, 0) } else { &weighted * weighted.transpose() };
        let mut curvature = DMatrix::zeros(raw, raw);
        let mut gradient = DVector::zeros(raw);
        let mut eliminated = Vec::new();
        let mut residual_rms = Vec::new();
        for u in 0..channels {
            let mut j = std::mem::replace(&mut rows[u], DMatrix::zeros(0, 0));
            for (mut column, root) in j.column_iter_mut().zip(roots.iter()) { column *= *root / lambda[u].sqrt(); }
            residual_rms.push((residuals[u].norm_squared() / n as f64).sqrt());
            let r = residuals[u].component_mul(&roots) / lambda[u].sqrt();
            let across = j.transpose();
            curvature += &j * &across;
            gradient += &j * &r;
            if only_light { continue; }
            // Albedo's rows are -modes.
            let mut own = square.clone();
            for t in 0..m { own[(t, t)] += 1.0; }
            let factor = own.cholesky()?;
            let cross = -(&weighted * &across);
            let right = -(&weighted * &r) + &nu.q[u] / lambda[u].sqrt();
            let lower = factor.l();
            let mut half = cross.clone();
            lower.solve_lower_triangular_mut(&mut half);
            let mut half_r = right.clone();
            lower.solve_lower_triangular_mut(&mut half_r);
            let t = half.transpose();
            curvature -= &t * &half;
            gradient -= &t * &half_r;
            eliminated.push(Eliminated { root: lambda[u].sqrt(), factor, cross, right });
        }
        // The light's prior.
        for c in 0..channels {
            for h in 1..HARMONICS {
                let sd = mean[c] * if h > 3 { knob("V2", 0.5) } else { knob("V1", 1.0) };
                curvature[(c * HARMONICS + h, c * HARMONICS + h)] += sd.powi(-2);
                gradient[c * HARMONICS + h] += nu.light[c][h] * sd.powi(-2);
            }
            curvature[(c * HARMONICS, c * HARMONICS)] += 1e-6;
        }
        if !only_light {
            // From the model's coefficients to the unknowns.
            let count = self.terms.count();
            let z = self.terms.coefficients;
            let mut map = DMatrix::zeros(raw, lights + count + POSE);
            for i in 0..lights { map[(i, i)] = 1.0; }
            map.view_mut((lights, lights), (k, z)).copy_from(self.basis);
            for (a, &e) in active.iter().enumerate() { map[(lights + k + a, lights + z + e)] = 1.0; }
            for i in 0..POSE { map[(lights + k + active.len() + i, lights + count + i)] = 1.0; }
            let t = map.transpose();
            curvature = &t * (curvature * &map);
            gradient = &t * gradient;
            for e in &mut eliminated { e.cross = &e.cross * &map; }
        }
        Some(Bordered { curvature, gradient, eliminated, residual_rms, weight: wsum / n as f64 })
    }
}

struct Eliminated {
    root: f64,
    factor: nalgebra::Cholesky<f64, nalgebra::Dyn>,
    cross: DMatrix<f64>,
    right: DVector<f64>,
}

struct Bordered {
    curvature: DMatrix<f64>,
    gradient: DVector<f64>,
    eliminated: Vec<Eliminated>,
    residual_rms: Vec<f64>,
    weight: f64,
}

#[allow(dead_code)]
fn unused(p: &Pose, s: &Seen) -> DVec2 { let _ = p; s.at }
