//! An entry of a list of what can be added.

use egui::text::{LayoutJob, TextFormat};
use egui::{Color32, FontId};

use super::theme::DIM;

/// A name with a detail, and one sentence about it.
pub(super) fn entry(name: &str, detail: &str, doc: &str) -> LayoutJob {
    let format = |size, color| TextFormat { font_id: FontId::proportional(size), color, ..TextFormat::default() };
    let mut job = LayoutJob::default();
    job.append(name, 0.0, format(12.5, Color32::from_gray(0xe4)));
    job.append(detail, 8.0, format(10.5, DIM));
    if !doc.is_empty() {
        job.append(&format!("\n{}", first_sentence(doc)), 0.0, format(10.5, Color32::from_gray(0xb4)));
    }
    job
}

fn first_sentence(doc: &str) -> &str {
    let paragraph = doc.trim_start().split("\n\n").next().unwrap_or(doc);
    paragraph.find(". ").map_or(paragraph, |end| &paragraph[..=end])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sentence_ends_at_its_full_stop() {
        assert_eq!(first_sentence(" One. Two."), "One.");
        assert_eq!(first_sentence("One of 1.5\n\nTwo."), "One of 1.5");
    }
}
