//! Grain: what a photo in little light is made of, and a head in good light would show.
//!
//! The grain is told by how far pixels of skin are from the mean of their neighbours' neighbours
//! (Immerkaer 1996, "Fast noise variance estimation"), by the median, which edges do not change. Then
//! every pixel becomes a mean of those around it that differ by no more than grain does (Tomasi &
//! Manduchi 1998, "Bilateral filtering for gray and color images"): brightness over a small window,
//! colour, of which the eye sees no detail and sensors tell little, over a larger one.

use super::Image;
use crate::srgb::BRIGHTNESS;

/// Grain whose standard deviation is below the first, in bytes of what is shown, is not seen; from the
/// second on it is taken off wholly. Portraits in daylight have up to 2, of pores and hair.
const SEEN: [f64; 2] = [3.0, 6.0];
/// What differs by so many standard deviations counts a quarter.
const ALIKE: f32 = 3.0;
/// How far means reach, px: of brightness, of colour.
const REACH: [usize; 2] = [4, 8];
/// A picture of more pixels a side is as well told by the means of some: a head wears fewer.
const FINEST: usize = 640;

/// A picture: brightness, and how far blue and red are from it, bytes.
struct Planes {
    width: usize,
    height: usize,
    planes: [Vec<f32>; 3],
    /// How much of each pixel is the person's, bytes; 0 where nothing is.
    alpha: Vec<u8>,
}

/// A picture without its grain.
pub(super) struct Smooth {
    pub width: usize,
    pub height: usize,
    /// sRGB, and the picture's alpha.
    pub rgba: Vec<u8>,
    /// So many pixels of the picture that it was are one of these, along a side.
    pub coarser: usize,
}

/// A part of a picture (corner and size, px) without its grain, where that would be seen by somebody who sees so many
/// times as much; `None` where it would not.
pub(super) fn smooth(
    image: &Image,
    [left, top]: [usize; 2],
    [width, height]: [usize; 2],
    gain: f64,
) -> Option<Smooth> {
    let coarser = width.max(height).div_ceil(FINEST).max(1);
    let picture = Planes::of(image, [left, top], [width, height], coarser)?;
    let [bright, blue, red] = [0, 1, 2].map(|plane| picture.grain(plane));
    let colour = blue.max(red);
    let seen = gain * f64::from(bright.max(0.5 * colour));
    let much = ((seen - SEEN[0]) / (SEEN[1] - SEEN[0])).clamp(0.0, 1.0) as f32;
    if much == 0.0 {
        return None;
    }
    let weights = BRIGHTNESS.as_vec3();
    let [smooth, blue, red] = picture.smooth(bright, colour, much);
    let mut rgba = Vec::with_capacity(4 * smooth.len());
    let colours = smooth.into_iter().zip(blue).zip(red);
    for (((y, b), r), &alpha) in colours.zip(&picture.alpha) {
        let g = -(weights.x * r + weights.z * b) / weights.y;
        rgba.extend([y + r, y + g, y + b].map(|value| value.round().clamp(0.0, 255.0) as u8));
        rgba.push(alpha);
    }
    Some(Smooth {
        width: picture.width,
        height: picture.height,
        rgba,
        coarser,
    })
}

impl Planes {
    /// Means of those of `coarser` x `coarser` pixels where something is; `None` of fewer than have a window.
    fn of(
        image: &Image,
        [left, top]: [usize; 2],
        [width, height]: [usize; 2],
        coarser: usize,
    ) -> Option<Self> {
        let (width, height) = (width / coarser, height / coarser);
        if width.min(height) < 3 {
            return None;
        }
        let weights = BRIGHTNESS.as_vec3();
        let mut planes = [0; 3].map(|_: i32| Vec::with_capacity(width * height));
        let mut alphas = Vec::with_capacity(width * height);
        for y in 0..height {
            for x in 0..width {
                let (mut sum, mut count, mut alpha) = ([0.0_f32; 3], 0_usize, 0_usize);
                for row in 0..coarser {
                    let first = (top + y * coarser + row) * image.width + left + x * coarser;
                    let pixels = image.rgba[4 * first..4 * (first + coarser)].chunks_exact(4);
                    for pixel in pixels.filter(|p| p[3] > 0) {
                        for (sum, &value) in sum.iter_mut().zip(pixel) {
                            *sum += f32::from(value);
                        }
                        alpha += usize::from(pixel[3]);
                        count += 1;
                    }
                }
                let [r, g, b] = sum.map(|sum| sum / count.max(1) as f32);
                alphas.push((alpha / (coarser * coarser)) as u8);
                let bright = weights.x * r + weights.y * g + weights.z * b;
                for (plane, value) in planes.iter_mut().zip([bright, b - bright, r - bright]) {
                    plane.push(value);
                }
            }
        }
        Some(Self {
            width,
            height,
            planes,
            alpha: alphas,
        })
    }

