//! WGSL features that not every device has.

/// Optional features of WGSL that a module may use. The default is none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct ShaderFeatures {
    /// Whether `real` and its vectors are half floats: eleven bits, from 2^-14 (some devices flush less to 0) to 65504.
    pub half: bool,
    /// Whether functions of a whole workgroup use subgroup operations: `workgroup_subgroups` replaces `workgroup`.
    pub subgroups: bool,
}

impl ShaderFeatures {
    /// The file of the library that an import of `name` brings.
    pub(crate) fn file(self, name: &str) -> &str {
        if self.subgroups && name == "workgroup" { "workgroup_subgroups" } else { name }
    }

    /// Values of constants and aliases of the library.
    pub(crate) fn constants(self) -> &'static [(&'static str, &'static str)] {
        if self.half { &[("real", "f16"), ("REAL_IS_HALF", "true")] } else { &[] }
    }
}
