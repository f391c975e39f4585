//! Types and fallbacks of the ports in a `node.ron`.

use crate::document::{Field, Group, Item, Tree};
use crate::node::{Fallback, Input, PortType};
use afterimage_base::diagnostic::{Diagnostic, Diagnostics, Location, Spanned, list, quote};

/// The fallback of an output. Readers of the main one get the first input of its type, if nothing is declared.
pub(super) fn fallback_of(
    item: Option<Item>,
    ty: PortType,
    is_main: bool,
    inputs: &[(Input, Location)],
    diagnostics: &mut Diagnostics,
) -> Fallback {
    let fitting = || inputs.iter().filter(|(port, _)| port.ty == ty).map(|(port, _)| &*port.name);
    let Some(item) = item else {
        let first = fitting().next().filter(|_| is_main);
        return first.map_or(Fallback::Zero, |name| Fallback::Input(name.to_owned().into()));
    };
    match &item.value {
        Tree::Name(name) if name == "Zero" => Fallback::Zero,
        Tree::Name(name) if name == "Absent" => Fallback::Absent,
        Tree::Text(name) if fitting().any(|port| port == name) => Fallback::Input(name.clone().into()),
        _ => {
            let inputs = match fitting().next() {
                Some(_) => format!(" or one of the inputs of its type in quotes: {}", list(fitting(), 8)),
                None => String::new(),
            };
            let error = Diagnostic::error("wrong-type", "`fallback` must be an input, `Zero` or `Absent`");
            diagnostics.push(error.at(&item.location, "").help(format!("write `Zero`, `Absent`{inputs}")));
            Fallback::Zero
        }
    }
}

/// The name and the fields of `Type(...)`.
pub(super) fn typed(
    name: &Spanned<String>,
    item: Item,
    what: &str,
    diagnostics: &mut Diagnostics,
) -> Option<(Spanned<String>, Group<Field>)> {
    match item.value {
        Tree::Struct(Some(ty), fields) => Some((ty, fields)),
        Tree::Name(ty) => Some((Spanned::new(ty, item.location), Group::default())),
        Tree::Broken => None,
        other => {
            let message = format!("the {what} {} has {} for a type", quote(&name.value), other.describe());
            diagnostics.push(
                Diagnostic::error("wrong-shape", message)
                    .at(&item.location, "")
                    .help("write it as `\"name\": Type(doc: \"...\")`"),
            );
            None
        }
    }
}
