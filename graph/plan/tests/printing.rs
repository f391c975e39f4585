//! Plans as text, JSON and SVG, their hashes and their differences.

use std::collections::BTreeSet;

use afterimage_generators::Recipe;
use afterimage_graph::check::Facts;
use afterimage_graph::image::{Format, Size};
use afterimage_graph::node::BufferLife;
use afterimage_plan::{Alias, Options, Plan, diff};

use super::support::{all_formats, checked, plan_at, plan_images, plan_of};

const RECIPE: Recipe = Recipe { seed: 5, nodes: 24, histories: 2, off: 12 };

fn example() -> Plan {
    plan_of(RECIPE, Options::default()).expect("the graph can be planned")
}

#[test]
fn the_text_lists_every_pass_and_every_skipped_node() {
    let plan = example();
    let text = plan.to_text();
    for pass in plan.work() {
        let whole = text.lines().any(|line| line.contains(&pass.nodes.join(" + ")) && line.contains(&pass.label));
        let line =
            |(node, label): (&String, &str)| text.lines().any(|line| line.contains(node) && line.contains(label));
        let in_parts = pass.nodes.iter().zip(pass.label.split(" + ")).all(line);
        assert!(whole || in_parts, "{}: {}\n{text}", pass.nodes.join(" + "), pass.label);
    }
    for skipped in &plan.savings.skipped {
        assert!(text.lines().any(|line| line.contains(&skipped.node) && line.ends_with(&skipped.why)), "{text}");
    }
    assert!(
        !plan.savings.skipped.is_empty() && text.contains("lower bound") && text.contains(&plan.hash().to_string())
    );
    assert!(text.lines().all(|line| line == line.trim_end()), "no spaces at the ends of lines");
}

#[test]
fn the_json_is_canonical() {
    let plan = example();
    let json: serde_json::Value = serde_json::from_str(&plan.to_json()).expect("JSON can be read");
    for key in ["hash", "passes", "batches", "skipped", "memory"] {
        assert!(json.get(key).is_some(), "no `{key}`");
    }
    let keys = ["unaliased", "unshared", "pooled", "placed", "lower_bound"];
    let m = &plan.memory;
    let memory = keys.map(|key| json["memory"][key].as_u64());
    assert_eq!(memory, [m.unaliased, m.unshared, m.pooled, m.placed, m.lower_bound].map(Some));
    assert_eq!(json["hash"], plan.hash().to_string());
    assert_eq!(json["passes"].as_array().map(Vec::len), Some(plan.passes.len()));
    let names = plan.image_names();
    for (pass, view) in plan.work().zip(json["passes"].as_array().expect("a list")) {
        let written = pass.written_image().map(|image| &*names[image.0 as usize]);
        assert!(
            written.is_none_or(|name| view["writes"].as_array().is_some_and(|all| all.iter().any(|it| it == name)))
        );
    }
    // Reading sorts the keys: writing again gives the same text only if they were sorted.
    assert_eq!(serde_json::to_string_pretty(&json).expect("JSON can be written"), plan.to_json());
}

#[test]
fn only_equal_plans_have_equal_hashes() {
    let plan = example();
    assert_eq!(plan.hash(), example().hash());
    let others = [
        plan_of(RECIPE, Options { alias: Alias::Pool, ..Options::default() }),
        plan_of(RECIPE, Options { fuse: false, ..Options::default() }),
        plan_of(Recipe { seed: 6, ..RECIPE }, Options::default()),
        plan_at(&RECIPE.graph(), Size::new(641, 360), Options::default()),
    ];
    for other in others {
        assert_ne!(plan.hash(), other.expect("the graph can be planned").hash());
    }
}

#[test]
fn a_plan_does_not_differ_from_itself() {
    let (plan, unfused) = (example(), plan_of(RECIPE, Options { fuse: false, ..Options::default() }).expect("plans"));
    assert!(diff(&plan, &example()).is_empty());
    let change = diff(&unfused, &plan);
    assert!(!change.added.is_empty() && !change.removed.is_empty());
    let (passes, moved) = (change.passes, change.bytes_moved);
    assert_eq!(passes.0 as usize - passes.1 as usize, change.removed.len() - change.added.len());
    let saved: u64 = plan.savings.fused.iter().map(|fused| fused.bytes_saved).sum();
    assert!(moved.0 >= moved.1 + saved, "fusion moves less: {moved:?}, {saved} less");
    let back = diff(&plan, &unfused);
    assert_eq!((back.added, back.removed), (change.removed.clone(), change.added.clone()));
    let text = change.to_string();
    assert!(change.removed.iter().all(|pass| text.contains(&format!("- {pass}\n"))), "{text}");
}

#[test]
fn the_picture_shows_every_image_of_the_heap() {
    let plan = example();
    let svg = plan.to_svg();
    for (name, image) in plan.image_names().iter().zip(&plan.images) {
        assert!(image.offset.is_none() || svg.contains(&format!("<title>{name}\n")), "no bar for {name}");
    }
    assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
    for tag in ["text", "title", "rect", "circle", "path"] {
        let opened = svg.matches(&format!("<{tag} ")).count() + svg.matches(&format!("<{tag}>")).count();
        let closed = svg.matches(&format!("</{tag}>")).count()
            + svg.matches("fill=\"#ffffff\"/>").count() * usize::from(tag == "rect");
        assert_eq!(opened, closed, "{tag}");
    }
}

/// What a buffer holds is part of the plan: another table is another plan.
#[test]
fn the_contents_and_the_life_of_a_buffer_are_part_of_the_plan() {
    let graph = checked(
        r#"Pipeline(
            inputs: { "scene": Exposed },
            nodes: { "around": LogGaussian(source: "scene", width: 16, height: 8) },
            outputs: { "around": "around" },
        )"#,
    );
    let plan = plan_images(&graph, Format::Rgba16Float, Facts::default(), all_formats(), Options::default());
    let lives = [
        BufferLife::Constant(vec![0; 16].into()),
        BufferLife::Constant(vec![1; 16].into()),
        BufferLife::Frame,
        BufferLife::Zeroed,
        BufferLife::Persistent,
    ];
    let other = |life: &BufferLife| {
        let mut other = plan.clone();
        other.buffers[0].life = life.clone();
        other.hash().to_string()
    };
    let hashes: BTreeSet<String> = lives.iter().map(other).collect();
    assert_eq!(hashes.len(), lives.len(), "{hashes:?}");
}

#[test]
fn plans_that_differ_in_images_or_figures_differ() {
    let plan = example();
    let unfused = plan_of(RECIPE, Options { fuse: false, ..Options::default() }).expect("the graph can be planned");
    assert!(diff(&plan, &plan).is_empty());
    assert!(!diff(&plan, &unfused).is_empty() && !diff(&unfused, &plan).is_empty());
    let mut slower = plan.clone();
    slower.batches.truncate(1);
    assert!(!diff(&plan, &slower).is_empty(), "only the number of batches differs");
}
