//! Selection of the part and the channels that make the picture.
//!
//! Channels are grouped by what stands before the last dot of their names, so `diffuse.R` belongs
//! to layer `diffuse` and `R` to the nameless one. The name of a part counts as a layer around
//! its channels.

use afterimage_base::diagnostic::did_you_mean;
use exr::meta::header::Header;

use super::label::cryptomattes;
use super::{luminance_chroma, text, unsupported};
use crate::codec::{CodecError, ErrorKind};

/// The names that renderers have for the picture that all others are parts of: Blender, Arnold and Nuke, Redshift
/// and V-Ray, Karma, RenderMan.
const PICTURES: [&str; 6] = ["combined", "rgba", "beauty", "rgb", "c", "ci"];

/// The channel of each of red, green, blue and alpha.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Choice {
    pub(super) part: usize,
    /// Channel indices; `None` is 0 for a color and 1 for alpha.
    pub(super) slots: [Option<usize>; 4],
    /// True for color, which is converted to Rec.709; false for data such as depth.
    pub(super) is_color: bool,
}

/// Finds what `layer` names, or the most likely picture of the file where it is `None`.
pub(super) fn choose(headers: &[Header], layer: Option<&str>) -> Result<Choice, CodecError> {
    let parts = parts(headers);
    match layer {
        Some(name) => named(&parts, name),
        None => likely(headers, &parts).ok_or_else(|| no_picture(&parts)),
    }
    .map_err(|error| if is_luminance_chroma(&parts, &error) { luminance_chroma() } else { error })
}

/// The sentence about the layer that is read if no name chooses one and several could be. Plain `R`, `G` and `B` are
/// the picture, whatever there is besides.
pub(super) fn chosen_layer(headers: &[Header]) -> Option<String> {
    let parts = parts(headers);
    let layers = layers(headers, &parts);
    let chosen = layers.first().filter(|chosen| !(chosen.is_color && chosen.name.is_empty()))?;
    let others = layers[1..].iter().filter(|other| other.is_color == chosen.is_color && !other.name.is_empty());
    let mut others: Vec<String> = others.map(|other| format!("`{}`", other.name)).collect();
    others.sort();
    let others = match others.len() {
        0 => return None,
        1..=6 => others.join(", "),
        all => format!("{}, and {} more", others[..6].join(", "), all - 6),
    };
    let chosen = if chosen.name.is_empty() { "without a name" } else { &format!("`{}`", chosen.name) };
    Some(format!("the layer {chosen} is read, and not {others}; `FILE.exr#LAYER` chooses another"))
}

/// Names of the layers that have one, and of the channels that no layer has.
pub(super) fn names(headers: &[Header]) -> Vec<String> {
    let parts = parts(headers);
    let layers = layers(headers, &parts);
    let mut names: Vec<String> = layers.iter().map(|layer| layer.name.clone()).collect();
    for part in &parts {
        let of_part = layers.iter().filter(|layer| layer.choice.part == part.index);
        let shown: Vec<usize> = of_part.flat_map(|layer| layer.choice.slots).flatten().collect();
        for group in &part.groups {
            let own = part.name.as_deref().filter(|_| parts.len() > 1 && part.below(&group.prefix).is_none());
            let others = group.channels.iter().filter(|(_, index)| !shown.contains(index));
            let words = others.map(|(last, _)| [own.unwrap_or_default(), &group.prefix, last]);
            names.extend(
                words.map(|words| words.into_iter().filter(|word| !word.is_empty()).collect::<Vec<_>>().join(".")),
            );
        }
    }
    names.retain(|name| !name.is_empty());
    names
}

fn parts(headers: &[Header]) -> Vec<Part> {
    headers.iter().enumerate().map(|(index, header)| Part::new(index, header)).collect()
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
            let full = text(&description.name);
            let (prefix, last) = full.rsplit_once('.').unwrap_or(("", &full));
            let entry = (last.to_owned(), channel);
            match groups.iter_mut().find(|group| group.prefix == prefix) {
                Some(group) => group.channels.push(entry),
                None => groups.push(Group { prefix: prefix.to_owned(), channels: vec![entry] }),
            }
        }
        groups.sort_by(|a, b| a.prefix.cmp(&b.prefix));
        let name = header.own_attributes.layer_name.as_ref().map(text);
        Self { index, name: name.filter(|name| !name.is_empty()), groups }
    }

    /// The rest of `name` when this part's own name is taken off its front.
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

    /// The picture that a group of a part shows: a color, a luminance, a vector, or its only channel.
    fn pick(&self, part: usize) -> Option<Choice> {
        if self.find(&["RY"]).or(self.find(&["BY"])).is_some() {
            return None;
        }
        let alpha = self.find(&["A", "alpha"]);
        let others: Vec<&(String, usize)> =
            self.channels.iter().filter(|(_, index)| self.channels.len() == 1 || Some(*index) != alpha).collect();
        let rgb = [["R", "red"], ["G", "green"], ["B", "blue"]].map(|names| self.find(&names));
        let [x, y, z] = ["X", "Y", "Z"].map(|name| self.find(&[name]));
        let [u, v, w] = ["U", "V", "W"].map(|name| self.find(&[name]));
        let (slots, is_color) = match (others.as_slice(), rgb, y) {
            // One channel is gray, whatever its letter.
            (&[&(_, only)], ..) => {
                let is_color = y == Some(only) || rgb.contains(&Some(only));
                (gray(only, alpha.filter(|alpha| *alpha != only)), is_color)
            }
            (_, [_, Some(_), _] | [Some(_), _, Some(_)], _) => ([rgb[0], rgb[1], rgb[2], alpha], true),
            _ if x.is_some() && y.is_some() => ([x, y, z, alpha], false),
            _ if u.is_some() && v.is_some() => ([u, v, w, alpha], false),
            (_, _, Some(luminance)) => (gray(luminance, alpha), true),
            _ => return None,
        };
        Some(Choice { part, slots, is_color })
    }
}

