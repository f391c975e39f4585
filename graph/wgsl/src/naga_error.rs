//! Errors of naga in the words of an author: places in the author's files, names of types, the code of an expression,
//! and names that may have been meant.

use naga::common::wgsl::TypeContext as _;
use naga::front::wgsl::ParseError;
use naga::valid::ValidationError;
use naga::{Module, Scalar, Span, TypeInner, VectorSize, WithSpan};

use afterimage_base::diagnostic::{did_you_mean, quote};

use crate::error::{ShaderError, ShaderLabel};
use crate::link::SourceMap;
use crate::token::{Token, TokenKind, tokens};

const TOO_DEEP: &str = "brackets, types or statements are nested too deeply for the parser";

/// Errors of one module that are reported together.
const MAX_ERRORS: usize = 5;

/// Names of GLSL and HLSL, and what WGSL calls them.
const OTHER_LANGUAGES: &[(&str, &str)] = &[
    ("atan2f", "atan2"),
    ("ddx", "dpdx"),
    ("ddy", "dpdy"),
    ("dFdx", "dpdx"),
    ("dFdy", "dpdy"),
    ("float", "f32"),
    ("float2", "vec2f"),
    ("float3", "vec3f"),
    ("float4", "vec4f"),
    ("frac", "fract"),
    ("half", "f32"),
    ("int", "i32"),
    ("inversesqrt", "inverseSqrt"),
    ("ivec2", "vec2i"),
    ("lerp", "mix"),
    ("mod", "%"),
    ("mul", "*"),
    ("rsqrt", "inverseSqrt"),
    ("uvec2", "vec2u"),
    ("vec2", "vec2f"),
    ("vec3", "vec3f"),
    ("vec4", "vec4f"),
];

/// Parses a module. If functions have errors that do not depend on each other, the first few are reported.
pub(crate) fn parse(source: &str, map: &SourceMap) -> Result<Module, ShaderError> {
    let error = match naga::front::wgsl::parse_str(source) {
        Ok(module) => return Ok(module),
        Err(error) => error,
    };
    let mut byte = author_byte(map, &error);
    let mut first = parse_error(source, map, &error, byte);
    let mut others = Vec::new();
    let mut text = source.to_owned();
    while others.len() + 1 < MAX_ERRORS {
        let Some(at) = byte else { break };
        let Some(without_body) = without_function_body(&text, at) else { break };
        text = without_body;
        let Err(error) = naga::front::wgsl::parse_str(&text) else { break };
        byte = author_byte(map, &error);
        if byte == Some(at) {
            break;
        }
        others.push(parse_error(source, map, &error, byte));
    }
    first.others = others.into();
    Err(first)
}

/// Shows the author's expression, which follows the requirement of a declaration of the library.
fn author_byte(map: &SourceMap, error: &ParseError) -> Option<usize> {
    map.of_author(error.labels().filter_map(|(span, _)| first_byte(span)))
}

fn parse_error(source: &str, map: &SourceMap, error: &ParseError, byte: Option<usize>) -> ShaderError {
    // naga has no place for this one.
    let is_too_deep = byte.is_none() && error.message().starts_with("internal");
    let at = error.labels().next().and_then(|(span, _)| span.to_range());
    let no_sampler = at.clone().and_then(|at| no_sampler(error.message(), source, at.start));
    let message = if is_too_deep { TOO_DEEP } else { no_sampler.as_deref().unwrap_or(error.message()) };
    let plain =
        message.replace("`{AbstractFloat}`", "a number with a point").replace("`{AbstractInt}`", "a whole number");
    let mut shown = error_at(map, byte, plain);
    shown.labels = labels(map, error.labels(), message);
    let unknown = error.labels().next().filter(|_| message.starts_with("no definition in scope"));
    let unknown = unknown.and_then(|(span, _)| source.get(span.to_range()?));
    let notes: Vec<&str> = error.notes().collect();
    let help = unknown
        .and_then(|name| suggestion(name, map))
        .or((!notes.is_empty()).then(|| notes.join("; ")))
        .or_else(|| advice(message, source, at?, map));
    shown.help = help.map(String::into_boxed_str);
    shown
}

