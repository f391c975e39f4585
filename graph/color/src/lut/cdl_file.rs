//! Color corrections in `.cdl`, `.cc` and `.ccc` files (ASC CDL 1.2).

use roxmltree::Node;

use super::LutError;
use super::text::short;
use super::xml::{self, elements, error, name, numbers};

/// The values of a color correction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColorCorrection {
    /// Factor of each channel.
    pub slope: [f32; 3],
    /// Added to each channel after the slope.
    pub offset: [f32; 3],
    /// Exponent of each channel.
    pub power: [f32; 3],
    /// Factor of the distance from gray.
    pub saturation: f32,
}

impl ColorCorrection {
    /// The identity.
    pub const NEUTRAL: Self = Self { slope: [1.0; 3], offset: [0.0; 3], power: [1.0; 3], saturation: 1.0 };
}

/// Spellings of the elements that the standard accepts.
const SOP: [&str; 2] = ["SOPNode", "ASC_SOP"];
const SAT: [&str; 3] = ["SatNode", "SATNode", "ASC_SAT"];

const DESCRIPTIONS: [&str; 3] = ["Description", "InputDescription", "ViewingDescription"];

/// Parses the color correction with this id from a file. Without an id the file must have exactly one correction.
///
/// # Errors
/// XML that cannot be read, another kind of file, an id that is missing, unknown or there twice, numbers that are
/// missing or outside of the domain: slopes from 0 on, powers above 0, saturations from 0 on.
pub fn parse_correction(text: &str, id: &str) -> Result<ColorCorrection, LutError> {
    let document = xml::parse(text)?;
    let root = document.root_element();
    let corrections = match name(root) {
        "ColorCorrection" => vec![root],
        "ColorCorrectionCollection" => corrections(root),
        "ColorDecisionList" => decisions(root)?,
        other => return Err(error(root, format!("`{}` is no element of a color correction", short(other)))),
    };
    values(chosen(root, &corrections, id)?)
}

fn corrections<'a, 'i>(node: Node<'a, 'i>) -> Vec<Node<'a, 'i>> {
    elements(node).filter(|element| name(*element) == "ColorCorrection").collect()
}

/// The corrections of a list of decisions. A decision may refer to a correction of another decision.
fn decisions<'a, 'i>(root: Node<'a, 'i>) -> Result<Vec<Node<'a, 'i>>, LutError> {
    let decisions = || elements(root).filter(|element| name(*element) == "ColorDecision");
    let found: Vec<_> = decisions().flat_map(corrections).collect();
    let references = decisions().flat_map(elements).filter(|element| name(*element) == "ColorCorrectionRef");
    for reference in references {
        let id = xml::attribute(reference, "ref")?;
        if !found.iter().any(|correction| correction.attribute("id") == Some(id)) {
            return Err(error(reference, format!("no correction of the file has the id `{}`", short(id))));
        }
    }
    Ok(found)
}

fn chosen<'a, 'i>(root: Node<'a, 'i>, all: &[Node<'a, 'i>], id: &str) -> Result<Node<'a, 'i>, LutError> {
    let has_id = |node: &&Node<'a, 'i>| node.attribute("id").map(str::trim) == Some(id);
    let found: Vec<_> = if id.is_empty() { all.iter().collect() } else { all.iter().filter(has_id).collect() };
    match (found.as_slice(), id) {
        ([one], _) => Ok(**one),
        ([], "") => Err(error(root, "the file has no `ColorCorrection`")),
        ([], _) => Err(LutError::new(0, format!("no correction has the id `{}`; {}", short(id), ids(all)))),
        (_, "") => Err(LutError::new(0, format!("the file has {} corrections: set `id`; {}", all.len(), ids(all)))),
        ([_, second, ..], _) => Err(error(**second, format!("the id `{}` is there twice", short(id)))),
    }
}

fn ids(all: &[Node<'_, '_>]) -> String {
    const SHOWN: usize = 8;
    let ids = all.iter().filter_map(|node| node.attribute("id"));
    let shown: Vec<String> = ids.clone().take(SHOWN).map(|id| format!("`{}`", short(id))).collect();
    let more = if ids.count() > SHOWN { " and more" } else { "" };
    format!("the ids are {}{more}", shown.join(", "))
}

fn values(correction: Node<'_, '_>) -> Result<ColorCorrection, LutError> {
    let is_known = |key: &str| DESCRIPTIONS.contains(&key) || SOP.contains(&key) || SAT.contains(&key);
    if let Some(other) = elements(correction).find(|element| !is_known(name(*element))) {
        return Err(error(other, format!("a correction has no element `{}`", short(name(other)))));
    }
    let mut values = ColorCorrection::NEUTRAL;
    if let Some(sop) = xml::element(correction, &SOP)? {
        (values.slope, values.offset, values.power) = slope_offset_power(sop)?;
    }
    if let Some(sat) = xml::element(correction, &SAT)? {
        values.saturation = saturation(sat)?;
    }
    Ok(values)
}

type Triples = ([f32; 3], [f32; 3], [f32; 3]);

/// The numbers of a node for slope, offset and power.
pub(crate) fn slope_offset_power(sop: Node<'_, '_>) -> Result<Triples, LutError> {
    let [slope, offset, power] = ["Slope", "Offset", "Power"].map(|key| xml::required(sop, &[key]));
    let (slope, offset, power) = (slope?, offset?, power?);
    let [slopes, offsets, powers] = [numbers::<3>(slope)?, numbers(offset)?, numbers(power)?];
    if slopes.iter().any(|x| *x < 0.0) {
        return Err(error(slope, "a slope is 0 or more"));
    }
    if powers.iter().any(|x| *x <= 0.0) {
        return Err(error(power, "a power is above 0"));
    }
    let narrow = |v: [f64; 3]| v.map(|x| x as f32);
    Ok((narrow(slopes), narrow(offsets), narrow(powers)))
}

/// The number of a node for saturation.
pub(crate) fn saturation(sat: Node<'_, '_>) -> Result<f32, LutError> {
    let saturation = xml::required(sat, &["Saturation"])?;
    match numbers::<1>(saturation)? {
        [x] if x >= 0.0 => Ok(x as f32),
        _ => Err(error(saturation, "a saturation is 0 or more")),
    }
}
