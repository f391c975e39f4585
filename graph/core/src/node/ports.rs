//! Ports: what goes into a node and what comes out, with the type and the state of each.

use super::block::HostBlock;
use afterimage_base::Shared;
use afterimage_base::image::ColorState;
use afterimage_base::value::Param;

/// Type of a wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum PortType {
    /// A 2-D image.
    Image,
    /// A 2-D image with several samples in each pixel, of a host or a drawing pass.
    Multisampled,
    /// Images of halving size, finest first.
    Pyramid,
    /// A 3-D image.
    Volume,
    /// A storage buffer: a histogram, a kernel.
    Table,
    /// One number or vector that stays on the GPU.
    Value,
    /// A struct of numbers from the host: a camera.
    Block,
}

impl PortType {
    /// The name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Image => "Image",
            Self::Multisampled => "Multisampled",
            Self::Pyramid => "Pyramid",
            Self::Volume => "Volume",
            Self::Table => "Table",
            Self::Value => "Value",
            Self::Block => "Block",
        }
    }
}

/// An input port.
#[derive(Clone, Debug)]
pub struct Input {
    /// Its name, also the name of the shader's argument.
    pub name: Shared<str>,
    /// Its type.
    pub ty: PortType,
    /// The color states that it accepts; empty for any.
    pub states: Shared<[ColorState]>,
    /// True if it may stay unwired.
    pub optional: bool,
    /// True if only x of a value is read.
    pub only_x: bool,
    /// Name of the content of a table, a value or a volume: only outputs with this content fit, and those that declare
    /// none.
    pub content: Option<Shared<str>>,
    /// The declaration of a host block.
    pub block: Option<&'static HostBlock>,
    /// Description for the manual.
    pub doc: Shared<str>,
}

impl Input {
    /// A required port.
    pub const fn new(name: &'static str, ty: PortType, doc: &'static str) -> Self {
        Self {
            name: Shared::of(name),
            ty,
            states: Shared::of(&[]),
            optional: false,
            only_x: false,
            content: None,
            block: None,
            doc: Shared::of(doc),
        }
    }

    /// A required port for a host block. The argument or uniform variable of the same name has the block's struct.
    pub const fn block(name: &'static str, block: &'static HostBlock, doc: &'static str) -> Self {
        let mut port = Self::new(name, PortType::Block, doc);
        port.block = Some(block);
        port
    }

    /// A required image port.
    pub const fn image(name: &'static str, doc: &'static str) -> Self {
        Self::new(name, PortType::Image, doc)
    }

    /// A required port for an image with several samples in each pixel. The argument of the same name is a
    /// `texture_multisampled_2d<f32>`, which `texel_sample` of the library reads.
    pub const fn multisampled(name: &'static str, doc: &'static str) -> Self {
        Self::new(name, PortType::Multisampled, doc)
    }

    /// A required port for a volume of colors, of a host or of a node. The argument of the same name is a
    /// `texture_3d<f32>`, which `texel3` and `tap3` of the library read.
    pub const fn volume(name: &'static str, doc: &'static str) -> Self {
        Self::new(name, PortType::Volume, doc)
    }

    /// Limits the color states that it accepts.
    pub const fn accepts(mut self, states: &'static [ColorState]) -> Self {
        // A constant function cannot drop what it replaces, which is a part of the program and needs no drop.
        std::mem::forget(std::mem::replace(&mut self.states, Shared::of(states)));
        self
    }

    /// Lets it stay unwired.
    pub const fn optional(mut self) -> Self {
        self.optional = true;
        self
    }

    /// States that no shader reads more of the value than its x, so that what gives it may leave out the rest.
    pub const fn only_x(mut self) -> Self {
        self.only_x = true;
        self
    }

    /// Names what its numbers are: the content of the outputs that fit.
    pub const fn content(mut self, name: &'static str) -> Self {
        // A constant function cannot drop what it replaces, which is a part of the program and needs no drop.
        std::mem::forget(self.content.replace(Shared::of(name)));
        self
    }
}

/// The state of what comes out of a port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum OutputState {
    /// Always this one.
    Always(ColorState),
    /// That of the named input.
    Same(Shared<str>),
    /// The one with the name of this choice parameter's value. At values that name none, that of the first input.
    Chosen(Shared<str>),
    /// Nothing that has a state: a table or a value.
    Nothing,
}

impl OutputState {
    /// The state of the named input.
    pub const fn same(input: &'static str) -> Self {
        Self::Same(Shared::of(input))
    }

