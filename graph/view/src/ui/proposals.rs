//! Proposals for a place of the text: sections, kinds, ports, parameters, values, and wires.

use afterimage_graph::check::{Graph, NODE_FIELDS, Source};
use afterimage_graph::document::{SECTIONS, TokenKind, image_type_names};
use afterimage_graph::image::Format;
use afterimage_graph::node::{NodeKind, PortType};
use afterimage_graph::value::{Param, Type};

use super::text_place::TextPlace;

/// Something that can be written.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Proposal {
    pub(super) name: String,
    /// The text that replaces the word at the cursor.
    pub(super) text: String,
    /// Bytes at the end of it that the cursor stands before.
    pub(super) back: usize,
    pub(super) detail: String,
    pub(super) doc: String,
}

impl Proposal {
    fn new(name: &str, text: String, detail: impl Into<String>, doc: &str) -> Self {
        Self { name: name.to_owned(), text, back: 0, detail: detail.into(), doc: doc.to_owned() }
    }

    /// A name without quotes.
    fn plain(name: &str, detail: impl Into<String>, doc: &str) -> Self {
        Self::new(name, name.to_owned(), detail, doc)
    }

    fn quoted(name: &str, detail: impl Into<String>, doc: &str) -> Self {
        Self::new(name, format!("\"{name}\""), detail, doc)
    }

    /// A key, with its colon unless that is there.
    fn key(self, place: &TextPlace) -> Self {
        let colon = if place.next == Some(TokenKind::Colon) { "" } else { ": " };
        Self { text: self.text + colon, ..self }
    }
}

/// The source of proposals: the kinds, and the last graph without errors.
pub(super) struct Known<'k> {
    pub(super) kinds: &'k [NodeKind],
    pub(super) graph: Option<&'k Graph>,
}

