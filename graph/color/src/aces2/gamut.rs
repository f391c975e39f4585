//! The gamut compression of ACES 2.0: along lines in J and M at one hue, toward a focus on the gray axis.

/// The width of the smooth minimum at the cusp, and what widens the cusps to make room for it.
pub(super) const SMOOTH_CUSPS: f64 = 0.12;
pub(super) const SMOOTH_M: f64 = 0.27;

const CUSP_MID_BLEND: f64 = 1.3;
const FOCUS_GAIN_BLEND: f64 = 0.3;
const COMPRESSION_THRESHOLD: f64 = 0.75;

/// The hulls at one hue.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hull {
    /// The cusp of the display: the brightest of the most colorful colors.
    pub(super) cusp_j: f64,
    pub(super) cusp_m: f64,
    /// The inverse exponent of the upper hull of the display.
    pub(super) upper_gamma_inv: f64,
    /// The largest M of the source at the peak's J.
    pub(super) reach_m: f64,
}

/// Values that are equal for all hues.
#[derive(Clone, Copy, Debug)]
pub struct GamutParams {
    /// J of a gray at the peak.
    pub limit_j: f64,
    /// J of middle gray.
    pub mid_j: f64,
    pub focus_distance: f64,
    /// The inverse exponent of the lower hull of the display.
    pub lower_gamma_inv: f64,
    /// The inverse exponent of the border of the source.
    pub model_gamma_inv: f64,
}

impl GamutParams {
    pub(super) fn focus(&self, cusp_j: f64) -> f64 {
        let blend = (CUSP_MID_BLEND - cusp_j / self.limit_j).min(1.0);
        cusp_j + (self.mid_j - cusp_j) * blend
    }

    /// The gain of the slope of lines through points of this J.
    fn slope_gain(&self, j: f64, cusp_j: f64) -> f64 {
        let threshold = cusp_j + (self.limit_j - cusp_j) * FOCUS_GAIN_BLEND;
        let gain = self.limit_j * self.focus_distance;
        if j <= threshold {
            return gain;
        }
        let adjustment = ((self.limit_j - threshold) / (self.limit_j - j).max(1e-4)).log10();
        gain * (adjustment * adjustment + 1.0)
    }

    /// J where the line through a point meets the gray axis.
    fn intersection(&self, j: f64, m: f64, focus: f64, gain: f64) -> f64 {
        let scaled = m / gain;
        let a = scaled / focus;
        if j < focus {
            let b = 1.0 - scaled;
            return 2.0 * j / (b + (b * b + 4.0 * a * j).sqrt());
        }
        let b = 1.0 + scaled + self.limit_j * a;
        let c = self.limit_j * scaled + j;
        2.0 * c / (b + (b * b - 4.0 * a * c).sqrt())
    }

    /// The line of compression through a point.
    pub(super) fn line(&self, j: f64, m: f64, hull: &Hull) -> Line {
        let focus = self.focus(hull.cusp_j);
        let gain = self.slope_gain(j, hull.cusp_j);
        let start = self.intersection(j, m, focus, gain);
        let room = if start < focus { start } else { self.limit_j - start };
        let slope = room * (start - focus) / (focus * gain);
        Line { start, slope, cusp: self.intersection(hull.cusp_j, hull.cusp_m, focus, gain) }
    }

    /// M where the line meets the hull of the display.
    pub(super) fn border(&self, line: Line, hull: &Hull) -> f64 {
        let lower = meeting(line.start, line.slope, self.lower_gamma_inv, hull.cusp_j, hull.cusp_m, line.cusp);
        let upper = meeting(
            self.limit_j - line.start,
            -line.slope,
            hull.upper_gamma_inv,
            self.limit_j - hull.cusp_j,
            hull.cusp_m,
            self.limit_j - line.cusp,
        );
        smooth_min(lower, upper, hull.cusp_m)
    }

    /// J and M in the gamut of the display.
    pub(super) fn compress(&self, j: f64, m: f64, hull: &Hull) -> [f64; 2] {
        if j <= 0.0 || m <= 0.0 || j > self.limit_j {
            return [j.max(0.0), 0.0];
        }
        let line = self.line(j, m, hull);
        let border = self.border(line, hull);
        if border <= 0.0 {
            return [j, 0.0];
        }
        let reach = meeting(line.start, line.slope, self.model_gamma_inv, self.limit_j, hull.reach_m, self.limit_j);
        let m = remapped(m, border, reach);
        [line.start + m * line.slope, m]
    }
}

/// The line `start + slope * M`, and where the line through the cusp meets the gray axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub(super) start: f64,
    pub(super) slope: f64,
    cusp: f64,
}

/// M where the line `start + slope * M` meets the curve `top_j * (M / top_m)^gamma`, approximately: the line's start is
/// moved by the exponent, and the curve is replaced by its chord.
fn meeting(start: f64, slope: f64, gamma_inv: f64, top_j: f64, top_m: f64, reference: f64) -> f64 {
    let moved = reference * (start / reference).powf(gamma_inv);
    moved * top_m / (top_j - slope * top_m)
}

fn smooth_min(a: f64, b: f64, scale: f64) -> f64 {
    let width = SMOOTH_CUSPS * scale;
    let h = (width - (a - b).abs()).max(0.0) / width;
    a.min(b) - h * h * h * width / 6.0
}

/// M from the range up to `reach` in the range up to `border`.
fn remapped(m: f64, border: f64, reach: f64) -> f64 {
    let share = (border / reach).max(COMPRESSION_THRESHOLD);
    let threshold = share * border;
    if m <= threshold || share >= 1.0 {
        return m;
    }
    let (gamut, source) = (border - threshold, reach - threshold);
    let scale = source / (source / gamut - 1.0);
    let over = (m - threshold) / scale;
    threshold + scale * over / (1.0 + over)
}
