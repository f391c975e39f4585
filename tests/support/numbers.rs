//! Pseudo-random numbers, and numbers that are printed.

/// Numbers from 0 to below 1, the same in every run: xorshift from a seed other than 0.
pub struct Numbers(pub u64);

impl Numbers {
    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 40) as f64 / (1u64 << 24) as f64
    }
}

/// True if a text is this number, rounded to the digits that it has.
pub fn is_rounded(text: &str, number: f64) -> bool {
    let digits = text.split_once('.').map_or(0, |(_, digits)| digits.len() as i32);
    text.parse::<f64>().is_ok_and(|printed| (printed - number).abs() <= 0.5001 * 10_f64.powi(-digits))
}
