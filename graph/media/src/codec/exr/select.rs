//! Which channels of which part make the picture.
//!
//! Channels are grouped by what stands before the last dot of their names, so `diffuse.R` belongs
//! to layer `diffuse` and `R` to the nameless one. The name of a part counts as a layer around
//! its channels.

use afterimage_base::diagnostic::did_you_mean;
use exr::meta::header::Header;

use super::label::cryptomattes;
use super::{subsampled, unsupported};
use crate::codec::{CodecError, ErrorKind};

/// Where each of red, green, blue and alpha is read from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Choice {
    /// Index of the header.
    pub(super) part: usize,
    /// Channel indices; `None` is 0 for a color and 1 for alpha.
    pub(super) slots: [Option<usize>; 4],
    /// Whether it is light, to be converted to Rec.709, or plain numbers such as depth.
    pub(super) is_color: bool,
}

/// Finds what `layer` names, or the most likely picture of the file where it is `None`.
pub(super) fn choose(headers: &[Header], layer: Option<&str>) -> Result<Choice, CodecError> {
    let parts: Vec<Part> = headers.iter().enumerate().map(|(index, header)| Part::new(index, header)).collect();
    match layer {
        Some(name) => named(&parts, name),
        None => likely(&parts).ok_or_else(|| no_picture(&parts)),
    }
    .map_err(|error| if is_luminance_chroma(&parts, &error) { subsampled() } else { error })
}

struct Part {
    index: usize,
    name: Option<String>,
    groups: Vec<Group>,
}

/// The channels that share a prefix, as (last component, index).
struct Group {
    prefix: String,
    channels: Vec<(String, usize)>,
}

impl Part {
    fn new(index: usize, header: &Header) -> Self {
        let mut groups: Vec<Group> = Vec::new();
        for (channel, description) in header.channels.list.iter().enumerate() {
            let full = description.name.to_string();
            let (prefix, last) = full.rsplit_once('.').unwrap_or(("", &full));
            let entry = (last.to_owned(), channel);
            match groups.iter_mut().find(|group| group.prefix == prefix) {
                Some(group) => group.channels.push(entry),
                None => groups.push(Group { prefix: prefix.to_owned(), channels: vec![entry] }),
            }
        }
        groups.sort_by(|a, b| a.prefix.cmp(&b.prefix));
        let name = header.own_attributes.layer_name.as_ref().map(ToString::to_string);
        Self { index, name: name.filter(|name| !name.is_empty()), groups }
    }

    /// What is left of `name` when this part's own name is taken off its front.
    fn below<'n>(&self, name: &'n str) -> Option<&'n str> {
        let rest = name.strip_prefix(self.name.as_deref()?)?;
        if rest.is_empty() { Some("") } else { rest.strip_prefix('.') }
    }

    fn layer(&self, prefix: &str) -> Option<Choice> {
        self.groups.iter().find(|group| group.prefix == prefix)?.pick(self.index)
    }

    fn channel(&self, name: &str) -> Option<Choice> {
        let (prefix, last) = name.rsplit_once('.').unwrap_or(("", name));
        let group = self.groups.iter().find(|group| group.prefix == prefix)?;
        let found = group.channels.iter().find(|(component, _)| component == last)?;
        Some(Choice { part: self.index, slots: gray(found.1, None), is_color: false })
    }

    fn whole(&self) -> Option<Choice> {
        self.groups.iter().find_map(|group| group.pick(self.index))
    }
}

impl Group {
    fn find(&self, names: &[&str]) -> Option<usize> {
        let is_one = |component: &str| names.iter().any(|name| name.eq_ignore_ascii_case(component));
        self.channels.iter().find(|(component, _)| is_one(component)).map(|(_, index)| *index)
    }

    /// How to see this group of a part as a picture: color, luminance, a vector, or its only channel.
    fn pick(&self, part: usize) -> Option<Choice> {
        if self.find(&["RY"]).or(self.find(&["BY"])).is_some() {
            return None;
        }
        let alpha = self.find(&["A", "alpha"]);
        let rgb = [["R", "red"], ["G", "green"], ["B", "blue"]].map(|names| self.find(&names));
        if let [_, Some(_), _] | [Some(_), _, Some(_)] = rgb {
            return Some(Choice { part, slots: [rgb[0], rgb[1], rgb[2], alpha], is_color: true });
        }
        let [x, y, z] = ["X", "Y", "Z"].map(|name| self.find(&[name]));
        let [u, v] = ["U", "V"].map(|name| self.find(&[name]));
        let (slots, is_color) = match (self.channels.as_slice(), y) {
            _ if x.is_some() && y.is_some() => ([x, y, z, alpha], false),
            _ if u.is_some() && v.is_some() => ([u, v, None, alpha], false),
            (_, Some(luminance)) => (gray(luminance, alpha), true),
            (&[(_, only)], _) => (gray(only, None), false),
            _ => return None,
        };
        Some(Choice { part, slots, is_color })
    }
}

