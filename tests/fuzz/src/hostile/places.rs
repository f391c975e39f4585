//! Things that are no files, in the place of each file that is read.

use std::ffi::OsString;
use std::os::unix::ffi::OsStringExt as _;

use afterimage_fuzz::DECLARED_SHADER;

use crate::case::{Case, Content};
use crate::classes::Sources;
use crate::shaders::scene;

/// What lies there.
fn things() -> Vec<Content> {
    let links = ["/dev/zero", "/dev/stdin", "/proc/self/mem", "/etc/shadow", "../../..", "thing", "nothing", "."];
    let others = [Content::Pipe, Content::Socket, Content::Folder, Content::Hole(20 << 30), Content::Hole(3 << 20)];
    others.into_iter().chain(links.map(Content::Link)).collect()
}

/// Names of the thing: usual, and unkind to a terminal or to a reader of paths.
fn names() -> [OsString; 3] {
    [OsString::from("thing"), OsString::from("\u{1b}[31mred\u{9b}"), OsString::from_vec(b"b\xff.exr".to_vec())]
}

const PLAIN: &str = r#"Pipeline(inputs: { "scene": Color }, nodes: { "a": Saturation(source: "scene", amount: 0.5) }, outputs: { "out": "a" }, "#;

const NODE: &str = r#"Kind(name: "Tint", doc: "Tints.", inputs: { "source": Image(doc: "The image.") }, outputs: { "result": Image(doc: "The result.", state: Same("source")) })"#;

const TINT: &str =
    r#"Pipeline(inputs: { "scene": Color }, nodes: { "a": Tint(source: "scene") }, outputs: { "out": "a" })"#;

type Place = fn(Content, OsString) -> Case;

/// Each place where a file is read, with that content and, if the user names it, that name.
const PLACES: [Place; 12] = [
    |content, name| Case::new("check").word(name.clone()).with_content(name, content),
    |content, _| of_pipeline(r#"extends: "thing")"#, content),
    |content, _| of_pipeline(r#"tiers: { "low": "thing" })"#, content),
    |content, _| named_by(r#"Pipeline(file: "thing", source: "scene")"#, content),
    |content, _| named_by(r#"ColorLut(source: "scene", file: "thing")"#, content),
    |content, _| named_by(r#"Cdl(source: "scene", file: "thing")"#, content),
    |content, _| of_folder("tint/node.ron", content).with("tint/tint.wgsl", DECLARED_SHADER),
    |content, _| of_folder("tint/tint.wgsl", content).with("tint/node.ron", NODE),
    |content, _| {
        let shader = "import super::thing::help;\nfn tint(source: vec4f) -> vec4f { return source; }";
        of_folder("tint/thing.wgsl", content).with("tint/node.ron", NODE).with("tint/tint.wgsl", shader)
    },
    |content, name| Case::new("nodes --nodes").word(name.clone()).with_content(name, content),
    |content, name| rendered(name.clone(), content, name),
    |content, name| {
        let pattern = "shot.####.exr --frames 1-3";
        let case = rendered("shot.0002.exr".into(), content, OsString::from(&pattern[..13]));
        let case = case.with("shot.0001.exr", scene()).word("--frames").word("1-3");
        // The name takes no part: the pattern does.
        if name == "thing" { case.word("--fps").word("24") } else { case }
    },
];

fn of_pipeline(more: &str, content: Content) -> Case {
    Case::new("check p.ron").with("p.ron", format!("{PLAIN}{more}")).with_content("thing", content)
}

fn named_by(node: &str, content: Content) -> Case {
    let text =
        format!(r#"Pipeline(inputs: {{ "scene": Color }}, nodes: {{ "a": {node} }}, outputs: {{ "out": "a" }})"#);
    Case::new("check p.ron").with("p.ron", text).with_content("thing", content)
}

fn of_folder(path: &str, content: Content) -> Case {
    Case::new("check p.ron --nodes tint").with("p.ron", TINT).with_content(path, content)
}

fn rendered(path: OsString, content: Content, input: OsString) -> Case {
    let out = if input == "shot.####.exr" { "out.####.exr" } else { "out.exr" };
    let case = Case::new("render p.ron").word(input).word("-o").word(out);
    case.with("p.ron", format!("{PLAIN})")).with_content(path, content)
}

pub(crate) fn cases() -> u64 {
    (things().len() * PLACES.len() * names().len()) as u64
}

pub(crate) fn case(_: &Sources, number: u64) -> Case {
    let (things, number) = (things(), number as usize);
    let (thing, rest) = (number % things.len(), number / things.len());
    PLACES[rest % PLACES.len()](things[thing].clone(), names()[rest / PLACES.len()].clone())
}
