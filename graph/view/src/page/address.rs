//! The address of the page, which carries what is shown.

use crate::model::Model;

/// What the part of the address after `#` states.
#[derive(Default)]
pub(super) struct Address {
    pub(super) pipeline: Option<String>,
    /// The text of a pipeline.
    pub(super) text: Option<String>,
    /// The size of the scene.
    pub(super) size: Option<(u32, u32)>,
    /// Where an image lies that is shown in the place of the scene.
    pub(super) image: Option<String>,
    /// Whether time stands, and nothing differs from frame to frame.
    pub(super) is_still: bool,
    /// Whether the picture is shown alone, each of its pixels on one of the screen.
    pub(super) is_bare: bool,
    /// The text that the address has.
    known: Option<String>,
}

impl Address {
    pub(super) fn read() -> Self {
        let hash = web_sys::window().and_then(|window| window.location().hash().ok()).unwrap_or_default();
        let mut address = Self::default();
        for part in hash.trim_start_matches('#').split('&') {
            match part.split_once('=') {
                Some(("pipeline", name)) => address.pipeline = Some(name.to_owned()),
                Some(("text", text)) => address.text = decoded(text),
                Some(("size", size)) => address.size = sides(size),
                Some(("image", image)) => address.image = decoded(image),
                _ => {
                    address.is_still |= part == "still";
                    address.is_bare |= part == "bare";
                }
            }
        }
        address
    }

    /// Writes the text into the address once it is another one than at first, so that the address can be passed on.
    pub(super) fn follow(&mut self, model: &Model) {
        let text = model.text().to_owned();
        let Some(known) = &self.known else {
            self.known = Some(text);
            return;
        };
        if *known == text {
            return;
        }
        let encoded = String::from(js_sys::encode_uri_component(&text));
        let history = web_sys::window().and_then(|window| window.history().ok());
        if let Some(history) = history {
            // An address that is too long for the browser stays as it was.
            let _ = history.replace_state_with_url(&wasm_bindgen::JsValue::NULL, "", Some(&format!("#text={encoded}")));
        }
        self.known = Some(text);
    }
}

fn decoded(text: &str) -> Option<String> {
    js_sys::decode_uri_component(text).ok().map(String::from)
}

/// `WIDTHxHEIGHT`.
fn sides(text: &str) -> Option<(u32, u32)> {
    let (width, height) = text.split_once('x')?;
    Some((width.parse().ok()?, height.parse().ok()?))
}
