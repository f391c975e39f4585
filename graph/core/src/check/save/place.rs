//! Where a change is written.

use super::path::{join_written, relative};
use super::resolve::{ResolvedChange, switch};
use super::state::{SetTo, State, Subject};
use crate::document::{Editor, Override, Tree};
use afterimage_base::value::{FileValue, Type, Value};

impl SetTo {
    /// As the file writes it.
    pub(super) fn text(&self, file: &str) -> String {
        match self {
            Self::Value(Value::File(named)) => {
                Value::File(FileValue { path: relative(file, &named.path).into(), bytes: None }).to_string()
            }
            Self::Value(value) => value.to_string(),
            Self::Off(off) => switch(*off).to_owned(),
        }
    }
}

impl State<'_> {
    /// Writes a change where the value is given; `tier` is the one of this state.
    pub(super) fn write(&self, editor: &mut Editor<'_>, tier: Option<&str>, change: &ResolvedChange) {
        let key = self.key(change.subject);
        let is_own = |file: &str| *file == *self.document.file;
        match (self.given(change.subject), tier) {
            (Some(location), _) if is_own(&location.file) => self.replace(editor, change),
            (Some(_), Some(tier)) if self.is_of_tier(change.subject) => {
                self.write_to_tier(editor, tier, &key, change.text.clone());
            }
            (None, _) => match change.subject {
                Subject::Value(node, index)
                    if self.draft(node).scope == 0 && is_own(&self.draft(node).kind_location.file) =>
                {
                    let name = &self.draft(node).kind.params()[index].name;
                    editor.add_field(self.draft(node).kind_location.start, name, change.text.clone());
                }
                _ => editor.add_to_set(&key, change.text.clone()),
            },
            _ => editor.add_to_set(&key, change.text.clone()),
        }
    }

    /// Writes a value in place of the one that is written.
    fn replace(&self, editor: &mut Editor<'_>, change: &ResolvedChange) {
        let Some(location) = self.given(change.subject) else { return };
        match (self.set_to(change.subject), &change.set_to) {
            (SetTo::Value(Value::Vector(old, n)), SetTo::Value(Value::Vector(new, _))) => {
                let number = |(old, new): (&f64, &f64)| (old != new).then(|| Value::Float(*new).to_string());
                editor.replace_numbers(location.span(), old.iter().zip(new).take(n).map(number).collect());
            }
            _ => editor.replace(location.span(), change.text.clone()),
        }
    }

    /// Adds an override to a tier. A tier that the file inherits is copied into it, because a tier replaces the
    /// inherited one of its name.
    pub(super) fn write_to_tier(&self, editor: &mut Editor<'_>, tier: &str, key: &str, text: String) {
        if !editor.has_tier(tier) {
            self.copy_tier(editor, tier, tier);
        }
        editor.add_to_tier(tier, key, text);
    }

    /// Adds a tier with the overrides of another one.
    pub(super) fn copy_tier(&self, editor: &mut Editor<'_>, from: &str, to: &str) {
        editor.add_tier(to);
        for setting in self.overrides(from) {
            if let Some(text) = self.copied(setting) {
                editor.add_to_tier(to, &setting.key.value, text);
            }
        }
    }

    /// The value of an override as the saved file writes it.
    fn copied(&self, setting: &Override) -> Option<String> {
        let location = &setting.value.location;
        let own = &self.document.file;
        if let (Tree::Text(path), true) = (&setting.value.value, self.is_file(&setting.key.value)) {
            let [here, there] = [own, &location.file].map(|file| join_written(file, path));
            if here != there {
                return Some(SetTo::Value(Value::File(FileValue { path: there.into(), bytes: None })).text(own));
            }
        }
        let text = self.builder.diagnostics.sources.text(&location.file)?;
        text.get(location.span()).map(str::to_owned)
    }

    /// Whether a key names a parameter that is a file.
    fn is_file(&self, key: &str) -> bool {
        let found = key.rsplit_once('.').and_then(|(node, field)| {
            let draft = self.draft(self.node(node)?);
            draft.kind.param(field)
        });
        found.is_some_and(|(_, param)| param.ty == Type::File)
    }
}
