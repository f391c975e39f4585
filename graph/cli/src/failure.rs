//! Why a command fails, and with which exit status.

use std::path::Path;
use std::process::ExitCode;

use afterimage_gpu::{GpuError, PostError};
use afterimage_graph::diagnostic::{Diagnostic, Diagnostics, Style};
use afterimage_lab::LabError;
use afterimage_media::{FileError, address_space_limit};
use afterimage_plan::PlanError;

use crate::terminal::{note, note_styled};

/// The reason of a failed command.
#[derive(Debug)]
pub(crate) enum Failure {
    /// An error that is not in a pipeline file.
    Error {
        /// The stable name of the error in JSON.
        code: &'static str,
        /// What is wrong: lower case, no full stop.
        message: String,
        /// What the user can do, if that is known.
        hint: Option<String>,
        /// 1 for an error of the input, 2 for an error of the machine.
        status: u8,
    },
    /// Errors in pipeline files.
    Pipeline(Diagnostics),
    /// The results are printed already; only the status is left.
    Printed {
        /// See [`status`](Failure::status).
        status: u8,
    },
}

impl Failure {
    /// An error of the input: arguments, images.
    pub(crate) fn user(message: impl std::fmt::Display) -> Self {
        Self::error("arguments", message, 1)
    }

    /// A file that cannot be read.
    pub(crate) fn unreadable(message: impl std::fmt::Display) -> Self {
        Self::error("unreadable-file", message, 1)
    }

    /// An error of the machine.
    pub(crate) fn machine(message: impl std::fmt::Display) -> Self {
        Self::error("machine", message, 2)
    }

    fn error(code: &'static str, message: impl std::fmt::Display, status: u8) -> Self {
        Self::Error { code, message: message.to_string(), hint: None, status }
    }

    /// Adds what the user can do.
    pub(crate) fn hint(mut self, text: impl std::fmt::Display) -> Self {
        if let Self::Error { hint, .. } = &mut self {
            *hint = Some(text.to_string());
        }
        self
    }

    /// Names the file in which the error is.
    pub(crate) fn at(mut self, file: &Path) -> Self {
        if let Self::Error { message, .. } = &mut self {
            *message = format!("{}: {message}", file.display());
        }
        self
    }

    /// The exit status: 1 for an error of the input, 2 for an error of the machine.
    pub(crate) fn status(&self) -> u8 {
        match self {
            Self::Error { status, .. } | Self::Printed { status } => *status,
            Self::Pipeline(_) => 1,
        }
    }

    /// The failure as diagnostics, for JSON.
    pub(crate) fn into_diagnostics(self) -> Diagnostics {
        let mut diagnostics = Diagnostics::default();
        match self {
            Self::Error { code, message, hint, .. } => {
                diagnostics.push(Diagnostic::error(code, message).maybe_help(hint));
            }
            Self::Pipeline(errors) => diagnostics.absorb(errors),
            Self::Printed { .. } => {}
        }
        diagnostics
    }

    /// What is wrong, without a hint.
    pub(crate) fn message(&self) -> String {
        match self {
            Self::Error { message, .. } => message.clone(),
            Self::Pipeline(diagnostics) => diagnostics.render(Style::Plain),
            Self::Printed { .. } => String::new(),
        }
    }

    pub(crate) fn print(&self) {
        match self {
            Self::Error { message, hint: Some(hint), .. } => note(&format!("error: {message}\n  hint: {hint}")),
            Self::Error { message, hint: None, .. } => note(&format!("error: {message}")),
            Self::Pipeline(diagnostics) => note_styled(&diagnostics.render(Style::Colored)),
            Self::Printed { .. } => {}
        }
    }

    /// Prints it and returns the exit status.
    pub(crate) fn report(&self) -> ExitCode {
        self.print();
        ExitCode::from(self.status())
    }
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        let message = format!("{}: {}", error.path.display(), error.message);
        let status = error.exit();
        Self::Error { code: "file", message, hint: error.hint, status }
    }
}

impl From<Diagnostics> for Failure {
    fn from(diagnostics: Diagnostics) -> Self {
        Self::Pipeline(diagnostics)
    }
}

impl From<PlanError> for Failure {
    fn from(error: PlanError) -> Self {
        let hint = match error {
            PlanError::TooMuchMemory { .. } => Some("`--gpu-memory SIZE` allows more"),
            PlanError::TooMuchHostMemory { .. } => Some("`--memory SIZE` allows more"),
            _ => None,
        };
        let failure = Self::error("plan", error, 1);
        match hint {
            Some(hint) => failure.hint(hint),
            None => failure,
        }
    }
}

impl From<GpuError> for Failure {
    fn from(error: GpuError) -> Self {
        match error {
            GpuError::TooLarge { .. } => {
                Self::user(error).hint("scale it down, or choose another device with `--adapter`")
            }
            // Without memory, the loader of drivers finds none.
            GpuError::NoAdapter { wanted: None, .. } => match address_space_limit() {
                None => Self::machine(error),
                Some(limit) => {
                    let mebibytes = limit >> 20;
                    Self::machine(format!("no graphics adapter: its driver may need more memory than {mebibytes} MiB"))
                        .hint("this process may use no more (`ulimit -v`)")
                }
            },
            GpuError::NoAdapter { wanted: Some(_), .. } | GpuError::Shader(_) => Self::user(error),
            GpuError::NoThreads { .. } if address_space_limit().is_some() => {
                Self::machine(error).hint("this process may use no more memory (`ulimit -v`)")
            }
            _ => Self::machine(error),
        }
    }
}

impl From<PostError> for Failure {
    fn from(error: PostError) -> Self {
        match error {
            PostError::Plan(error) => error.into(),
            PostError::Gpu(error) => error.into(),
            error => Self::user(error),
        }
    }
}

impl From<LabError> for Failure {
    fn from(error: LabError) -> Self {
        match error {
            LabError::Request { message, hint } => Self::Error { code: "arguments", message, hint, status: 1 },
            LabError::Machine(message) => Self::machine(message),
            LabError::File(error) => error.into(),
            LabError::Pipeline(diagnostics) => diagnostics.into(),
            LabError::Session(error) => error.into(),
        }
    }
}
