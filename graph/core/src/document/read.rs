//! From the text of a file, by its tree, to the sections of a pipeline.

use std::sync::Arc;

use super::claim::{CLAIM, Claim, claim};
use super::entries::{Document, InputEntry, NodeEntry, OutputEntry, Override, Tier};
use super::input_options::{contradiction, image_type, image_type_names, set_option};
use super::output::{OUTPUT, output};
use super::parser::{self, Parsed};
use super::syntax;
use super::tree::{Field, Group, Item, Tree};
use super::unknown::unknown;
use afterimage_base::diagnostic::{Diagnostic, Diagnostics, Location, Sources, Spanned, did_you_mean, list, quote};
use afterimage_base::image::ColorState;

/// The names of the sections of a pipeline.
pub const SECTIONS: [&str; 9] = ["inputs", "nodes", "outputs", "set", "tiers", "claims", "extends", "facts", "usual"];

/// The largest file that is read, in bytes. A pipeline of a thousand nodes has a tenth of it.
pub const MAX_FILE: usize = 4 << 20;

/// Reads a pipeline file. The name is the one that messages show, and that files named in it are relative to.
///
/// Reading continues after a syntax error: the document holds what could be read, [`Document::problems`] the errors.
///
/// # Errors
/// When the text holds no `Pipeline( ... )`.
pub fn parse(file_name: &str, text: &str) -> Result<Document, Diagnostics> {
    let text = without_mark(text);
    let mut sources = Sources::default();
    let file = sources.insert(file_name, if text.len() > MAX_FILE { "" } else { text });
    let mut problems = Diagnostics::new(sources);
    if let Err(error) = check_length(&file, text) {
        problems.push(error);
        return Err(problems);
    }
    let Parsed { tree, errors } = parser::read(&file, text);
    errors.into_iter().for_each(|error| problems.push(error));
    document(&file, tree, problems)
}

/// The text without the byte order mark that some editors begin a file with.
pub fn without_mark(text: &str) -> &str {
    text.strip_prefix('\u{feff}').unwrap_or(text)
}

fn check_length(file: &Arc<str>, text: &str) -> Result<(), Diagnostic> {
    let start = Location::new(file, 0..0);
    match text.len() > MAX_FILE {
        true => Err(syntax::too_long(&start, text.len(), MAX_FILE)),
        false if parser::is_blank(file, text) => Err(syntax::blank(&start)),
        false => Ok(()),
    }
}

/// The document of a file's tree, with the problems found so far; only these if it is no pipeline at all.
fn document(file: &Arc<str>, tree: Item, mut problems: Diagnostics) -> Result<Document, Diagnostics> {
    if matches!(tree.value, Tree::Name(_)) {
        // The syntax of prose is of no interest.
        problems = Diagnostics::new(problems.sources);
    }
    let (name, fields) = match pipeline(tree) {
        Ok(pipeline) => pipeline,
        Err(None) => return Err(problems),
        Err(Some(error)) => {
            problems.push(error);
            return Err(problems);
        }
    };
    let mut reader = Reader { problems, unread: Vec::new(), is_partial: fields.is_partial };
    let mut document = Document {
        file: file.clone(),
        location: name.location,
        extends: None,
        inputs: Vec::new(),
        nodes: Vec::new(),
        outputs: Vec::new(),
        set: Vec::new(),
        tiers: Vec::new(),
        claims: Vec::new(),
        facts: None,
        usual: Vec::new(),
        problems: Diagnostics::default(),
        unread: Vec::new(),
        is_partial: false,
    };
    let sections = reader.unique(fields.entries, "section");
    if !reader.is_partial {
        reader.missing_sections(&document, &sections);
    }
    for (section, value) in sections {
        reader.section(&mut document, &section, value);
    }
    let Reader { problems, unread, is_partial } = reader;
    Ok(Document { problems, unread, is_partial, ..document })
}