impl<'k> Known<'k> {
    pub(super) fn kind(&self, name: &str) -> Option<&'k NodeKind> {
        self.kinds.iter().find(|kind| kind.name() == name)
    }

    /// The kind of a node, which the text or what it inherits names.
    fn kind_of_node(&self, place: &TextPlace, node: &str) -> Option<&'k NodeKind> {
        let written = place.nodes.iter().find(|(name, _)| name == node).and_then(|(_, kind)| self.kind(kind));
        written.or_else(|| Some(self.graph?.node(node)?.1.kind()))
    }

    /// The kind that the place is about, and the name of its port or parameter there.
    pub(super) fn described(&self, place: &TextPlace) -> Option<(&'k NodeKind, Option<String>)> {
        let section = &*place.groups.get(1)?.key;
        let present = place.key.clone().or_else(|| Some(place.typed.clone()).filter(|typed| !typed.is_empty()));
        match (section, place.groups.get(2)) {
            ("nodes", Some(group)) => Some((self.kind(&group.name)?, present.filter(|_| place.groups.len() == 3))),
            ("nodes", None) => Some((self.kind_of_node(place, &present?)?, None)),
            _ => {
                let name = present?;
                let (node, field) = name.rsplit_once('.').unwrap_or((&name, ""));
                Some((self.kind_of_node(place, node)?, Some(field.to_owned())))
            }
        }
    }

    /// All that can be written at a place, the likeliest first.
    pub(super) fn proposals(&self, place: &TextPlace) -> Vec<Proposal> {
        let found = self.all(place);
        let typed = place.typed.to_lowercase();
        let rank = |proposal: &Proposal| {
            let name = proposal.name.to_lowercase();
            match (name.starts_with(&typed), name.contains(&typed)) {
                (true, _) => Some(0),
                (_, true) => Some(1),
                // Of kinds, the manual is searched, too.
                _ => (typed.len() > 2 && proposal.doc.to_lowercase().contains(&typed)).then_some(2),
            }
        };
        let mut ranked: Vec<(usize, Proposal)> =
            found.into_iter().filter_map(|proposal| Some((rank(&proposal)?, proposal))).collect();
        ranked.sort_by_key(|(rank, _)| *rank);
        ranked.into_iter().map(|(_, proposal)| proposal).collect()
    }

    fn all(&self, place: &TextPlace) -> Vec<Proposal> {
        let groups: Vec<&str> = place.groups.iter().skip(1).map(|group| &*group.key).collect();
        match (&groups[..], place.key.as_deref()) {
            ([], None) if place.groups.len() == 1 => {
                let unwritten = SECTIONS.iter().filter(|section| !has_key(place, section));
                unwritten.map(|section| Proposal::plain(section, "section", "").key(place)).collect()
            }
            (["nodes"], Some(_)) => self.kinds.iter().map(|kind| of_kind(kind, place)).collect(),
            (["inputs"], Some(_)) => {
                let blocks = self.kinds.iter().flat_map(|kind| kind.blocks());
                let mut found: Vec<Proposal> =
                    image_type_names().map(|name| Proposal::plain(name, "image", "")).collect();
                found.extend(blocks.map(|block| Proposal::plain(block.name, "block", block.doc)));
                found.sort_by(|a, b| a.name.cmp(&b.name));
                found.dedup_by(|a, b| a.name == b.name);
                found
            }
            (["outputs"], Some(_)) => self.wires(place, None),
            (["set" | "usual"] | ["tiers", _], None) => self.parameters(place),
            (["set"] | ["tiers", _], Some(name)) => {
                let Some((node, field)) = name.rsplit_once('.') else {
                    return vec![Proposal::plain("Off", "", "The node does not run.")];
                };
                let param = self.kind_of_node(place, node).and_then(|kind| kind.param(field));
                param.map_or(Vec::new(), |(_, param)| values(param))
            }
            (["nodes", _], key) if place.groups.len() == 3 => {
                let Some(kind) = self.kind(&place.groups[2].name) else { return Vec::new() };
                key.map_or_else(|| fields(kind, place), |key| self.values_of(kind, key, place))
            }
            _ => Vec::new(),
        }
    }

    /// The values of a port, a parameter or a common field of a node.
    fn values_of(&self, kind: &NodeKind, field: &str, place: &TextPlace) -> Vec<Proposal> {
        if let Some(input) = kind.input(field) {
            return self.wires(place, Some(input.ty));
        }
        match (kind.param(field), field) {
            (Some((_, param)), _) => values(param),
            (None, "format") => Format::ALL.iter().map(|format| Proposal::plain(format.name(), "", "")).collect(),
            (None, _) => Vec::new(),
        }
    }

    /// The wires that can be read, those of a type first.
    fn wires(&self, place: &TextPlace, ty: Option<PortType>) -> Vec<Proposal> {
        let mut inputs: Vec<&str> = place.inputs.iter().map(|input| &**input).collect();
        let mut nodes: Vec<&str> = place.nodes.iter().map(|(node, _)| &**node).collect();
        let inherited = self.graph.into_iter().flat_map(|graph| &graph.inputs).map(|input| &*input.name);
        inputs.extend(inherited);
        let inherited = self.graph.into_iter().flat_map(|graph| &graph.nodes).map(|node| &*node.name);
        nodes.extend(inherited.filter(|name| !name.contains('/')));
        let own = place.groups.get(2).map(|group| &*group.key);
        let mut found: Vec<(Option<PortType>, Proposal)> = Vec::new();
        for name in inputs {
            let of_graph = self.graph.and_then(|graph| {
                let index = graph.inputs.iter().position(|input| input.name == name)?;
                Some(graph.port_type(Source::Input(index)))
            });
            found.push((of_graph, Proposal::quoted(name, "input", "An input of the pipeline.")));
        }
        for name in nodes {
            let Some(kind) = self.kind_of_node(place, name) else { continue };
            for (index, output) in kind.outputs().iter().enumerate() {
                let path = if index == 0 { name.to_owned() } else { format!("{name}.{}", output.name) };
                let detail = format!("{}, {}", kind.name(), output.ty.name());
                if own != Some(name) {
                    found.push((Some(output.ty), Proposal::quoted(&path, &*detail, &output.doc)));
                }
                if place.typed.contains('@') {
                    let earlier = format!("{path}@previous");
                    found.push((Some(output.ty), Proposal::quoted(&earlier, detail, "That of the frame before.")));
                }
            }
        }
        found.sort_by_key(|(of, _)| ty.is_some() && *of != ty);
        let mut names = std::collections::BTreeSet::new();
        found.into_iter().map(|(_, proposal)| proposal).filter(|proposal| names.insert(proposal.name.clone())).collect()
    }

    /// The names of parameters, and of nodes, for overrides.
    fn parameters(&self, place: &TextPlace) -> Vec<Proposal> {
        let inherited = self.graph.into_iter().flat_map(|graph| &graph.nodes);
        let mut nodes: Vec<&str> = place.nodes.iter().map(|(node, _)| &**node).collect();
        nodes
            .extend(inherited.map(|node| &*node.name).filter(|name| !place.nodes.iter().any(|(node, _)| node == name)));
        let mut found = Vec::new();
        for node in nodes {
            let Some(kind) = self.kind_of_node(place, node) else { continue };
            found.push(Proposal::quoted(node, kind.name(), "Off: the node does not run.").key(place));
            for param in kind.params() {
                let name = format!("{node}.{}", param.name);
                found.push(Proposal::quoted(&name, short_type(param), &param.doc).key(place));
            }
        }
        found
    }
}

