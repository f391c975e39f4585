//! Errors of commands, with their exit status.

use std::path::Path;
use std::process::ExitCode;

use afterimage::host::PostError;
use afterimage_gpu::GpuError;
use afterimage_graph::diagnostic::{Diagnostic, Diagnostics, Style, shown, shown_path};
use afterimage_lab::LabError;
use afterimage_media::{FileError, memory_limit};
use afterimage_plan::PlanError;

use crate::terminal::{note, note_styled};

/// The reason of a failed command.
#[derive(Debug)]
pub(crate) enum Failure {
    /// An error that is not in a pipeline file.
    Error {
        /// The stable name of the error in JSON.
        code: &'static str,
        /// The error: lower case, no full stop, and [`shown`].
        message: String,
        /// A hint for the user.
        hint: Option<String>,
        /// 1 for an error of the input, 2 for an error of the machine.
        status: u8,
    },
    Pipeline(Diagnostics),
    /// The results are printed already; only the status is left.
    Printed {
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
        Self::Error { code, message: one_line(message), hint: None, status }
    }

    /// An error that this program has made of lines: of shaders, or of the device.
    fn of_lines(code: &'static str, error: impl std::fmt::Display, status: u8) -> Self {
        Self::Error { code, message: error.to_string(), hint: None, status }
    }

    /// Adds what the user can do.
    pub(crate) fn hint(mut self, text: impl std::fmt::Display) -> Self {
        if let Self::Error { hint, .. } = &mut self {
            *hint = Some(one_line(text));
        }
        self
    }

    /// Adds the limit of this process's memory, if it has one. Drivers name many causes where they get too little.
    fn or_limited_memory(self) -> Self {
        match memory_limit() {
            None => self,
            Some(limit) => {
                self.hint(format!("this process may use no more than {} MiB of memory (`ulimit -v`)", limit >> 20))
            }
        }
    }

    /// Names the file in which the error is.
    pub(crate) fn at(mut self, file: &Path) -> Self {
        if let Self::Error { message, .. } = &mut self {
            *message = format!("{}: {message}", shown_path(file));
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

    /// The error without its hint.
    pub(crate) fn message(&self) -> String {
        match self {
            Self::Error { message, .. } => message.clone(),
            Self::Pipeline(diagnostics) => diagnostics.render(Style::Plain),
            Self::Printed { .. } => String::new(),
        }
    }

    pub(crate) fn print(&self) {
        match self {
            Self::Error { message, hint, .. } => {
                format!("error: {message}").lines().for_each(note);
                hint.iter().for_each(|hint| note(&format!("  hint: {hint}")));
            }
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

fn one_line(text: impl std::fmt::Display) -> String {
    shown(&text.to_string()).into_owned()
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        let message = format!("{}: {}", shown_path(&error.path), error.message);
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
        let is_of_system = error.is_of_system();
        let failure = Self::of_lines("plan", error, if is_of_system { 2 } else { 1 });
        match hint {
            Some(hint) => failure.hint(hint),
            None if is_of_system => failure.or_limited_memory(),
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
            GpuError::NoAdapter { wanted: None, .. } if memory_limit().is_some() => {
                Self::machine("no graphics adapter: its driver may need more memory").or_limited_memory()
            }
            GpuError::NoAdapter { wanted: None, .. } => Self::machine(error),
            GpuError::NoAdapter { wanted: Some(_), .. } => Self::user(error),
            GpuError::Shader(_) => Self::of_lines("arguments", error, 1),
            GpuError::NoThreads { .. } => Self::machine(error)
                .hint("its user or this process may have no more (`ulimit -u`), or no memory for them (`ulimit -v`)"),
            _ => Self::of_lines("machine", error, 2).or_limited_memory(),
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
            LabError::Request { message, hint: None } => Self::user(message),
            LabError::Request { message, hint: Some(hint) } => Self::user(message).hint(hint),
            LabError::Machine(message) => Self::machine(message),
            LabError::File(error) => error.into(),
            LabError::Pipeline(diagnostics) => diagnostics.into(),
            LabError::Post(error) => error.into(),
        }
    }
}
