//! The config of this process.

use std::sync::OnceLock;

use ocio::Config;

use crate::failure::Failure;

/// What the built-in configs call the light that pipelines work in.
pub(super) const LIGHT: &str = "Linear Rec.709 (sRGB)";

/// The name of the config on the command line.
static NAME: OnceLock<String> = OnceLock::new();
static CONFIG: OnceLock<Result<Config, String>> = OnceLock::new();

/// Chooses the config of this process: a `.ocio` or `.ocioz` file, or a built-in one such as `ocio://default`.
///
/// # Errors
/// It cannot be read.
pub(crate) fn choose(name: &str) -> Result<(), Failure> {
    let _ = NAME.set(name.to_owned());
    config().map(|_| ()).map_err(|error| {
        Failure::user(error).hint("name a `.ocio` or `.ocioz` file, or a built-in config: `ocio://default`")
    })
}

/// The config of this process: that of `--ocio`, or of the variable `OCIO`.
pub(super) fn config() -> Result<&'static Config, String> {
    let read = || {
        let name = NAME.get().cloned().or_else(|| std::env::var("OCIO").ok().filter(|name| !name.is_empty()));
        let name = name.ok_or("no config is chosen: name it with `--ocio FILE`, or in the variable `OCIO`")?;
        Config::create_from_file(&name).map_err(|error| format!("`{name}`: {}", sentence(&error)))
    };
    CONFIG.get_or_init(read).as_ref().map_err(String::clone)
}

/// What OpenColorIO says, in a line.
pub(super) fn sentence(error: &ocio::Error) -> String {
    let lines: Vec<&str> = error.message().lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    lines.join(" ").trim_end_matches('.').to_owned()
}
