//! Entries of the sections of a pipeline file.

use std::ops::Range;
use std::sync::Arc;

use super::claim::Claim;
use super::tree::{Field, Group, Item};
use afterimage_base::diagnostic::{Diagnostics, Location, Spanned};
use afterimage_base::image::ColorState;

/// A pipeline file as it is written. It may have errors.
#[derive(Clone, Debug)]
pub struct Document {
    /// The file's name.
    pub file: Arc<str>,
    /// Location of the word `Pipeline`.
    pub location: Location,
    /// The file that this one changes.
    pub extends: Option<Spanned<String>>,
    /// The images and blocks that the host gives.
    pub inputs: Vec<InputEntry>,
    /// The nodes.
    pub nodes: Vec<NodeEntry>,
    /// The images that the host gets.
    pub outputs: Vec<OutputEntry>,
    /// Changes to nodes, in the order in which they are made.
    pub set: Vec<Override>,
    /// The quality levels.
    pub tiers: Vec<(Spanned<String>, Tier)>,
    /// Measurements of tiers. A file that extends this one does not inherit them.
    pub claims: Vec<(Spanned<String>, Claim)>,
    /// The facts that conditions may use, with their meanings; `None` if the file does not list them.
    pub facts: Option<Vec<(Spanned<String>, String)>>,
    /// The parameters that people change first, with their meanings in this pipeline.
    pub usual: Vec<(Spanned<String>, Spanned<String>)>,
    /// Mistakes that can be seen without knowing any node kind.
    pub problems: Diagnostics,
    /// Names whose entries could not be read, so that nothing is reported twice.
    pub(crate) unread: Vec<String>,
    /// True if more names are missing than `unread` knows.
    pub(crate) is_partial: bool,
}

/// An image or a host block that the host gives.
#[derive(Clone, Debug, PartialEq)]
pub struct InputEntry {
    /// Its name.
    pub name: Spanned<String>,
    /// Color state of an image.
    pub state: ColorState,
    /// Channels that an image has at least.
    pub min_channels: u8,
    /// The name of a type that is none of images: that of a host block, if some kind declares it.
    pub block: Option<Spanned<String>>,
    /// True if the host may leave it out.
    pub optional: bool,
    /// True if it has several samples in each pixel.
    pub multisampled: bool,
    /// True if it is a volume.
    pub volume: bool,
    /// True if the pipeline needs an alpha that is not 1 everywhere.
    pub needs_alpha: bool,
    /// A factor of its colors, before anything is limited.
    pub scale: f64,
}

/// An image that the host gets.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputEntry {
    /// Its name.
    pub name: Spanned<String>,
    /// The text of its wire.
    pub source: Spanned<String>,
    /// True if its alpha is coverage: the share of the pixel that the picture covers.
    pub has_coverage: bool,
}

/// A node.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeEntry {
    /// Its name.
    pub name: Spanned<String>,
    /// The name of its kind.
    pub kind: Spanned<String>,
    /// Ports, parameters and what every node takes, in the order of the file; a name may occur twice.
    pub(crate) fields: Group<Field>,
}

impl NodeEntry {
    /// The bytes from its name to its last field.
    pub fn span(&self) -> Range<usize> {
        let ends = self.fields.entries.iter().map(|(_, item)| item.location.end);
        self.name.location.start..ends.chain([self.kind.location.end]).max().unwrap_or(self.kind.location.end)
    }
}

/// A change to a node: `"mips.levels": 3` or `"local": Off`.
#[derive(Clone, Debug, PartialEq)]
pub struct Override {
    /// `node.parameter`, `node`, or either of them behind `outer/`.
    pub key: Spanned<String>,
    pub(crate) value: Item,
}

/// Content of a tier.
#[derive(Clone, Debug, PartialEq)]
pub enum Tier {
    /// The same pipeline with changes.
    Settings(Vec<Override>),
    /// Another file.
    File(Spanned<String>),
}