    /// The state with the name of a choice parameter's value, or that of the first input.
    pub const fn chosen(param: &'static str) -> Self {
        Self::Chosen(Shared::of(param))
    }
}

/// An output port.
#[derive(Clone, Debug)]
pub struct Output {
    /// Its name; the first output of a kind is its main one, called `result` by custom.
    pub name: Shared<str>,
    /// Its type.
    pub ty: PortType,
    /// The color state of its image.
    pub state: OutputState,
    /// Its value.
    pub doc: Shared<str>,
    /// Replacement for readers if the node does not run.
    pub fallback: Fallback,
    /// Name of the content of a table, a value or a volume: the layout of a histogram, stops of exposure.
    pub content: Option<Shared<str>>,
}

impl Output {
    /// A port. Its fallback is [`Fallback::of_type`], unless `or` or `or_input` sets another one.
    pub const fn new(name: &'static str, ty: PortType, state: OutputState, doc: &'static str) -> Self {
        Self { name: Shared::of(name), ty, state, doc: Shared::of(doc), fallback: Fallback::of_type(ty), content: None }
    }

    /// An image port.
    pub const fn image(name: &'static str, state: OutputState, doc: &'static str) -> Self {
        Self::new(name, PortType::Image, state, doc)
    }

    /// Sets what its readers get when the node does not run.
    pub const fn or(mut self, fallback: Fallback) -> Self {
        // A constant function cannot drop what it replaces, which is a part of the program and needs no drop.
        std::mem::forget(std::mem::replace(&mut self.fallback, fallback));
        self
    }

    /// Names what its numbers are: inputs with another content do not fit. A table needs it.
    pub const fn content(mut self, name: &'static str) -> Self {
        // A constant function cannot drop what it replaces, which is a part of the program and needs no drop.
        std::mem::forget(self.content.replace(Shared::of(name)));
        self
    }

    /// Lets its readers read the named input when the node does not run.
    pub const fn or_input(self, name: &'static str) -> Self {
        self.or(Fallback::input(name))
    }
}

/// Part of an output that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum OutputUse {
    /// Nothing.
    Unused,
    /// Only x of a value.
    OnlyX,
    /// All of it.
    Whole,
    /// All of it, as a mean of the picture: what lies beyond the border is unknown there.
    Mean,
}

/// Declaration of a kind, as a recorder needs it.
#[derive(Clone, Copy, Debug)]
pub struct Signature<'a> {
    /// The kind's name.
    pub name: &'a str,
    /// Its parameters.
    pub params: &'a [Param],
    /// Its input ports.
    pub inputs: &'a [Input],
    /// Its output ports, the main one first.
    pub outputs: &'a [Output],
}

impl Signature<'_> {
    /// The index of an input port. Panics if the kind has none of that name.
    pub(super) fn input_index(&self, name: &str) -> usize {
        let index = self.inputs.iter().position(|port| port.name == name);
        index.unwrap_or_else(|| panic!("`{}` has no input `{name}`", self.name))
    }

    /// The index of an output port. Panics if the kind has none of that name.
    pub(super) fn output_index(&self, name: &str) -> usize {
        let index = self.outputs.iter().position(|port| port.name == name);
        index.unwrap_or_else(|| panic!("`{}` has no output `{name}`", self.name))
    }

    /// The index of a parameter. Panics if the kind has none of that name.
    pub(super) fn param_index(&self, name: &str) -> usize {
        let index = self.params.iter().position(|param| param.name == name);
        index.unwrap_or_else(|| panic!("`{}` has no parameter `{name}`", self.name))
    }
}

/// Replacement of an output of a node that does not run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fallback {
    /// Whatever the named input holds.
    Input(Shared<str>),
    /// Exactly zero everywhere: black. A pixel reads 0, a texture is one black texel.
    Zero,
    /// Nothing: to its readers the port is unwired. A reader that needs it is off too.
    Absent,
}

impl Fallback {
    /// Whatever the named input holds.
    pub const fn input(name: &'static str) -> Self {
        Self::Input(Shared::of(name))
    }

    /// The fallback of a port that declares none: zero for images and pyramids, otherwise nothing.
    pub const fn of_type(ty: PortType) -> Self {
        match ty {
            PortType::Image | PortType::Pyramid => Self::Zero,
            PortType::Multisampled | PortType::Volume | PortType::Table | PortType::Value | PortType::Block => {
                Self::Absent
            }
        }
    }
}
