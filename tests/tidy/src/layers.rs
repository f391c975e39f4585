//! The layers of the crates: which crate may depend on which.

use crate::workspace::Crate;

/// Each crate of the product from the lowest layer up, with the crates that it is built on.
///
/// It may name these and those below them as normal dependencies. A member that is missing here is an error, so that a
/// new crate gets its place in the list.
pub const LAYERS: &[(&str, &[&str])] = &[
    ("afterimage-shaders", &[]),
    ("afterimage-base", &[]),
    ("afterimage-wgsl", &["afterimage-base", "afterimage-shaders"]),
    ("afterimage-graph", &["afterimage-base", "afterimage-wgsl"]),
    ("afterimage-plan", &["afterimage-base", "afterimage-wgsl", "afterimage-graph"]),
    ("afterimage-color", &["afterimage-graph"]),
    ("afterimage-nodes", &["afterimage-color", "afterimage-graph", "afterimage-shaders"]),
    ("afterimage-pipelines", &["afterimage-graph"]),
    ("afterimage-gpu", &["afterimage-plan"]),
    ("afterimage-media", &["afterimage-base"]),
    ("afterimage", &["afterimage-gpu", "afterimage-media", "afterimage-nodes", "afterimage-pipelines"]),
    ("afterimage-lab", &["afterimage"]),
    ("afterimage-view", &["afterimage"]),
    ("afterimage-c", &["afterimage"]),
    (
        "afterimage-cli",
        &["afterimage", "afterimage-lab", "afterimage-nodes", "afterimage-pipelines", "afterimage-view"],
    ),
];

/// External crates that only some crates may name as normal dependencies.
pub const RESERVED: &[(&str, &[&str])] =
    &[("wgpu", &["afterimage-gpu"]), ("wgpu-hal", &["afterimage-gpu"]), ("ash", &["afterimage-gpu"])];

/// What breaks the rules of the layers, a sentence each.
pub fn violations(crates: &[&Crate]) -> Vec<String> {
    crates.iter().flat_map(|one| of_crate(one)).collect()
}

fn of_crate(one: &Crate) -> Vec<String> {
    if !LAYERS.iter().any(|(name, _)| *name == one.name) {
        return vec![format!("crate `{}` has no place in the list of layers", one.name)];
    }
    let normal = one.dependencies.iter().filter(|dependency| !dependency.dev).map(|dependency| &dependency.name);
    let refused = normal.filter(|used| !is_allowed(&one.name, used));
    refused.map(|used| format!("`{}` must not depend on `{used}`", one.name)).collect()
}

fn is_allowed(user: &str, used: &str) -> bool {
    let reserved = RESERVED.iter().find(|(name, _)| *name == used).map(|(_, users)| *users);
    let is_member = used == "afterimage" || used.starts_with("afterimage-");
    match reserved {
        Some(users) => users.contains(&user),
        None => !is_member || is_below(used, user),
    }
}

/// True if one crate is built on the other, directly or not.
fn is_below(lower: &str, upper: &str) -> bool {
    let direct = LAYERS.iter().find(|(name, _)| *name == upper).map_or(&[][..], |(_, direct)| direct);
    direct.iter().any(|name| *name == lower || is_below(lower, name))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspace::Dependency;

    fn crate_with(name: &str, normal: &[&str], dev: &[&str]) -> Crate {
        let dependency =
            |dev| move |name: &&str| Dependency { name: (*name).to_owned(), dev, is_local: true, has_version: true };
        let dependencies = normal.iter().map(dependency(false)).chain(dev.iter().map(dependency(true))).collect();
        Crate { name: name.to_owned(), folder: "".into(), roots: Vec::new(), dependencies, is_published: true }
    }

    #[test]
    fn an_edge_to_a_higher_layer_is_found() {
        let graph = crate_with("afterimage-graph", &["afterimage-base", "afterimage-plan", "ron"], &[]);
        assert_eq!(violations(&[&graph]), ["`afterimage-graph` must not depend on `afterimage-plan`"]);
    }

    #[test]
    fn crates_below_those_of_the_list_may_be_named() {
        let gpu = crate_with("afterimage-gpu", &["afterimage-plan", "afterimage-base"], &[]);
        let media = crate_with("afterimage-media", &["afterimage-graph"], &[]);
        assert_eq!(violations(&[&gpu, &media]), ["`afterimage-media` must not depend on `afterimage-graph`"]);
    }

    #[test]
    fn a_reserved_crate_is_found_outside_of_its_users() {
        let gpu = crate_with("afterimage-gpu", &["wgpu"], &[]);
        let program = crate_with("afterimage-cli", &["wgpu"], &[]);
        assert_eq!(violations(&[&gpu, &program]), ["`afterimage-cli` must not depend on `wgpu`"]);
    }

    #[test]
    fn dependencies_of_tests_are_free() {
        let graph = crate_with("afterimage-graph", &[], &["afterimage-nodes", "wgpu"]);
        assert_eq!(violations(&[&graph]), Vec::<String>::new());
    }

    #[test]
    fn an_unknown_member_is_found() {
        let extra = crate_with("afterimage-extra", &[], &[]);
        assert_eq!(violations(&[&extra]), ["crate `afterimage-extra` has no place in the list of layers"]);
    }

    #[test]
    fn edges_of_the_list_lead_to_lower_layers() {
        for (at, (name, allowed)) in LAYERS.iter().enumerate() {
            let below = &LAYERS[..at];
            for used in *allowed {
                assert!(below.iter().any(|(lower, _)| lower == used), "`{name}` -> `{used}` leads up");
            }
        }
    }
}
