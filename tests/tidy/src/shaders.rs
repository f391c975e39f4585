//! Functions of the shared shaders that nothing calls.

use std::collections::BTreeMap;

use crate::workspace::{Workspace, files_in, read};

/// Folders whose files may name a function: kinds and passes by its name in a text, kernels by a call, and documents
/// that offer it to authors.
const FOLDERS: [&str; 4] = ["graph", "nodes", "shaders", "tests"];

/// The functions of `shaders/` that no other line names, a sentence each.
pub fn unused_functions(workspace: &Workspace) -> Vec<String> {
    let folders = FOLDERS.map(|folder| workspace.root.join(folder));
    let files = folders.iter().flat_map(|folder| files_in(folder, &["wgsl", "wesl", "rs", "ron", "md"]));
    let texts: Vec<String> = files.map(|file| read(&file)).collect();
    let shaders = files_in(&workspace.root.join("shaders"), &["wgsl"]);
    let shaders: Vec<String> = shaders.iter().map(|file| read(file)).collect();
    unused(&shaders, &texts).into_iter().map(|name| format!("nothing calls `{name}`")).collect()
}

/// The functions of these shaders whose names stand once in all texts.
fn unused<'a>(shaders: &'a [String], texts: &[String]) -> Vec<&'a str> {
    let mut uses: BTreeMap<&str, usize> = BTreeMap::new();
    texts.iter().flat_map(|text| words(text)).for_each(|word| *uses.entry(word).or_default() += 1);
    let declared = shaders.iter().flat_map(|text| text.lines()).filter_map(|line| line.strip_prefix("fn "));
    let names = declared.filter_map(|line| words(line).next());
    names.filter(|name| uses.get(name).is_none_or(|uses| *uses < 2)).collect()
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|word| !word.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_function_that_is_declared_and_no_more_is_found() {
        let shader = "fn twice(x: f32) -> f32 { return x + x; }\nfn twice_more() { twice(2.0); }\n".to_owned();
        let kind = "pass.function(&SHADER, \"twice_more\")".to_owned();
        let shaders = [shader.clone()];
        assert_eq!(unused(&shaders, &[shader.clone(), kind]), [""; 0]);
        assert_eq!(unused(&shaders, &[shader]), ["twice_more"]);
    }
}