/// The channels of color layers, which are in the primaries of the file. The colors of Cryptomatte are
/// numbers of objects.
pub(super) fn color_channels(header: &Header) -> Vec<usize> {
    let mattes = cryptomattes(header);
    let groups = Part::new(0, header).groups;
    let choices = groups.iter().filter(|group| !is_matte(&mattes, &group.prefix)).filter_map(|group| group.pick(0));
    let colors = choices.filter(|choice| choice.is_rgb());
    colors.flat_map(|choice| [0, 1, 2].map(|slot| choice.slots[slot])).flatten().collect()
}

/// True for a layer that is a rank of one of these Cryptomattes.
fn is_matte(mattes: &[String], layer: &str) -> bool {
    let mut ranks = mattes.iter().filter_map(|matte| layer.strip_prefix(matte.as_str()));
    ranks.any(|rank| rank.bytes().all(|byte| byte.is_ascii_digit()))
}

impl Choice {
    /// True for a color that is not gray.
    pub(super) fn is_rgb(&self) -> bool {
        self.is_color && self.slots[0] != self.slots[1]
    }
}

fn gray(channel: usize, alpha: Option<usize>) -> [Option<usize>; 4] {
    [Some(channel), Some(channel), Some(channel), alpha]
}

/// A layer that can be shown.
struct Layer {
    choice: Choice,
    /// Its name with that of its part.
    name: String,
    /// True for color: neither data nor identifiers of objects.
    is_color: bool,
}

/// The likely picture of a file.
fn likely(headers: &[Header], parts: &[Part]) -> Option<Choice> {
    layers(headers, parts).into_iter().next().map(|layer| layer.choice)
}

/// All layers that can be shown, the most likely picture first: a color before a gray and before data, then a layer
/// without a name, then what is [called](PICTURES) so, then the channels without a layer of a part, then the views in
/// their order.
fn layers(headers: &[Header], parts: &[Part]) -> Vec<Layer> {
    let views = views(headers);
    let mut found = Vec::new();
    for (part, header) in parts.iter().zip(headers) {
        let mattes = cryptomattes(header);
        for group in &part.groups {
            let Some(choice) = group.pick(part.index) else { continue };
            let own = part.name.as_deref().filter(|_| parts.len() > 1).unwrap_or_default();
            let own = if part.below(&group.prefix).is_some() { "" } else { own };
            let words: Vec<&str> =
                [own, &group.prefix].iter().flat_map(|name| name.split('.')).filter(|word| !word.is_empty()).collect();
            let view_of = |word: &str| views.iter().position(|view| view.eq_ignore_ascii_case(word));
            let view = words.iter().find_map(|word| view_of(word)).map_or(0, |view| view + 1);
            let rank = match words.iter().rfind(|word| view_of(word).is_none()) {
                None => 0,
                Some(word) => {
                    let known = PICTURES.iter().position(|picture| picture.eq_ignore_ascii_case(word));
                    known.map_or(usize::MAX, |known| known + 1)
                }
            };
            let is_color = choice.is_color && !is_matte(&mattes, &group.prefix);
            let order = (!is_color, !choice.is_rgb(), rank, !group.prefix.is_empty(), view);
            found.push((order, Layer { choice, name: words.join("."), is_color }));
        }
    }
    found.sort_by_key(|(order, _)| *order);
    found.into_iter().map(|(_, layer)| layer).collect()
}

/// The names of the views, the default one first: the first that a list of views has, otherwise the left one.
fn views(headers: &[Header]) -> Vec<String> {
    let own = headers.iter().map(|header| &header.own_attributes);
    let listed = own.clone().flat_map(|own| own.multi_view_names.iter().flatten()).map(text);
    let named = own.filter_map(|own| own.view_name.as_ref()).map(text);
    listed.chain(["left".to_owned(), "right".to_owned()]).chain(named).collect()
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
