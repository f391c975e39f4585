//! Validation by naga and the lints, with errors at the author's line.

use std::io;

use naga::valid::ModuleInfo;

use crate::barriers::check_barriers;
use crate::error::ShaderError;
use crate::limits::{STACK_BYTES, check_cost, check_memory};
use crate::link::SourceMap;
use crate::lints;
use crate::naga_error::{self, error_at, first_byte, parse};

/// Parses and validates a module; the first error otherwise.
///
/// # Errors
/// What naga or the lints refuse, at the author's line.
pub fn validate(source: &str, map: &SourceMap) -> Result<naga::Module, ShaderError> {
    on_stack(STACK_BYTES, || validate_here(source, map)).unwrap_or_else(|why| Err(no_thread(map, &why)))
}

/// The same for a module of untrusted files, whose values, variables and functions have limits; those of the library do
/// not count.
pub(crate) fn validate_untrusted(
    source: &str,
    map: &SourceMap,
    is_of_library: &(dyn Fn(Option<&String>) -> bool + Sync),
) -> Result<naga::Module, ShaderError> {
    let validated = on_stack(STACK_BYTES, || {
        let module = parse(source, map)?;
        match check_memory(&module, is_of_library) {
            Some((span, why)) => Err(error_at(map, first_byte(span), why)),
            None => {
                let (module, info) = checked(module, source, map)?;
                match check_cost(&module, &info, is_of_library).or_else(|| check_barriers(&module)) {
                    Some((span, why)) => Err(error_at(map, first_byte(span), why)),
                    None => Ok(module),
                }
            }
        }
    });
    validated.unwrap_or_else(|why| Err(no_thread(map, &why)))
}

fn no_thread(map: &SourceMap, why: &io::Error) -> ShaderError {
    error_at(map, None, format!("the system has no thread to read this on: {why}"))
}

/// The web has no threads. What may be nested there is limited as everywhere.
#[cfg(target_family = "wasm")]
fn on_stack<T>(_: usize, work: impl FnOnce() -> T) -> io::Result<T> {
    Ok(work())
}

/// naga's parser recurses, more deeply than the stack of every thread allows.
#[cfg(not(target_family = "wasm"))]
fn on_stack<T: Send>(bytes: usize, work: impl FnOnce() -> T + Send) -> io::Result<T> {
    let builder = std::thread::Builder::new().stack_size(bytes);
    std::thread::scope(|scope| {
        let thread = builder.spawn_scoped(scope, work)?;
        Ok(thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
    })
}

fn validate_here(source: &str, map: &SourceMap) -> Result<naga::Module, ShaderError> {
    checked(parse(source, map)?, source, map).map(|(module, _)| module)
}

fn checked(module: naga::Module, source: &str, map: &SourceMap) -> Result<(naga::Module, ModuleInfo), ShaderError> {
    if let Some((span, why)) = lints::first(&module) {
        return Err(error_at(map, first_byte(span), why.into()));
    }
    let capabilities = naga::valid::Capabilities::all();
    let flags = naga::valid::ValidationFlags::all();
    let info = naga::valid::Validator::new(flags, capabilities)
        .validate(&module)
        .map_err(|error| naga_error::validation_error(source, map, &module, &error))?;
    Ok((module, info))
}

#[cfg(all(test, not(target_family = "wasm")))]
mod tests {
    use super::*;

    #[test]
    fn a_stack_that_the_system_does_not_have_is_an_error() {
        assert!(on_stack(usize::MAX / 4, || ()).is_err());
    }
}