/// The sections of a pipeline; an error otherwise, or none if it has been reported.
fn pipeline(tree: Item) -> Result<(Spanned<String>, Group<Field>), Option<Diagnostic>> {
    const SHAPE: &str = "a pipeline file is `Pipeline(inputs: { ... }, nodes: { ... }, outputs: { ... })`";
    let wrong = |what: String| Diagnostic::error("not-a-pipeline", what).help(SHAPE);
    let error = match tree.value {
        Tree::Struct(Some(name), fields) if name.value == "Pipeline" => return Ok((name, fields)),
        Tree::Broken => return Err(None),
        Tree::Struct(Some(name), _) | Tree::Tuple(Some(name), _) if name.value != "Pipeline" => {
            wrong(format!("the file holds {}, not a `Pipeline`", quote(&name.value))).at(&name.location, "")
        }
        Tree::Tuple(Some(name), _) => wrong("the sections of a `Pipeline` need names".into()).at(&name.location, ""),
        Tree::Struct(None, _) => {
            wrong("the word `Pipeline` before the parenthesis is missing".into()).at(&tree.location.part(0..1), "")
        }
        other => {
            let first = tree.location.part(0..tree.location.span().len().min(1));
            wrong(format!("the file holds {}, not a `Pipeline`", other.describe())).at(&first, "")
        }
    };
    Err(Some(error))
}

/// The changes of a map such as `set` or a tier.
pub(crate) fn settings(item: Item, what: &str) -> Result<(Vec<Override>, Vec<Diagnostic>), Diagnostic> {
    let mut reader = Reader { problems: Diagnostics::default(), unread: Vec::new(), is_partial: false };
    let wrong = Diagnostic::error("wrong-shape", format!("{what} holds {}, not changes", item.value.describe()))
        .at(&item.location, "")
        .help("write it as `{ \"node.parameter\": value, \"node\": Off }`");
    let entries = match item.value {
        Tree::Map(group) => group,
        Tree::Broken => Group::default(),
        _ => return Err(wrong),
    };
    let settings = reader.keyed(entries, "key").into_iter().map(|(key, value)| Override { key, value }).collect();
    Ok((settings, reader.problems.iter().cloned().collect()))
}

struct Reader {
    problems: Diagnostics,
    unread: Vec<String>,
    is_partial: bool,
}

impl Reader {
    /// The fields without those whose name has occurred before.
    fn unique<T>(&mut self, fields: Vec<(Spanned<String>, T)>, what: &str) -> Vec<(Spanned<String>, T)> {
        let mut seen = std::collections::BTreeMap::new();
        let mut kept = Vec::new();
        for (name, value) in fields {
            match seen.get(&name.value) {
                Some(first) => self.problems.push(doubled(&name, first, what)),
                None => {
                    seen.insert(name.value.clone(), name.location.clone());
                    kept.push((name, value));
                }
            }
        }
        kept
    }

    fn missing_sections(&mut self, document: &Document, sections: &[(Spanned<String>, Item)]) {
        // A misspelt section is reported at its own location.
        let means = |section: &str, name: &str| {
            section == name || !SECTIONS.contains(&section) && did_you_mean(section, [name]).is_some()
        };
        let has = |name: &str| sections.iter().any(|(section, _)| means(&section.value, name));
        for name in ["nodes", "outputs"] {
            // A file that extends another inherits what it leaves out.
            if !has(name) && !has("extends") {
                let help = match name {
                    "nodes" => "add `nodes: { \"name\": Kind(source: \"scene\") }`; it may be empty, `nodes: {}`",
                    _ => "add `outputs: { \"display\": \"node\" }` with the node that makes the picture",
                };
                let message = format!("the pipeline has no section {}", quote(name));
                self.problems.push(Diagnostic::error("missing-section", message).at(&document.location, "").help(help));
            }
        }
    }

    fn section(&mut self, document: &mut Document, name: &Spanned<String>, value: Item) {
        match name.value.as_str() {
            "extends" => document.extends = self.text(value, "`extends`", "the name of a file in quotes"),
            "inputs" => document.inputs = self.entries(value, "inputs", "{ \"scene\": Color }", Self::input),
            "nodes" => {
                let shape = "{ \"name\": Kind(source: \"scene\") }";
                document.nodes = self.entries(value, "nodes", shape, Self::node);
            }
            "outputs" => {
                document.outputs = self.entries(value, "outputs", "{ \"display\": \"node\" }", Self::output);
            }
            "set" => document.set = self.settings(value, "`set`"),
            "tiers" => {
                let entries = self.map(value, "tiers", "{ \"low\": { \"node.parameter\": value } }");
                document.tiers = entries.into_iter().map(|(name, value)| self.tier(name, value)).collect();
            }
            "claims" => {
                let shape = "{ \"low\": Claim(ms: 0.2, on: \"a GPU at 3840x2160\") }";
                let entries = self.map(value, "claims", shape);
                document.claims = entries.into_iter().filter_map(|(name, value)| self.claim(name, value)).collect();
            }
            "facts" => {
                let entries = self.map(value, "facts", "{ \"emissive\": \"something in view emits light\" }");
                let facts = self.texts(entries, "fact", "a sentence in quotes that says what it means");
                document.facts = Some(facts.into_iter().map(|(name, doc)| (name, doc.value)).collect());
            }
            "usual" => {
                let entries = self.map(value, "usual", "{ \"lit.strength\": \"factor of the bloom\" }");
                document.usual = self.texts(entries, "parameter", "a sentence in quotes that says what it changes");
            }
            other => {
                self.is_partial = true;
                let message = format!("a pipeline has no section {}", quote(other));
                self.problems.push(unknown("unknown-section", message, name, "sections", &SECTIONS));
            }
        }
    }

