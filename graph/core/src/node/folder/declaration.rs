//! Declaration in a `node.ron`.

use crate::node::{Input, Output, PortType};
use afterimage_base::diagnostic::{Location, Spanned};
use afterimage_base::image::{Format, Size};
use afterimage_base::value::Param;

/// A `node.ron`, with the locations that errors in the shader refer to.
pub(super) struct Declaration {
    pub(super) name: Spanned<String>,
    pub(super) doc: String,
    pub(super) inputs: Vec<(Input, Location)>,
    /// The images between inputs and outputs, and after them the outputs. Each may read those before it.
    pub(super) made: Vec<Made>,
    pub(super) params: Vec<(Param, Location)>,
    pub(super) of_color: bool,
}

/// An image or a pyramid that a function makes.
pub(super) struct Made {
    pub(super) name: Spanned<String>,
    pub(super) function: Spanned<String>,
    pub(super) shape: Shape,
    /// The size, if the shape does not imply it.
    pub(super) size: SizeRule,
    pub(super) format: Format,
    /// Arguments of the function that do not read what has their name.
    pub(super) reads: Vec<(Spanned<String>, Read)>,
    /// The port, if it is an output.
    pub(super) port: Option<Output>,
}

/// Calls of a function: their number and sizes.
pub(super) enum Shape {
    /// Once: an image. Its invocations may share workgroups of that many, across and down.
    Image { workgroup: Option<[u32; 2]> },
    /// From fine to coarse: a pyramid. The first level has half the size of the named image.
    Down { of: Spanned<String>, levels: u32 },
    /// For each level of the named pyramid: a pyramid.
    Each { of: Spanned<String> },
    /// From coarse to fine through the named pyramid: an image of the size of its finest level.
    Up { of: Spanned<String> },
}

/// Source of an argument that has another name.
pub(super) struct Read {
    pub(super) of: Spanned<String>,
    /// The level, of a pyramid; the coarsest one if there are fewer.
    pub(super) level: Option<u32>,
}

/// The size of an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SizeRule {
    Same,
    Half,
    Double,
    Fixed(u32, u32),
}

/// Source of an argument of a function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Source {
    /// An input, by its place.
    Input(usize),
    /// The result of another function, by its index.
    Made(usize),
    /// A level of a pyramid.
    Level(Pyramid, u32),
    /// Of a function that is called for several levels: the level at hand, or for `Down` the image above.
    AtHand,
    /// The result of `Up` so far, of the coarser levels.
    Coarser,
}

/// A pyramid: an input or what a function makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pyramid {
    Input(usize),
    Made(usize),
}

/// The argument of a function of `Up` with what was made of the coarser levels.
pub(super) const COARSER: &str = "coarser";

impl SizeRule {
    pub(super) fn of(self, size: Size) -> Size {
        match self {
            Self::Same => size,
            Self::Half => size.half(),
            Self::Double => Size::new(size.width.saturating_mul(2), size.height.saturating_mul(2)),
            Self::Fixed(width, height) => Size::new(width, height),
        }
    }
}

impl Shape {
    /// The type of what is made.
    pub(super) fn ty(&self) -> PortType {
        match self {
            Self::Image { .. } | Self::Up { .. } => PortType::Image,
            Self::Down { .. } | Self::Each { .. } => PortType::Pyramid,
        }
    }

    /// The workgroup of the function, if it has one.
    pub(super) fn workgroup(&self) -> Option<[u32; 2]> {
        match self {
            Self::Image { workgroup } => *workgroup,
            _ => None,
        }
    }

    /// Source of its levels, with the type.
    pub(super) fn of(&self) -> Option<(&Spanned<String>, PortType)> {
        match self {
            Self::Image { .. } => None,
            Self::Down { of, .. } => Some((of, PortType::Image)),
            Self::Each { of } | Self::Up { of } => Some((of, PortType::Pyramid)),
        }
    }
}

impl Declaration {
    /// The input of that name, or what is made under that name before the given place.
    pub(super) fn named(&self, name: &str, before: usize) -> Option<Source> {
        let input = self.inputs.iter().position(|(port, _)| port.name == name).map(Source::Input);
        let made = || self.made[..before].iter().position(|made| made.name.value == name).map(Source::Made);
        input.or_else(made)
    }

    /// Source of an argument of the function at that index, if there is something of that name.
    pub(super) fn source(&self, at: usize, argument: &str) -> Option<Source> {
        let made = &self.made[at];
        if made.shape.of().is_some_and(|(of, _)| of.value == argument) {
            return Some(Source::AtHand);
        }
        if matches!(made.shape, Shape::Up { .. }) && argument == COARSER {
            return Some(Source::Coarser);
        }
        match made.reads.iter().find(|(name, _)| name.value == argument) {
            Some((_, read)) => self.read(read, at),
            None => self.named(argument, at),
        }
    }

    fn read(&self, read: &Read, before: usize) -> Option<Source> {
        match (self.named(&read.of.value, before)?, read.level) {
            (Source::Input(input), Some(level)) => Some(Source::Level(Pyramid::Input(input), level)),
            (Source::Made(made), Some(level)) => Some(Source::Level(Pyramid::Made(made), level)),
            (source, _) => Some(source),
        }
    }

    /// The type of what an argument reads.
    pub(super) fn ty(&self, source: Source) -> PortType {
        match source {
            Source::Input(input) => self.inputs[input].0.ty,
            Source::Made(made) => self.made[made].shape.ty(),
            Source::Level(..) | Source::AtHand | Source::Coarser => PortType::Image,
        }
    }

    /// Returns whether what an argument reads may have another size than what its function makes.
    pub(super) fn differs_in_size(&self, at: usize, source: Source) -> bool {
        let made = &self.made[at];
        match source {
            Source::Input(_) => made.size != SizeRule::Same || made.shape.of().is_some(),
            Source::Made(other) => made.size != self.made[other].size || made.shape.of().is_some(),
            Source::AtHand => matches!(made.shape, Shape::Down { .. }),
            Source::Level(..) | Source::Coarser => true,
        }
    }
}
