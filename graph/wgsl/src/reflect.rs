//! Reflection of a module, from naga's IR.

use naga::valid::ModuleInfo;
use naga::{AddressSpace, ImageClass, ImageDimension, ScalarKind as NagaKind, TypeInner};

use crate::barriers::sharing;
use crate::direct_reads::{direct_reads, filtering};
use crate::entry::{EntryPoint, entry_point};
use crate::error::ShaderError;
use crate::library::Source;
use crate::limits::{CompileCost, compile_costs};
use crate::link::{Declared, GENERATED, Instance, Linker, check_work};
use crate::sample_mode::SampleMode;
use crate::shader_cost::{ShaderCost, shader_costs};
use crate::validate::{validate_uncompiled, validate_untrusted};

/// The functions, structs and bindings of a module.
#[derive(Clone, Debug, Default)]
pub struct Reflection {
    /// Functions that return a `vec4f`: the kernel functions.
    pub functions: Vec<Function>,
    pub entries: Vec<EntryPoint>,
    /// Structs that can be uniforms.
    pub structs: Vec<StructLayout>,
    /// Bound variables of whole kernels.
    pub globals: Vec<Global>,
    /// Functions and entry points of the file that read textures directly, and not through `texel` and `tap`.
    pub direct_reads: Vec<String>,
    /// Functions and entry points of the file that filter textures, also through `tap`.
    pub filtering: Vec<String>,
    /// Functions of the file that use memory of a workgroup, or wait for its other invocations.
    pub sharing: Vec<String>,
    /// Cost per pixel of the functions of the file.
    pub shader_costs: Vec<(String, ShaderCost)>,
    /// Compilation cost of the functions and entry points of the file.
    pub costs: Vec<(String, CompileCost)>,
}

#[derive(Clone, Debug)]
pub struct Function {
    pub name: String,
    /// Names and types of its arguments.
    pub args: Vec<(String, ArgType)>,
}

/// Type of an argument of a kernel function.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ArgType {
    /// Numbers: a pixel (4) or a value on the GPU (1 to 4).
    Floats(u8),
    /// A 2-D texture.
    Texture,
    /// A 2-D texture with several samples in each texel.
    Multisampled,
    /// A 3-D texture.
    Volume,
    Sampler,
    /// The place of the pixel: `Point` of the framework's library.
    Point,
    /// The frame's time: `Frame` of the framework's library.
    Frame,
    /// The place in a workgroup: `Invocation` of the framework's library.
    Invocation,
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
    pub name: String,
    /// Bytes from the start of the struct.
    pub offset: u32,
    pub scalar: ScalarKind,
    pub width: u32,
    /// Elements of an array, or columns of a matrix.
    pub count: u32,
    /// Bytes from one element to the next.
    pub stride: u32,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StructLayout {
    pub name: String,
    pub size: u32,
    pub members: Vec<Member>,
}

/// A bound variable of a whole kernel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Global {
    pub name: String,
    pub group: u32,
    pub binding: u32,
    pub kind: GlobalKind,
}

/// Kind of a bound variable.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GlobalKind {
    /// The uniform with the frame's time: of the type `Frame` of the framework's library.
    Frame,
    /// A uniform of this struct type.
    Uniform(String),
    /// A sampled texture; a volume if true.
    Texture(bool),
    /// A storage texture that is written; a volume if true.
    StorageTexture(bool),
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

    /// The name of the struct that an argument of a kernel function has, or a uniform variable of that name.
    pub fn struct_of(&self, function: &str, name: &str) -> Option<&str> {
        let arg = self.function(function).and_then(|function| function.args.iter().find(|(arg, _)| arg == name));
        match (arg, self.globals.iter().find(|global| global.name == name)) {
            (Some((_, ArgType::Struct(ty))), _) => Some(ty),
            (None, Some(Global { kind: GlobalKind::Uniform(ty), .. })) => Some(ty),
            _ => None,
        }
    }

    pub fn layout(&self, name: &str) -> Option<&StructLayout> {
        self.structs.iter().find(|s| s.name == name)
    }
}

/// Reflects a file: it is linked with its imports, parsed and validated.
pub(crate) fn reflect(source: &Source) -> Result<Reflection, ShaderError> {
    reflect_linked(source).map_err(|error| match error.file == GENERATED {
        // The file is all that is known of the place.
        true => ShaderError { file: source.file.name().to_string(), line: 1, column: 1, ..error },
        false => error,
    })
}

