//! Documents: a graph that can be planned, or errors with words and places.

use std::sync::Arc;

use afterimage_graph::check::{CheckOptions, Loader, check};
use afterimage_graph::diagnostic::Diagnostics;
use afterimage_graph::document::parse;
use afterimage_graph::image::Size;
use afterimage_graph::node::Registry;
use afterimage_plan::{Caps, Options, verify};

use crate::corpus::shipped;
use crate::plan::planned;

/// The only files there are: the shipped pipelines, a small table, and the document itself.
pub(crate) struct Few<'t> {
    shipped: &'t [(String, String)],
    itself: &'t str,
}

const CUBE: &str = "LUT_3D_SIZE 2\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 0.9 1\n";

impl<'t> Few<'t> {
    pub(crate) fn new(itself: &'t str) -> Self {
        Self { shipped: all_shipped(), itself }
    }
}

/// The shipped pipelines, read once.
pub(crate) fn all_shipped() -> &'static [(String, String)] {
    static SHIPPED: std::sync::OnceLock<Vec<(String, String)>> = std::sync::OnceLock::new();
    SHIPPED.get_or_init(shipped)
}

/// The built-in kinds.
pub(crate) fn registry() -> &'static Registry {
    static REGISTRY: std::sync::OnceLock<Registry> = std::sync::OnceLock::new();
    REGISTRY.get_or_init(|| Registry::new(&[afterimage_nodes::ALL]).expect("the built-in kinds have different names"))
}

impl Loader for Few<'_> {
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
        let text = match path {
            "self.ron" => Some(self.itself),
            path if path.ends_with(".cube") => Some(CUBE),
            path => self.shipped.iter().find(|(name, _)| name == path).map(|(_, text)| text.as_str()),
        };
        text.map(|text| text.as_bytes().into()).ok_or_else(|| "there is no such file".to_owned())
    }
}

/// One of N documents without errors is planned: the target `plan` plans all of its own.
const ONE_OF: usize = 8;

/// True if the text is a pipeline without errors.
pub(crate) fn survives(text: &str) -> bool {
    let loader = Few::new(text);
    let options = CheckOptions { tier: None, sets: Vec::new(), loader: &loader };
    let checked = parse("self.ron", text).and_then(|document| check(&document, registry(), &options));
    match checked {
        Ok((graph, warnings)) => {
            has_words(&warnings);
            let is_planned = text.len().is_multiple_of(ONE_OF);
            if let Some(Ok(plan)) =
                is_planned.then(|| planned(&graph, Size::new(64, 36), Caps::default(), Options::default()))
            {
                assert_eq!(verify(&plan), Ok(()));
            }
            true
        }
        Err(diagnostics) => {
            assert!(diagnostics.has_errors());
            has_words(&diagnostics);
            false
        }
    }
}

/// Every message says what and where, in each form.
pub(crate) fn has_words(diagnostics: &Diagnostics) {
    assert!(diagnostics.iter().all(|one| !one.message.is_empty() && !one.labels.is_empty()), "{diagnostics}");
    let text = diagnostics.to_string();
    assert!(diagnostics.is_empty() || text.starts_with("error[") || text.starts_with("warning["), "{text}");
    assert!(text.chars().all(|c| c == '\n' || !c.is_control()), "{text:?}");
    assert_eq!(diagnostics.to_json().as_array().map(Vec::len), Some(diagnostics.len()));
}
