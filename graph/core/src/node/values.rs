//! The parameters of a node, as uniforms take them.

use afterimage_base::value::{Param, Value};
use afterimage_wgsl::UniformValue;

/// The parameters of a node, which uniforms find by their names.
#[derive(Clone, Copy, Debug, Default)]
pub struct UniformValues<'a> {
    params: &'a [Param],
    values: &'a [Value],
}

impl<'a> UniformValues<'a> {
    /// Parameters with their values, in the same order.
    pub fn new(params: &'a [Param], values: &'a [Value]) -> Self {
        Self { params, values }
    }

    /// The value of the parameter of that name.
    pub fn get(&self, name: &str) -> Option<UniformValue> {
        let index = self.params.iter().position(|param| param.name == name)?;
        Some((&self.values[index]).into())
    }
}
