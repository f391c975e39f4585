//! The page beside the images of `demo`: each with its name, what it is and the command that renders it.

use std::fmt::Write;
use std::path::Path;

use afterimage_lab::shell_word;
use afterimage_pipelines::PIPELINES;

use crate::pipelines::caption;

pub(super) const FILE: &str = "index.html";

const HEAD: &str = r#"<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<title>Afterimage: one scene, all pipelines</title>
<style>
  body { margin: 0 auto; max-width: 110rem; padding: 2rem; background: #1c1c1e; color: #ddd; font: 1rem/1.5 sans-serif }
  main { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(26rem, 100%), 1fr)); gap: 2rem }
  figure { margin: 0 }
  img { width: 100%; height: auto; display: block }
  h1, h2 { font-weight: 600; margin: .75rem 0 .25rem }
  h2 { font-size: 1.1rem }
  p { margin: 0 0 .5rem }
  code { font-size: .85rem; color: #9cd; overflow-wrap: anywhere }
</style>
<h1>One scene, all pipelines</h1>
<p>The scene is <a href="scene.exr" style="color: #9cd">scene.exr</a>: linear light, rendered by the program itself.</p>
<main>
"#;

/// The page as HTML, for images in this folder.
pub(super) fn page(folder: &Path) -> String {
    let mut page = HEAD.to_owned();
    for (name, text) in PIPELINES {
        let (about, command) = (escaped(&caption(text)), escaped(&command(folder, name)));
        let image = format!("<img src=\"{name}.png\" alt=\"The scene through {name}\" loading=\"lazy\">");
        let figure = format!(
            "<figure><a href=\"{name}.png\">{image}</a>\n<h2>{name}</h2>\n<p>{about}</p>\n\
             <code>{command}</code></figure>\n"
        );
        page.push_str(&figure);
    }
    page.push_str("</main>\n</html>\n");
    page
}

/// Lines with commands to go on with.
pub(super) fn commands(folder: &Path) -> Vec<String> {
    let (program, scene) = (program(), scene(folder));
    let look = if cfg!(feature = "view") { format!("view lynx {scene}") } else { "plan lynx".to_owned() };
    vec![
        format!("open `{}` in a browser, then try:", folder.join(FILE).display()),
        format!("  {program} {look}"),
        format!("  {}", command(folder, "tsushima")),
        format!("  {program} pipelines lynx --write my.ron"),
    ]
}

fn command(folder: &Path, name: &str) -> String {
    format!("{} render {name} {} -o {name}.png", program(), scene(folder))
}

/// The image of the scene, as a word of a command.
fn scene(folder: &Path) -> String {
    shell_word(&folder.join("scene.exr").to_string_lossy())
}

/// The program as it was called, which may not be on the `PATH`.
fn program() -> String {
    std::env::args().next().map_or_else(|| "afterimage".to_owned(), |called| shell_word(&called))
}

/// Text as it stands in HTML; what is between backticks as code.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut is_code = false;
    for letter in text.chars() {
        match letter {
            '`' => {
                out.push_str(if is_code { "</code>" } else { "<code>" });
                is_code = !is_code;
            }
            '&' | '<' | '>' | '"' => write!(out, "&#{};", u32::from(letter)).expect("a string takes all text"),
            _ => out.push(letter),
        }
    }
    out
}
