//! A file is loaded and parsed once, however many tiers it has.

use std::cell::RefCell;
use std::sync::Arc;

use afterimage_graph::check::{Checker, Loader};
use afterimage_graph::document::parse;
use afterimage_graph::node::Registry;

use super::{CaseFiles, kinds};

/// Remembers what was loaded.
#[derive(Default)]
struct Counted(RefCell<Vec<String>>);

impl Loader for Counted {
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
        self.0.borrow_mut().push(path.to_owned());
        CaseFiles.load(path)
    }
}

#[test]
fn every_tier_is_checked_with_the_same_files() {
    let text = r#"Pipeline(
        extends: "files/film_base.ron",
        nodes: { "glow": Pipeline(file: "files/bloom.ron", source: "exposed") },
        outputs: { "light": "glow" },
        tiers: { "low": { "exposed.stops": -1.0 }, "film": "files/film.ron", "lost": "files/none.ron" },
    )"#;
    let registry = Registry::new(&[kinds::ALL]).expect("the kinds have different names");
    let document = parse("tiers.ron", text).unwrap_or_else(|errors| panic!("{errors}"));
    let loader = Counted::default();
    let checker = Checker::new(&document, &registry, &loader);
    assert_eq!(checker.tiers(), ["low", "film", "lost"]);
    for _ in 0..2 {
        for tier in [None, Some("low"), Some("film")] {
            checker.check(tier, &[]).unwrap_or_else(|errors| panic!("{tier:?}: {errors}"));
        }
        let errors = checker.check(Some("lost"), &[]).expect_err("the file is not there");
        assert!(errors.to_string().contains("cannot read `files/none.ron`"), "{errors}");
    }
    let mut loaded = loader.0.into_inner();
    loaded.sort();
    assert_eq!(loaded, ["files/bloom.ron", "files/film.ron", "files/film_base.ron", "files/none.ron"]);
}
