//! Why the program stops, and with which status.

use std::process::ExitCode;

use afterimage_gpu::GpuError;
use afterimage_graph::diagnostic::{Diagnostics, Style};
use afterimage_plan::PlanError;

use afterimage_media::FileError;

/// What stopped a command.
#[derive(Debug)]
pub(crate) struct Failure {
    /// What to print; may hold several lines and colours.
    pub(crate) text: String,
    /// 1 where the user's input is at fault, 2 where the machine is.
    pub(crate) status: u8,
}

impl Failure {
    /// The user's input is at fault.
    pub(crate) fn user(message: impl std::fmt::Display) -> Self {
        Self { text: format!("error: {message}"), status: 1 }
    }

    /// The machine is at fault.
    pub(crate) fn machine(message: impl std::fmt::Display) -> Self {
        Self { text: format!("error: {message}"), status: 2 }
    }

    /// Adds what the user can do.
    pub(crate) fn hint(mut self, hint: impl std::fmt::Display) -> Self {
        self.text = format!("{}\n  hint: {hint}", self.text);
        self
    }

    /// Prints it and gives the exit status.
    pub(crate) fn report(&self) -> ExitCode {
        if !self.text.is_empty() {
            crate::terminal::note(&self.text);
        }
        ExitCode::from(self.status)
    }
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        Self { text: format!("error: {error}"), status: error.exit() }
    }
}

impl From<Diagnostics> for Failure {
    fn from(diagnostics: Diagnostics) -> Self {
        Self { text: diagnostics.render(Style::Coloured), status: 1 }
    }
}

impl From<PlanError> for Failure {
    fn from(error: PlanError) -> Self {
        Self::user(error)
    }
}

impl From<GpuError> for Failure {
    fn from(error: GpuError) -> Self {
        match error {
            GpuError::NoAdapter { wanted: Some(_), .. } | GpuError::Shader(_) => Self::user(error),
            _ => Self::machine(error),
        }
    }
}
