//! The changed photo, by the processor.

use super::Field;
use crate::photo::Image;
use crate::photo::light::{encoded, linear_byte};

/// Steps of linear light that are told apart when it is encoded again: half a step of a byte in the
/// darkest tones, where the encoding is steepest (12.92), is 1/6589.
const STEPS: usize = 8192;

/// Light and bytes.
struct Tone {
    /// The linear light of each byte.
    linear: [f32; 256],
    /// The byte, with fractions, of each of the steps of linear light from 0 to 1.
    encoded: Vec<f32>,
}

impl Tone {
    fn new() -> Self {
        let steps = (0..=STEPS).map(|i| {
            let light = i as f64 / STEPS as f64;
            (255.0 * encoded(light)) as f32
        });
        Self {
            linear: std::array::from_fn(|byte| linear_byte(byte as u8) as f32),
            encoded: steps.collect(),
        }
    }

    /// A value of 0 to 255 in linear light times a factor, encoded again.
    fn scaled(&self, value: f32, gain: f32) -> f32 {
        let value = value.clamp(0.0, 255.0);
        let below = (value as usize).min(254);
        let part = value - below as f32;
        let light = self.linear[below] + part * (self.linear[below + 1] - self.linear[below]);
        let at = (light * gain).min(1.0) * STEPS as f32;
        let below = (at as usize).min(STEPS - 1);
        self.encoded[below] + (at - below as f32) * (self.encoded[below + 1] - self.encoded[below])
    }
}

/// What four pixels in a row count at a part of the way from the second to the third (Catmull & Rom
/// 1974): unlike linear interpolation it keeps pores and hair sharp.
fn weights(t: f32) -> [f32; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [
        0.5 * (-t + 2.0 * t2 - t3),
        0.5 * (2.0 - 5.0 * t2 + 3.0 * t3),
        0.5 * (t + 4.0 * t2 - 3.0 * t3),
        0.5 * (t3 - t2),
    ]
}

impl Field {
    /// The photo that is changed so: pixels as they were given. Where nothing moves they are the same.
    ///
    /// `scale` is how many px of this photo are one of the photo that the field is of.
    pub fn render(&self, image: &Image, scale: f64) -> Vec<u8> {
        let mut out = image.rgba.to_vec();
        let tone = Tone::new();
        let step = self.step * scale;
        // The range of pixels whose middles are between nodes.
        let range = |origin: f64, nodes: usize, pixels: usize| {
            let first = (origin * scale - 0.5).ceil().max(0.0);
            let end = (origin * scale + (nodes - 1) as f64 * step - 0.5).floor() + 1.0;
            first as usize..(end.max(0.0) as usize).min(pixels)
        };
        let xs = range(self.origin.x, self.columns, image.width);
        let between = |pixel: usize, origin: f64, nodes: usize| {
            let at = (pixel as f64 + 0.5 - origin * scale) / step;
            let node = (at as usize).min(nodes - 2);
            (node, (at - node as f64) as f32)
        };
        let columns: Vec<(usize, f32)> = (xs.clone())
            .map(|x| between(x, self.origin.x, self.columns))
            .collect();
        for y in range(self.origin.y, self.rows, image.height) {
            let (row, down) = between(y, self.origin.y, self.rows);
            for (x, &(column, right)) in xs.clone().zip(&columns) {
                let node = row * self.columns + column;
                let corners = [node, node + 1, node + self.columns, node + self.columns + 1];
                if corners.iter().all(|&n| self.is_still(n)) {
                    continue;
                }
                let shares = [
                    (1.0 - right) * (1.0 - down),
                    right * (1.0 - down),
                    (1.0 - right) * down,
                    right * down,
                ];
                let mut motion = [0.0; 2];
                let mut gain = [0.0; 3];
                for (&corner, share) in corners.iter().zip(shares) {
                    (motion.iter_mut().zip(&self.motion[corner]))
                        .for_each(|(m, n)| *m += share * n);
                    (gain.iter_mut().zip(&self.gain[corner])).for_each(|(g, n)| *g += share * n);
                }
                let [dx, dy] = motion.map(|m| m * scale as f32);
                let values = image.sample(x, y, dx, dy);
                let pixel = &mut out[4 * (y * image.width + x)..][..3];
                for channel in 0..3 {
                    let value = tone.scaled(values[channel], gain[channel]);
                    pixel[channel] = (value + 0.5) as u8;
                }
            }
        }
        out
    }

    fn is_still(&self, node: usize) -> bool {
        self.motion[node] == [0.0; 2] && self.gain[node] == [1.0; 3]
    }
}

impl Image<'_> {
    /// The colour at a pixel's middle moved by some px, 0 to 255; beyond the border it is the border's.
    fn sample(&self, x: usize, y: usize, dx: f32, dy: f32) -> [f32; 3] {
        let split = |pixel: usize, by: f32, most: usize| {
            let whole = by.floor();
            let clamp = |i: isize| i.clamp(0, most as isize - 1) as usize;
            let first = pixel as isize + whole as isize;
            (
                [first - 1, first, first + 1, first + 2].map(clamp),
                weights(by - whole),
            )
        };
        let (xs, across) = split(x, dx, self.width);
        let (ys, down) = split(y, dy, self.height);
        let mut sum = [0.0; 3];
        for (y, weight) in ys.into_iter().zip(down) {
            let row = y * self.width;
            let mut line = [0.0; 3];
            for (x, weight) in xs.into_iter().zip(across) {
                let pixel = &self.rgba[4 * (row + x)..][..3];
                for channel in 0..3 {
                    line[channel] += weight * f32::from(pixel[channel]);
                }
            }
            for channel in 0..3 {
                sum[channel] += weight * line[channel];
            }
        }
        sum
    }
}
