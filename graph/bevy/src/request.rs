//! What the main world requests from the render world for a camera.

use std::collections::BTreeMap;
use std::sync::Arc;

use afterimage_graph::check::{Facts, Graph};
use bevy::prelude::*;
use bevy::render::RenderApp;
use bevy::render::extract_component::ExtractComponent;

use crate::setting::{Setting, Target};
use crate::status::Report;

/// The request of a camera. A new `Arc` of settings means that something has changed.
#[derive(Component, Clone, Default, ExtractComponent)]
#[extract_app(RenderApp)]
pub(crate) struct CameraRequest {
    pub(crate) settings: Option<Arc<Settings>>,
    pub(crate) report: Report,
}

/// The pipeline of a camera and everything that is set for it.
#[derive(Clone)]
pub(crate) struct Settings {
    pub(crate) graph: Arc<Graph>,
    pub(crate) facts: Facts,
    /// Why settings that are neither flags nor numbers are refused as facts.
    pub(crate) refused: Vec<String>,
    pub(crate) parameters: BTreeMap<String, Setting>,
    pub(crate) target: Target,
    pub(crate) cuts: u32,
    pub(crate) fade: u16,
}
