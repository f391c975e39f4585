//! The order of the plugin's systems.

use bevy::prelude::*;

/// Sets of systems of a frame, for systems that must run before or after them.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AfterimageSystems {
    /// In `PostUpdate`: settings and assets of the cameras are looked at, and changes begin.
    Follow,
    /// In `Core3d` and `Core2d` of the render world: the pipeline of a camera is recorded. The camera's main texture has
    /// the scene before, and after it the result, unless that goes to the output.
    Record,
}
