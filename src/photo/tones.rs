//! The tones of skin, the logarithms of (albedo / model's colour), beyond what a photo shows of it, and from photo to photo.

use glam::DVec3;

use super::median;
use super::skin::{FEWEST, Skin};
use crate::srgb::BRIGHTNESS;

/// Smoothing passes over the mesh: tones are continued over some 40 mm, and the rest is drawn to the
/// usual one.
const PASSES: usize = 120;
/// How strongly an unseen vertex is drawn to the usual tone, of its neighbours' pull.
const USUAL: f64 = 0.01;
/// What is believed less than this is not asked how tones differ there.
const SEEN: f64 = 0.1;
/// Tones of two photos that differ by the first of these logarithms more than they usually do are doubted, and not believed
/// by the second.
const ANOTHER: [f64; 2] = [0.2, 0.5];
/// Smoothing passes over how tones differ: what is smaller than some 10 mm is left to each photo.
const BLURRED: usize = 8;

/// The logarithm of (albedo / model's colour) of each vertex, all over the mesh: that of bare skin at brows. And the
/// usual one.
pub(super) fn all_round(skin: &Skin, brow: &[bool]) -> (Vec<DVec3>, DVec3) {
    let mut known = skin.seen_tones();
    known.retain(|k| skin.trust[k.0] > 0.8 && !brow[k.0]);
    let usual = median(known.iter().filter(|k| skin.beardless(k.0)).map(|k| k.1));
    let mut tones = vec![usual; skin.trust.len()];
    let mut is_known = vec![false; tones.len()];
    let mirror = &skin.model.parts().topology.mirror;
    for &(v, tone) in &known {
        tones[v] = tone;
        is_known[v] = true;
    }
    for &(v, tone) in &known {
        let other = mirror[v] as usize;
        if !is_known[other] {
            tones[other] = tone;
        }
    }
    let seen: Vec<bool> = (0..tones.len())
        .map(|v| is_known[v] || is_known[mirror[v] as usize])
        .collect();
    let is_next = |v: usize| !seen[v];
    continued(skin, &mut tones, &is_next, PASSES, usual);
    (tones, usual)
}

/// Makes the logarithms of tones at some vertices of the skin smoothly follow their neighbours'.
fn continued(
    skin: &Skin,
    tones: &mut [DVec3],
    is_next: &dyn Fn(usize) -> bool,
    passes: usize,
    usual: DVec3,
) {
    let all = skin.model.parts().topology.part_vertices("skin");
    let neighbours = skin.neighbours();
    for _ in 0..passes {
        for &v in &all {
            let v = v as usize;
            if !is_next(v) || neighbours[v].is_empty() {
                continue;
            }
            let sum: DVec3 = neighbours[v].iter().map(|&n| tones[n as usize]).sum();
            let count = neighbours[v].len() as f64;
            tones[v] = (sum / count + usual * USUAL) / (1.0 + USUAL);
        }
    }
}

/// The logarithm of the way from the tones of a photo to those of the first, at each vertex, and how far it is believed
/// there. The way is how they differ but for what is small, which is in one place of one and beside it in the other. Where
/// the first does not show the skin its tones are those that it has around: lights are told worst at the sides of faces, and
/// how the skin differs there in the large nobody knows. What differs by much is a shadow or hair.
pub(super) fn between(first: &Skin, fill: &[DVec3], other: &Skin) -> Vec<(DVec3, f64)> {
    let least = DVec3::splat(1e-3);
    let differs = (0..other.trust.len()).filter_map(|v| {
        let seen = other.vertex(v).filter(|_| other.trust[v] > SEEN)?;
        let own = first.vertex(v).unwrap_or_default();
        let own = fill[v].lerp(own, first.trust[v]);
        Some((v, (own.max(least) / seen.max(least)).map(f64::ln)))
    });
    let differs: Vec<(usize, DVec3)> = differs.collect();
    let both = differs.iter().filter(|d| first.trust[d.0] > 0.5);
    let both: Vec<DVec3> = both.map(|d| d.1).collect();
    let usual = match both.len() < FEWEST {
        true => median(differs.iter().map(|d| d.1)),
        false => median(both.into_iter()),
    };
    let mut gain = vec![usual; other.trust.len()];
    let mut is_known = vec![false; gain.len()];
    let limit = DVec3::splat(ANOTHER[1]);
    for (v, own) in differs {
        gain[v] = usual + (own - usual).clamp(-limit, limit);
        is_known[v] = true;
    }
    continued(other, &mut gain, &|v| !is_known[v], PASSES, usual);
    continued(other, &mut gain, &|_| true, BLURRED, usual);
    let believed = |gain: DVec3| {
        let off = (gain - usual).dot(BRIGHTNESS).abs();
        let much = (off - ANOTHER[0]) / (ANOTHER[1] - ANOTHER[0]);
        (gain, 1.0 - much.clamp(0.0, 1.0))
    };
    gain.into_iter().map(believed).collect()
}