fn reflect_linked(source: &Source) -> Result<Reflection, ShaderError> {
    let mut linker = Linker::new(SampleMode::Plain);
    let instance = linker.add(source, &[])?;
    let (linked, declared) = linker.link_whole(instance, source.file.has_workgroups())?;
    let names = Names { declared: &declared, instance };
    let (module, info) = match source.file.is_untrusted() {
        false => validate_uncompiled(&linked.text, &linked.map)?,
        true => {
            check_work(&linked)?;
            validate_untrusted(&linked.text, &linked.map, &|name| names.of_framework(name).is_some())?
        }
    };
    Ok(Reader { module: &module, info: &info, names }.reflection())
}

struct Reader<'m> {
    module: &'m naga::Module,
    info: &'m ModuleInfo,
    names: Names<'m>,
}

/// Names in the files of what the linked module declares.
#[derive(Clone, Copy)]
struct Names<'d> {
    declared: &'d [Declared],
    instance: Instance,
}

impl<'d> Names<'d> {
    fn find(self, name: Option<&String>) -> Option<&'d Declared> {
        self.declared.iter().find(|declared| Some(&declared.name) == name)
    }

    /// The name in the file of one of its own declarations.
    fn own(self, name: Option<&String>) -> Option<String> {
        let found = self.find(name).filter(|declared| declared.instance == self.instance);
        found.map(|declared| declared.original.clone())
    }

    /// The name of a type in the file that declares it.
    fn any(self, name: Option<&String>) -> String {
        self.find(name).map(|declared| declared.original.clone()).unwrap_or_default()
    }

    /// The name of a type that the framework's library declares.
    fn of_framework(self, name: Option<&String>) -> Option<&'d str> {
        self.find(name).filter(|declared| declared.is_framework).map(|declared| declared.original.as_str())
    }
}