    /// The standard deviation of a plane's grain; 0 where nothing is.
    fn grain(&self, plane: usize) -> f32 {
        let values = &self.planes[plane];
        let mut off = Vec::with_capacity(values.len());
        for y in 1..self.height - 1 {
            for x in 1..self.width - 1 {
                let first = |dy: usize| (y + dy - 1) * self.width + x - 1;
                if (0..3).any(|dy| self.alpha[first(dy)..][..3].contains(&0)) {
                    continue;
                }
                let row = |dy: usize| &values[first(dy)..][..3];
                let across = |dy: usize| row(dy)[0] - 2.0 * row(dy)[1] + row(dy)[2];
                off.push((across(0) - 2.0 * across(1) + across(2)).abs());
            }
        }
        if off.is_empty() {
            return 0.0;
        }
        let middle = off.len() / 2;
        // The mask has a norm of 6, and half of a normal distribution is within 0.6745.
        *off.select_nth_unstable_by(middle, f32::total_cmp).1 / (6.0 * 0.6745)
    }

    /// The planes with so much (0 to 1) of their grain taken off.
    fn smooth(&self, bright: f32, colour: f32, much: f32) -> [Vec<f32>; 3] {
        let [near, far] = REACH;
        let [y, b, r] = &self.planes;
        let [smooth] = self.means(near, bright, [y]);
        let [blue, red] = self.means(far, colour, [b, r]);
        let mut planes = [smooth, blue, red];
        for (plane, before) in planes.iter_mut().zip(&self.planes) {
            for (value, before) in plane.iter_mut().zip(before) {
                *value = before + much * (*value - before);
            }
        }
        planes
    }

    /// Of each pixel the means of planes over those around it that are alike in all of them.
    fn means<const N: usize>(&self, reach: usize, grain: f32, of: [&[f32]; N]) -> [Vec<f32>; N] {
        let scale = 1.0 / (ALIKE * grain.max(0.1)).powi(2);
        // Near ones count more.
        let near: Vec<f32> = (0..=reach)
            .map(|d| (-2.0 * (d as f32 / reach as f32).powi(2)).exp())
            .collect();
        let mut out = [0; N].map(|_: i32| Vec::with_capacity(self.width * self.height));
        for y in 0..self.height {
            let rows = y.saturating_sub(reach)..(y + reach + 1).min(self.height);
            for x in 0..self.width {
                let own = of.map(|plane| plane[y * self.width + x]);
                let columns = x.saturating_sub(reach)..(x + reach + 1).min(self.width);
                let mut sums = [0.0; N];
                let mut total = 0.0;
                for row in rows.clone() {
                    let beside = near[row.abs_diff(y)];
                    for column in columns.clone() {
                        if self.alpha[row * self.width + column] == 0 {
                            continue;
                        }
                        let other = of.map(|plane| plane[row * self.width + column]);
                        let each = other.iter().zip(&own);
                        let off: f32 = each.map(|(a, b)| (a - b).powi(2)).sum();
                        let alike = 1.0 / (1.0 + off * scale);
                        let weight = beside * near[column.abs_diff(x)] * alike * alike;
                        total += weight;
                        for (sum, value) in sums.iter_mut().zip(other) {
                            *sum += weight * value;
                        }
                    }
                }
                for (out, sum) in out.iter_mut().zip(sums) {
                    out.push(if total > 0.0 { sum / total } else { 0.0 });
                }
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A step from one grey to another, with uniform noise of a standard deviation, and its picture.
    fn step(noise: f64) -> Vec<u8> {
        let mut state = 1_u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24) - 0.5
        };
        let pixel = |at: usize| if at % 64 < 32 { 40.0 } else { 90.0 };
        let noise = noise * 12_f64.sqrt();
        (0..64 * 64)
            .flat_map(|at| {
                let channels =
                    [0; 3].map(|_| (pixel(at) + noise * random()).round().clamp(0.0, 255.0) as u8);
                [channels[0], channels[1], channels[2], 255]
            })
            .collect()
    }

    #[test]
    fn grain_goes_and_edges_stay() {
        let rgba = step(6.0);
        let image = Image::new(64, 64, &rgba).unwrap();
        let clean = step(0.0);
        let off = |rgba: &[u8], columns: std::ops::Range<usize>| {
            let all = rgba.iter().zip(&clean).enumerate();
            let inside = all.filter(|(i, _)| columns.contains(&(i / 4 % 64)) && i % 4 < 3);
            let squares: Vec<f64> = inside
                .map(|(_, (&a, &b))| (f64::from(a) - f64::from(b)).powi(2))
                .collect();
            (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
        };
        let smooth = smooth(&image, [0, 0], [64, 64], 4.0).unwrap().rgba;
        assert!(off(&rgba, 0..64) > 5.5);
        // A third where it is plain, and half next to the edge, which is eight times as high as the grain.
        assert!(off(&smooth, 4..28) < 2.0, "{}", off(&smooth, 4..28));
        assert!(off(&smooth, 30..34) < 3.0, "{}", off(&smooth, 30..34));
    }

    #[test]
    fn what_nobody_sees_stays() {
        for (noise, gain) in [(0.0, 30.0), (1.5, 1.5)] {
            let rgba = step(noise);
            let image = Image::new(64, 64, &rgba).unwrap();
            assert!(smooth(&image, [0, 0], [64, 64], gain).is_none(), "{noise}");
        }
        let image = [9; 16];
        let image = Image::new(2, 2, &image).unwrap();
        assert!(smooth(&image, [0, 0], [2, 2], 4.0).is_none());
    }
}
