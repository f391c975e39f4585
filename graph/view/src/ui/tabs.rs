//! The tabs below the picture.

use egui::{RichText, Ui};

use super::theme;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tab {
    Graph,
    /// The text of the pipeline.
    Text,
    Cost,
    Messages,
    /// The parameters, in a window that is too narrow to show them next to the picture.
    Parameters,
    /// The scopes and the pixel inspector, likewise.
    Scopes,
}

/// The open tab, and the one to go back to.
pub struct Tabs {
    /// `None` while the panel is closed.
    pub open: Option<Tab>,
    had_problem: bool,
    /// The value of `open` before a problem opened the messages.
    before_problem: Option<Option<Tab>>,
    /// All panels are tabs, because the window is narrow.
    is_narrow: bool,
    /// The value of `open` in the wide window.
    of_wide: Option<Tab>,
}

impl Default for Tabs {
    fn default() -> Self {
        let open = Some(Tab::Graph);
        Self { open, had_problem: false, before_problem: None, is_narrow: false, of_wide: None }
    }
}

impl Tabs {
    /// Opens a tab, or closes it if it is open.
    pub(super) fn toggle(&mut self, tab: Tab) {
        self.open = if self.open == Some(tab) { None } else { Some(tab) };
    }

    /// Opens the messages while there is a problem, unless the text is open, which shows its errors itself.
    pub(super) fn follow_problem(&mut self, has_problem: bool) {
        let had_problem = std::mem::replace(&mut self.had_problem, has_problem);
        if has_problem && !had_problem && self.open != Some(Tab::Text) {
            self.before_problem = Some(self.open.replace(Tab::Messages));
        }
        if let Some(before) = self.before_problem.take_if(|_| !has_problem)
            && self.open == Some(Tab::Messages)
        {
            self.open = before;
        }
    }

    pub(super) fn is_narrow(&self) -> bool {
        self.is_narrow
    }

    /// Adds the tabs of a narrow window, or removes them.
    pub(super) fn set_narrow(&mut self, is_narrow: bool) {
        let was_narrow = std::mem::replace(&mut self.is_narrow, is_narrow);
        if is_narrow && !was_narrow {
            self.of_wide = self.open.replace(Tab::Parameters);
        } else if was_narrow && !is_narrow && matches!(self.open, Some(Tab::Parameters | Tab::Scopes)) {
            self.open = self.of_wide;
        }
    }

    /// Shows the names of the tabs; that of the messages is red if `is_wrong`.
    pub(super) fn show(&mut self, ui: &mut Ui, is_wrong: bool) {
        let tabs = [("Graph", Tab::Graph), ("Text", Tab::Text), ("Cost", Tab::Cost), ("Messages", Tab::Messages)];
        let narrow = [("Parameters", Tab::Parameters), ("Scopes", Tab::Scopes)];
        let narrow = if self.is_narrow { &narrow[..] } else { &[] };
        for (name, tab) in narrow.iter().copied().chain(tabs) {
            let text = RichText::new(name);
            let text = if is_wrong && tab == Tab::Messages { text.color(theme::ERROR) } else { text };
            if ui.selectable_label(self.open == Some(tab), text).clicked() {
                self.toggle(tab);
            }
        }
    }
}
