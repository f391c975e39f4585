//! The address bar: reads it, follows the model with it, and notices when it changes.

use std::cell::Cell;
use std::rc::Rc;

use afterimage_graph::value::Value;
use wasm_bindgen::JsCast as _;
use wasm_bindgen::closure::Closure;

use crate::address::Address;
use crate::model::{Model, Target};

/// The address as the browser has it.
pub(super) fn read() -> Address {
    let hash = web_sys::window().and_then(|window| window.location().hash().ok()).unwrap_or_default();
    Address::parse(&hash)
}

/// Calls `wake` when the user changes the address, and notes it in the cell that is returned.
pub(super) fn watch(wake: impl Fn() + 'static) -> Rc<Cell<bool>> {
    let has_changed = Rc::new(Cell::new(false));
    let noted = has_changed.clone();
    let changed = Closure::<dyn Fn()>::new(move || {
        noted.set(true);
        wake();
    });
    if let Some(window) = web_sys::window() {
        window.set_onhashchange(Some(changed.as_ref().unchecked_ref()));
    }
    // The page has one, and for good.
    changed.forget();
    has_changed
}

/// The state of the model that the address holds.
#[derive(PartialEq)]
pub(super) struct Stated {
    name: String,
    text: String,
    values: Vec<(Target, Value)>,
    tier: Option<String>,
}

impl Stated {
    pub(super) fn of(model: &Model) -> Self {
        Self {
            name: model.editor().project().name(),
            text: model.editor().text().to_owned(),
            values: model.editor().changes().iter().map(|(target, value)| (target.clone(), value.clone())).collect(),
            tier: model.editor().tier().map(str::to_owned),
        }
    }
}

/// Writes the pipeline with its changed values, and the tier, into an address and the address bar.
pub(super) fn write(address: &mut Address, model: &Model) {
    let text = model.editor().text_with_changes();
    let built_in = afterimage_pipelines::PIPELINES.iter().find(|(_, known)| *known == text);
    address.show(built_in.map(|(name, _)| *name), &text);
    address.set("tier", model.editor().tier());
    if let Some(history) = web_sys::window().and_then(|window| window.history().ok()) {
        // An address that is too long for the browser stays as it was.
        let _ = history.replace_state_with_url(&wasm_bindgen::JsValue::NULL, "", Some(&address.to_string()));
    }
}

/// Sets the title of the page.
pub(super) fn set_title(title: &str) {
    if let Some(document) = web_sys::window().and_then(|window| window.document()) {
        document.set_title(title);
    }
}
