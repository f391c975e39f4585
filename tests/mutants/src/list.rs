//! The mutants that cargo-mutants finds, in a fixed random order.

use std::collections::HashMap;
use std::process::Command;

use serde::{Deserialize, Serialize};

/// A place in a file, from 1.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub(crate) struct Place {
    pub(crate) line: usize,
    pub(crate) column: usize,
}

/// The text that a mutant replaces.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub(crate) struct Span {
    pub(crate) start: Place,
}

/// One change of the code, as `cargo mutants --list --json` describes it.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(crate) struct Mutant {
    /// The file, the place and the change.
    pub(crate) name: String,
    pub(crate) file: String,
    pub(crate) package: String,
    pub(crate) genre: String,
    pub(crate) replacement: String,
    pub(crate) span: Span,
}

impl Mutant {
    /// The file and the change without the place, which an edit of the file above it moves.
    fn change(&self) -> String {
        let change = self.name.splitn(4, ':').nth(3).unwrap_or_default();
        format!("{}:{change}", self.file)
    }
}

/// All mutants of the crates, in an order that depends on the seed and not on the lines where they are.
pub(crate) fn shuffled(packages: &[&str], seed: u64) -> Vec<Mutant> {
    let mut occurrences: HashMap<String, u64> = HashMap::new();
    let mut keyed: Vec<(u64, Mutant)> = Vec::new();
    for mutant in packages.iter().flat_map(|package| listed(package)) {
        let occurrence = occurrences.entry(mutant.change()).or_default();
        keyed.push((hash(&mutant.change(), seed.wrapping_add(*occurrence << 32)), mutant));
        *occurrence += 1;
    }
    keyed.sort_by(|a, b| (a.0, &a.1.name).cmp(&(b.0, &b.1.name)));
    keyed.into_iter().map(|(_, mutant)| mutant).collect()
}

fn listed(package: &str) -> Vec<Mutant> {
    let output = Command::new("cargo").args(["mutants", "--list", "--json", "-p", package]).output();
    let output = output.expect("cargo can be called");
    assert!(output.status.success(), "cargo mutants: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("cargo mutants lists JSON")
}

/// FNV-1a with the finalizer of splitmix64, which spreads equal beginnings.
fn hash(text: &str, seed: u64) -> u64 {
    let fnv = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    let mut z = text.bytes().fold(0xcbf2_9ce4_8422_2325 ^ seed, fnv);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
