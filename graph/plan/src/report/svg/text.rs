//! Widths of texts, and colors.

/// About how wide so many letters of this size are.
pub(crate) fn width_of(letters: usize, size: f64) -> f64 {
    0.6 * size * letters as f64
}

/// The text, shortened to what fits into a width at this size of letters.
pub(crate) fn fitting(text: &str, width: f64, size: f64) -> String {
    let room = (width / width_of(1, size)).max(0.0) as usize;
    let length = text.chars().count();
    match room {
        _ if length <= room => text.to_owned(),
        0..3 => String::new(),
        _ => text.chars().take(room - 1).chain(['…']).collect(),
    }
}

/// A soft color of that hue in degrees.
pub(crate) fn color(hue: f64) -> String {
    let (saturation, lightness) = (0.56, 0.72);
    let strength = saturation * f64::min(lightness, 1.0 - lightness);
    let channel = |offset: f64| {
        let k = (offset + hue / 30.0) % 12.0;
        let value = lightness - strength * f64::min(k - 3.0, 9.0 - k).clamp(-1.0, 1.0);
        (255.0 * value).round() as u8
    };
    format!("#{:02x}{:02x}{:02x}", channel(0.0), channel(8.0), channel(4.0))
}
