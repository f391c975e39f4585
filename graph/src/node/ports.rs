//! Ports: what goes into a node and what comes out, with the type and the state of each.

use afterimage_base::image::ColorState;

/// What travels on a wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum PortType {
    /// A 2-D image.
    Image,
    /// Images of halving size, finest first.
    Pyramid,
    /// A 3-D image.
    Volume,
    /// A storage buffer: a histogram, a kernel.
    Table,
    /// One number or vector that stays on the GPU.
    Value,
}

impl PortType {
    /// The name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Image => "Image",
            Self::Pyramid => "Pyramid",
            Self::Volume => "Volume",
            Self::Table => "Table",
            Self::Value => "Value",
        }
    }
}

/// An input port.
#[derive(Clone, Copy, Debug)]
pub struct Input {
    /// Its name, also the name of the shader's argument.
    pub name: &'static str,
    /// What it takes.
    pub ty: PortType,
    /// The image states it takes; empty for any.
    pub states: &'static [ColorState],
    /// Whether it may stay unwired.
    pub optional: bool,
    /// What it is for.
    pub doc: &'static str,
}

impl Input {
    /// A required port.
    pub const fn new(name: &'static str, ty: PortType, doc: &'static str) -> Self {
        Self { name, ty, states: &[], optional: false, doc }
    }

    /// A required image port.
    pub const fn image(name: &'static str, doc: &'static str) -> Self {
        Self::new(name, PortType::Image, doc)
    }

    /// Limits the states it takes.
    pub const fn accepts(self, states: &'static [ColorState]) -> Self {
        Self { states, ..self }
    }

    /// Lets it stay unwired.
    pub const fn optional(self) -> Self {
        Self { optional: true, ..self }
    }
}

/// The state of what comes out of a port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputState {
    /// Always this one.
    Always(ColorState),
    /// That of the named input.
    Same(&'static str),
    /// Nothing that has a state: a table or a value.
    Nothing,
}

/// An output port.
#[derive(Clone, Copy, Debug)]
pub struct Output {
    /// Its name; the first output of a kind is its main one, called `result` by custom.
    pub name: &'static str,
    /// What it gives.
    pub ty: PortType,
    /// The state of the image it gives.
    pub gives: OutputState,
    /// What it holds.
    pub doc: &'static str,
}

impl Output {
    /// A port.
    pub const fn new(name: &'static str, ty: PortType, gives: OutputState, doc: &'static str) -> Self {
        Self { name, ty, gives, doc }
    }

    /// An image port.
    pub const fn image(name: &'static str, gives: OutputState, doc: &'static str) -> Self {
        Self::new(name, PortType::Image, gives, doc)
    }
}

/// What stands in for an output of a node that does not run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fallback {
    /// Whatever the named input holds.
    Input(&'static str),
    /// Exactly zero everywhere: black. A pixel reads 0, a texture is one black texel.
    Zero,
    /// Nothing: to its readers the port is unwired. A reader that needs it is off too.
    Absent,
}
