//! From [0, 1] to codes. Eight bits are dithered with triangular noise, so that smooth skies do
//! not band: the mean error is 0 and the noise does not depend on the signal.

/// Which noise to use: equal seeds give equal pictures.
#[derive(Debug, Clone, Copy)]
pub(super) struct Noise {
    row: u32,
}

impl Noise {
    pub(super) fn of_row(seed: u32, y: u32) -> Self {
        Self { row: pcg(y ^ pcg(seed)) }
    }

    /// Two uniform numbers in (0, 1) for each channel of a pixel.
    pub(super) fn at(self, x: u32) -> [(f32, f32); 3] {
        let pixel = pcg(x ^ self.row);
        std::array::from_fn(|channel| {
            let bits = pcg(pixel.wrapping_add(channel as u32));
            (uniform(bits >> 16), uniform(bits & 0xffff))
        })
    }
}

fn uniform(sixteen_bits: u32) -> f32 {
    (sixteen_bits as f32 + 0.5) / 65536.0
}

/// The PCG output hash (Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 2020).
fn pcg(value: u32) -> u32 {
    let state = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// The nearest code of `max`. NaN passes, and casting to an integer makes it 0.
pub(super) fn quantise(value: f32, max: f32) -> f32 {
    (value.clamp(0.0, 1.0) * max + 0.5).floor()
}

/// An 8-bit code, dithered by `u1` and `u2`. The triangular noise fades to one code's width of
/// uniform noise at the ends, so solid black and solid white stay solid.
pub(crate) fn dithered(value: f32, u1: f32, u2: f32) -> u8 {
    let code = value.clamp(0.0, 1.0) * 255.0;
    let inside = (code.min(255.0 - code) * 2.0).clamp(0.0, 1.0);
    let uniform = u1 - 0.5;
    let noise = uniform + (u2 - 0.5) * inside;
    ((code + noise).clamp(0.0, 255.0) + 0.5) as u8
}
