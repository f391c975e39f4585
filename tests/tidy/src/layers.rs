//! The layers of the crates: which crate may depend on which.

use crate::workspace::Crate;

/// Each crate of the product from the lowest layer up, with the crates that it may name as normal dependencies.
///
/// A member that is missing here is an error, so that a new crate gets its place in the list.
pub const LAYERS: &[(&str, &[&str])] = &[
    ("afterimage-base", &[]),
    ("afterimage-wgsl", &["afterimage-base"]),
    ("afterimage-graph", &["afterimage-base", "afterimage-wgsl"]),
    ("afterimage-plan", &["afterimage-base", "afterimage-wgsl", "afterimage-graph"]),
    ("afterimage-nodes", &["afterimage-graph"]),
    ("afterimage-gpu", &["afterimage-plan"]),
    ("afterimage-media", &["afterimage-base"]),
    ("afterimage-lab", &["afterimage-gpu", "afterimage-media", "afterimage-plan"]),
    (
        "afterimage",
        &[
            "afterimage-base",
            "afterimage-wgsl",
            "afterimage-graph",
            "afterimage-plan",
            "afterimage-nodes",
            "afterimage-gpu",
            "afterimage-media",
            "afterimage-lab",
        ],
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
    let Some((_, allowed)) = LAYERS.iter().find(|(name, _)| *name == one.name) else {
        return vec![format!("crate `{}` has no place in the list of layers", one.name)];
    };
    let normal = one.dependencies.iter().filter(|dependency| !dependency.dev);
    normal.filter_map(|dependency| refused(&one.name, &dependency.name, allowed)).collect()
}

fn refused(user: &str, used: &str, allowed: &[&str]) -> Option<String> {
    let reserved = RESERVED.iter().find(|(name, _)| *name == used).map(|(_, users)| *users);
    let is_member = used == "afterimage" || used.starts_with("afterimage-");
    let refused = match reserved {
        Some(users) => !users.contains(&user),
        None => is_member && !allowed.contains(&used),
    };
    refused.then(|| format!("`{user}` must not depend on `{used}`"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspace::Dependency;

    fn crate_with(name: &str, normal: &[&str], dev: &[&str]) -> Crate {
        let dependency = |dev| move |name: &&str| Dependency { name: (*name).to_owned(), dev };
        let dependencies = normal.iter().map(dependency(false)).chain(dev.iter().map(dependency(true))).collect();
        Crate { name: name.to_owned(), folder: "".into(), roots: Vec::new(), dependencies }
    }

    #[test]
    fn an_edge_to_a_higher_layer_is_found() {
        let graph = crate_with("afterimage-graph", &["afterimage-base", "afterimage-plan", "ron"], &[]);
        assert_eq!(violations(&[&graph]), ["`afterimage-graph` must not depend on `afterimage-plan`"]);
    }

    #[test]
    fn a_reserved_crate_is_found_outside_of_its_users() {
        let gpu = crate_with("afterimage-gpu", &["wgpu"], &[]);
        let program = crate_with("afterimage", &["wgpu"], &[]);
        assert_eq!(violations(&[&gpu, &program]), ["`afterimage` must not depend on `wgpu`"]);
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
