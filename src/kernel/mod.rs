//! The arithmetic of an event: from coefficients that changed to positions and normals.
//!
//! Coefficients are whole numbers of steps of a sigma ([`crate::face`]), modes are `i16` in steps that
//! are whole multiples of a power of two ([`Modes`], [`STEPS`](crate::quantise::STEPS)), and positions
//! are summed in f64, which holds all of that exactly. So a change of coefficients can be added to
//! what is there: the bits are those of summing everything again, in whatever order, and a million
//! changes drift by nothing. An event costs what it changes.
//!
//! Each step works on four or eight numbers at once, by the `wide` crate: with the instructions of
//! wasm's simd128, SSE2 or NEON, and one number after the other where there are none of these. All of
//! them give the same bits.

mod modes;
mod normals;
mod surround;

use wide::f64x2;

pub(crate) use modes::CHUNK;
pub use modes::Modes;
pub(crate) use normals::Patch;
pub(crate) use surround::Surrounding;

/// Adds numbers, and rounds the sums to f32.
pub(crate) fn add_to(sums: &mut [f64], numbers: &[f64], rounded: &mut [f32]) {
    let (pairs, last) = sums.as_chunks_mut::<2>();
    let (outs, ends) = rounded.as_chunks_mut::<2>();
    let (numbers, rest) = numbers.as_chunks::<2>();
    for ((sum, &number), out) in pairs.iter_mut().zip(numbers).zip(outs) {
        let total = f64x2::new(*sum) + f64x2::new(number);
        *sum = total.to_array();
        *out = narrow(total);
    }
    for ((sum, number), out) in last.iter_mut().zip(rest).zip(ends) {
        *sum += number;
        *out = *sum as f32;
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
