//! Process nodes that are formulas.

use roxmltree::Node;

use super::depth::{Depths, channels, only, usable};
use crate::lut::cdl_file::{saturation, slope_offset_power};
use crate::lut::text::short;
use crate::lut::xml::{self, attribute, element, error, name, number_in, numbers};
use crate::lut::{ColorCorrection, LutError};
use crate::process::{Antilog, CdlStep, LIMIT, Logarithm, Power, Step};

/// The coefficients include the factor between both bit depths.
pub(super) fn matrix(node: Node<'_, '_>, depths: Depths<'_>) -> Result<Step, LutError> {
    only(node, &[], &["Array"])?;
    let array = xml::required(node, &["Array"])?;
    let dim = attribute(array, "dim")?;
    let words: Vec<&str> = dim.split_ascii_whitespace().collect();
    let rows = match words.as_slice() {
        // Version 2 states the number of channels too.
        ["3", "3"] | ["3", "3", "3"] => {
            let m = numbers::<9>(array)?;
            [0, 3, 6].map(|row| [m[row], m[row + 1], m[row + 2], 0.0])
        }
        ["3", "4"] | ["3", "4", "3"] => {
            let m = numbers::<12>(array)?;
            [0, 4, 8].map(|row| [m[row], m[row + 1], m[row + 2], m[row + 3]])
        }
        _ => return Err(error(array, format!("`dim` of a matrix is `3 3` or `3 4`, not `{}`", short(dim)))),
    };
    let (input, output) = (depths.input.scale, depths.output.scale);
    let factor = input / output;
    Ok(Step::Matrix(rows.map(|[r, g, b, offset]| [r * factor, g * factor, b * factor, offset / output])))
}

/// The bounds of a range: input and output, normalized.
type Bound = Option<[f64; 2]>;

pub(super) fn range(node: Node<'_, '_>, depths: Depths<'_>) -> Result<Step, LutError> {
    only(node, &["style"], &["minInValue", "maxInValue", "minOutValue", "maxOutValue"])?;
    let limits = match node.attribute("style") {
        None | Some("Clamp") => true,
        Some("noClamp") => false,
        Some(other) => return Err(error(node, format!("`style` is `Clamp` or `noClamp`, not `{}`", short(other)))),
    };
    let low = bound(node, "minInValue", "minOutValue", depths)?;
    let high = bound(node, "maxInValue", "maxOutValue", depths)?;
    match (low, high) {
        (Some(low), Some(high)) => scaled(node, low, high, limits),
        (None, None) => Err(error(node, "`Range` has neither a minimum nor a maximum")),
        _ if !limits => Err(error(node, "`noClamp` needs minima and maxima")),
        (low, high) => one_sided(node, low, high),
    }
}

fn bound(node: Node<'_, '_>, input: &str, output: &str, depths: Depths<'_>) -> Result<Bound, LutError> {
    let value = |key: &str| element(node, &[key])?.map(|value| numbers::<1>(value).map(|[x]| x)).transpose();
    match (value(input)?, value(output)?) {
        (Some(x), Some(y)) => Ok(Some([x / depths.input.scale, y / depths.output.scale])),
        (None, None) => Ok(None),
        _ => Err(error(node, format!("`{input}` and `{output}` need each other"))),
    }
}

fn scaled(node: Node<'_, '_>, low: [f64; 2], high: [f64; 2], limits: bool) -> Result<Step, LutError> {
    if high[0] <= low[0] {
        return Err(error(node, "`maxInValue` must be above `minInValue`"));
    }
    if high[1] < low[1] {
        return Err(error(node, "`maxOutValue` must not be below `minOutValue`"));
    }
    let slope = (high[1] - low[1]) / (high[0] - low[0]);
    let offset = low[1] - low[0] * slope;
    usable(node, &[slope, offset])?;
    let [low, high] = if limits { [low[1], high[1]] } else { [-LIMIT, LIMIT] };
    Ok(Step::Range { slope, offset, low, high })
}

/// A limit at one end, which must be the same before and after.
fn one_sided(node: Node<'_, '_>, low: Bound, high: Bound) -> Result<Step, LutError> {
    let is_equal = |bound: Bound| bound.is_none_or(|[x, y]| (x - y).abs() <= 1e-6 * x.abs().max(1.0));
    if !is_equal(low) || !is_equal(high) {
        return Err(error(node, "with a minimum or a maximum alone, both of its values must be the same light"));
    }
    let [low, high] = [low.map_or(-LIMIT, |[_, y]| y), high.map_or(LIMIT, |[_, y]| y)];
    Ok(Step::limits(low, high))
}

