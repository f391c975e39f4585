//! Advice about words that the command line does not have.

use std::path::Path;

use clap::Error;
use clap::builder::StyledStr;
use clap::error::{ContextKind, ContextValue, ErrorKind};

use crate::built_in::is_pipeline;
use crate::files::is_image_name;

/// The error with a tip where the parser has none of use.
pub(crate) fn advised(mut error: Error) -> Error {
    let tip = match error.kind() {
        ErrorKind::UnknownArgument if error.get(ContextKind::SuggestedArg).is_none() => {
            about_argument(word(&error, ContextKind::InvalidArg))
        }
        ErrorKind::InvalidSubcommand if word(&error, ContextKind::InvalidSubcommand) == "view" => {
            error.remove(ContextKind::SuggestedSubcommand);
            "this program has no viewer: build it without `--no-default-features`"
        }
        ErrorKind::InvalidSubcommand if error.get(ContextKind::SuggestedSubcommand).is_none() => {
            about_command(word(&error, ContextKind::InvalidSubcommand))
        }
        _ => return error,
    };
    error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![StyledStr::from(tip)]));
    error
}

fn word(error: &Error, kind: ContextKind) -> &str {
    match error.get(kind) {
        Some(ContextValue::String(word)) => word,
        _ => "",
    }
}

fn about_argument(word: &str) -> &'static str {
    match word {
        "--ocio" => "this program has no OpenColorIO: build it with `--features ocio`",
        word if word.starts_with('-') => {
            "`--help` lists the options; a parameter of the pipeline is set by `--set NODE.PARAMETER=VALUE`"
        }
        word if is_image_name(Path::new(word)) => {
            "`-o FILE` names the file to write, `--input NAME=FILE` a further image"
        }
        word if is_pipeline(Path::new(word)) => "a run has one pipeline",
        _ => "a value is joined to its name, as in `--set NODE.PARAMETER=VALUE`",
    }
}

fn about_command(word: &str) -> &'static str {
    match is_image_name(Path::new(word)) || is_pipeline(Path::new(word)) {
        true => "a command comes first: `afterimage render PIPELINE IMAGE -o out.png`",
        false => "`afterimage --help` lists the commands; `afterimage render PIPELINE IMAGE -o out.png` renders",
    }
}
