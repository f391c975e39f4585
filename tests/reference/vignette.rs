//! Darkening toward the corners (formula book, 15).

use super::math::{mix, smooth_step};

/// The factor at `uv`: 1 inside, 0 from half a frame outwards. `intensity` ≥ −1 moves the edge
/// inwards, `smoothness` is the width of the fade, `aspect` stretches x (1 gives an ellipse in
/// a wide frame, width / height a circle).
pub(crate) fn factor(uv: [f64; 2], intensity: f64, smoothness: f64, aspect: f64) -> f64 {
    let r = ((uv[0] - 0.5) * aspect).hypot(uv[1] - 0.5) * (1.0 + intensity);
    1.0 - smooth_step(0.5 - smoothness.max(1e-4), 0.5, r)
}

/// The factor blended with 1: an `amount` of 0 changes nothing.
pub(crate) fn blended(factor: f64, amount: f64) -> f64 {
    mix(1.0, factor, amount)
}

/// The natural fall-off cos⁴ θ, where `k` is tan² θ at distance 1 from the middle.
pub(crate) fn natural(uv: [f64; 2], k: f64, aspect: f64) -> f64 {
    let r = ((uv[0] - 0.5) * aspect).hypot(uv[1] - 0.5);
    (1.0 + k * r * r).powi(-2)
}

#[test]
fn the_natural_fall_off_is_the_fourth_power_of_a_cosine() {
    let angle: f64 = 0.3;
    let k = (angle.tan() / 0.4).powi(2);
    assert!((natural([0.5, 0.9], k, 1.0) - angle.cos().powi(4)).abs() < 1e-14);
    assert!((natural([0.7, 0.5], k, 2.0) - angle.cos().powi(4)).abs() < 1e-14);
}

#[test]
fn aspect_makes_the_edge_round_and_amount_fades_it() {
    let wide = factor([0.5 + 0.2, 0.5], 0.0, 0.3, 2.0);
    assert!((wide - factor([0.5, 0.9], 0.0, 0.3, 1.0)).abs() < 1e-14);
    assert!(wide > 0.2 && wide < 0.3);
    assert_eq!(blended(wide, 0.0), 1.0);
    assert_eq!(blended(wide, 1.0), wide);
}
