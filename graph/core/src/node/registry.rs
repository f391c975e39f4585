//! The table of kinds that a program knows.

use std::collections::{BTreeMap, BTreeSet};

use super::block::HostBlock;
use super::kind::NodeKind;
use afterimage_base::value::{ChoiceName, Param, Type};
use afterimage_wgsl::ShaderError;

/// All node kinds of a program, by name.
#[derive(Clone, Debug, Default)]
pub struct Registry {
    kinds: BTreeMap<String, NodeKind>,
}

/// Error of a table of kinds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RegistryError {
    /// Two kinds have this name.
    DuplicateKind(String),
    /// A shader of a kind cannot be linked, or is not valid.
    Shader {
        /// The name of the kind.
        kind: String,
        /// The error, at the author's file and line.
        error: Box<ShaderError>,
    },
}

impl std::fmt::Display for RegistryError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::DuplicateKind(name) => write!(f, "two node kinds are called `{name}`"),
            Self::Shader { kind, error } => write!(f, "the shader of `{kind}` is wrong: {error}"),
        }
    }
}

impl std::error::Error for RegistryError {}

impl Registry {
    /// All kinds of several tables.
    ///
    /// # Errors
    /// Two of them share a name, or a shader that a kind [lists](super::TypedKind::SHADERS) is wrong.
    pub fn new(tables: &[&[NodeKind]]) -> Result<Self, RegistryError> {
        let mut kinds = BTreeMap::new();
        for kind in tables.iter().copied().flatten() {
            if kinds.insert(kind.name().to_owned(), kind.clone()).is_some() {
                return Err(RegistryError::DuplicateKind(kind.name().to_owned()));
            }
            for shader in kind.shaders() {
                if let Err(error) = shader.reflect() {
                    return Err(RegistryError::Shader { kind: kind.name().to_owned(), error: Box::new(error) });
                }
            }
        }
        Ok(Self { kinds })
    }

    /// The kind of that name.
    pub fn get(&self, name: &str) -> Option<&NodeKind> {
        self.kinds.get(name)
    }

    /// All kinds, by name.
    pub fn iter(&self) -> impl Iterator<Item = &NodeKind> + '_ {
        self.kinds.values()
    }

    /// The host block of that name, which a port of some kind declares.
    pub fn block(&self, name: &str) -> Option<&'static HostBlock> {
        self.blocks().find(|block| block.name == name)
    }

    /// The host blocks that ports declare; one that several ports declare comes as often.
    pub fn blocks(&self) -> impl Iterator<Item = &'static HostBlock> + '_ {
        self.iter().flat_map(|kind| kind.blocks())
    }

    /// The names of the kinds that a topic such as `bloom` or `film grain` may mean, the likeliest first: those whose
    /// own name has its words or is abbreviated by it, and those with a choice or a first paragraph that has them. If
    /// there are none, those whose manual has them anywhere.
    pub fn about(&self, topic: &str) -> Vec<&str> {
        let meant =
            SYNONYMS.iter().find(|(word, _)| topic.eq_ignore_ascii_case(word)).map_or(topic, |(_, words)| words);
        let words: Vec<String> = stems(meant).filter(|word| word.len() > 2).collect();
        let is_about = |text: &str| {
            let found: BTreeSet<String> = stems(text).collect();
            !words.is_empty() && words.iter().all(|word| found.contains(word))
        };
        let rank = |kind: &NodeKind| {
            let initials: String = kind.name().chars().filter(|c| c.is_ascii_uppercase()).collect();
            if is_about(kind.name()) || initials.len() > 1 && initials.eq_ignore_ascii_case(topic) {
                return Some(0);
            }
            if kind.params().iter().any(|param| choices(param).iter().any(|choice| is_about(choice.name))) {
                return Some(1);
            }
            let paragraph = kind.doc().split("\n\n").next().unwrap_or_default();
            let is_in_manual = || is_about(kind.doc()) || kind.params().iter().any(|param| is_about(&param.doc));
            if is_about(paragraph) { Some(2) } else { is_in_manual().then_some(3) }
        };
        let mut found: Vec<(u32, &str)> = self.iter().filter_map(|kind| Some((rank(kind)?, kind.name()))).collect();
        found.sort_unstable();
        if found.first().is_some_and(|(rank, _)| *rank < 3) {
            found.retain(|(rank, _)| *rank < 3);
        }
        found.into_iter().map(|(_, name)| name).collect()
    }

    /// All names, sorted.
    pub fn names(&self) -> impl Iterator<Item = &str> + '_ {
        self.kinds.keys().map(String::as_str)
    }
}

fn choices(param: &Param) -> &'static [ChoiceName] {
    match param.ty {
        Type::Choice(choices) => choices,
        _ => &[],
    }
}

/// Words of the field that no manual has, and words of the manuals that say the same.
const SYNONYMS: [(&str, &str); 36] = [
    ("aa", "smooths edges"),
    ("adaptation", "adapts"),
    ("anti-aliasing", "smooths edges"),
    ("antialiasing", "smooths edges"),
    ("ao", "ambient occlusion"),
    ("black and white", "saturation"),
    ("blurry background", "focus"),
    ("bokeh", "focus"),
    ("brighter", "exposure"),
    ("bw", "saturation"),
    ("cartoon", "halftone"),
    ("clarity", "contrast regions"),
    ("comic", "halftone"),
    ("cooler", "temperature"),
    ("crop", "cuts sides"),
    ("dark corners", "vignette"),
    ("darker", "exposure"),
    ("defocus", "focus"),
    ("duotone", "gradient luminance"),
    ("eye adaptation", "adapts"),
    ("fisheye", "bends lens"),
    ("glow", "bloom"),
    ("grayscale", "saturation"),
    ("lightshafts", "shafts"),
    ("miniature", "tilt-shift"),
    ("mips", "pyramid"),
    ("monochrome", "saturation"),
    ("msaa", "multisampled"),
    ("old movie", "film grain"),
    ("posterize", "levels channel"),
    ("resize", "scales image"),
    ("sepia", "gradient luminance"),
    ("tonemapping", "tone curve"),
    ("velocity", "moves path"),
    ("warm", "temperature"),
    ("warmer", "temperature"),
];

/// The words without endings of grammar: those of `grading` and of `grades` are equal.
fn stems(text: &str) -> impl Iterator<Item = String> {
    words(text).into_iter().map(|word| {
        let endings = ["ing", "es", "ed", "s", "e"].into_iter();
        let stem = endings.filter_map(|ending| word.strip_suffix(ending)).find(|stem| stem.len() > 3);
        stem.map(str::to_owned).unwrap_or(word)
    })
}

/// The words of a text or of a name such as `ColorLut`, in lower case.
fn words(text: &str) -> Vec<String> {
    let mut words = Vec::new();
    for part in text.split(|c: char| !c.is_alphabetic()) {
        let mut word = String::new();
        let mut before = ' ';
        for c in part.chars() {
            if c.is_uppercase() && before.is_lowercase() {
                words.push(std::mem::take(&mut word));
            }
            word.extend(c.to_lowercase());
            before = c;
        }
        words.push(word);
    }
    words.retain(|word| !word.is_empty());
    words
}
