//! What a module declares, read from naga's view of it.

use naga::{AddressSpace, ImageClass, ImageDimension, ScalarKind as NagaKind, TypeInner};

use crate::error::validate;
use crate::import::Text;
use crate::{SampleMode, Shader, ShaderError, ShaderFeatures};

/// The functions, structs and bindings of a module.
#[derive(Clone, Debug, Default)]
pub struct Reflection {
    /// Functions that return a `vec4f`: the kernel functions.
    pub functions: Vec<Function>,
    /// Entry points.
    pub entries: Vec<EntryPoint>,
    /// Structs that can be uniforms.
    pub structs: Vec<StructLayout>,
    /// Bound variables of whole kernels.
    pub globals: Vec<Global>,
}

/// The entry point of a whole kernel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EntryPoint {
    /// Its name.
    pub name: String,
    /// Invocations of a workgroup, in each direction.
    pub workgroup: [u32; 3],
}

/// A kernel function.
#[derive(Clone, Debug)]
pub struct Function {
    /// Its name.
    pub name: String,
    /// Names and types of its arguments.
    pub args: Vec<(String, ArgType)>,
}

/// How a kernel function takes an argument.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ArgType {
    /// Numbers: a pixel (4) or a value on the GPU (1 to 4).
    Floats(u8),
    /// A 2-D texture.
    Texture,
    /// A 3-D texture.
    Volume,
    /// A sampler.
    Sampler,
    /// The struct of that name.
    Struct(String),
    /// Anything else: not allowed.
    Other(String),
}

/// The kind of number in a uniform.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScalarKind {
    /// `f32`.
    Float,
    /// `i32`.
    Int,
    /// `u32`.
    Uint,
}

/// A member of a uniform struct.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Member {
    /// Its name.
    pub name: String,
    /// Bytes from the start of the struct.
    pub offset: u32,
    /// Kind of its numbers.
    pub scalar: ScalarKind,
    /// Numbers in one element.
    pub width: u32,
    /// Elements, and the bytes from one to the next.
    pub count: u32,
    /// Bytes from one element to the next.
    pub stride: u32,
}

/// A uniform struct's layout.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StructLayout {
    /// Its name.
    pub name: String,
    /// Bytes in all.
    pub size: u32,
    /// Its members.
    pub members: Vec<Member>,
}

/// A bound variable of a whole kernel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Global {
    /// Its name.
    pub name: String,
    /// `@group`.
    pub group: u32,
    /// `@binding`.
    pub binding: u32,
    /// What it is.
    pub kind: GlobalKind,
}

/// What a bound variable is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GlobalKind {
    /// A uniform of this struct type.
    Uniform(String),
    /// A sampled texture; a volume if true.
    Texture(bool),
    /// A storage texture that is written; a volume if true.
    StorageTexture(bool),
    /// A sampler.
    Sampler,
    /// A storage buffer; written too if true.
    Buffer(bool),
    /// Anything else: not allowed.
    Other,
}

impl Reflection {
    /// The entry point of that name.
    pub fn entry(&self, name: &str) -> Option<&EntryPoint> {
        self.entries.iter().find(|entry| entry.name == name)
    }

    /// The kernel function of that name.
    pub fn function(&self, name: &str) -> Option<&Function> {
        self.functions.iter().find(|f| f.name == name)
    }

    /// The struct of that name.
    pub fn layout(&self, name: &str) -> Option<&StructLayout> {
        self.structs.iter().find(|s| s.name == name)
    }
}

pub(crate) fn reflect(shader: &Shader) -> Result<Reflection, ShaderError> {
    let mut text = Text::default().reading(SampleMode::Plain, ShaderFeatures::default())?;
    text.module(shader)?;
    let module = validate(&text.text, &text.map)?;
    Ok(Reflection {
        functions: module.functions.iter().filter_map(|(_, f)| function(&module, f)).collect(),
        entries: module.entry_points.iter().map(entry_point).collect(),
        structs: module.types.iter().filter_map(|(_, ty)| layout(&module, ty)).collect(),
        globals: module.global_variables.iter().filter_map(|(_, g)| global(&module, g)).collect(),
    })
}

