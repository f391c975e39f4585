//! Afterimage for Bevy.
