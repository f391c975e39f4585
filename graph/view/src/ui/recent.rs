//! The pipelines that were opened last.

use std::path::{Path, PathBuf};

use egui::{RichText, Ui};

use super::theme::DIM;
use crate::model::Model;

/// Lists a pipeline that was opened, if one is given, and returns those that were opened last, the newest first.
pub type RecentFiles = Box<dyn FnMut(Option<&Path>) -> Vec<PathBuf>>;

/// The pipelines that were opened last, as far as the shell lists them.
#[derive(Default)]
pub(super) struct RecentMenu {
    pub(super) files: Option<RecentFiles>,
    /// The pipeline that is open.
    present: Option<PathBuf>,
    /// The list is that of the open pipeline.
    is_listed: bool,
    listed: Vec<PathBuf>,
    /// The pipeline that the user wants to open, for the shell.
    pub(super) chosen: Option<PathBuf>,
}

impl RecentMenu {
    /// Lists the pipeline that is open, once.
    pub(super) fn follow(&mut self, model: &Model) {
        let path = model.editor().project().path();
        self.is_listed &= path == self.present.as_deref();
        if let Some(files) = self.files.as_mut().filter(|_| !self.is_listed) {
            (self.present, self.is_listed) = (path.map(Path::to_owned), true);
            self.listed = files(path);
        }
    }

    /// Shows the pipelines other than the open one.
    pub(super) fn show(&mut self, ui: &mut Ui) {
        let is_present = |path: &PathBuf| {
            let present = self.present.as_ref().and_then(|present| std::path::absolute(present).ok());
            present.as_ref() == Some(path)
        };
        let others: Vec<&PathBuf> = self.listed.iter().filter(|path| !is_present(path)).collect();
        if others.is_empty() {
            return;
        }
        ui.label(RichText::new("Opened before").color(DIM).small());
        for path in others {
            let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
            if ui.button(&*name).on_hover_text(path.display().to_string()).clicked() {
                self.chosen = Some(path.clone());
                ui.close();
            }
        }
        ui.separator();
    }
}
