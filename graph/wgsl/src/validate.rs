//! Validation by naga and the lints, with errors at the author's line.

use naga::Span;
use naga::valid::ModuleInfo;

use crate::barriers::check_barriers;
use crate::error::ShaderError;
use crate::limits::{check_cost, check_memory};
use crate::link::SourceMap;
use crate::lints;

const TOO_DEEP: &str = "brackets, types or statements are nested too deeply for the parser";

/// Parses and validates a module; the first error otherwise.
///
/// # Errors
/// What naga or the lints refuse, at the author's line.
pub fn validate(source: &str, map: &SourceMap) -> Result<naga::Module, ShaderError> {
    on_large_stack(|| validate_here(source, map))
}

/// The same for a module of untrusted files, whose values, variables and functions have limits; those of the library do
/// not count.
pub(crate) fn validate_untrusted(
    source: &str,
    map: &SourceMap,
    is_of_library: &(dyn Fn(Option<&String>) -> bool + Sync),
) -> Result<naga::Module, ShaderError> {
    on_large_stack(|| {
        let module = parse(source, map)?;
        match check_memory(&module) {
            Some((span, why)) => Err(place_error(map, first_byte(span), why)),
            None => {
                let (module, info) = checked(module, map)?;
                match check_cost(&module, &info, is_of_library).or_else(|| check_barriers(&module)) {
                    Some((span, why)) => Err(place_error(map, first_byte(span), why)),
                    None => Ok(module),
                }
            }
        }
    })
}

/// The web has no threads. What may be nested there is limited as everywhere.
#[cfg(target_family = "wasm")]
fn on_large_stack<T>(work: impl FnOnce() -> T) -> T {
    work()
}

/// naga's parser recurses, more deeply than the stack of every thread allows.
#[cfg(not(target_family = "wasm"))]
fn on_large_stack<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    let builder = std::thread::Builder::new().stack_size(crate::limits::STACK_BYTES);
    std::thread::scope(|scope| {
        let thread = builder.spawn_scoped(scope, work);
        let thread = thread.unwrap_or_else(|error| panic!("the system has no more threads: {error}"));
        thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

fn validate_here(source: &str, map: &SourceMap) -> Result<naga::Module, ShaderError> {
    checked(parse(source, map)?, map).map(|(module, _)| module)
}

fn parse(source: &str, map: &SourceMap) -> Result<naga::Module, ShaderError> {
    naga::front::wgsl::parse_str(source).map_err(|error| {
        // What a declaration of the library requires is named before the author's expression.
        let byte = map.of_author(error.labels().filter_map(|(span, _)| first_byte(span)));
        // naga has no place for this one.
        let is_too_deep = byte.is_none() && error.message().starts_with("internal");
        let message = if is_too_deep { TOO_DEEP } else { error.message() };
        place_error(map, byte, message.to_owned())
    })
}

fn checked(module: naga::Module, map: &SourceMap) -> Result<(naga::Module, ModuleInfo), ShaderError> {
    if let Some((span, why)) = lints::first(&module) {
        return Err(place_error(map, first_byte(span), why.into()));
    }
    let capabilities = naga::valid::Capabilities::all();
    let flags = naga::valid::ValidationFlags::all();
    let info = naga::valid::Validator::new(flags, capabilities).validate(&module).map_err(|error| {
        // Of all the places that the error goes through, the narrowest says most.
        let spans = error.spans().filter_map(|(span, _)| Some((span.to_range()?.len(), *span)));
        let narrowest = spans.filter(|(length, _)| *length > 0).min_by_key(|(length, _)| *length);
        place_error(map, narrowest.and_then(|(_, span)| first_byte(span)), root_cause(error.as_inner()))
    })?;
    Ok((module, info))
}

fn first_byte(span: Span) -> Option<usize> {
    span.to_range().map(|range| range.start)
}

fn root_cause(error: &dyn std::error::Error) -> String {
    let mut parts = vec![error.to_string()];
    let mut source = error.source();
    while let Some(inner) = source {
        parts.push(inner.to_string());
        source = inner.source();
    }
    // "Function [10] is invalid" and the like only lead to what is said last.
    let last = parts.len() - 1;
    let says_more = |(at, part): &(usize, String)| *at == last || !part.ends_with("is invalid");
    parts.into_iter().enumerate().filter(says_more).map(|(_, part)| part).collect::<Vec<_>>().join(": ")
}

fn place_error(map: &SourceMap, byte: Option<usize>, mut message: String) -> ShaderError {
    // naga's sentences begin with a capital letter, ours do not; names stay as they are.
    let is_sentence = message.chars().nth(1).is_some_and(|second| second.is_ascii_lowercase() || second == ' ');
    if let Some(first) = message.get_mut(..1).filter(|_| is_sentence) {
        first.make_ascii_lowercase();
    }
    map.error(byte, message)
}
