//! The arithmetic of an event: from coefficients that changed to positions and normals.
//!
//! Coefficients are whole numbers of steps of a sigma ([`PER_SIGMA`](crate::quantise::PER_SIGMA)), modes are `i16` in steps that
//! are whole multiples of a power of two ([`Modes`], [`STEPS`](crate::quantise::STEPS)), and positions
//! are summed in f64, which holds all of that exactly. So a change of coefficients can be added to
//! what is there: the bits are those of summing everything again, in whatever order, and a million
//! changes drift by nothing. An event costs what it changes.
//!
//! Each step works on four or eight numbers at once, by the `wide` crate: with the instructions of
//! wasm's simd128, SSE2 or NEON. Where there are none of these, modes are summed two to a word of 64
//! bits, and all else is done one number after the other. All of them give the same bits.

mod modes;
mod normals;

use wide::{f64x2, i32x4};

pub(crate) use modes::CHUNK;
pub use modes::Modes;
pub(crate) use normals::Patch;

/// Adds whole numbers times a scale to as many sums.
#[inline(never)]
pub(crate) fn add_to(sums: &mut [f64], numbers: &[i32], scale: f64) {
    let (fours, last) = sums.as_chunks_mut::<4>();
    let (numbers, rest) = numbers.as_chunks::<4>();
    let scales = f64x2::splat(scale);
    for (sum, &[a, b, c, d]) in fours.iter_mut().zip(numbers) {
        let low = f64x2::from_i32x4_lower2(i32x4::new([a, b, 0, 0])) * scales;
        let high = f64x2::from_i32x4_lower2(i32x4::new([c, d, 0, 0])) * scales;
        let [e, f, g, h] = *sum;
        let [e, f] = (f64x2::new([e, f]) + low).to_array();
        let [g, h] = (f64x2::new([g, h]) + high).to_array();
        *sum = [e, f, g, h];
    }
    for (sum, number) in last.iter_mut().zip(rest) {
        *sum += f64::from(*number) * scale;
    }
}

/// Rounds sums to f32, as many of them.
#[inline(never)]
pub(crate) fn round_to(sums: &[f64], rounded: &mut [f32]) {
    let (pairs, last) = sums.as_chunks::<2>();
    let (outs, ends) = rounded.as_chunks_mut::<2>();
    for (&sum, out) in pairs.iter().zip(outs) {
        *out = narrow(f64x2::new(sum));
    }
    for (&sum, out) in last.iter().zip(ends) {
        *out = sum as f32;
    }
}

/// Two numbers rounded to f32.
#[inline(always)]
fn narrow(numbers: f64x2) -> [f32; 2] {
    // Of four at a time the compiler makes four times one.
    #[cfg(target_feature = "simd128")]
    {
        let four: [f32; 4] = bytemuck::cast(std::arch::wasm32::f32x4_demote_f64x2_zero(
            bytemuck::cast(numbers),
        ));
        [four[0], four[1]]
    }
    #[cfg(not(target_feature = "simd128"))]
    numbers.to_array().map(|x| x as f32)
}