/// The channels that are light in the primaries of the file: those of color layers. The colors of Cryptomatte are
/// numbers of objects.
pub(super) fn light_channels(header: &Header) -> Vec<usize> {
    let mattes = cryptomattes(header);
    let is_matte = |prefix: &str| {
        let mut ranks = mattes.iter().filter_map(|matte| prefix.strip_prefix(matte.as_str()));
        ranks.any(|rank| rank.bytes().all(|byte| byte.is_ascii_digit()))
    };
    let groups = Part::new(0, header).groups;
    let choices = groups.iter().filter(|group| !is_matte(&group.prefix)).filter_map(|group| group.pick(0));
    let light = choices.filter(|choice| choice.is_color && choice.slots[0] != choice.slots[1]);
    light.flat_map(|choice| [0, 1, 2].map(|slot| choice.slots[slot])).flatten().collect()
}

fn gray(channel: usize, alpha: Option<usize>) -> [Option<usize>; 4] {
    [Some(channel), Some(channel), Some(channel), alpha]
}

/// Plain color channels first, then any color layer, then any channels that can be shown.
fn likely(parts: &[Part]) -> Option<Choice> {
    let layers = || parts.iter().flat_map(|part| part.groups.iter().map(move |g| (part, g)));
    let color = |choice: &Choice| choice.is_color;
    let nameless = parts.iter().filter_map(|part| part.layer("")).find(color);
    let any_color = || layers().filter_map(|(part, g)| part.layer(&g.prefix)).find(color);
    let anything = || parts.iter().find_map(Part::whole);
    nameless.or_else(any_color).or_else(anything)
}

fn named(parts: &[Part], name: &str) -> Result<Choice, CodecError> {
    let below = || parts.iter().filter_map(|part| part.below(name).map(|rest| (part, rest)));
    parts
        .iter()
        .find_map(|part| part.layer(name))
        .or_else(|| below().find_map(|(part, rest)| part.layer(rest)))
        .or_else(|| parts.iter().find_map(|part| part.channel(name)))
        .or_else(|| below().find_map(|(part, rest)| part.channel(rest)))
        .or_else(|| below().filter(|(_, rest)| rest.is_empty()).find_map(|(part, _)| part.whole()))
        .ok_or_else(|| unknown(parts, name))
}

fn unknown(parts: &[Part], name: &str) -> CodecError {
    let group = parts.iter().flat_map(|part| &part.groups).find(|group| group.prefix == name);
    if let Some(group) = group {
        return unsupported(format!("layer `{name}` is neither a color nor a vector"))
            .hint(format!("name one of its channels: {}", group.full_names().join(", ")));
    }
    let groups: Vec<&Group> = parts.iter().flat_map(|part| &part.groups).collect();
    let channels: Vec<String> = groups.iter().flat_map(|group| group.full_names()).collect();
    let names = groups.iter().map(|group| &*group.prefix).chain(channels.iter().map(String::as_str));
    let near = did_you_mean(name, names.filter(|name| !name.is_empty()));
    CodecError::new(ErrorKind::Missing, format!("it has no layer or channel `{name}`"))
        .hint(near.unwrap_or_else(|| format!("it has {}", contents(parts))))
}

fn no_picture(parts: &[Part]) -> CodecError {
    unsupported("no layer of this EXR is a color picture")
        .hint(format!("name a channel after `#`, for example `file.exr#Z`; it has {}", contents(parts)))
}

/// Luminance-chroma channels at full size pass the decoder's own check for subsampling.
fn is_luminance_chroma(parts: &[Part], error: &CodecError) -> bool {
    let mut groups = parts.iter().flat_map(|part| &part.groups);
    error.kind == ErrorKind::Unsupported && groups.any(|g| g.find(&["RY", "BY"]).is_some())
}

impl Group {
    fn full_names(&self) -> Vec<String> {
        let dotted = |(last, _): &(String, usize)| match self.prefix.as_str() {
            "" => format!("`{last}`"),
            prefix => format!("`{prefix}.{last}`"),
        };
        self.channels.iter().map(dotted).collect()
    }
}

/// Every name a user could have meant, shortened where there are very many.
fn contents(parts: &[Part]) -> String {
    const ENOUGH: usize = 24;
    let mut names = Vec::new();
    for part in parts {
        let channels: Vec<String> = part.groups.iter().flat_map(Group::full_names).collect();
        match &part.name {
            Some(name) if parts.len() > 1 => {
                names.push(format!("part `{name}` ({})", channels.join(", ")));
            }
            _ => names.extend(channels),
        }
    }
    let more = names.len().saturating_sub(ENOUGH);
    names.truncate(ENOUGH);
    if more > 0 {
        names.push(format!("and {more} more"));
    }
    names.join(", ")
}
