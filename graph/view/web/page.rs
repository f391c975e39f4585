//! The page in the browser: see `build.sh`.

fn main() {
    #[cfg(target_family = "wasm")]
    afterimage_view::page::start();
}
