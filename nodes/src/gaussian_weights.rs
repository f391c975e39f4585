//! The weights of a Gaussian kernel as three numbers, from which a shader computes each weight.

/// The weight at offset i is `scale * 2^(falloff * i^2)`. All weights within the radius sum to 1.
pub(crate) struct GaussianWeights {
    pub(crate) radius: u32,
    /// Factor of the squared offset in the exponent; negative.
    pub(crate) falloff: f64,
    /// The weight at the center.
    pub(crate) scale: f64,
}

/// At this sigma and below, all but 4e-6 of the weight is at the center.
const NO_BLUR: f32 = 0.2;

impl GaussianWeights {
    pub(crate) const COPY: Self = Self { radius: 0, falloff: 0.0, scale: 1.0 };

    /// The kernel of standard deviation `sigma` up to `reach` sigmas. `None` if a blur changes nothing.
    pub(crate) fn new(sigma: f32, reach: f32) -> Option<Self> {
        if sigma <= NO_BLUR {
            return None;
        }
        let radius = (reach * sigma).ceil() as u32;
        let falloff = -std::f64::consts::LOG2_E / (2.0 * f64::from(sigma).powi(2));
        let side: f64 = (1..=radius).map(|i| (falloff * f64::from(i).powi(2)).exp2()).sum();
        Some(Self { radius, falloff, scale: 1.0 / (1.0 + 2.0 * side) })
    }

    /// The axes to blur with their kernels, for these standard deviations. Axes that are needed, as where sigmas may
    /// change, are among them without a blur, too.
    pub(crate) fn of_axes(
        sigmas: &[f32],
        reach: f32,
        is_needed: impl Fn(usize) -> bool,
    ) -> impl Iterator<Item = (usize, Self)> {
        sigmas.iter().enumerate().filter_map(move |(axis, sigma)| {
            let kernel = Self::new(*sigma, reach).or_else(|| is_needed(axis).then_some(Self::COPY))?;
            Some((axis, kernel))
        })
    }
}
