//! Spans of the crate `tracing`, if the feature of that name is on.

/// The rest of the block is a span of that name.
#[doc(hidden)] // For the crate `afterimage`.
#[macro_export]
macro_rules! span {
    ($name:literal) => {
        #[cfg(feature = "tracing")]
        let _span = $crate::tracing::debug_span!($name).entered();
    };
}
