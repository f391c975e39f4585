//! Measurements of pipelines: error metrics, plots, and the searches and tests that use them.

pub mod metrics;
