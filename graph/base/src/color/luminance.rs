//! Luminance weights of linear light.

/// Weights of Rec.709, with the four digits of the recommendation. Their sum is exactly 1.
pub const LUMINANCE_REC709: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Weights of Rec.2020.
pub const LUMINANCE_REC2020: [f64; 3] = [0.262700212011, 0.677998071519, 0.059301716470];

/// Luminance of linear Rec.709.
pub fn rec709_luminance([r, g, b]: [f32; 3]) -> f32 {
    let [red, green, blue] = LUMINANCE_REC709.map(|weight| weight as f32);
    red * r + green * g + blue * b
}
