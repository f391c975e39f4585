//! What a recording has looked up by names for a pass around a function. The next recording of the node needs none of
//! it again: hosts set parameters in every frame.

use afterimage_base::Shared;
use afterimage_wgsl::{Member, StructLayout, UniformValue};

use super::details::FunctionDetails;
use crate::node::drawing::Subresource;
use crate::node::resource::ImageId;
use crate::node::values::UniformValues;

/// What the arguments of a function and the numbers of its uniform come from.
#[derive(Clone, Debug, Default)]
pub(super) struct KnownPass {
    is_known: bool,
    /// What the node has said of the pass: while it says the same, the arguments are the same.
    reads: Vec<(Shared<str>, ImageId)>,
    levels: Vec<(&'static str, Subresource)>,
    computed: Vec<&'static str>,
    numbers: Vec<Number>,
}

/// A member of a uniform.
#[derive(Clone, Debug)]
struct Number {
    member: Member,
    source: NumberSource,
}

#[derive(Clone, Copy, Debug)]
enum NumberSource {
    /// What the node has computed, by its place among these.
    Computed(usize),
    /// A parameter of the node.
    Parameter(usize),
}

impl KnownPass {
    /// Whether this is known of a pass that the node describes so.
    pub(super) fn is_for(&self, details: &FunctionDetails) -> bool {
        let FunctionDetails { reads, levels, computed, promises: _ } = details;
        self.is_known
            && all(&self.reads, reads, |(known, image), (name, other)| image == other && is_same(known, name))
            && all(&self.levels, levels, |(known, part), (name, other)| part == other && is_same(known, name))
            && all(&self.computed, computed, |known, (name, _)| is_same(known, name))
    }

    /// Looks up where the numbers of a uniform come from: what the node computes, or else its parameters.
    ///
    /// # Errors
    /// A member has no value.
    pub(super) fn look_up(
        &mut self,
        details: &FunctionDetails,
        layout: Option<&StructLayout>,
        parameters: UniformValues<'_>,
    ) -> Result<(), String> {
        self.reads.clone_from(&details.reads);
        self.levels.clone_from(&details.levels);
        self.computed.clear();
        self.computed.extend(details.computed.iter().map(|(name, _)| *name));
        self.numbers.clear();
        for member in layout.iter().flat_map(|layout| &layout.members) {
            let computed = self.computed.iter().rposition(|name| *name == member.name).map(NumberSource::Computed);
            let source = computed.or_else(|| parameters.index(&member.name).map(NumberSource::Parameter));
            let source = source.ok_or_else(|| format!("`{}` has no value", member.name))?;
            self.numbers.push(Number { member: member.clone(), source });
        }
        self.is_known = true;
        Ok(())
    }

    /// Writes the uniform.
    ///
    /// # Errors
    /// A member has too many numbers.
    pub(super) fn write(
        &self,
        parameters: UniformValues<'_>,
        computed: &[(&'static str, UniformValue)],
        uniform: &mut [u8],
    ) -> Result<(), String> {
        uniform.fill(0);
        self.numbers.iter().try_for_each(|Number { member, source }| {
            let written = match source {
                NumberSource::Computed(at) => member.write(&computed[*at].1, uniform),
                NumberSource::Parameter(at) => member.write(&parameters.at(*at), uniform),
            };
            written.map_err(|why| format!("`{}` {why}", member.name))
        })
    }
}

fn all<A, B>(known: &[A], others: &[B], is_same: impl Fn(&A, &B) -> bool) -> bool {
    known.len() == others.len() && known.iter().zip(others).all(|(known, other)| is_same(known, other))
}

/// Names are mostly literals, so that both are one.
fn is_same(known: &str, name: &str) -> bool {
    std::ptr::eq(known, name) || known == name
}
