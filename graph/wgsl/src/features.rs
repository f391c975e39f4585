//! What a module may say that not every device understands.

/// The arithmetic and the operations that a module may use beyond what every device has. The default is what every device has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct ShaderFeatures {
    /// Whether `real` and its vectors are half floats: eleven bits, from 2^-14 (some devices take less for 0) to 65504.
    pub half: bool,
    /// Whether the invocations of a workgroup are brought together by operations of subgroups: `workgroup_subgroups` replaces `workgroup`.
    pub subgroups: bool,
}

impl ShaderFeatures {
    /// The file of the library that stands for one.
    pub(crate) fn stands_for(self, name: &str) -> &str {
        if self.subgroups && name == "workgroup" { "workgroup_subgroups" } else { name }
    }

    /// Lines that a module begins with.
    pub(crate) fn settings(self) -> String {
        let (enable, real) = if self.half { ("enable f16;\n", "f16") } else { ("", "f32") };
        let vectors: String = (2..=4).map(|n| format!("alias real{n} = vec{n}<{real}>;\n")).collect();
        format!("{enable}alias real = {real};\n{vectors}const REAL_IS_HALF: bool = {};", self.half)
    }
}
