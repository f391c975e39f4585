//! Entry points: what a whole kernel or a drawing shader starts with, and what it takes and gives by location.

use naga::{Binding, Module, ScalarKind as NagaKind, ShaderStage, TypeInner};

/// An entry point of a module.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EntryPoint {
    pub name: String,
    pub stage: EntryStage,
    /// Invocations of a workgroup, in each direction; 0 where there is none.
    pub workgroup: [u32; 3],
    /// Its arguments with a `@location`, in ascending order.
    pub inputs: Vec<Located>,
    /// Its results with a `@location`, in ascending order.
    pub outputs: Vec<Located>,
}

/// Stage of an entry point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EntryStage {
    Compute,
    Vertex,
    Fragment,
    /// Anything else: not allowed.
    Other,
}

/// A value with a `@location`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Located {
    pub location: u32,
    /// The kind of its numbers.
    pub number: NumberKind,
    /// Numbers of a vector; 1 for a scalar.
    pub width: u32,
}

/// The kind of the numbers of a value with a `@location`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum NumberKind {
    /// `f32`.
    Float,
    /// `i32`.
    Int,
    /// `u32`.
    Uint,
    Other,
}

impl std::fmt::Display for Located {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let number = match self.number {
            NumberKind::Float => "f32",
            NumberKind::Int => "i32",
            NumberKind::Uint => "u32",
            NumberKind::Other => "another type",
        };
        match self.width {
            1 => write!(f, "@location({}) {number}", self.location),
            width => write!(f, "@location({}) vec{width}<{number}>", self.location),
        }
    }
}

/// The entry point under the name that its file gives it.
pub(crate) fn entry_point(module: &Module, entry: &naga::EntryPoint, name: String) -> EntryPoint {
    let (mut inputs, mut outputs) = (Vec::new(), Vec::new());
    for argument in &entry.function.arguments {
        locate(module, argument.ty, argument.binding.as_ref(), &mut inputs);
    }
    if let Some(result) = &entry.function.result {
        locate(module, result.ty, result.binding.as_ref(), &mut outputs);
    }
    inputs.sort_unstable();
    outputs.sort_unstable();
    let stage = match entry.stage {
        ShaderStage::Compute => EntryStage::Compute,
        ShaderStage::Vertex => EntryStage::Vertex,
        ShaderStage::Fragment => EntryStage::Fragment,
        _ => EntryStage::Other,
    };
    EntryPoint { name, stage, workgroup: entry.workgroup_size, inputs, outputs }
}

/// Adds a value that has a location, or the members of a struct that have one.
fn locate(module: &Module, ty: naga::Handle<naga::Type>, binding: Option<&Binding>, found: &mut Vec<Located>) {
    match (&module.types[ty].inner, binding) {
        (inner, Some(Binding::Location { location, .. })) => {
            let (number, width) = numbers(inner);
            found.push(Located { location: *location, number, width });
        }
        (TypeInner::Struct { members, .. }, None) => {
            members.iter().for_each(|member| locate(module, member.ty, member.binding.as_ref(), found));
        }
        _ => {}
    }
}

fn numbers(inner: &TypeInner) -> (NumberKind, u32) {
    let kind = |kind: NagaKind| match kind {
        NagaKind::Float => NumberKind::Float,
        NagaKind::Sint => NumberKind::Int,
        NagaKind::Uint => NumberKind::Uint,
        _ => NumberKind::Other,
    };
    match inner {
        TypeInner::Scalar(scalar) => (kind(scalar.kind), 1),
        TypeInner::Vector { size, scalar } => (kind(scalar.kind), *size as u32),
        _ => (NumberKind::Other, 1),
    }
}
