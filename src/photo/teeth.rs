//! Whether teeth are all that a photo shows between lips: then the jaw is shut, however far the lips are apart.
//!
//! The points of a smile do not tell how far the jaw is open: lips that part by a centimetre may be drawn from shut
//! teeth, or go with a jaw that fell, on a shorter chin. The prior of expressions prefers the jaw, which explains all
//! of it at once. People who look into cameras have their teeth shut.

use glam::DVec2;

use super::light::Image;
use super::median;
use crate::srgb::BRIGHTNESS;

/// Lips are apart when what is between them is at least this part as high as it is wide, and so many px.
const APART: (f64, f64) = (0.1, 4.0);
/// So many columns between the inner points of the lips are looked at, each at so many places, but for this part
/// at either end, which is lip.
const COLUMNS: usize = 9;
const PLACES: usize = 24;
const EDGE: f64 = 0.12;
/// A tooth is less red than the lips by this part of what they are redder than grey, and not much darker; or
/// it is brighter by far.
const PALER: f64 = 0.3;
const SHADED: f64 = 0.7;
const BRIGHT: f64 = 1.4;
/// Below the upper teeth so much of a column may be none, as lips cast shadows on teeth and the lower row's edges are
/// seen: all is shut up to the first of these, open from the second.
const GAP: [f64; 2] = [0.22, 0.42];

/// How far teeth that are shut are all that is seen, 0..=1, between the lips of these 68 points (px); 0 when the lips
/// are not apart or outside of the image.
pub(super) fn shut(image: &Image, points: &[DVec2]) -> f64 {
    gap(image, points).map_or(0.0, |gap| {
        1.0 - ((gap - GAP[0]) / (GAP[1] - GAP[0])).clamp(0.0, 1.0)
    })
}

/// The part of the columns below the upper teeth's first pixels that is none.
fn gap(image: &Image, points: &[DVec2]) -> Option<f64> {
    let upper = [61, 62, 63].map(|i| points[i]);
    let lower = [67, 66, 65].map(|i| points[i]);
    let high = upper.iter().zip(&lower).map(|(a, b)| a.distance(*b));
    let high = high.sum::<f64>() / 3.0;
    let wide = points[60].distance(points[64]);
    if high < APART.1 || high < APART.0 * wide {
        return None;
    }
    // The middles of both lips.
    let lips = [(50, 61), (51, 62), (52, 63), (58, 67), (57, 66), (56, 65)];
    let lips: Option<Vec<_>> = (lips.iter())
        .map(|&(a, b)| image.at((points[a] + points[b]) / 2.0))
        .collect();
    let lip = median(lips?.into_iter());
    let redness = lip.x / lip.y.max(1e-4);
    let light = lip.dot(BRIGHTNESS);
    let is_tooth = |at: DVec2| {
        let seen = image.at(at)?;
        let pale = seen.x < seen.y * (redness - PALER * (redness - 1.0).max(0.0));
        let own = seen.dot(BRIGHTNESS);
        Some((pale && own > SHADED * light) || own > BRIGHT * light)
    };
    let mut gaps = Vec::with_capacity(COLUMNS);
    for column in 0..COLUMNS {
        let across = 2.0 * column as f64 / (COLUMNS - 1) as f64;
        let on = |line: &[DVec2; 3]| {
            let from = (across as usize).min(1);
            line[from].lerp(line[from + 1], across - from as f64)
        };
        let [top, bottom] = [on(&upper), on(&lower)];
        let place = |i: usize| {
            let part = (i as f64 + 0.5) / PLACES as f64;
            top.lerp(bottom, EDGE + (1.0 - 2.0 * EDGE) * part)
        };
        let teeth: Option<Vec<bool>> = (0..PLACES).map(|i| is_tooth(place(i))).collect();
        let teeth = teeth?;
        // Above them is gum, or the upper lip's shadow.
        let first = teeth.iter().position(|&tooth| tooth);
        gaps.push(first.map_or(1.0, |first| {
            let below = &teeth[first..];
            below.iter().filter(|tooth| !**tooth).count() as f64 / PLACES as f64
        }));
    }
    gaps.sort_unstable_by(f64::total_cmp);
    Some(gaps[COLUMNS / 2])
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: u32 = 100;

    /// The 68 points of a mouth whose inner line is a 40 x 16 px ellipse in the middle of an image.
    fn mouth() -> Vec<DVec2> {
        let mut points = vec![DVec2::ZERO; super::super::POINTS];
        let on = |half: DVec2, turn: f64| DVec2::splat(50.0) + half * DVec2::from_angle(turn);
        for i in 0..12 {
            // From the subject's right corner over the upper lip.
            let turn = std::f64::consts::PI * (1.0 + i as f64 / 6.0);
            points[48 + i] = on(DVec2::new(26.0, 16.0), turn);
        }
        for i in 0..8 {
            let turn = std::f64::consts::PI * (1.0 + i as f64 / 4.0);
            points[60 + i] = on(DVec2::new(20.0, 8.0), turn);
        }
        points
    }

    /// Skin and lips, and between them what is there of how far down, 0..=1.
    fn shown(light: f64, inside: impl Fn(f64) -> [f64; 3]) -> f64 {
        let mut rgba = Vec::new();
        for y in 0..SIZE {
            for x in 0..SIZE {
                let from = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) - 50.0;
                let colour = if (from / DVec2::new(20.0, 8.0)).length() < 1.0 {
                    inside((from.y + 8.0) / 16.0)
                } else if (from / DVec2::new(26.0, 16.0)).length() < 1.0 {
                    [190.0, 110.0, 105.0]
                } else {
                    [215.0, 170.0, 150.0]
                };
                rgba.extend(colour.map(|c| (c * light) as u8).iter().chain(&[255]));
            }
        }
        let image = Image::new(SIZE, SIZE, &rgba).unwrap();
        shut(&image, &mouth())
    }

    const TEETH: [f64; 3] = [215.0, 205.0, 185.0];
    const DARK: [f64; 3] = [60.0, 25.0, 25.0];
    const TONGUE: [f64; 3] = [180.0, 100.0, 95.0];

    #[test]
    fn teeth_are_shut_when_nothing_else_is_seen() {
        for light in [1.0, 0.6, 0.3] {
            assert_eq!(shown(light, |_| TEETH), 1.0, "teeth in a light of {light}");
            // Gums above them are no gap.
            let gummy = |y| if y < 0.35 { TONGUE } else { TEETH };
            assert_eq!(shown(light, gummy), 1.0, "gums in a light of {light}");
            let laugh = |y| if y < 0.5 { TEETH } else { DARK };
            assert_eq!(shown(light, laugh), 0.0, "a gap in a light of {light}");
            let both = |y| match y {
                0.35..0.75 => TONGUE,
                _ => TEETH,
            };
            assert_eq!(shown(light, both), 0.0, "a tongue in a light of {light}");
            assert_eq!(shown(light, |_| DARK), 0.0);
            assert_eq!(shown(light, |_| TONGUE), 0.0);
        }
    }

    #[test]
    fn lips_that_are_shut_say_nothing() {
        let rgba = vec![200; 4 * (SIZE * SIZE) as usize];
        let image = Image::new(SIZE, SIZE, &rgba).unwrap();
        let mut points = mouth();
        for p in &mut points[60..] {
            p.y = 50.0;
        }
        assert_eq!(shut(&image, &points), 0.0);
        // Nor does a mouth outside of the image.
        let far: Vec<DVec2> = mouth().iter().map(|p| *p + 1000.0).collect();
        assert_eq!(shut(&image, &far), 0.0);
    }
}
