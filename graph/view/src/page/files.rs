//! Files that come from the web, and files that go to the user.

use wasm_bindgen::{JsCast as _, JsValue};
use wasm_bindgen_futures::JsFuture;

use crate::Exported;

/// The bytes at an address.
///
/// # Errors
/// The reason, as a sentence without a full stop.
pub(super) async fn fetched(address: &str) -> Result<Vec<u8>, String> {
    let response = response(address).await.map_err(|_| unreachable(address))?;
    match response.status() {
        200..=299 => {}
        404 => return Err(format!("there is no file `{address}` on the server")),
        status => return Err(format!("the server does not give `{address}`: status {status}")),
    }
    let bytes = bytes(&response).await.map_err(|_| unreachable(address))?;
    Ok(js_sys::Uint8Array::new(&bytes).to_vec())
}

/// Browsers do not tell a page why a request failed.
fn unreachable(address: &str) -> String {
    format!(
        "`{address}` cannot be fetched: its server does not answer, or does not allow other sites to read it (CORS)"
    )
}

async fn response(address: &str) -> Result<web_sys::Response, JsValue> {
    let window = web_sys::window().expect("a page has a window");
    JsFuture::from(window.fetch_with_str(address)).await?.dyn_into()
}

async fn bytes(response: &web_sys::Response) -> Result<JsValue, JsValue> {
    JsFuture::from(response.array_buffer()?).await
}

/// Hands a file to the browser, which stores it as it stores downloads.
pub(super) fn download(exported: &Exported) -> Result<(), JsValue> {
    let document = web_sys::window().and_then(|window| window.document()).expect("a page has a document");
    let parts = js_sys::Array::of1(&js_sys::Uint8Array::from(&exported.bytes[..]));
    let blob = web_sys::Blob::new_with_u8_array_sequence(&parts)?;
    let url = web_sys::Url::create_object_url_with_blob(&blob)?;
    let link: web_sys::HtmlAnchorElement = document.create_element("a")?.dyn_into()?;
    link.set_href(&url);
    link.set_download(&exported.name);
    link.click();
    web_sys::Url::revoke_object_url(&url)
}

/// An error of the browser as a text.
pub(super) fn text_of(error: &JsValue) -> String {
    let message = error.dyn_ref::<js_sys::Error>().map(|error| String::from(error.message()));
    message.or(error.as_string()).unwrap_or_else(|| "the browser does not state why".to_owned())
}
