//! The text of a linked module, with its map.

use std::borrow::Cow;
use std::ops::Range;

use super::instance::{Instance, Part, Target};
use super::resolve::replacing;
use super::source_map::SourceMap;
use crate::module::{Declaration, Use};

/// The module: what every device must be asked for, then the declarations of each instance.
/// `loop_start` follows the first bracket of the loops whose steps are counted.
pub(super) fn emit(parts: &[Part<'_>], loop_start: &str) -> (String, SourceMap) {
    let mut writer = Writer { parts, loop_start, text: String::with_capacity(8192), map: SourceMap::default() };
    writer.directives();
    for (index, part) in parts.iter().enumerate() {
        if part.reached.contains(&true) {
            writer.part(Instance(index as u32), part);
        }
    }
    (writer.text, writer.map)
}

struct Writer<'w, 'a> {
    parts: &'w [Part<'a>],
    loop_start: &'w str,
    text: String,
    map: SourceMap,
}

impl<'w> Writer<'w, '_> {
    fn directives(&mut self) {
        let mut lines: Vec<&str> = Vec::new();
        for part in self.parts.iter().filter(|part| part.reached.contains(&true)) {
            for bytes in &part.module.directives {
                let line = &part.file.text()[bytes.clone()];
                if !lines.contains(&line) {
                    lines.push(line);
                }
            }
        }
        for line in lines {
            self.text.push_str(line);
            self.text.push('\n');
        }
    }

    fn part(&mut self, instance: Instance, part: &'w Part<'_>) {
        self.map.file(part.file.name(), part.file.text(), part.is_framework);
        for (declaration, reached) in part.module.declarations.iter().zip(&part.reached) {
            if *reached && !self.is_replaced(part, declaration) {
                self.declaration(instance, part, declaration);
            }
        }
    }

    /// Returns whether something else is used in place of what is declared.
    fn is_replaced(&self, part: &Part<'_>, declaration: &Declaration) -> bool {
        declaration.name.is_some_and(|name| part.replacements.iter().any(|replacement| replacement.name == name))
    }

    fn declaration(&mut self, instance: Instance, part: &'w Part<'_>, declaration: &Declaration) {
        let source: &str = part.file.text();
        let bytes = part.module.bytes(declaration.tokens.start as usize..declaration.tokens.end as usize);
        let mut at = bytes.start;
        for (changed, by) in self.changes(instance, part, declaration, &bytes) {
            if changed.start < at {
                continue;
            }
            self.copy(source, at..changed.start);
            self.map.segment(self.text.len(), changed.start, changed.len());
            self.text.push_str(&by);
            at = changed.end;
        }
        self.copy(source, at..bytes.end);
        self.text.push('\n');
    }

    fn copy(&mut self, source: &str, bytes: Range<usize>) {
        if !bytes.is_empty() {
            self.map.segment(self.text.len(), bytes.start, bytes.len());
            self.text.push_str(&source[bytes]);
        }
    }

    /// Other text for bytes of a declaration, in order; where two begin at one byte, the edit comes first.
    fn changes(
        &self,
        instance: Instance,
        part: &'w Part<'_>,
        declaration: &Declaration,
        bytes: &Range<usize>,
    ) -> Vec<(Range<usize>, Cow<'w, str>)> {
        let edits = part.edits.iter().filter(|(edited, _)| bytes.start <= edited.start && edited.end <= bytes.end);
        let mut changes: Vec<(Range<usize>, Cow<'w, str>)> =
            edits.map(|(bytes, text)| (bytes.clone(), Cow::Borrowed(text.as_str()))).collect();
        let loops = part.loops.iter().filter(|at| bytes.start <= at.start && at.end <= bytes.end);
        changes.extend(loops.map(|at| (at.clone(), Cow::Borrowed(self.loop_start))));
        let is_edited = !changes.is_empty();
        changes.extend(declaration.uses.iter().filter_map(|used| self.renamed(instance, part, used)));
        if is_edited {
            changes.sort_by_key(|(bytes, _)| bytes.start);
        }
        changes
    }

    /// Another name for one that is used.
    fn renamed(&self, instance: Instance, part: &'w Part<'_>, used: &Use) -> Option<(Range<usize>, Cow<'w, str>)> {
        let token = used.token as usize;
        match part.targets[used.symbol.index()]? {
            Target::Declared(other, symbol) => {
                let name = self.parts[other.index()].final_name(symbol);
                let is_same = other == instance && part.renamed[used.symbol.index()].is_none();
                (!is_same && name != part.module.name(used.symbol))
                    .then(|| (part.module.bytes(token..token + 1), Cow::Borrowed(name)))
            }
            Target::Replaced(index) => {
                let replacement = &part.replacements[index];
                let by = match replacing(self.parts, instance, index) {
                    Target::Declared(code, symbol) => self.parts[code.index()].final_name(symbol),
                    _ => &replacement.by,
                };
                Some((part.module.bytes(token..token + 1), Cow::Owned(format!("{by}{}", replacement.members))))
            }
            Target::Language => None,
        }
    }
}