fn has_key(place: &TextPlace, name: &str) -> bool {
    place.groups.last().is_some_and(|group| group.keys.iter().any(|key| key == name))
}

/// A kind with its parentheses, and the ports that must be wired.
fn of_kind(kind: &NodeKind, place: &TextPlace) -> Proposal {
    let inputs: Vec<&str> = kind.inputs().iter().filter(|input| !input.optional).map(|input| &*input.name).collect();
    let outputs: Vec<&str> = kind.outputs().iter().map(|output| &*output.name).collect();
    let detail = format!("{} → {}", inputs.join(", "), outputs.join(", "));
    let has_parentheses = place.next == Some(TokenKind::Open);
    let text = if has_parentheses { kind.name().to_owned() } else { format!("{}()", kind.name()) };
    Proposal { back: usize::from(!has_parentheses), ..Proposal::new(kind.name(), text, detail, kind.doc()) }
}

/// The ports and parameters of a kind that a node does not have yet, and what every node takes.
fn fields(kind: &NodeKind, place: &TextPlace) -> Vec<Proposal> {
    let inputs = kind.inputs().iter().map(|input| {
        let detail = if input.optional { ", may be left out" } else { "" };
        Proposal::plain(&input.name, format!("{}{detail}", input.ty.name()), &input.doc)
    });
    let params = kind.params().iter().map(|param| Proposal::plain(&param.name, short_type(param), &param.doc));
    let common = NODE_FIELDS.iter().map(|name| Proposal::plain(name, "of every node", ""));
    let is_open = |proposal: &Proposal| !has_key(place, &proposal.name) || place.next == Some(TokenKind::Colon);
    inputs.chain(params).chain(common).filter(is_open).map(|proposal| proposal.key(place)).collect()
}

/// The values of a parameter: its choices, or the default and the neutral one.
fn values(param: &Param) -> Vec<Proposal> {
    match param.ty {
        Type::Choice(choices) => choices.iter().map(|choice| Proposal::plain(choice.name, "", choice.doc)).collect(),
        Type::Bool => ["true", "false"].map(|name| Proposal::plain(name, "", &param.doc)).into(),
        _ => {
            let neutral = param.neutral.iter().filter(|neutral| **neutral != param.default);
            let neutral = neutral.map(|value| Proposal::plain(&value.to_string(), "changes nothing", &param.doc));
            let default = Proposal::plain(&param.default.to_string(), "the default", &param.doc);
            std::iter::once(default).chain(neutral).collect()
        }
    }
}

/// The type of a parameter in a word, with its default.
pub(super) fn short_type(param: &Param) -> String {
    let default = &param.default;
    match (param.ty, param.domain) {
        (Type::Choice(_), _) => format!("choice, {default}"),
        (Type::File, _) => "file".into(),
        (_, Some((low, high))) => format!("{default}, from {low} to {high}"),
        _ => format!("{default}"),
    }
}

#[cfg(test)]
mod tests {
    use afterimage_graph::document::tokens;
    use afterimage_graph::node::Registry;

    use super::*;