fn entry_point(entry: &naga::EntryPoint) -> EntryPoint {
    EntryPoint { name: entry.name.clone(), workgroup: entry.workgroup_size }
}

fn function(module: &naga::Module, function: &naga::Function) -> Option<Function> {
    let result = function.result.as_ref()?;
    if floats(&module.types[result.ty].inner) != Some(4) {
        return None;
    }
    let arg = |a: &naga::FunctionArgument| (a.name.clone().unwrap_or_default(), arg_type(&module.types[a.ty]));
    Some(Function { name: function.name.clone()?, args: function.arguments.iter().map(arg).collect() })
}

fn floats(inner: &TypeInner) -> Option<u8> {
    match inner {
        TypeInner::Scalar(s) if s.kind == NagaKind::Float => Some(1),
        TypeInner::Vector { size, scalar } if scalar.kind == NagaKind::Float => Some(*size as u8),
        _ => None,
    }
}

fn arg_type(ty: &naga::Type) -> ArgType {
    let sampled = |class: &ImageClass| matches!(class, ImageClass::Sampled { kind: NagaKind::Float, multi: false });
    match &ty.inner {
        TypeInner::Image { dim: ImageDimension::D2, arrayed: false, class } if sampled(class) => ArgType::Texture,
        TypeInner::Image { dim: ImageDimension::D3, arrayed: false, class } if sampled(class) => ArgType::Volume,
        TypeInner::Sampler { comparison: false } => ArgType::Sampler,
        TypeInner::Struct { .. } => ArgType::Struct(ty.name.clone().unwrap_or_default()),
        inner => match floats(inner) {
            Some(n) => ArgType::Floats(n),
            None => ArgType::Other(format!("{inner:?}")),
        },
    }
}

fn layout(module: &naga::Module, ty: &naga::Type) -> Option<StructLayout> {
    let TypeInner::Struct { members, span } = &ty.inner else { return None };
    let member = |m: &naga::StructMember| member(module, m);
    Some(StructLayout {
        name: ty.name.clone()?,
        size: *span,
        members: members.iter().map(member).collect::<Option<Vec<_>>>()?,
    })
}

fn member(module: &naga::Module, member: &naga::StructMember) -> Option<Member> {
    let inner = &module.types[member.ty].inner;
    let (element, count, stride) = match inner {
        TypeInner::Array { base, size: naga::ArraySize::Constant(n), stride } => {
            (&module.types[*base].inner, n.get(), *stride)
        }
        inner => (inner, 1, 0),
    };
    let (scalar, width) = match element {
        TypeInner::Scalar(s) => (s.kind, 1),
        TypeInner::Vector { size, scalar } => (scalar.kind, *size as u32),
        _ => return None,
    };
    let scalar = match scalar {
        NagaKind::Float => ScalarKind::Float,
        NagaKind::Sint => ScalarKind::Int,
        NagaKind::Uint => ScalarKind::Uint,
        _ => return None,
    };
    Some(Member { name: member.name.clone()?, offset: member.offset, scalar, width, count, stride })
}

fn global(module: &naga::Module, global: &naga::GlobalVariable) -> Option<Global> {
    let binding = global.binding.as_ref()?;
    let ty = &module.types[global.ty];
    let kind = match (&ty.inner, global.space) {
        (_, AddressSpace::Uniform) => GlobalKind::Uniform(ty.name.clone().unwrap_or_default()),
        (_, AddressSpace::Storage { access }) => GlobalKind::Buffer(access.contains(naga::StorageAccess::STORE)),
        (TypeInner::Image { dim, class: ImageClass::Sampled { .. }, .. }, _) => {
            GlobalKind::Texture(*dim == ImageDimension::D3)
        }
        (TypeInner::Image { dim, class: ImageClass::Storage { .. }, .. }, _) => {
            GlobalKind::StorageTexture(*dim == ImageDimension::D3)
        }
        (TypeInner::Sampler { .. }, _) => GlobalKind::Sampler,
        _ => GlobalKind::Other,
    };
    Some(Global { name: global.name.clone()?, group: binding.group, binding: binding.binding, kind })
}
