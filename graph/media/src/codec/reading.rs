//! How a file is read.

use crate::codec::{Budget, ColorSpace};

/// How a file is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReadOptions {
    /// The memory that decoding may take.
    pub budget: Budget,
    /// What the numbers of a color picture mean, whatever the file states; `None` believes the file.
    pub space: Option<ColorSpace>,
}

impl From<Budget> for ReadOptions {
    fn from(budget: Budget) -> Self {
        Self { budget, space: None }
    }
}
