//! Shaders of a node, and the errors in them.

use std::cell::RefCell;

use afterimage_wgsl::{Reflection, Shader, ShaderError};

/// Reads shaders of a node, and collects the errors in them.
#[derive(Default)]
pub(super) struct NodeShaders {
    errors: RefCell<Vec<ShaderError>>,
}

impl NodeShaders {
    /// Reflection of a module; empty if it is wrong.
    pub(super) fn reflection<'s>(&self, shader: &'s Shader) -> &'s Reflection {
        shader.reflect().unwrap_or_else(|error| {
            self.add_error(error);
            &NOTHING
        })
    }

    /// Adds an error in a shader of the node. `record` of a kind cannot fail, so it goes on with passes that never run.
    pub(super) fn add_error(&self, error: ShaderError) {
        let mut errors = self.errors.borrow_mut();
        if !errors.contains(&error) {
            errors.push(error);
        }
    }

    pub(super) fn has_errors(&self) -> bool {
        !self.errors.borrow().is_empty()
    }

    pub(super) fn into_errors(self) -> Vec<ShaderError> {
        self.errors.into_inner()
    }
}

/// Reflection of a wrong module.
static NOTHING: Reflection = Reflection {
    functions: Vec::new(),
    entries: Vec::new(),
    structs: Vec::new(),
    globals: Vec::new(),
    direct_reads: Vec::new(),
    filtering: Vec::new(),
    sharing: Vec::new(),
    shader_costs: Vec::new(),
    costs: Vec::new(),
};
