//! The changed photo, by the processor.

use std::ops::Range;

use super::Field;
use crate::Result;
use crate::photo::Image;
use crate::srgb;

/// Of a colour's value: three channels in one number, so that one multiplication is three. A sum of
/// taps has a channel within -2^20 and 2^20.
const LANE: u32 = 21;
/// Bits of a tap's weight: with their signs the weights sum to less than 1.6 in size, times 255 times
/// 2^11 within a lane.
const WEIGHT: u32 = 11;
/// Bits of a value besides the eight of a byte when its light is looked up.
const FINE: u32 = 3;
/// Steps of linear light that are told apart when it is encoded again: half a step of a byte in the
/// darkest tones, where the encoding is steepest (12.92), is 1/6589.
const STEPS: usize = 8192;
/// A gain that is nearer to 1 changes no byte.
const UNLIT: f32 = 1e-3;

/// Light and bytes.
struct Tone {
    /// The linear light of each value, in steps.
    linear: Vec<f32>,
    /// The byte of each of the steps of linear light from 0 to 1.
    encoded: Vec<u8>,
}

impl Tone {
    fn new() -> Self {
        let fine = 1 << FINE;
        let linear = (0..=255 * fine).map(|value| {
            let (byte, part) = (
                (value / fine) as u8,
                f64::from(value % fine) / f64::from(fine),
            );
            let [low, high] = [byte, byte.saturating_add(1)].map(srgb::light);
            ((low + part * (high - low)) * STEPS as f64) as f32
        });
        let encoded = (0..=STEPS).map(|i| srgb::byte(i as f64 / STEPS as f64));
        Self {
            linear: linear.collect(),
            encoded: encoded.collect(),
        }
    }