    fn proposed(marked: &str) -> Vec<Proposal> {
        let registry = Registry::new(&[afterimage_nodes::ALL]).expect("names are unique");
        let kinds: Vec<NodeKind> = registry.iter().cloned().collect();
        let at = marked.find('|').expect("the text has a mark");
        let text = marked.replace('|', "");
        Known { kinds: &kinds, graph: None }.proposals(&TextPlace::of(&text, &tokens(&text), at))
    }

    fn names(marked: &str) -> Vec<String> {
        proposed(marked).into_iter().map(|proposal| proposal.name).collect()
    }

    /// A pipeline whose third node is this text.
    fn third(node: &str) -> String {
        let first = r#""exposed": Exposure(source: "scene"), "mips": Downsample(source: "exposed"),"#;
        format!("Pipeline(inputs: {{ \"scene\": Color }}, nodes: {{ {first} \"third\": {node} }})")
    }

    #[test]
    fn kinds_ports_parameters_values_and_wires_are_proposed_where_they_belong() {
        assert_eq!(names("Pipeline(inputs: {}, no|"), ["nodes"]);
        assert_eq!(names(&third("Vign|"))[0], "Vignette");
        assert_eq!(names(&third("ToneMap(|)"))[..2], ["source", "curve"]);
        assert!(!names(&third("ToneMap(source: \"exposed\", |)")).contains(&"source".to_owned()));
        assert!(names(&third("ToneMap(curve: |)")).contains(&"AcesNarkowicz".to_owned()));
        assert_eq!(names(&third("ToneMap(curve: AcesNark|)"))[0], "AcesNarkowicz");
        // Wires that a port can take come first: a pyramid is no image.
        let wires = names(&third("ToneMap(source: |)"));
        assert_eq!((&*wires[0], wires.contains(&"third".to_owned())), ("exposed", false));
        assert_eq!(names(&third("Upsample(source: |)"))[0], "mips");
        assert_eq!(names(&third("ToneMap(source: \"mi|"))[..2], ["mips.coarsest", "mips"]);
        assert_eq!(names(&third("ToneMap(source: \"exposed@|\")")), ["exposed@previous"]);
        assert!(names(&third("ToneMap(format: Rgba16|)")).contains(&"Rgba16Float".to_owned()));
        assert!(names("Pipeline(inputs: { \"z\": De|").contains(&"Depth".to_owned()));
    }

    #[test]
    fn what_is_written_has_its_signs_and_they_are_not_doubled() {
        let first = |marked: &str| proposed(marked).remove(0);
        assert_eq!((&*first(&third("Vignette|")).text, first(&third("Vignette|")).back), ("Vignette()", 1));
        assert_eq!(first(&third("Vignette|(source: \"a\")")).text, "Vignette");
        assert_eq!(first(&third("ToneMap(cur|)")).text, "curve: ");
        assert_eq!(first(&third("ToneMap(cur|: AcesNarkowicz)")).text, "curve");
        assert_eq!(first(&third("ToneMap(source: exp|)")).text, "\"exposed\"");
        let with_tier = third("ToneMap()").replace("})", "}, tiers: { \"low\": { \"third.cur|");
        assert_eq!(first(&with_tier).text, "\"third.curve\": ");
    }

    #[test]
    fn the_cursor_is_about_a_kind_and_one_of_its_fields() {
        let registry = Registry::new(&[afterimage_nodes::ALL]).expect("names are unique");
        let kinds: Vec<NodeKind> = registry.iter().cloned().collect();
        let described = |marked: &str| {
            let (at, text) = (marked.find('|').expect("a mark"), marked.replace('|', ""));
            let place = TextPlace::of(&text, &tokens(&text), at);
            let (kind, field) = Known { kinds: &kinds, graph: None }.described(&place)?;
            Some((kind.name().to_owned(), field))
        };
        let is = |kind: &str, field: Option<&str>| Some((kind.to_owned(), field.map(str::to_owned)));
        assert_eq!(described(&third("ToneMap(curve: Aces|)")), is("ToneMap", Some("curve")));
        assert_eq!(described(&third("Tone|Map()")), is("ToneMap", None));
        assert_eq!(described("Pipeline(|)"), None);
    }
}