/// A validator's error: the narrowest of its places says most.
pub(crate) fn validation_error(
    source: &str,
    map: &SourceMap,
    module: &Module,
    error: &WithSpan<ValidationError>,
) -> ShaderError {
    let spans = error.spans().filter_map(|(span, _)| Some((span.to_range()?.len(), *span)));
    let narrowest = spans.filter(|(length, _)| *length > 0).min_by_key(|(length, _)| *length);
    let cause = root_cause(error.as_inner());
    // Expressions, types and functions are numbered each by themselves.
    let message = without_handles(&cause, |handle, follows_type| {
        let is_expression = |what: &str| what.ends_with(handle) && what.contains("Expression");
        let expression = error.spans().find(|(_, what)| is_expression(what)).filter(|_| !follows_type);
        let is_type = follows_type || error.spans().any(|(_, what)| what.ends_with(handle) && what.contains("Type"));
        match expression {
            Some((span, _)) => code_at(source, *span),
            None if is_type => type_name(module, handle),
            None => None,
        }
    });
    let message = with_type_names(message);
    let message = match message.strip_prefix("The `return` expression None does not match the declared return type ") {
        Some(ty) => format!("some path of the function ends without a `return` of its type, {ty}"),
        None => message,
    };
    let at = narrowest.and_then(|(_, span)| first_byte(span));
    let message = at.and_then(|at| no_sampler(&message, source, at)).unwrap_or(message);
    let is_composed = message.starts_with("composing expects") || message.starts_with("Composing expects");
    let mut shown = error_at(map, at, message);
    if is_composed {
        let help = "together, the arguments have as many numbers as the vector has components";
        shown.help = Some(help.to_owned().into_boxed_str());
    }
    shown
}

pub(crate) fn error_at(map: &SourceMap, byte: Option<usize>, mut message: String) -> ShaderError {
    // naga's sentences begin with a capital letter, ours do not; names stay as they are.
    let is_sentence = message.chars().nth(1).is_some_and(|second| second.is_ascii_lowercase() || second == ' ');
    if let Some(first) = message.get_mut(..1).filter(|_| is_sentence) {
        first.make_ascii_lowercase();
    }
    map.error(byte, message)
}

pub(crate) fn first_byte(span: Span) -> Option<usize> {
    span.to_range().map(|range| range.start)
}

/// The parser's remarks, without those that repeat the message.
fn labels<'e>(map: &SourceMap, labels: impl Iterator<Item = (Span, &'e str)>, message: &str) -> Vec<ShaderLabel> {
    let mut found = Vec::new();
    for (span, text) in labels {
        let place = first_byte(span).and_then(|byte| map.locate(byte));
        if let Some(place) = place.filter(|_| !text.is_empty() && !message.contains(text)) {
            found.push(ShaderLabel { place, text: text.to_owned() });
        }
    }
    found
}

fn suggestion(unknown: &str, map: &SourceMap) -> Option<String> {
    if let Some((_, name)) = OTHER_LANGUAGES.iter().find(|(other, _)| *other == unknown) {
        return Some(format!("WGSL has {} for it", quote(name)));
    }
    if unknown.ends_with("_sampler") {
        return Some(format!("the argument `{unknown}: sampler` follows that of its texture"));
    }
    let builtin = naga::keywords::wgsl::BUILTIN_IDENTIFIERS.iter().copied();
    let mut names: Vec<&str> = Vec::new();
    for text in map.author_texts() {
        let tokens = tokens(text).unwrap_or_default();
        names.extend(tokens.iter().filter(|token| token.kind == TokenKind::Name).map(|token| token.of(text)));
    }
    did_you_mean(unknown, names.into_iter().filter(|name| *name != unknown).chain(builtin))
}

