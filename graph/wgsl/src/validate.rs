//! Validation by naga, the lints and the compiler for devices, with errors at the author's line.

use std::io;

use afterimage_base::panics::catch_panic;
use naga::valid::{Capabilities, ModuleInfo};

#[cfg(not(target_family = "wasm"))]
use crate::back_end;
use crate::barriers::check_barriers;
use crate::error::ShaderError;
use crate::limits::{STACK_BYTES, check_cost, check_memory};
use crate::link::SourceMap;
use crate::lints;
use crate::naga_error::{self, error_at, first_byte, parse};

/// A module, and what the validator knows of it.
type Validated = (naga::Module, ModuleInfo);

/// Parses and validates a module without compiling it.
pub(crate) fn validate_uncompiled(source: &str, map: &SourceMap) -> Result<Validated, ShaderError> {
    guarded(map, || checked(parse(source, map)?, source, map, Capabilities::all()))
}

/// Parses and validates a module that a device is to run, and compiles it as far as that needs no device.
///
/// # Errors
/// What naga, the lints and the compiler refuse, at the author's line.
pub fn validate(source: &str, map: &SourceMap) -> Result<naga::Module, ShaderError> {
    guarded(map, || {
        let (module, info) = checked(parse(source, map)?, source, map, Capabilities::all())?;
        compile(&module, &info, map)?;
        Ok(module)
    })
}

/// The same for a module of untrusted files. It may only use what every device has, and its values, variables and
/// functions have limits; those of the library do not count.
pub(crate) fn validate_untrusted(
    source: &str,
    map: &SourceMap,
    is_of_library: &(dyn Fn(Option<&String>) -> bool + Sync),
) -> Result<Validated, ShaderError> {
    guarded(map, || {
        let module = parse(source, map)?;
        match check_memory(&module, is_of_library) {
            Some((span, why)) => Err(error_at(map, first_byte(span), why)),
            None => {
                let (module, info) = checked(module, source, map, of_every_device())?;
                match check_cost(&module, &info, is_of_library).or_else(|| check_barriers(&module)) {
                    Some((span, why)) => Err(error_at(map, first_byte(span), why)),
                    None => compile(&module, &info, map).map(|()| (module, info)),
                }
            }
        }
    })
}

/// Runs naga on a stack that is large enough; a panic of it is an error.
fn guarded<T: Send>(map: &SourceMap, work: impl FnOnce() -> Result<T, ShaderError> + Send) -> Result<T, ShaderError> {
    match on_stack(STACK_BYTES, || catch_panic(work)) {
        Ok(Ok(result)) => result,
        Ok(Err(panic)) => Err(error_at(map, None, format!("the reader of shaders cannot take this: {panic}"))),
        Err(why) => Err(no_thread(map, &why)),
    }
}

fn no_thread(map: &SourceMap, why: &io::Error) -> ShaderError {
    let error = error_at(map, None, format!("the system has no thread to read this on: {why}"));
    ShaderError { is_of_system: true, ..error }
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

/// Capabilities that modules may use on every device; the framework enables no others.
fn of_every_device() -> Capabilities {
    Capabilities::default() | Capabilities::IMMEDIATES | Capabilities::SHADER_FLOAT16_IN_FLOAT32
}

/// The web compiles shaders itself.
#[cfg(target_family = "wasm")]
fn compile(_: &naga::Module, _: &ModuleInfo, _: &SourceMap) -> Result<(), ShaderError> {
    Ok(())
}

#[cfg(not(target_family = "wasm"))]
fn compile(module: &naga::Module, info: &ModuleInfo, map: &SourceMap) -> Result<(), ShaderError> {
    back_end::compile(module, info, map)
}

fn checked(
    module: naga::Module,
    source: &str,
    map: &SourceMap,
    capabilities: Capabilities,
) -> Result<Validated, ShaderError> {
    if let Some((span, why)) = lints::first(&module) {
        return Err(error_at(map, first_byte(span), why.into()));
    }
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
