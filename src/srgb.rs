//! Colours as files have them, and the light that they stand for (sRGB, IEC 61966-2-1).

use std::sync::LazyLock;

use glam::DVec3;

/// How much of red, green and blue, in linear light, makes brightness.
pub(crate) const BRIGHTNESS: DVec3 = DVec3::new(0.2126, 0.7152, 0.0722);

/// The linear light, 0 to 1, of an encoded value of 0 to 1.
pub(crate) fn decode(value: f64) -> f64 {
    match value <= 0.04045 {
        true => value / 12.92,
        false => ((value + 0.055) / 1.055).powf(2.4),
    }
}

/// The encoded value, 0 to 1, of a linear light; what is below 0 or above 1 is cut off.
pub(crate) fn encode(light: f64) -> f64 {
    let light = light.clamp(0.0, 1.0);
    match light <= 0.003_130_8 {
        true => 12.92 * light,
        false => 1.055 * light.powf(1.0 / 2.4) - 0.055,
    }
}

/// The linear light of a byte.
pub(crate) fn light(byte: u8) -> f64 {
    static ALL: LazyLock<[f64; 256]> =
        LazyLock::new(|| std::array::from_fn(|byte| decode(byte as f64 / 255.0)));
    ALL[usize::from(byte)]
}

/// The byte nearest to a linear light.
pub(crate) fn byte(light: f64) -> u8 {
    (255.0 * encode(light)).round() as u8
}

/// The linear light of a colour.
pub(crate) fn linear(colour: [u8; 3]) -> DVec3 {
    DVec3::from_array(colour.map(light))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_come_back() {
        for value in 0..=255 {
            assert_eq!(byte(light(value)), value);
        }
        assert_eq!([byte(-1.0), byte(7.0)], [0, 255]);
        // Half of the light is encoded as 188.
        assert_eq!(byte(0.5), 188);
        assert!((linear([255; 3]).dot(BRIGHTNESS) - 1.0).abs() < 1e-12);
    }
}