/// Help for mistakes of authors who know other languages.
fn advice(message: &str, source: &str, at: std::ops::Range<usize>, map: &SourceMap) -> Option<String> {
    const COMPONENTS: &str = "xyzwrgba";
    let word = source.get(at.clone())?;
    if word.starts_with('?') {
        return Some("WGSL has `select(otherwise, value, condition)` for `condition ? value : otherwise`".to_owned());
    }
    if message.starts_with("expected `;`") {
        return Some("a statement ends with `;`: it is missing before this".to_owned());
    }
    if message.starts_with("invalid field accessor") {
        let is_of_vector = word.chars().all(|c| COMPONENTS.contains(c));
        let owner = source.get(..at.start)?.trim_end_matches('.');
        let owner = owner.rsplit(|c: char| !c.is_alphanumeric() && c != '_').next()?;
        let ty = map.author_texts().find_map(|text| type_of(text, owner));
        let told = ty.map(|ty| format!("{} is a {}", quote(owner), quote(ty)));
        if !is_of_vector {
            return suggestion(word, map).or(told);
        }
        let of_vector = "a vector has `x`, `y`, `z`, `w` or `r`, `g`, `b`, `a`, as many as its size";
        return Some(told.map_or(of_vector.to_owned(), |told| format!("{told}; {of_vector}")));
    }
    let before = source.get(..at.start)?.rsplit(['\n', ';', '{']).next()?.trim();
    let is_type =
        OTHER_LANGUAGES.iter().any(|(other, name)| *other == before && !name.starts_with(|c| "%*".contains(c)));
    let declares = message.starts_with("expected assignment") && is_type;
    declares.then(|| format!("WGSL declares a value by `let {word} = ...`, and one that changes by `var {word} = ...`"))
}

/// The error of a call that reads a texture without its sampler. The place is that of the call, or of an argument that
/// should be a sampler.
fn no_sampler(message: &str, source: &str, at: usize) -> Option<String> {
    let name = |text: &str| text.rsplit(|c: char| !c.is_alphanumeric() && c != '_').next().map(str::to_owned);
    let (before, after) = source.split_at_checked(at)?;
    let (called, given) = match after.split_once('(') {
        Some((called, after))
            if message.contains(" arguments")
                && ["tap", "textureSample"].iter().any(|name| called.starts_with(name)) =>
        {
            let given = after.split([';', '\n']).next().filter(|given| !given.contains("sampler"))?;
            (called.to_owned(), given.split_once(',')?.0)
        }
        _ if message == "Not a global variable or a function argument" => {
            let (before, given) = before.trim_end().strip_suffix(',')?.rsplit_once('(')?;
            (name(before)?, given)
        }
        _ => return None,
    };
    let (texture, tap) = (name(given)?, if called.starts_with("tap") { &called } else { "tap" });
    Some(format!(
        "`{called}` reads a texture through its sampler: write `{tap}({texture}, {texture}_sampler, uv)`, with the \
         argument `{texture}_sampler: sampler` after the texture `{texture}`"
    ))
}

/// The type that a declaration `name: type` states.
fn type_of<'t>(text: &'t str, name: &str) -> Option<&'t str> {
    let tokens = tokens(text).ok()?;
    let is_declared = |window: &[Token]| window[0].of(text) == name && window[1].is(':');
    let window = tokens.windows(3).find(|window| is_declared(window))?;
    Some(window[2].of(text))
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

/// The message with the validator's numbers, such as `[7]` and `Some([7])`, replaced by what `name` has for them, or
/// left out. The second argument of `name` says whether the number follows the word "type".
fn without_handles(message: &str, name: impl Fn(&str, bool) -> Option<String>) -> String {
    let mut rest = message;
    let mut plain = String::new();
    while let Some(start) = rest.find('[') {
        let after = &rest[start + 1..];
        let digits = after.find(|c: char| !c.is_ascii_digit()).unwrap_or(after.len());
        if digits == 0 || !after[digits..].starts_with(']') {
            plain.push_str(&rest[..=start]);
            rest = after;
            continue;
        }
        let handle = &rest[start..start + digits + 2];
        let is_some = rest[..start].ends_with("Some(");
        plain.push_str(rest[..start].trim_end_matches("Some("));
        rest = &after[digits + 1..];
        rest = rest.strip_prefix(')').filter(|_| is_some).unwrap_or(rest);
        match name(handle, plain.trim_end().to_lowercase().ends_with("type")) {
            Some(name) => plain.push_str(&quote(&name)),
            None => plain.truncate(plain.trim_end().len()),
        }
    }
    plain + rest
}