pub(super) fn log(node: Node<'_, '_>) -> Result<Step, LutError> {
    only(node, &["style"], &["LogParams"])?;
    let style = attribute(node, "style")?;
    let plain = |base: f64| LogParams { base, ..LogParams::default() };
    let params = || channels(node, "LogParams", None, LogParams::read);
    let (params, is_camera, is_inverse) = match style {
        "log10" => ([plain(10.0); 3], false, false),
        "antiLog10" => ([plain(10.0); 3], false, true),
        "log2" => ([plain(2.0); 3], false, false),
        "antiLog2" => ([plain(2.0); 3], false, true),
        "linToLog" => (params()?, false, false),
        "logToLin" => (params()?, false, true),
        "cameraLinToLog" => (params()?, true, false),
        "cameraLogToLin" => (params()?, true, true),
        _ => return Err(error(node, format!("`{}` is no style of `Log`", short(style)))),
    };
    let [red, green, blue] = params.map(|params| params.curve(node, is_camera));
    let curves = [red?, green?, blue?];
    if !is_inverse {
        return Ok(Step::Logarithm(curves));
    }
    let inverses = curves.map(|curve| curve.inverse());
    inverses.iter().try_for_each(|Antilog { slope, offset, a, b, scale, shift, .. }| {
        usable(node, &[*slope, *offset, *a, *b, *scale, *shift])
    })?;
    Ok(Step::Antilog(inverses))
}

/// The parameters of a logarithm.
#[derive(Clone, Copy)]
struct LogParams {
    base: f64,
    log_slope: f64,
    log_offset: f64,
    lin_slope: f64,
    lin_offset: f64,
    lin_break: Option<f64>,
    linear_slope: Option<f64>,
}

impl Default for LogParams {
    fn default() -> Self {
        Self {
            base: 2.0,
            log_slope: 1.0,
            log_offset: 0.0,
            lin_slope: 1.0,
            lin_offset: 0.0,
            lin_break: None,
            linear_slope: None,
        }
    }
}

impl LogParams {
    fn read(params: Node<'_, '_>) -> Result<Self, LutError> {
        let known = ["base", "logSideSlope", "logSideOffset", "linSideSlope", "linSideOffset", "linSideBreak"];
        xml::only(params, &[&known[..], &["linearSlope", "channel"]].concat(), &[])?;
        let number = |key: &str, default: f64| number_in(params, key).map(|x| x.unwrap_or(default));
        let read = Self {
            base: number("base", 2.0)?,
            log_slope: number("logSideSlope", 1.0)?,
            log_offset: number("logSideOffset", 0.0)?,
            lin_slope: number("linSideSlope", 1.0)?,
            lin_offset: number("linSideOffset", 0.0)?,
            lin_break: number_in(params, "linSideBreak")?,
            linear_slope: number_in(params, "linearSlope")?,
        };
        if read.base <= 0.0 || read.base == 1.0 {
            return Err(error(params, "`base` is above 0 and not 1"));
        }
        if read.log_slope == 0.0 || read.lin_slope == 0.0 || read.linear_slope == Some(0.0) {
            return Err(error(params, "a slope of 0 has no inverse"));
        }
        Ok(read)
    }

    /// The curve, with a linear part for the styles of cameras.
    fn curve(&self, node: Node<'_, '_>, is_camera: bool) -> Result<Logarithm, LutError> {
        let plain = Logarithm {
            slope: 1.0,
            offset: 0.0,
            end: -3e38,
            a: self.lin_slope,
            b: self.lin_offset,
            scale: self.log_slope / self.base.log2(),
            shift: self.log_offset,
        };
        let curve = if is_camera { self.with_line(node, plain)? } else { plain };
        let Logarithm { slope, offset, a, b, scale, shift, .. } = curve;
        usable(node, &[slope, offset, a, b, scale, shift])?;
        Ok(curve)
    }

    /// The line continues the curve at the break, with its slope unless another one is stated.
    fn with_line(&self, node: Node<'_, '_>, curve: Logarithm) -> Result<Logarithm, LutError> {
        let end = self.lin_break.ok_or_else(|| error(node, "the style needs `linSideBreak`"))?;
        let argument = self.lin_slope * end + self.lin_offset;
        if argument <= 0.0 {
            return Err(error(node, "the logarithm is not defined at `linSideBreak`"));
        }
        let tangent = curve.scale * self.lin_slope / (argument * std::f64::consts::LN_2);
        let slope = self.linear_slope.unwrap_or(tangent);
        Ok(Logarithm { slope, offset: curve.curve(end) - slope * end, end, ..curve })
    }
}

