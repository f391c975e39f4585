//! The plug-in in apps without a window.

mod facade;
mod fades;
mod inputs;
mod live;
mod lost;
mod pixels;
mod program;
mod said;
mod shown;
mod views;
