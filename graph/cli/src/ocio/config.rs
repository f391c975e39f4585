//! The config of this process, and the files that it and its transforms are made from.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use afterimage_graph::diagnostic::{did_you_mean, list};
use afterimage_media::run_files;
use ocio::fileformats::file_transform::clear_file_transform_caches;
use ocio::{Config, Processor};

use crate::failure::Failure;

/// The name of linear Rec.709 in the built-in configs.
pub(super) const REC709: &str = "Linear Rec.709 (sRGB)";

/// The name of the config on the command line.
static NAME: OnceLock<String> = OnceLock::new();
static CONFIG: Mutex<Option<Result<Arc<Config>, String>>> = Mutex::new(None);
/// The config, the files of transforms, and those that transforms lack.
static FILES: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

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
pub(super) fn config() -> Result<Arc<Config>, String> {
    locked(&CONFIG).get_or_insert_with(read).clone()
}

fn read() -> Result<Arc<Config>, String> {
    let name = NAME.get().cloned().or_else(|| std::env::var("OCIO").ok().filter(|name| !name.is_empty()));
    let name = name.ok_or("no config is chosen: name it with `--ocio FILE`, or in the variable `OCIO`")?;
    if !name.starts_with("ocio://") {
        note_files([name.as_str().into()]);
        // OpenColorIO would wait for the writer of a pipe.
        if !Path::new(&name).is_file() {
            return Err(format!("there is no regular file `{name}`"));
        }
    }
    Config::create_from_file(&name).map(Arc::new).map_err(|error| {
        let message = sentence(&error);
        // Its name comes before already.
        let why = message.split_once("' failed. ").map_or(&*message, |(_, why)| why);
        format!("`{name}`: {why}")
    })
}

/// A processor of the config, or what OpenColorIO says. Notes the files that it is made from, or lacks.
pub(super) fn noted(made: ocio::Result<Processor>) -> Result<Processor, String> {
    match made {
        Ok(processor) => {
            note_files(processor.processor_metadata().files().iter().map(PathBuf::from));
            Ok(processor)
        }
        Err(error) => {
            // OpenColorIO quotes the file that is wrong, and all places where it has looked for one.
            note_files(error.message().split('\'').skip(1).step_by(2).map(PathBuf::from));
            Err(sentence(&error))
        }
    }
}

fn note_files(files: impl IntoIterator<Item = PathBuf>) {
    locked(&FILES).extend(files);
    list_files();
}

/// Adds the files to the list of the run: OpenColorIO opens them by itself.
pub(crate) fn list_files() {
    locked(&FILES).iter().for_each(|file| run_files::reads(file, "a file of OpenColorIO"));
}

/// The files whose change makes other transforms, as far as transforms have been made.
pub(crate) fn files() -> BTreeSet<PathBuf> {
    locked(&FILES).clone()
}

/// Forgets the config and all files if these are among them. Returns whether they are.
pub(super) fn forget(changed: &BTreeSet<PathBuf>) -> bool {
    if locked(&FILES).is_disjoint(changed) {
        return false;
    }
    clear_file_transform_caches();
    *locked(&CONFIG) = None;
    true
}

pub(super) fn locked<T>(value: &Mutex<T>) -> MutexGuard<'_, T> {
    value.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The error about a color space that neither the config nor `others` have.
pub(super) fn no_space(config: &Config, name: &str, others: &[&str]) -> String {
    let known: Vec<&str> = (0..config.num_color_spaces()).map(|at| config.color_space_name_by_index(at)).collect();
    let meant = did_you_mean(name, known.iter().chain(others).copied());
    let all = || format!("it has {}", list(known.iter().copied(), 16));
    format!("the config has no color space `{name}`; {}", meant.unwrap_or_else(all))
}

/// A message of OpenColorIO in one line: which file is wrong, why, and how to mend it.
pub(super) fn sentence(error: &ocio::Error) -> String {
    let lines: Vec<&str> = error.message().lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    let text = lines.join(" ");
    let text = text.trim_end_matches('.');
    if let Some((_, places)) = text.split_once("The following attempts were made: ") {
        let places = places.replace('\'', "`").replace(" : ", ", ");
        return format!("there is no file {places}; put it there, or add its folder to `search_path` of the config");
    }
    let absolute = text.strip_prefix("The specified absolute file reference '");
    if let Some(place) = absolute.and_then(|rest| rest.split('\'').next()) {
        return format!("there is no file `{place}`; put it there, or correct the config");
    }
    let unreadable =
        text.strip_prefix("The specified transform file '").and_then(|rest| rest.split_once("' could not be loaded"));
    if let Some((file, reasons)) = unreadable {
        // Each format with the ending of the file has its reason. The first is the usual one.
        return match reasons.split(" failed with: ").nth(1).and_then(|reasons| reasons.split("    '").next()) {
            Some(reason) => {
                let reason = reason.trim_end_matches('.').replace(&format!(" ({file})"), "");
                format!("`{file}` is not read: {reason}; write the file again with the program that made it")
            }
            None => format!("`{file}` has no format of OpenColorIO; convert it to .cube, as `ociobakelut` does"),
        };
    }
    text.to_owned()
}

#[cfg(test)]
mod tests {
    use std::fs;

    use ocio::{FileTransform, TransformDirection};

    use super::*;

    #[test]
    fn a_missing_file_and_one_that_changes_are_read_again() {
        let path = std::env::temp_dir().join(format!("afterimage-ocio-{}.spimtx", std::process::id()));
        let transform = FileTransform::new(path.to_str().expect("it is text")).into();
        let config = Config::create_raw();
        let read = || noted(config.get_processor_for_transform(&transform, TransformDirection::Forward));
        assert!(read().expect_err("it is missing").starts_with("there is no file"));
        for red in [2.0, 3.0] {
            assert!(files().contains(&path), "{:?}", files());
            assert!(forget(&BTreeSet::from([path.clone()])) && !forget(&BTreeSet::new()));
            fs::write(&path, format!("{red} 0 0 0\n0 1 0 0\n0 0 1 0\n")).expect("it can be written");
            let mut color = [1.0; 3];
            config.clear_processor_cache();
            read().expect("it is a matrix").default_cpu_processor().apply_rgb(&mut color);
            assert_eq!(color, [red, 1.0, 1.0]);
        }
        fs::remove_file(path).expect("it is there");
    }

    #[test]
    fn errors_name_the_file_and_how_to_mend_it() {
        let message = |text: &str| sentence(&ocio::Error::msg(text));
        let missing = "The specified file reference 'a.csp' could not be located. The following attempts were made: \
                       '/luts/a.csp' : '/more/a.csp'.";
        let mended = "there is no file `/luts/a.csp`, `/more/a.csp`; put it there, or add its folder to \
                      `search_path` of the config";
        assert_eq!(message(missing), mended);
        let tried = "The specified transform file '/luts/a.cube' could not be loaded.\nAll formats have been tried. \
                     (Enable debug log for errors from all formats.) ";
        let none = "`/luts/a.cube` has no format of OpenColorIO; convert it to .cube, as `ociobakelut` does";
        assert_eq!(message(tried), none);
        let two = "The formats for the file's extension gave the errors:\n\n    'iridas_cube' failed with: Error \
                   parsing Iridas .cube file (/luts/a.cube).  At line (9): '0.5'.  Malformed color triples \
                   specified.    'resolve_cube' failed with: Error";
        let one = "`/luts/a.cube` is not read: Error parsing Iridas .cube file.  At line (9): '0.5'.  Malformed color \
                   triples specified; write the file again with the program that made it";
        assert_eq!(message(&format!("{tried}{two}")), one);
    }
}
