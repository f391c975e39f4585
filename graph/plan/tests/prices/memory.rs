//! The table of `graph/docs/measurements/memory.md`, which is that of the present plans.

use afterimage_plan::Memory;

use super::Prices;

const DOCUMENT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/measurements/memory.md");
/// The line above the rows.
const RULE: &str = "|---|--:|--:|--:|--:|--:|\n";

/// Compares the rows of the pipelines as written with those of the document, or writes them.
pub(super) fn compare(prices: &[Prices], blesses: bool) {
    let written = prices.iter().filter_map(|row| Some((row.name.strip_suffix(" as written")?, row.memory.as_ref()?)));
    let rows: String = written.map(|(name, memory)| row(name, memory)).collect();
    let text = std::fs::read_to_string(DOCUMENT).unwrap_or_else(|error| panic!("{DOCUMENT}: {error}"));
    let (head, known) = text.split_once(RULE).expect("the document has a table");
    if blesses {
        let text = format!("{head}{RULE}{rows}");
        std::fs::write(DOCUMENT, text).unwrap_or_else(|error| panic!("{DOCUMENT}: {error}"));
    } else {
        assert_eq!(known, rows, "memory.md is stale: if this is meant, set AFTERIMAGE_BLESS=1");
    }
}

fn row(name: &str, memory: &Memory) -> String {
    let bytes = [memory.unaliased, memory.unshared, memory.pooled, memory.placed, memory.kept];
    let cells = bytes.map(|bytes| format!("{:.1}", bytes as f64 / f64::from(1 << 20)));
    format!("| {name} | {} |\n", cells.join(" | "))
}
