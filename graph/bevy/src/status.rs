//! The state of each camera's pipeline, for the game.

use std::sync::{Arc, Mutex, PoisonError};

use afterimage_gpu::FadeSkipReason;
use bevy::prelude::*;

/// The state of a camera's pipeline, beside its [`Afterimage`](crate::Afterimage). It changes only when one of its
/// fields does. Errors and warnings are logged, too, once each.
#[derive(Component, Clone, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
#[type_path = "bevy_afterimage"]
pub struct AfterimageStatus {
    /// What is wrong with the files of the pipeline, with excerpts. What was loaded before renders on.
    pub files: Option<String>,
    /// Facts and parameters that are refused, and why. The values before stay.
    pub settings: Vec<String>,
    /// What is wrong with the last frame. Without a plan it is not rendered.
    pub frame: Option<String>,
    /// Effects of Bevy that do the pipeline's work a second time on this camera.
    pub others: Vec<String>,
    /// Whether the pipeline was rendered in the last frame that Bevy drew with the camera.
    pub is_running: bool,
    /// Whether a plan for changed facts, another tier or another pipeline is being made.
    pub is_changing: bool,
    /// Why the last change came in at once although [`fade`](crate::Afterimage::fade) is set.
    pub fade_skip_reason: Option<String>,
    /// The passes of the plan that renders, each by its nodes and its work.
    pub passes: Vec<String>,
}

/// What the render world says of a camera.
#[derive(Clone, Default)]
pub(crate) struct Rendered {
    pub(crate) settings: Vec<String>,
    pub(crate) frame: Option<String>,
    pub(crate) is_running: bool,
    pub(crate) is_changing: bool,
    pub(crate) fade_skip_reason: Option<FadeSkipReason>,
    pub(crate) passes: Vec<String>,
}

/// The way from the render world to the main world: what is new.
#[derive(Clone, Default)]
pub(crate) struct Report(Arc<Mutex<Option<Rendered>>>);

impl Report {
    pub(crate) fn send(&self, rendered: Rendered) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(rendered);
    }

    pub(crate) fn take(&self) -> Option<Rendered> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}
