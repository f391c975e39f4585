//! The compiler between a module and the driver: naga's writer of SPIR-V, as wgpu runs it for a pipeline. It needs no
//! device, so that what it refuses, or panics over, is an error at the author's line.
//!
//! The writers for Metal and Direct3D are not asked: a panic of theirs is caught where the pipeline is made.

use afterimage_base::panics::catch_panic;
use naga::back::pipeline_constants::process_overrides;
use naga::back::spv::{Options, PipelineOptions, WriterFlags, write_vec};
use naga::proc::{BoundsCheckPolicies, BoundsCheckPolicy};
use naga::valid::ModuleInfo;
use naga::{Block, Function, Handle, Module, Span, Statement};

use crate::error::ShaderError;
use crate::link::SourceMap;
use crate::naga_error::{error_at, first_byte};

/// Compiles a valid module: all of its entry points or, if it has none, all functions.
///
/// # Errors
/// What the compiler says, at the first statement that it cannot take.
pub(crate) fn compile(module: &Module, info: &ModuleInfo, map: &SourceMap) -> Result<(), ShaderError> {
    let Err(why) = written(module, info) else { return Ok(()) };
    let place = first_at_fault(module, info).and_then(first_byte);
    Err(error_at(map, place, format!("the compiler for graphics devices cannot take this: {why}")))
}

fn written(module: &Module, info: &ModuleInfo) -> Result<(), String> {
    if module.entry_points.is_empty() {
        return compiled(|| write_vec(module, info, &options(), None).map_err(|error| error.to_string()));
    }
    for entry in &module.entry_points {
        let pipeline = PipelineOptions { shader_stage: entry.stage, entry_point: entry.name.clone() };
        compiled(|| {
            // Overrides get their values here, and what uses them is evaluated and validated again.
            let (module, info) =
                process_overrides(module, info, Some((entry.stage, entry.name.as_str())), &Default::default())
                    .map_err(|error| error.to_string())?;
            write_vec(&module, &info, &options(), Some(&pipeline)).map_err(|error| error.to_string())
        })?;
    }
    Ok(())
}

/// Runs the compiler; a panic of it is its answer, too.
fn compiled(work: impl FnOnce() -> Result<Vec<u32>, String>) -> Result<(), String> {
    catch_panic(work).flatten().map(|_| ())
}

/// Those of wgpu for shaders whose indices are checked.
fn options() -> Options<'static> {
    let checked = BoundsCheckPolicy::Restrict;
    let unchecked = BoundsCheckPolicy::Unchecked;
    Options {
        lang_version: (1, 3),
        flags: WriterFlags::LABEL_VARYINGS | WriterFlags::FORCE_POINT_SIZE,
        bounds_check_policies: BoundsCheckPolicies {
            index: checked,
            buffer: checked,
            image_load: checked,
            binding_array: unchecked,
        },
        ..Options::default()
    }
}

/// The first statement of a function without which the compiler takes the functions up to it.
fn first_at_fault(module: &Module, info: &ModuleInfo) -> Option<Span> {
    let mut empty = module.clone();
    empty.entry_points.clear();
    let mut statements = Vec::new();
    for (handle, function) in empty.functions.iter_mut() {
        let body = std::mem::take(&mut function.body);
        statements.extend(body.span_into_iter().map(|(statement, span)| (handle, statement, span)));
    }
    let (mut taken, mut refused) = (0, statements.len());
    if written(&with_statements(&empty, &statements), info).is_ok() {
        return None;
    }
    while taken + 1 < refused {
        let middle = usize::midpoint(taken, refused);
        match written(&with_statements(&empty, &statements[..middle]), info) {
            Ok(()) => taken = middle,
            Err(_) => refused = middle,
        }
    }
    let (function, _, span) = statements.get(taken)?;
    let is_known = span.to_range().is_some_and(|range| !range.is_empty());
    Some(if is_known { *span } else { module.functions.get_span(*function) })
}

/// The module with the first statements of its functions. A function that ends early returns zero.
fn with_statements(empty: &Module, statements: &[(Handle<Function>, Statement, Span)]) -> Module {
    let mut module = empty.clone();
    for (function, statement, span) in statements {
        let body: &mut Block = &mut module.functions[*function].body;
        body.push(statement.clone(), *span);
    }
    module
}
