//! Tables of colors that the executors of several views share.
//!
//! Each executor fills a table that it begins to use, with what it holds if another one has filled it. So none depends
//! on whether the commands of another one are submitted.

use std::sync::{Arc, Mutex, Weak};

use afterimage_graph::image::ImageDesc;
use afterimage_graph::node::{Arg, ImageId, KernelCall, Origin};
use afterimage_plan::Plan;

use crate::store::Stored;

/// The tables that executors on one device have, and that others may take.
#[derive(Default)]
pub(crate) struct SharedTables(Mutex<Vec<Weak<SharedTable>>>);

/// A table, which lives as long as the memory of a plan that reads it.
pub(crate) struct SharedTable {
    pub(crate) stored: Stored,
    contents: Contents,
}

/// What a table holds: the colors that a recipe makes with these numbers.
#[derive(PartialEq)]
struct Contents {
    recipe: Recipe,
    numbers: Vec<Vec<u8>>,
}

/// What fills a table but for numbers: functions, and the texels that they read.
#[derive(PartialEq)]
pub(crate) struct Recipe {
    desc: ImageDesc,
    kernels: Vec<KernelCall>,
    constants: Vec<(ImageDesc, Arc<[u8]>)>,
}

impl Contents {
    /// `None` if numbers in it may change while the plan runs.
    fn new(plan: &Plan, table: ImageId) -> Option<Self> {
        let pass = plan.work().nth(filling_pass(plan, table)?)?;
        let changes = |name: &String| pass.nodes.iter().any(|node| name.starts_with(&format!("{node}.")));
        if plan.dynamic.iter().any(changes) {
            return None;
        }
        let numbers = pass.kernels.iter().map(|kernel| kernel.uniform.clone()).collect();
        Some(Self { recipe: Recipe::new(plan, table)?, numbers })
    }
}

impl Recipe {
    /// `None` if the functions read what frames make.
    pub(crate) fn new(plan: &Plan, table: ImageId) -> Option<Self> {
        let pass = plan.work().nth(filling_pass(plan, table)?)?;
        let (mut kernels, mut constants) = (pass.kernels.clone(), Vec::new());
        // Nodes have other names elsewhere, and images other numbers.
        for kernel in &mut kernels {
            (kernel.node, kernel.origin) = (String::new(), None);
            kernel.uniform.clear();
            for arg in &mut kernel.args {
                if let Arg::Texture(image) = &mut arg.value {
                    let planned = plan.image(*image);
                    let Origin::Constant(texels) = &planned.origin else { return None };
                    *image = ImageId(constants.len() as u32);
                    constants.push((planned.desc, texels.clone()));
                }
            }
        }
        Some(Self { desc: plan.image(table).desc, kernels, constants })
    }
}

/// The pass that fills a table.
pub(crate) fn filling_pass(plan: &Plan, table: ImageId) -> Option<usize> {
    plan.work().position(|pass| pass.function_result() == Some(table))
}

impl SharedTables {
    /// The table for an image of a plan: that of another executor, or a new one. `None` if it is shared with none.
    pub(crate) fn get(&self, plan: &Plan, image: ImageId, make: impl FnOnce() -> Stored) -> Option<Arc<SharedTable>> {
        let contents = Contents::new(plan, image)?;
        let mut tables = self.0.lock().expect(UNBROKEN);
        tables.retain(|table| table.strong_count() > 0);
        if let Some(known) = tables.iter().filter_map(Weak::upgrade).find(|table| table.contents == contents) {
            return Some(known);
        }
        let table = Arc::new(SharedTable { stored: make(), contents });
        tables.push(Arc::downgrade(&table));
        Some(table)
    }

    /// Whether the tables of a plan may become those of one that differs in uniforms only: not if another executor or
    /// another pass reads one that would change. If they may, nobody else gets those that change.
    pub(crate) fn may_change(&self, own: &[(ImageId, Arc<SharedTable>)], plan: &Plan) -> bool {
        let mut tables = self.0.lock().expect(UNBROKEN);
        let changes = |(image, table): &&(ImageId, Arc<SharedTable>)| {
            Contents::new(plan, *image).is_none_or(|contents| contents != table.contents)
        };
        let changed: Vec<&Arc<SharedTable>> = own.iter().filter(changes).map(|(_, table)| table).collect();
        if changed.iter().any(|table| Arc::strong_count(table) > 1) {
            return false;
        }
        tables.retain(|known| !changed.iter().any(|table| Arc::as_ptr(table) == known.as_ptr()));
        true
    }
}

const UNBROKEN: &str = "no thread panics with the lock";
