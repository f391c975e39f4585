//! Spans of the crate `tracing`, if the feature of that name is on.

/// The rest of the block is a span of that name.
macro_rules! span {
    ($name:literal) => {
        #[cfg(feature = "tracing")]
        let _span = tracing::debug_span!($name).entered();
    };
}
