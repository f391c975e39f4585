//! Colors of the text of a pipeline.

use afterimage_graph::document::{TextToken, TokenKind, tokens};
use egui::text::{LayoutJob, LayoutSection, TextFormat};
use egui::{Color32, FontId, TextStyle, Ui};

use super::theme::{DIM, ERROR};

const PLAIN: Color32 = Color32::from_gray(0xd4);
const KIND: Color32 = Color32::from_rgb(0x6c, 0xa8, 0xe0);
const KEY: Color32 = Color32::from_gray(0xd4);
const TEXT: Color32 = Color32::from_rgb(0x9c, 0xc4, 0x84);
const NUMBER: Color32 = Color32::from_rgb(0xe0, 0xb0, 0x78);

/// The tokens of a text and the layout that colors them, until the text is another one.
#[derive(Default)]
pub(super) struct Colors {
    text: String,
    pub(super) tokens: Vec<TextToken>,
    job: LayoutJob,
}

impl Colors {
    /// The layout of a text.
    pub(super) fn job(&mut self, ui: &Ui, text: &str) -> &LayoutJob {
        if self.text != text || self.job.sections.is_empty() {
            self.text = text.to_owned();
            self.tokens = tokens(text);
            self.job = job(text, &self.tokens, &TextStyle::Monospace.resolve(ui.style()));
        }
        &self.job
    }
}

fn job(text: &str, tokens: &[TextToken], font: &FontId) -> LayoutJob {
    let mut job = LayoutJob { text: text.to_owned(), ..LayoutJob::default() };
    let mut end = 0;
    let mut color = |from: usize, to: usize, color: Color32| {
        // A text without letters has a height, too.
        if from < to || text.is_empty() {
            let format = TextFormat { font_id: font.clone(), color, ..TextFormat::default() };
            let byte_range = from.into()..to.into();
            job.sections.push(LayoutSection { leading_space: 0.0, byte_range, format });
        }
    };
    for (index, token) in tokens.iter().enumerate() {
        let next = tokens.get(index + 1).map(|token| token.kind);
        // Comments are between tokens.
        color(end, token.span.start, DIM);
        let of_token = match (token.kind, next) {
            (TokenKind::Name | TokenKind::Text, Some(TokenKind::Colon)) => KEY,
            (TokenKind::Name, Some(TokenKind::Open)) => KIND,
            (TokenKind::Name | TokenKind::Number, _) => NUMBER,
            (TokenKind::Text, _) => TEXT,
            (TokenKind::OpenText | TokenKind::Other, _) => ERROR,
            _ => PLAIN,
        };
        color(token.span.start, token.span.end, of_token);
        end = token.span.end;
    }
    color(end, text.len(), DIM);
    job
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_has_one_color() {
        for (name, text) in
            afterimage_pipelines::PIPELINES.iter().copied().chain([("broken", "P(a: \"\u{e4}\r\n // b")])
        {
            let job = job(text, &tokens(text), &FontId::monospace(11.5));
            let mut end = 0;
            for section in &job.sections {
                assert_eq!(section.byte_range.start.0, end, "{name}");
                end = section.byte_range.end.0;
            }
            assert_eq!(end, text.len(), "{name}");
        }
    }
}
