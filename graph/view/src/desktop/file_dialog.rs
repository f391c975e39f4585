//! The dialog of the desktop that chooses a file.

use std::io;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender, channel};

use winit::window::Window;

use super::Wake;
use crate::ui::FileRequest;

/// Dialogs that are open, and the files that were chosen in them.
pub(super) struct FileDialogs {
    wake: Wake,
    sender: Sender<Answer>,
    answers: Receiver<Answer>,
}

/// The request and the file; `None` if the user has chosen none, or the desktop has no dialog.
pub(super) type Answer = (FileRequest, Option<PathBuf>);

impl FileDialogs {
    pub(super) fn new(wake: Wake) -> Self {
        let (sender, answers) = channel();
        Self { wake, sender, answers }
    }

    /// Opens a dialog. The window goes on meanwhile.
    ///
    /// # Errors
    /// The system gives no thread.
    pub(super) fn open(&self, window: &Window, request: FileRequest) -> io::Result<()> {
        let dialog = rfd::AsyncFileDialog::new().set_parent(window);
        let dialog = match &request {
            FileRequest::Pipeline => {
                dialog.set_title("Open a pipeline").add_filter("Pipelines", &in_both_cases(&["ron"]))
            }
            FileRequest::Input { name, endings } => dialog
                .set_title(format!("File of the input {name}"))
                .add_filter("Files of this input", &in_both_cases(endings))
                .add_filter("All files", &["*"]),
        };
        let chosen = dialog.pick_file();
        let (sender, wake) = (self.sender.clone(), self.wake.clone());
        let wait = move || {
            let file = pollster::block_on(chosen).map(|file| file.path().to_owned());
            // Nobody listens once the window is closed.
            let _ = sender.send((request, file));
            wake.call();
        };
        std::thread::Builder::new().spawn(wait).map(drop)
    }

    /// A file that was chosen since the last call.
    pub(super) fn take(&self) -> Option<Answer> {
        self.answers.try_recv().ok()
    }
}

/// Endings in lower and in upper case, as cameras write them: dialogs tell them apart.
fn in_both_cases(endings: &[&str]) -> Vec<String> {
    endings.iter().flat_map(|ending| [(*ending).to_owned(), ending.to_uppercase()]).collect()
}
