//! Limits of the memory that values and variables take.

use naga::proc::GlobalCtx;
use naga::{AddressSpace, Module, Span, TypeInner};

use super::{ARRAY_BYTES, VALUE_BYTES, WORKGROUP_BYTES};
use crate::walk::calls;

/// The first value or function that takes too much memory, and why it is too much.
pub(crate) fn check_memory(module: &Module, is_of_library: &dyn Fn(Option<&String>) -> bool) -> Option<(Span, String)> {
    let types = module.types.iter().find_map(|(handle, ty)| {
        let message = VALUE_BYTES.exceeded(bytes(&ty.inner, module.to_ctx()))?;
        Some((module.types.get_span(handle), message))
    });
    large_variable(module).or(types).or_else(|| arrays(module, is_of_library)).or_else(|| workgroup(module))
}

/// A variable of a type that is too large: the type itself may have no place.
fn large_variable(module: &Module) -> Option<(Span, String)> {
    module.functions.iter().find_map(|(_, function)| {
        function.local_variables.iter().find_map(|(handle, variable)| {
            let message = VALUE_BYTES.exceeded(bytes(&module.types[variable.ty].inner, module.to_ctx()))?;
            Some((function.local_variables.get_span(handle), message))
        })
    })
}

/// The variable with which the memory of a workgroup becomes too large.
fn workgroup(module: &Module) -> Option<(Span, String)> {
    let mut sum = 0_usize;
    module.global_variables.iter().filter(|(_, global)| global.space == AddressSpace::WorkGroup).find_map(
        |(handle, global)| {
            let own = bytes(&module.types[global.ty].inner, module.to_ctx());
            sum = sum.saturating_add(own.saturating_add(15) / 16 * 16);
            Some((module.global_variables.get_span(handle), WORKGROUP_BYTES.exceeded(sum)?))
        },
    )
}

fn bytes(ty: &TypeInner, context: GlobalCtx<'_>) -> usize {
    ty.try_size(context).map_or(usize::MAX, |bytes| bytes as usize)
}

fn arrays(module: &Module, is_of_library: &dyn Fn(Option<&String>) -> bool) -> Option<(Span, String)> {
    let mut sums = Vec::with_capacity(module.functions.len());
    // A module declares functions before those that call them.
    for (handle, function) in module.functions.iter() {
        let own = function.local_variables.iter().map(|(_, variable)| variable.ty);
        let own: usize = own.map(|ty| array_bytes(module, &module.types[ty].inner)).fold(0, usize::saturating_add);
        let mut sum = own;
        // A function of the library that reads eight repaired texels is not eight arrays of the author.
        if !is_of_library(function.name.as_ref()) {
            calls(&function.body, &mut |callee| sum = sum.saturating_add(sums[callee.index()]));
        }
        sums.push(sum);
        if let Some(message) = ARRAY_BYTES.exceeded(sum) {
            return Some((module.functions.get_span(handle), message));
        }
    }
    None
}

/// Bytes of the arrays in a value.
fn array_bytes(module: &Module, ty: &TypeInner) -> usize {
    match ty {
        TypeInner::Array { .. } => bytes(ty, module.to_ctx()),
        TypeInner::Struct { members, .. } => {
            let members = members.iter().map(|member| array_bytes(module, &module.types[member.ty].inner));
            members.fold(0, usize::saturating_add)
        }
        _ => 0,
    }
}
