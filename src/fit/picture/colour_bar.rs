//! Lengths as colours, and the bar that says which is which.

use super::render::Image;

/// Anchors of the "inferno" scale (van der Walt and Smith, matplotlib), evenly spaced but for the
/// darkest: dark is none, and brightness rises evenly, so that it reads without colour too.
const SCALE: [[f64; 3]; 8] = [
    [20.0, 12.0, 53.0],
    [65.0, 10.0, 104.0],
    [106.0, 23.0, 110.0],
    [147.0, 38.0, 103.0],
    [188.0, 55.0, 84.0],
    [221.0, 81.0, 58.0],
    [243.0, 120.0, 25.0],
    [252.0, 200.0, 60.0],
];

/// Digits, and what else stands on a bar, as seven rows of five dots.
const GLYPHS: [(char, [u8; 7]); 13] = [
    ('0', [14, 17, 17, 17, 17, 17, 14]),
    ('1', [4, 12, 4, 4, 4, 4, 14]),
    ('2', [14, 17, 1, 6, 8, 16, 31]),
    ('3', [14, 17, 1, 6, 1, 17, 14]),
    ('4', [2, 6, 10, 18, 31, 2, 2]),
    ('5', [31, 16, 30, 1, 1, 17, 14]),
    ('6', [6, 8, 16, 30, 17, 17, 14]),
    ('7', [31, 1, 2, 4, 8, 8, 8]),
    ('8', [14, 17, 17, 14, 17, 17, 14]),
    ('9', [14, 17, 17, 15, 1, 2, 12]),
    ('.', [0, 0, 0, 0, 0, 12, 12]),
    ('m', [0, 0, 26, 21, 21, 21, 21]),
    ('>', [8, 4, 2, 1, 2, 4, 8]),
];

/// The colour of a length between none and `largest`; longer ones have the colour of that.
pub fn colour(length: f64, largest: f64) -> [u8; 3] {
    let x = (length / largest).clamp(0.0, 1.0) * (SCALE.len() - 1) as f64;
    let (low, part) = (x as usize, x.fract());
    let high = (low + 1).min(SCALE.len() - 1);
    std::array::from_fn(|c| (SCALE[low][c] + (SCALE[high][c] - SCALE[low][c]) * part).round() as u8)
}

/// A picture with the bar on a white strip below it.
pub fn below(image: &Image, largest: f64) -> Image {
    const STRIP: usize = 50;
    let mut taller = image.clone();
    taller.height += STRIP;
    (taller.pixels).resize(taller.width * taller.height, [255; 3]);
    draw(&mut taller, largest);
    taller
}

/// Draws the bar from nothing to `largest` mm along the lower edge of a picture, with five steps.
pub fn draw(image: &mut Image, largest: f64) {
    const HEIGHT: usize = 12;
    let (left, width) = (image.width / 10, image.width * 8 / 10);
    let top = image.height.saturating_sub(HEIGHT + 30);
    for y in top..(top + HEIGHT).min(image.height) {
        for x in 0..width {
            image.pixels[y * image.width + left + x] = colour(x as f64, width as f64);
        }
    }
    for step in 0..=5 {
        let (unit, more) = if step == 5 { (" mm", ">") } else { ("", "") };
        let text = format!("{more}{:.1}{unit}", largest * f64::from(step) / 5.0);
        let at = left + width * step as usize / 5;
        let half = 6 * text.chars().count();
        let end = image.width.saturating_sub(2 * half + 2);
        write(
            image,
            [at.saturating_sub(half).min(end), top + HEIGHT + 6],
            &text,
        );
    }
}

/// Writes a line of text with dots of two pixels; characters without a glyph are blank.
fn write(image: &mut Image, [left, top]: [usize; 2], text: &str) {
    for (place, character) in text.chars().enumerate() {
        let Some((_, rows)) = GLYPHS.iter().find(|(c, _)| *c == character) else {
            continue;
        };
        for y in 0..14 {
            for x in 0..10 {
                let (row, column) = (top + y, left + 12 * place + x);
                let dot = rows[y / 2] >> (4 - x / 2) & 1 == 1;
                if dot && row < image.height && column < image.width {
                    image.pixels[row * image.width + column] = [40, 40, 44];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brightness_rises_with_length() {
        // Luma of sRGB, Rec. 709.
        let luma = |x: f64| {
            let [r, g, b] = colour(x, 1.0).map(f64::from);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        for step in 0..50 {
            assert!(luma(f64::from(step) / 50.0) < luma(f64::from(step + 1) / 50.0));
        }
        assert_eq!(colour(7.0, 1.0), colour(1.0, 1.0));
    }

    #[test]
    fn a_bar_stays_in_its_picture() {
        for (width, height) in [(400, 300), (30, 20), (1, 1)] {
            let mut image = Image {
                width,
                height,
                pixels: vec![[255; 3]; width * height],
            };
            draw(&mut image, 2.0);
            let drawn = image.pixels.iter().filter(|p| **p != [255; 3]).count();
            assert!(drawn > 0 || width == 1);
        }
    }
}
