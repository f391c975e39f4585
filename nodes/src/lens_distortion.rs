//! LensDistortion: straight lines bend, as a lens bends them, or become straight again.

use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("lens_distortion");

choices! {
    /// The formula of a lens.
    pub enum LensModel {
        /// Brown and Conrady: `k1`, `k2`, `k3` and the tangential `p1` and `p2`, as calibrations give them.
        BrownConrady,
        /// Fitzgibbon's division model: `k1` and `k2`. One coefficient describes wide lenses.
        Division,
    }
}

choices! {
    /// Direction of the mapping.
    pub enum LensDirection {
        /// An image without distortion, such as a rendered one, becomes as the lens would have it.
        Distort,
        /// An image of the lens becomes straight.
        Undistort,
    }
}

node_kind! {
    /// Bends an image as a lens does, or undoes it.
    ///
    /// Places are relative to the optical center, and the distance r = 1 is half of the diagonal. The model of
    /// `BrownConrady` is that of OpenCV: a straight place is at p (1 + k1 r^2 + k2 r^4 + k3 r^6) plus the tangential
    /// part in the image of the lens (coefficients for a focal length f are multiplied by powers of half of the
    /// diagonal over f: k1 by its square). In `Division` a place p of the lens's image is straight at p / (1 + k1 r^2 +
    /// k2 r^4). Negative k1 makes barrels with `BrownConrady`, and positive ones with `Division`. What has no closed
    /// form is solved by Newton's method, to a thousandth of a pixel.
    ///
    /// Where the formula folds the image, it is continued from the last place before. Beyond the border the border is
    /// read: `zoom` hides it. It is a warp: with a `ChromaticAberration` before or after it, it is one pass, and with
    /// nothing between two distortions, the image is filtered once.
    pub struct LensDistortion {
        /// The formula.
        pub model: LensModel = LensModel::BrownConrady;
        /// What is done to the image.
        pub direction: LensDirection = LensDirection::Distort;
        /// Radial, second power.
        pub k1: f32 = -0.1 => within(-1.0..=1.0), usually(-0.3..=0.3), neutral(0.0);
        /// Radial, fourth power.
        pub k2: f32 = 0.0 => within(-1.0..=1.0), usually(-0.1..=0.1), neutral(0.0);
        /// Radial, sixth power; for `BrownConrady`.
        pub k3: f32 = 0.0
            => within(-1.0..=1.0), usually(-0.1..=0.1), neutral(0.0), when("model", [LensModel::BrownConrady]);
        /// Tangential, upwards; for `BrownConrady`.
        pub p1: f32 = 0.0
            => within(-0.05..=0.05), usually(-0.01..=0.01), neutral(0.0), when("model", [LensModel::BrownConrady]);
        /// Tangential, sideways; for `BrownConrady`.
        pub p2: f32 = 0.0
            => within(-0.05..=0.05), usually(-0.01..=0.01), neutral(0.0), when("model", [LensModel::BrownConrady]);
        /// The optical center, from the center of the image.
        pub center: [f32; 2] = [0.0, 0.0] => within(-0.5..=0.5), unit("uv");
        /// Magnification of the result about the optical center.
        pub zoom: f32 = 1.0 => within(0.25..=4.0), usually(0.8..=1.25), neutral(1.0);
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "The image.").accepts(&[
        ColorState::Scene,
        ColorState::Exposed,
        ColorState::DisplayLinear,
        ColorState::Encoded,
        ColorState::Data,
    ])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The bent or straight image.").or_input("source")];
    const INVARIANTS: Invariants = Invariants { symmetric: false, keeps_constant: true, ..Invariants::DEFAULT };
}

/// No place of an image is farther from its optical center, in halves of the diagonal, at any zoom.
const FARTHEST: f64 = 12.0;
/// The least slope of the radial function: places beyond are continued.
const MIN_RISE: f64 = 0.1;
/// Distances that are tried in search of the limit.
const STEPS: u32 = 1536;

impl LensDistortion {
    fn radial(&self, r: f64) -> f64 {
        let [k1, k2, k3] = [self.k1, self.k2, self.k3].map(f64::from);
        let s = r * r;
        match self.model {
            LensModel::BrownConrady => r * (1.0 + s * (k1 + s * (k2 + s * k3))),
            LensModel::Division => {
                let below = 1.0 + s * (k1 + s * k2);
                if below > 0.01 { r / below } else { f64::NEG_INFINITY }
            }
        }
    }

    /// The distance up to which the radial function rises by at least [`MIN_RISE`].
    fn limit(&self) -> f64 {
        let step = FARTHEST / f64::from(STEPS);
        let distance = |index: u32| f64::from(index) * step;
        let rises = |index: &u32| self.radial(distance(index + 1)) - self.radial(distance(*index)) >= MIN_RISE * step;
        distance((0..STEPS).take_while(rises).count() as u32).max(step)
    }

    fn function(&self) -> &'static str {
        match (self.model, self.direction) {
            (LensModel::BrownConrady, LensDirection::Undistort) => "lens_distortion_brown",
            (LensModel::BrownConrady, LensDirection::Distort) => "lens_distortion_brown_inverse",
            (LensModel::Division, LensDirection::Distort) => "lens_distortion_division",
            (LensModel::Division, LensDirection::Undistort) => "lens_distortion_division_inverse",
        }
    }

    fn changes_nothing(&self) -> bool {
        let own = match self.model {
            LensModel::BrownConrady => [self.k3, self.p1, self.p2],
            LensModel::Division => [0.0; 3],
        };
        self.zoom == 1.0 && [self.k1, self.k2].iter().chain(&own).all(|k| *k == 0.0)
    }
}

impl Node for LensDistortion {
    fn is_identity(&self, inputs: &InputValues) -> bool {
        self.changes_nothing() || inputs.is_zero("source")
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        pass.warp(&SHADER, self.function(), source).set("limit", self.limit()).write("result", desc);
    }
}
