//! XML of color files: parsed within limits, with the line of every error.

use roxmltree::{Document, Error, Node, ParsingOptions};

use super::LutError;
use super::text::short;

/// The largest file, in bytes.
const MAX_BYTES: usize = 100 << 20;

/// Maximum number of elements, texts and comments.
const MAX_NODES: u32 = 250_000;

/// Maximum number of `=`, of which each attribute has one: the parser compares each attribute with those of its element
/// and each namespace with those around it.
const MAX_ATTRIBUTES: usize = 5000;

/// The largest magnitude of a number in a file.
const MOST: f64 = 1e9;

/// Parses XML. Document type definitions, and with them entities, are refused.
pub(crate) fn parse(text: &str) -> Result<Document<'_>, LutError> {
    if text.len() > MAX_BYTES {
        return Err(LutError::new(0, format!("the file is larger than {} MiB", MAX_BYTES >> 20)));
    }
    if text.bytes().filter(|byte| *byte == b'=').count() > MAX_ATTRIBUTES {
        return Err(LutError::new(0, format!("the file has more than {MAX_ATTRIBUTES} attributes")));
    }
    let options = ParsingOptions { nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    Document::parse_with_options(text, options).map_err(|error| {
        let line = match error {
            Error::UnexpectedEndOfStream | Error::UnclosedRootNode | Error::NoRootNode => text.lines().count().max(1),
            Error::NodesLimitReached | Error::AttributesLimitReached | Error::NamespacesLimitReached => 0,
            _ => error.pos().row as usize,
        };
        match error {
            Error::DtdDetected => LutError::new(line, "a document type definition is not accepted"),
            Error::NodesLimitReached => LutError::new(line, format!("the file has more than {MAX_NODES} elements")),
            _ => LutError::new(line, format!("the XML cannot be read: {error}")),
        }
    })
}

/// An error in an element.
pub(crate) fn error(node: Node<'_, '_>, message: impl Into<String>) -> LutError {
    LutError::new(line(node, node.range().start), message)
}

fn line(node: Node<'_, '_>, at: usize) -> usize {
    node.document().text_pos_at(at).row as usize
}

/// The name of an element, without its namespace.
pub(crate) fn name<'a>(node: Node<'a, '_>) -> &'a str {
    node.tag_name().name()
}

pub(crate) fn elements<'a, 'i: 'a>(node: Node<'a, 'i>) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(Node::is_element)
}

/// The only element with one of these names in an element. An error if there are several.
pub(crate) fn element<'a, 'i>(node: Node<'a, 'i>, names: &[&str]) -> Result<Option<Node<'a, 'i>>, LutError> {
    let mut found = elements(node).filter(|element| names.contains(&name(*element)));
    let first = found.next();
    match found.next() {
        None => Ok(first),
        Some(second) => Err(error(second, format!("`{}` is there twice", name(second)))),
    }
}

/// The same where it must be there.
pub(crate) fn required<'a, 'i>(node: Node<'a, 'i>, names: &[&str]) -> Result<Node<'a, 'i>, LutError> {
    element(node, names)?.ok_or_else(|| error(node, format!("`{}` has no `{}`", name(node), names[0])))
}

/// Refuses attributes and elements with other names.
pub(crate) fn only(node: Node<'_, '_>, attributes: &[&str], names: &[&str]) -> Result<(), LutError> {
    let own = |attribute: &roxmltree::Attribute<'_, '_>| attribute.namespace().is_none();
    let unknown = node.attributes().filter(own).find(|attribute| !attributes.contains(&attribute.name()));
    if let Some(attribute) = unknown {
        return Err(error(node, format!("`{}` has no attribute `{}`", name(node), short(attribute.name()))));
    }
    match elements(node).find(|element| !names.contains(&name(*element))) {
        None => Ok(()),
        Some(other) => Err(error(other, format!("`{}` has no element `{}`", name(node), short(name(other))))),
    }
}

pub(crate) fn attribute<'a>(node: Node<'a, '_>, key: &str) -> Result<&'a str, LutError> {
    node.attribute(key).ok_or_else(|| error(node, format!("`{}` has no attribute `{key}`", name(node))))
}

/// The number in an attribute, if it is there.
pub(crate) fn number_in(node: Node<'_, '_>, key: &str) -> Result<Option<f64>, LutError> {
    let parse = |word: &str| number(word.trim()).map_err(|why| error(node, format!("`{key}`: {why}")));
    node.attribute(key).map(parse).transpose()
}

/// Exactly `N` numbers in an element.
pub(crate) fn numbers<const N: usize>(node: Node<'_, '_>) -> Result<[f64; N], LutError> {
    let mut found = [0.0; N];
    fill(node, N, |index, word| number(word).map(|x| found[index] = x))?;
    Ok(found)
}

/// Passes exactly `count` words of an element to `take`, with their indices. An error of `take` gets the line of its
/// word.
pub(crate) fn fill(
    node: Node<'_, '_>,
    count: usize,
    mut take: impl FnMut(usize, &str) -> Result<(), String>,
) -> Result<(), LutError> {
    let mut found = 0;
    for text in node.children().filter(Node::is_text) {
        let content = text.text().unwrap_or_default();
        for word in content.split_ascii_whitespace() {
            let at = || line(node, text.range().start + (word.as_ptr() as usize - content.as_ptr() as usize));
            if found == count {
                return Err(LutError::new(
                    at(),
                    format!("there are more than the {count} numbers of `{}`", name(node)),
                ));
            }
            take(found, word).map_err(|why| LutError::new(at(), why))?;
            found += 1;
        }
    }
    match found == count {
        true => Ok(()),
        false => Err(error(node, format!("`{}` has {count} numbers, not {found}", name(node)))),
    }
}

/// A finite number. The error is a message.
pub(crate) fn number(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(x) if x.abs() <= MOST => Ok(x),
        Ok(x) if x.is_finite() => Err(format!("`{}` is larger than 1e9", short(word))),
        Ok(_) => Err(format!("`{}` is not finite", short(word))),
        Err(_) => Err(format!("`{}` is not a number", short(word))),
    }
}
