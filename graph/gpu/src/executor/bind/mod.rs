//! Bind groups for the images that the host gives for a frame.

pub(crate) mod binder;
pub(crate) mod builder;
mod depth_view;
pub(crate) mod formats;
pub(crate) mod host_images;
pub(crate) mod view_levels;
pub(crate) mod views;