    /// The entries of a section, each with a name of its own.
    fn map(&mut self, item: Item, section: &str, shape: &str) -> Vec<(Spanned<String>, Item)> {
        match item.value {
            Tree::Map(group) => {
                self.is_partial |= group.is_partial;
                self.keyed(group, "name")
            }
            Tree::Broken => {
                self.is_partial = true;
                Vec::new()
            }
            other => {
                let message = format!("`{section}` holds {}, not a map", other.describe());
                let help = format!("write it as `{section}: {shape}`");
                self.problems.push(Diagnostic::error("wrong-shape", message).at(&item.location, "").help(help));
                self.is_partial = true;
                Vec::new()
            }
        }
    }

    fn keyed(&mut self, group: Group<(Item, Item)>, what: &str) -> Vec<(Spanned<String>, Item)> {
        let mut named = Vec::new();
        for (key, value) in group.entries {
            match key.value {
                Tree::Text(text) => named.push((Spanned::new(text, key.location), value)),
                // Entries of other sections, where a bracket is missing.
                _ if group.is_partial => {}
                other => {
                    let message = format!("a {what} here is a text in quotes, not {}", other.describe());
                    let diagnostic = Diagnostic::error("wrong-shape", message).at(&key.location, "");
                    self.problems.push(match other {
                        Tree::Name(name) => {
                            self.unread.push(name.clone());
                            diagnostic.help(format!("write `\"{name}\": ...`")).rewrite(format!("\"{name}\""))
                        }
                        _ => diagnostic.help("write it as `\"name\": ...`"),
                    });
                }
            }
        }
        self.unique(named, what)
    }

    fn text(&mut self, item: Item, what: &str, expected: &str) -> Option<Spanned<String>> {
        match item.value {
            Tree::Text(text) => Some(Spanned::new(text, item.location)),
            Tree::Broken => None,
            other => {
                let message = format!("{what} is {expected}, not {}", other.describe());
                self.problems.push(Diagnostic::error("wrong-shape", message).at(&item.location, ""));
                None
            }
        }
    }

    /// The entries of a section; the names of those that cannot be read are remembered.
    fn entries<T>(
        &mut self,
        value: Item,
        section: &str,
        shape: &str,
        entry: fn(&mut Self, Spanned<String>, Item) -> Option<T>,
    ) -> Vec<T> {
        let mut entries = Vec::new();
        for (name, value) in self.map(value, section, shape) {
            let text = name.value.clone();
            match entry(self, name, value) {
                Some(entry) => entries.push(entry),
                None => self.unread.push(text),
            }
        }
        entries
    }

    /// The entries that hold texts.
    fn texts(
        &mut self,
        entries: Vec<(Spanned<String>, Item)>,
        one: &str,
        expected: &str,
    ) -> Vec<(Spanned<String>, Spanned<String>)> {
        let text = |(name, value): (Spanned<String>, Item)| {
            let what = format!("{one} {}", quote(&name.value));
            self.text(value, &what, expected).map(|text| (name, text))
        };
        entries.into_iter().filter_map(text).collect()
    }

