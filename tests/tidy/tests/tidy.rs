//! The house rules, applied to the workspace.
#![allow(missing_docs, reason = "a test binary has no outside")]

use afterimage_tidy::cycles::{cycles, describe};
use afterimage_tidy::modules::Tree;
use afterimage_tidy::workspace::{Workspace, read};
use afterimage_tidy::{
    calls, documents, files, layers, licenses, opens, packages, places, promises, shaders, stages, unsafes, versions,
};

#[track_caller]
fn assert_none(violations: &[String]) {
    assert!(violations.is_empty(), "{} violations\n{}", violations.len(), violations.join("\n"));
}

#[test]
fn dependencies_follow_the_layers() {
    assert_none(&layers::violations(&Workspace::this().product().collect::<Vec<_>>()));
}

#[test]
fn library_crates_can_be_packaged() {
    assert_none(&packages::violations(&Workspace::this().product().collect::<Vec<_>>()));
}

#[test]
fn documents_state_the_versions_of_the_manifests() {
    assert_none(&versions::violations(&Workspace::this()));
}

#[test]
fn features_are_documented() {
    assert_none(&versions::undocumented_features(&Workspace::this()));
}

#[test]
fn imports_have_no_cycle() {
    let workspace = Workspace::this();
    let roots = workspace.product().flat_map(|member| &member.roots);
    let found: Vec<String> = roots.flat_map(|root| cycles(&Tree::of(root))).map(|cycle| describe(&cycle)).collect();
    assert_none(&found);
}

#[test]
fn files_are_narrow_and_described() {
    let workspace = Workspace::this();
    assert_none(&files::violations(&workspace, &files::of_product(&workspace)));
}

#[test]
fn files_are_opened_in_one_place() {
    let workspace = Workspace::this();
    assert_none(&opens::violations(&workspace, &files::of_product(&workspace)));
}

#[test]
fn functions_of_shaders_are_called() {
    assert_none(&shaders::unused_functions(&Workspace::this()));
}

#[test]
fn calls_are_those_of_the_house() {
    let workspace = Workspace::this();
    assert_none(&calls::violations(&workspace, &files::of_product(&workspace)));
}

#[test]
fn licenses_and_sources_of_dependencies_are_allowed() {
    assert_none(&licenses::violations(&Workspace::this()));
}

#[test]
fn unsafe_code_has_reasons() {
    let found = unsafes::all(&Workspace::this());
    assert!(found.len() > 10, "only {} `unsafe` blocks are found", found.len());
    assert_none(&unsafes::violations(&found));
}

#[test]
fn places_that_documents_name_exist() {
    let root = Workspace::this().root;
    let text = read(&root.join("graph/docs/ARCHITECTURE.md"));
    let named = text.matches("` in `").count();
    assert!(named > 60, "only {named} functions are named");
    assert_none(&places::violations(&root, &text));
}

#[test]
fn the_table_of_stages_is_the_list_of_calls_of_the_planner() {
    let root = Workspace::this().root;
    let (table, planner) =
        (read(&root.join("graph/docs/ARCHITECTURE.md")), read(&root.join("graph/plan/src/planner.rs")));
    let called = stages::called(&planner);
    assert!(called.len() > 10, "only {} stages are found", called.len());
    assert_eq!(stages::documented(&table), called);
}

#[test]
fn tests_hold_the_promises_about_security() {
    let workspace = Workspace::this();
    let text = read(&workspace.root.join(".github/SECURITY.md"));
    assert!(text.matches("| tests |").count() == 2, "the tables are there");
    assert_none(&promises::violations(&text, &promises::tests(&workspace)));
}

#[test]
fn crates_that_read_what_strangers_write_have_no_unsafe_code() {
    let found = unsafes::all(&Workspace::this());
    let pure = ["graph/base/src", "graph/wgsl/src", "graph/core/src"];
    let violations = found.iter().filter(|one| pure.iter().any(|folder| one.file.starts_with(folder)));
    assert_none(&violations.map(|one| format!("{}:{}", one.file.display(), one.line)).collect::<Vec<_>>());
}

#[test]
fn links_and_names_of_documents_exist() {
    let workspace = Workspace::this();
    let (documents, known) = (documents::all(&workspace), documents::words_of_code(&workspace));
    assert!(documents.len() > 30, "only {} documents are found", documents.len());
    let links = documents.iter().flat_map(|document| documents::broken_links(&workspace, document));
    let names = documents.iter().flat_map(|document| documents::unknown_names(&workspace, document, &known));
    assert_none(&links.chain(names).collect::<Vec<_>>());
}
