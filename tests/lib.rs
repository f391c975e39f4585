//! Tests.

/// The programs of the recipes run. Their commands are tests of the command line.
#[cfg(all(doctest, not(no_gpu)))]
#[doc = include_str!("../graph/docs/recipes.md")]
struct Recipes;