    fn input(&mut self, name: Spanned<String>, value: Item) -> Option<InputEntry> {
        let (ty, options) = match value.value {
            Tree::Name(ty) => (Spanned::new(ty, value.location), Vec::new()),
            Tree::Struct(Some(ty), options) => (ty, options.entries),
            Tree::Broken => return None,
            other => {
                let message = format!("input {} has {} for a type", quote(&name.value), other.describe());
                let help = match &other {
                    Tree::Text(ty) if image_type(ty).is_some() => format!("write `{ty}` without quotes"),
                    _ => format!("the types of images are {}", list(image_type_names(), 16)),
                };
                self.problems.push(Diagnostic::error("wrong-shape", message).at(&value.location, "").help(help));
                return None;
            }
        };
        let image_type = image_type(&ty.value);
        let mut input = InputEntry {
            name,
            state: image_type.map_or(ColorState::Data, |known| known.state),
            min_channels: image_type.map_or(1, |known| known.min_channels),
            block: image_type.is_none().then_some(ty),
            optional: false,
            multisampled: false,
            volume: false,
            needs_alpha: false,
            scale: 1.0,
        };
        for (option, value) in self.unique(options, "option") {
            self.input_option(&mut input, &option, &value);
        }
        contradiction(&input).into_iter().for_each(|problem| self.problems.push(problem));
        Some(input)
    }

    fn input_option(&mut self, input: &mut InputEntry, option: &Spanned<String>, value: &Item) {
        set_option(input, option, value).into_iter().for_each(|problem| self.problems.push(problem));
    }

    fn output(&mut self, name: Spanned<String>, value: Item) -> Option<OutputEntry> {
        match value.value {
            Tree::Struct(Some(word), options) if word.value == OUTPUT => {
                let options = self.unique(options.entries, "option");
                output(name, &word, options, &mut self.problems)
            }
            other => {
                let what = format!("output {}", quote(&name.value));
                let item = Item { value: other, location: value.location };
                let source = self.text(item, &what, "the name of a node or an input in quotes")?;
                Some(OutputEntry { name, source, has_coverage: false })
            }
        }
    }

    fn node(&mut self, name: Spanned<String>, value: Item) -> Option<NodeEntry> {
        let what = match value.value {
            Tree::Struct(Some(kind), fields) => return Some(NodeEntry { name, kind, fields }),
            Tree::Name(kind) => {
                return Some(NodeEntry { name, kind: Spanned::new(kind, value.location), fields: Group::default() });
            }
            Tree::Broken => return None,
            Tree::Tuple(Some(kind), _) => format!("the ports and parameters of {} need names", quote(&kind.value)),
            other => format!("node {} is {}, not a kind with its fields", quote(&name.value), other.describe()),
        };
        let help = "write it as `\"name\": Kind(port: \"other\", parameter: value)`";
        self.problems.push(Diagnostic::error("wrong-shape", what).at(&value.location, "").help(help));
        None
    }

    fn settings(&mut self, value: Item, what: &str) -> Vec<Override> {
        match settings(value, what) {
            Ok((settings, problems)) => {
                problems.into_iter().for_each(|problem| self.problems.push(problem));
                settings
            }
            Err(problem) => {
                self.problems.push(problem);
                Vec::new()
            }
        }
    }

    fn tier(&mut self, name: Spanned<String>, value: Item) -> (Spanned<String>, Tier) {
        let tier = match value.value {
            Tree::Text(file) => Tier::File(Spanned::new(file, value.location)),
            _ => Tier::Settings(self.settings(value, &format!("tier {}", quote(&name.value)))),
        };
        (name, tier)
    }

    fn claim(&mut self, name: Spanned<String>, value: Item) -> Option<(Spanned<String>, Claim)> {
        let problems = match value.value {
            Tree::Struct(Some(word), figures) if word.value == CLAIM => {
                match claim(&word, self.unique(figures.entries, "figure")) {
                    Ok(claim) => return Some((name, claim)),
                    Err(problems) => problems,
                }
            }
            Tree::Broken => return None,
            other => {
                let message = format!("the claim of {} is {}", quote(&name.value), other.describe());
                let help = "write it as `\"low\": Claim(ms: 0.2, on: \"a GPU at 3840x2160\")`";
                vec![Diagnostic::error("wrong-shape", message).at(&value.location, "").help(help)]
            }
        };
        problems.into_iter().for_each(|problem| self.problems.push(problem));
        None
    }
}

/// Two entries of one name.
pub(crate) fn doubled(again: &Spanned<String>, first: &Location, what: &str) -> Diagnostic {
    Diagnostic::error("doubled", format!("the {what} {} is given twice", quote(&again.value)))
        .at(&again.location, "given again here")
        .also(first, "first given here")
        .help("keep one of them")
}