pub(super) fn exponent(node: Node<'_, '_>) -> Result<Step, LutError> {
    only(node, &["style"], &["ExponentParams"])?;
    let style = attribute(node, "style")?;
    let (form, is_inverse) = match style.strip_suffix("Rev") {
        Some(form) => (form, true),
        None => (style.strip_suffix("Fwd").unwrap_or_default(), false),
    };
    let is_curve = form.starts_with("monCurve");
    let curve = |params: Node<'_, '_>| -> Result<Power, LutError> {
        let (gamma, offset) = exponent_params(params, is_curve)?;
        let gamma_or_inverse = if is_inverse { gamma.recip() } else { gamma };
        Ok(match form {
            "basic" => Power::plain(gamma_or_inverse, 0.0),
            "basicMirror" => Power::plain(gamma_or_inverse, 0.0).mirrored(),
            "basicPassThru" => Power::plain(gamma_or_inverse, 1.0),
            "monCurve" => monitor_curve(gamma, offset, is_inverse),
            "monCurveMirror" => monitor_curve(gamma, offset, is_inverse).mirrored(),
            _ => return Err(error(node, format!("`{}` is no style of `Exponent`", short(style)))),
        })
    };
    let is_mirrored = form.ends_with("Mirror");
    let unchanged = Power { is_mirrored, ..Power::plain(1.0, if form == "basic" { 0.0 } else { 1.0 }) };
    let curves = channels(node, "ExponentParams", Some(unchanged), curve)?;
    curves
        .iter()
        .try_for_each(|Power { slope, a, b, scale, shift, .. }| usable(node, &[*slope, *a, *b, *scale, *shift]))?;
    Ok(Step::Power(curves))
}

/// The exponent and the offset.
fn exponent_params(params: Node<'_, '_>, is_curve: bool) -> Result<(f64, f64), LutError> {
    xml::only(params, &["exponent", "offset", "channel"], &[])?;
    let missing = |key: &str| error(params, format!("`{}` has no attribute `{key}`", name(params)));
    let gamma = number_in(params, "exponent")?.ok_or_else(|| missing("exponent"))?;
    let offset = number_in(params, "offset")?;
    if !is_curve {
        return match (0.01..=100.0).contains(&gamma) {
            _ if offset.is_some() => Err(error(params, "`offset` belongs to the styles that begin with `monCurve`")),
            true => Ok((gamma, 0.0)),
            false => Err(error(params, "`exponent` is 0.01 to 100")),
        };
    }
    let offset = offset.ok_or_else(|| missing("offset"))?;
    match (1.0..=10.0).contains(&gamma) && (0.0..=0.9).contains(&offset) {
        true => Ok((gamma, offset)),
        false => Err(error(params, "with `monCurve`, `exponent` is 1 to 10 and `offset` is 0 to 0.9")),
    }
}

/// A power with a linear part near black. An exponent of 1 and an offset of 0, for which the formula divides by 0, are
/// replaced by their neighbors.
fn monitor_curve(gamma: f64, offset: f64, is_inverse: bool) -> Power {
    const NEAR: f64 = 1e-6;
    let (g, k) = (gamma.max(1.0 + NEAR), offset.max(NEAR));
    let y_break = (k * g / ((g - 1.0) * (1.0 + k))).powf(g);
    let slope = (g - 1.0) / k * y_break;
    let plain = Power::plain(g, slope);
    if is_inverse {
        let exponent = g.recip();
        Power { slope: slope.recip(), end: y_break, exponent, scale: 1.0 + k, shift: -k, ..plain }
    } else {
        Power { end: k / (g - 1.0), a: 1.0 / (1.0 + k), b: k / (1.0 + k), ..plain }
    }
}

pub(super) fn cdl(node: Node<'_, '_>) -> Result<Step, LutError> {
    only(node, &["style"], &["SOPNode", "SatNode", "SATNode"])?;
    let (is_limited, is_reverse) = match node.attribute("style") {
        // The second names are those of version 2.
        None | Some("Fwd" | "v1.2_Fwd") => (true, false),
        Some("Rev" | "v1.2_Rev") => (true, true),
        Some("FwdNoClamp" | "noClampFwd") => (false, false),
        Some("RevNoClamp" | "noClampRev") => (false, true),
        Some(other) => return Err(error(node, format!("`{}` is no style of `ASC_CDL`", short(other)))),
    };
    let mut correction = ColorCorrection::NEUTRAL;
    if let Some(sop) = element(node, &["SOPNode"])? {
        (correction.slope, correction.offset, correction.power) = slope_offset_power(sop)?;
    }
    if let Some(sat) = element(node, &["SatNode", "SATNode"])? {
        correction.saturation = saturation(sat)?;
    }
    let cdl = CdlStep { is_limited, ..correction.into() };
    if !is_reverse {
        return Ok(Step::Cdl(cdl));
    }
    let reversed = cdl.reversed();
    let [x, y, z] = reversed.slope.to_array();
    usable(node, &[x, y, z, reversed.saturation])
        .map_err(|_| error(node, "a slope or a saturation of 0 has no reverse"))?;
    Ok(Step::Cdl(reversed))
}