    /// The byte of a sum of taps, times a factor in linear light.
    fn byte(&self, sum: i64, gain: f32) -> u8 {
        if (gain - 1.0).abs() < UNLIT {
            return ((sum + (1 << (WEIGHT - 1))) >> WEIGHT).clamp(0, 255) as u8;
        }
        let bits = WEIGHT - FINE;
        let value = ((sum + (1 << (bits - 1))) >> bits).clamp(0, 255 << FINE);
        let light = self.linear[value as usize] * gain + 0.5;
        self.encoded[(light as usize).min(STEPS)]
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

/// Motion and gain.
type Change = [f32; 5];

impl Field {
    /// The photo that is changed so: pixels as they were given. Where nothing moves they are the same.
    ///
    /// `scale` is how many px of this photo are one of the photo that the field is of.
    pub fn render(&self, image: &Image, scale: f64) -> Vec<u8> {
        let mut rgba = image.rgba.to_vec();
        self.draw([image.width, image.height], &mut rgba, scale);
        rgba
    }

    /// The same in the place of the photo's own pixels, `width` x `height` of them: of a large photo there is no second
    /// one in memory, only the rows that are read for one.
    ///
    /// # Errors
    /// As [`Image::new`].
    pub fn render_in_place(&self, size: [u32; 2], rgba: &mut [u8], scale: f64) -> Result<()> {
        let Image { width, height, .. } = Image::new(size[0], size[1], rgba)?;
        self.draw([width, height], rgba, scale);
        Ok(())
    }

    fn draw(&self, [width, height]: [usize; 2], rgba: &mut [u8], scale: f64) {
        let tone = Tone::new();
        let step = self.step * scale;
        // The pixels whose middles are between nodes, and where.
        let between = |origin: f64, nodes: usize, pixels: usize| -> Vec<(usize, usize, f32)> {
            let first = (origin * scale - 0.5).ceil().max(0.0) as usize;
            let end = (origin * scale + (nodes - 1) as f64 * step - 0.5).floor() + 1.0;
            let range = first..(end.max(0.0) as usize).min(pixels);
            let each = range.map(|pixel| {
                let at = (pixel as f64 + 0.5 - origin * scale) / step;
                let node = (at as usize).min(nodes - 2);
                (pixel, node, (at - node as f64) as f32)
            });
            each.collect()
        };
        let columns = between(self.origin.x, self.columns, width);
        let (Some(&(first, ..)), Some(&(last, ..))) = (columns.first(), columns.last()) else {
            return;
        };
        // Along an axis, px: how far back and ahead of a pixel others are read, four taps each, and one more on either
        // side for what rounding does. Nowhere less than none: what is drawn has been read.
        let reach = |axis: usize, most: usize| -> [usize; 2] {
            let motion = self.motion.iter().map(|m| m[axis] * scale as f32);
            let [back, ahead] = motion.fold([0.0_f32; 2], |[back, ahead], m| {
                [back.max(-m), ahead.max(m)]
            });
            [back.ceil() as usize, ahead.floor() as usize].map(|px| px.min(most))
        };
        let read = |[back, ahead]: [usize; 2], from: usize, to: usize, most: usize| {
            from.saturating_sub(back + 2)..(to + ahead + 4).min(most)
        };
        let [sideways, along] = [reach(0, width), reach(1, height)];
        let rows = (along[0] + along[1] + 6).min(height);
        let mut band = Band::new(read(sideways, first, last, width), rows);
        for (y, row, down) in between(self.origin.y, self.rows, height) {
            band.go_to(read(along, y, y, height), rgba, width);
            let upper = row * self.columns;
            let lower = upper + self.columns;
            // Along a row of pixels what changes is linear between two columns of nodes.
            let line: Vec<Option<Change>> = (upper..lower)
                .map(|node| self.mixed(node, node + self.columns, down))
                .collect();
            for &(x, column, right) in &columns {
                let (from, to) = match (line[column], line[column + 1]) {
                    (None, None) => continue,
                    (from, to) => (from.unwrap_or(STILL), to.unwrap_or(STILL)),
                };
                let [dx, dy, gain @ ..]: Change =
                    std::array::from_fn(|i| from[i] + right * (to[i] - from[i]));
                let [dx, dy] = [dx, dy].map(|d| d * scale as f32);
                let sums = band.sample(x, y, dx, dy);
                let pixel = &mut rgba[4 * (y * width + x)..][..3];
                for channel in 0..3 {
                    pixel[channel] = tone.byte(sums[channel], gain[channel]);
                }
            }
        }
    }

    /// Between two nodes; nothing when neither does anything.
    fn mixed(&self, from: usize, to: usize, part: f32) -> Option<Change> {
        let change = |node: usize| {
            let ([x, y], [r, g, b]) = (self.motion[node], self.gain[node]);
            [x, y, r, g, b]
        };
        let (from, to) = (change(from), change(to));
        let mixed = std::array::from_fn(|i| from[i] + part * (to[i] - from[i]));
        (from != STILL || to != STILL).then_some(mixed)
    }
}

/// No change.
const STILL: Change = [0.0, 0.0, 1.0, 1.0, 1.0];

/// Rows of an image, each pixel's colour in one number, that go down with what is drawn.
struct Band {
    columns: Range<usize>,
    rows: Range<usize>,
    colours: Vec<i64>,
}

impl Band {
    /// With room for so many rows at a time.
    fn new(columns: Range<usize>, rows: usize) -> Self {
        // And for those that are not let go of yet.
        let room = columns.len() * (rows + rows / 2 + 1);
        Self {
            columns,
            rows: 0..0,
            colours: Vec::with_capacity(room),
        }
    }

    /// Reads more rows of an image down to the end of some, and lets go of those above.
    fn go_to(&mut self, rows: Range<usize>, rgba: &[u8], width: usize) {
        if self.colours.is_empty() {
            self.rows = rows.start..rows.start;
        }
        // Half of all at once, so that each is moved twice and not always.
        let gone = rows.start.saturating_sub(self.rows.start);
        if 2 * gone > rows.len() {
            self.colours.drain(..gone * self.columns.len());
            self.rows.start = rows.start;
        }
        for y in self.rows.end..rows.end {
            let first = 4 * (y * width + self.columns.start);
            let pixels = rgba[first..first + 4 * self.columns.len()].chunks_exact(4);
            self.colours.extend(pixels.map(|p| {
                i64::from(p[0]) + (i64::from(p[1]) << LANE) + (i64::from(p[2]) << (2 * LANE))
            }));
        }
        self.rows.end = rows.end.max(self.rows.end);
    }

    /// The sums of the taps at a pixel's middle moved by some px, in units of 1 / 2^[`WEIGHT`] of a
    /// byte's; beyond the border is the border's colour.
    fn sample(&self, x: usize, y: usize, dx: f32, dy: f32) -> [i64; 3] {
        let (left, across) = split(dx);
        let (top, down) = split(dy);
        // From the first that is kept.
        let first = |at: usize, by: isize, kept: &Range<usize>| {
            (at as isize - 1 - kept.start as isize).saturating_add(by)
        };
        let (x, y) = (first(x, left, &self.columns), first(y, top, &self.rows));
        let weights = products(across, down);
        let (width, height) = (self.columns.len(), self.rows.len());
        let mut sum = 0;
        if x >= 0 && y >= 0 && x as usize + 4 <= width && y as usize + 4 <= height {
            let mut at = y as usize * width + x as usize;
            for row in weights {
                let taps = &self.colours[at..at + 4];
                sum += taps[0] * row[0] + taps[1] * row[1] + taps[2] * row[2] + taps[3] * row[3];
                at += width;
            }
        } else {
            let clamp = |from: isize, i: usize, most: usize| {
                from.saturating_add(i as isize).clamp(0, most as isize - 1) as usize
            };
            for (j, row) in weights.into_iter().enumerate() {
                let line = clamp(y, j, height) * width;
                for (i, weight) in row.into_iter().enumerate() {
                    sum += self.colours[line + clamp(x, i, width)] * weight;
                }
            }
        }
        // The lowest channel's sign has gone into the next, and so on.
        let sign = |lane: i64| (lane << (64 - LANE)) >> (64 - LANE);
        let red = sign(sum);
        let rest = (sum - red) >> LANE;
        let green = sign(rest);
        [red, green, (rest - green) >> LANE]
    }
}

/// Whole px, and the weights for what is left.
fn split(by: f32) -> (isize, [f32; 4]) {
    let whole = by.floor();
    (whole as isize, weights(by - whole))
}

/// The weights of 4 x 4 taps, whole numbers that sum to 2^[`WEIGHT`]: what rounding leaves over goes to
/// the tap nearest to the middle.
fn products(across: [f32; 4], down: [f32; 4]) -> [[i64; 4]; 4] {
    let one = (1 << WEIGHT) as f32;
    let products = down.map(|d| across.map(|a| (a * d * one).round_ties_even() as i64));
    let mut products = products;
    let sum: i64 = products.as_flattened().iter().sum();
    let nearest = |w: [f32; 4]| 1 + usize::from(w[2] > w[1]);
    products[nearest(down)][nearest(across)] += (1 << WEIGHT) - sum;
    products
}
