//! Afterimage.
