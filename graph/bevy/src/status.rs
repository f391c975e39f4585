//! The state of each camera's pipeline, for the game.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bevy::prelude::*;

/// The state of a camera's pipeline, beside its [`Afterimage`](crate::Afterimage). It changes only when one of its
/// fields does. Errors and warnings are logged, too, once each.
#[derive(Component, Clone, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
#[type_path = "bevy_afterimage"]
pub struct AfterimageStatus {
    /// Errors in the files of the pipeline, with excerpts. The pipeline that was loaded before renders on.
    pub files: Option<String>,
    /// Facts and parameters that are refused, and why. The values before stay.
    pub settings: Vec<String>,
    /// Names that the pipeline does not know, of facts and watched values, and the nearest ones.
    pub unknown: Vec<String>,
    /// The tier that renders, or that a plan is being made for; with a budget, the one that it allows.
    pub tier: Option<String>,
    /// The error of the last frame. Without a plan it is not rendered.
    pub frame: Option<String>,
    /// Effects of Bevy that do the pipeline's work a second time on this camera.
    pub others: Vec<String>,
    /// True if the pipeline was rendered in the last frame that Bevy drew with the camera.
    pub is_running: bool,
    /// True while a plan for changed facts, another tier or another pipeline is being made.
    pub is_changing: bool,
    /// The reason why the last change came in at once although [`fade`](crate::Afterimage::fade) is set.
    pub fade_skip_reason: Option<String>,
    /// The passes of the plan that renders, each by its nodes and its work.
    pub passes: Vec<String>,
}

/// The newest values of [`watched`](crate::Afterimage::watched), by their labels; those of skipped nodes are missing.
/// They are a few frames old, because nothing waits for them.
#[derive(Component, Clone, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
#[type_path = "bevy_afterimage"]
pub struct AfterimageReadings(pub BTreeMap<String, Vec4>);

/// The report of the render world on a camera.
#[derive(Clone, Default)]
pub(crate) struct Rendered {
    pub(crate) settings: Vec<String>,
    pub(crate) unknown: Vec<String>,
    pub(crate) tier: Option<String>,
    pub(crate) frame: Option<String>,
    pub(crate) is_running: bool,
    pub(crate) is_changing: bool,
    pub(crate) fade_skip_reason: Option<String>,
    pub(crate) passes: Vec<String>,
}

/// The way from the render world to the main world.
#[derive(Clone, Default)]
pub(crate) struct Report(Arc<Mutex<Sent>>);

#[derive(Default)]
pub(crate) struct Sent {
    /// The state of the last frame, unless it was taken.
    pub(crate) rendered: Option<Rendered>,
    pub(crate) readings: BTreeMap<String, Vec4>,
}

impl Report {
    pub(crate) fn lock(&self) -> MutexGuard<'_, Sent> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