/// The message with the validator's descriptions of numbers and vectors replaced by the names of their types.
fn with_type_names(message: String) -> String {
    let scalars = [(Scalar::F32, "f32"), (Scalar::I32, "i32"), (Scalar::U32, "u32"), (Scalar::BOOL, "bool")];
    let sizes = [(VectorSize::Bi, 2), (VectorSize::Tri, 3), (VectorSize::Quad, 4)];
    let mut plain = message.replace(" with (of type ", " with a value (of type ");
    plain = plain.replace(" and (of type ", " and one (of type ");
    for (scalar, name) in scalars {
        for (size, count) in sizes {
            let vector = format!("{:?}", TypeInner::Vector { size, scalar });
            plain = plain.replace(&vector, &format!("`vec{count}<{name}>`"));
        }
        plain = plain.replace(&format!("{:?}", TypeInner::Scalar(scalar)), &quote(name));
    }
    plain
}

fn type_name(module: &Module, handle: &str) -> Option<String> {
    let (ty, _) = module.types.iter().find(|(ty, _)| format!("{ty:?}") == handle)?;
    Some(module.types.type_to_string(ty))
}

/// The code of an expression, if it is short.
fn code_at(source: &str, span: Span) -> Option<String> {
    const MAX_LENGTH: usize = 40;
    let code = source.get(span.to_range()?)?;
    (!code.is_empty() && code.len() <= MAX_LENGTH && !code.contains('\n')).then(|| code.to_owned())
}

/// The module in which the function around a byte only returns a zero, with all bytes outside of its body in their
/// places; `None` if no function is there or its body cannot be told.
fn without_function_body(text: &str, byte: usize) -> Option<String> {
    let tokens = tokens(text).ok()?;
    let is_fn = |token: &Token| token.kind == TokenKind::Name && token.of(text) == "fn";
    let starts: Vec<usize> = (0..tokens.len()).filter(|at| is_fn(&tokens[*at])).collect();
    let first = *starts.iter().rfind(|at| tokens[**at].start as usize <= byte)?;
    let open = first + tokens[first..].iter().position(|token| token.is('{'))?;
    let mut depth = 0;
    let mut close = None;
    for (at, token) in tokens.iter().enumerate().skip(open) {
        depth += i32::from(token.is('{')) - i32::from(token.is('}'));
        if depth == 0 {
            close = Some(at);
            break;
        }
    }
    let (body, end) = (tokens[open].end as usize, tokens[close?].start as usize);
    let signature = &text[tokens[first].start as usize..tokens[open].start as usize];
    let zero = match signature.rsplit_once("->") {
        Some((_, returned)) if returned.contains('@') => return None,
        Some((_, returned)) => format!("return {}();", returned.trim()),
        None => String::new(),
    };
    let is_in_body = (body..=end).contains(&byte);
    (is_in_body && zero.len() <= end - body)
        .then(|| format!("{}{zero:<width$}{}", &text[..body], &text[end..], width = end - body))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_the_validator_become_names() {
        let name = |handle: &str, follows_type: bool| match handle {
            "[7]" => Some(if follows_type { "vec3<f32>" } else { "a + b" }.to_owned()),
            _ => None,
        };
        for (message, plain) in [
            ("type Some([7]) of [7]", "type `vec3<f32>` of `a + b`"),
            ("Expression [12] is wrong, [x] is not", "Expression is wrong, [x] is not"),
            ("Argument 3 of [", "Argument 3 of ["),
        ] {
            assert_eq!(without_handles(message, name), plain);
        }
    }

    #[test]
    fn a_function_without_its_body_has_its_length() {
        let text = "fn f(a: f32) -> f32 { return wrong(a) + 1.0; } fn g() { let x = 1; }";
        let blank = without_function_body(text, text.find("wrong").expect("it is there")).expect("a function");
        assert_eq!(blank.len(), text.len());
        assert!(naga::front::wgsl::parse_str(&blank).is_ok(), "{blank}");
        assert_eq!(without_function_body(text, 3), None, "a signature is no body");
        assert_eq!(without_function_body("const A = 1;", 3), None);
    }
}