impl Reader<'_> {
    fn reflection(&self) -> Reflection {
        let module = self.module;
        let mut structs: Vec<(bool, StructLayout)> =
            module.types.iter().filter_map(|(_, ty)| self.layout(ty)).collect();
        // Its own come first: they hide those of imports.
        structs.sort_by_key(|(is_own, _)| !is_own);
        Reflection {
            functions: module.functions.iter().filter_map(|(_, f)| self.function(f)).collect(),
            entries: module.entry_points.iter().filter_map(|entry| self.entry_point(entry)).collect(),
            structs: structs.into_iter().map(|(_, layout)| layout).collect(),
            globals: module.global_variables.iter().filter_map(|(_, g)| self.global(g)).collect(),
            direct_reads: self.own(direct_reads(module, &|name| self.names.of_framework(name).is_some())),
            filtering: self.own(filtering(module)),
            sharing: self.own(sharing(module)),
            shader_costs: shader_costs(module)
                .into_iter()
                .filter_map(|(name, work)| Some((self.names.own(Some(name))?, work)))
                .collect(),
            costs: compile_costs(module, self.info, &|name| self.names.of_framework(name).is_some())
                .into_iter()
                .filter_map(|(name, cost)| Some((self.names.own(Some(name))?, cost)))
                .collect(),
        }
    }

    /// The names of the file's own functions among these.
    fn own(&self, names: Vec<&String>) -> Vec<String> {
        names.into_iter().filter_map(|name| self.names.own(Some(name))).collect()
    }

    fn entry_point(&self, entry: &naga::EntryPoint) -> Option<EntryPoint> {
        Some(entry_point(self.module, entry, self.names.own(Some(&entry.name))?))
    }

    fn function(&self, function: &naga::Function) -> Option<Function> {
        let result = function.result.as_ref()?;
        if floats(&self.module.types[result.ty].inner) != Some(4) {
            return None;
        }
        let arg = |a: &naga::FunctionArgument| (a.name.clone().unwrap_or_default(), self.arg_type(a));
        let name = self.names.own(function.name.as_ref())?;
        Some(Function { name, args: function.arguments.iter().map(arg).collect() })
    }

    fn arg_type(&self, arg: &naga::FunctionArgument) -> ArgType {
        let ty = &self.module.types[arg.ty];
        let sampled = |class: &ImageClass| matches!(class, ImageClass::Sampled { kind: NagaKind::Float, multi: false });
        let samples = |class: &ImageClass| matches!(class, ImageClass::Sampled { kind: NagaKind::Float, multi: true });
        match &ty.inner {
            TypeInner::Image { dim: ImageDimension::D2, arrayed: false, class } if sampled(class) => ArgType::Texture,
            TypeInner::Image { dim: ImageDimension::D2, arrayed: false, class } if samples(class) => {
                ArgType::Multisampled
            }
            TypeInner::Image { dim: ImageDimension::D3, arrayed: false, class } if sampled(class) => ArgType::Volume,
            TypeInner::Sampler { comparison: false } => ArgType::Sampler,
            TypeInner::Struct { .. } => match self.names.of_framework(ty.name.as_ref()) {
                Some("Point") => ArgType::Point,
                Some("Frame") => ArgType::Frame,
                Some("Invocation") => ArgType::Invocation,
                _ => ArgType::Struct(self.names.any(ty.name.as_ref())),
            },
            inner => floats(inner).map_or_else(|| ArgType::Other(format!("{inner:?}")), ArgType::Floats),
        }
    }

    /// The layout of a struct, and whether the file declares it.
    fn layout(&self, ty: &naga::Type) -> Option<(bool, StructLayout)> {
        let TypeInner::Struct { members, span } = &ty.inner else { return None };
        let members = members.iter().map(|m| member(self.module, m)).collect::<Option<Vec<_>>>()?;
        let name = self.names.any(ty.name.as_ref());
        Some((self.names.own(ty.name.as_ref()).is_some(), StructLayout { name, size: *span, members }))
    }

    fn global(&self, global: &naga::GlobalVariable) -> Option<Global> {
        let binding = global.binding.as_ref()?;
        let ty = &self.module.types[global.ty];
        let kind = match (&ty.inner, global.space) {
            (_, AddressSpace::Uniform) if self.names.of_framework(ty.name.as_ref()) == Some("Frame") => {
                GlobalKind::Frame
            }
            (_, AddressSpace::Uniform) => GlobalKind::Uniform(self.names.any(ty.name.as_ref())),
            (_, AddressSpace::Storage { access }) => GlobalKind::Buffer(access.contains(naga::StorageAccess::STORE)),
            (TypeInner::Image { dim, class: ImageClass::Sampled { multi: false, .. }, .. }, _) => {
                GlobalKind::Texture(*dim == ImageDimension::D3)
            }
            (TypeInner::Image { dim, class: ImageClass::Storage { .. }, .. }, _) => {
                GlobalKind::StorageTexture(*dim == ImageDimension::D3)
            }
            (TypeInner::Sampler { comparison: false }, _) => GlobalKind::Sampler,
            _ => GlobalKind::Other,
        };
        let name = self.names.own(global.name.as_ref())?;
        Some(Global { name, group: binding.group, binding: binding.binding, kind })
    }
}

fn floats(inner: &TypeInner) -> Option<u8> {
    match inner {
        TypeInner::Scalar(s) if s.kind == NagaKind::Float => Some(1),
        TypeInner::Vector { size, scalar } if scalar.kind == NagaKind::Float => Some(*size as u8),
        _ => None,
    }
}

fn member(module: &naga::Module, member: &naga::StructMember) -> Option<Member> {
    let ((scalar, width), count, stride) = match &module.types[member.ty].inner {
        TypeInner::Array { base, size: naga::ArraySize::Constant(n), stride } => {
            (vector(&module.types[*base].inner)?, n.get(), *stride)
        }
        // A column is aligned like a vector of its length: three numbers take the space of four.
        TypeInner::Matrix { columns, rows, scalar } => {
            let rows = *rows as u32;
            ((scalar.kind, rows), *columns as u32, 4 * rows.next_power_of_two())
        }
        inner => (vector(inner)?, 1, 0),
    };
    let scalar = match scalar {
        NagaKind::Float => ScalarKind::Float,
        NagaKind::Sint => ScalarKind::Int,
        NagaKind::Uint => ScalarKind::Uint,
        _ => return None,
    };
    Some(Member { name: member.name.clone()?, offset: member.offset, scalar, width, count, stride })
}

/// The kind and the number of the numbers of a scalar or a vector.
fn vector(inner: &TypeInner) -> Option<(NagaKind, u32)> {
    match inner {
        TypeInner::Scalar(s) => Some((s.kind, 1)),
        TypeInner::Vector { size, scalar } => Some((scalar.kind, *size as u32)),
        _ => None,
    }
}
