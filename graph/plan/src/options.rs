//! The switches of the planner.

use afterimage_base::caps::Caps;
use serde::Serialize;

/// Switches of the planner.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
pub struct Options {
    /// Whether point kernels are fused, and kernels joined that reduce one image.
    pub fuse: bool,
    /// When images are halved row by row.
    pub row_downsample: When,
    /// How transient images share memory.
    pub alias: Alias,
    /// Whether each pass is a batch of its own.
    pub serial: bool,
    /// Whether every intermediate is stored in 32 bits and filtered with all of them, where a device's own filter has
    /// eight bits of fraction: the reference of `measure`.
    pub exact: bool,
    /// Whether the order with the fewest batches is chosen before that with the smallest memory.
    pub batches_first: bool,
    /// Whether unchecked shaders, too, run with the driver's checks of indices and loops. Pixels are the same.
    pub bounds_checks: bool,
    /// Whether sums of weighted colors (halvings, tents, the filter of Caracal) are made in half floats, where the
    /// device has them and no image of the pass is in 32 bits. What is stored in between has 11 bits anyway; a sum of
    /// them loses about one more.
    pub half: bool,
    /// Whether sums over a workgroup (of meters and of the wide logarithmic mean) use subgroup operations, where the
    /// device has them. They add in another order, so results differ by roundings of 32-bit floats.
    pub subgroups: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            fuse: true,
            row_downsample: When::WhereItPays,
            alias: Alias::Placed,
            serial: false,
            exact: false,
            batches_first: false,
            bounds_checks: false,
            half: false,
            subgroups: false,
        }
    }
}

/// When a way to run kernels together is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub enum When {
    /// Never.
    Never,
    /// Where it is expected to be faster, on a device with fast workgroup memory.
    WhereItPays,
    /// Wherever it is possible: for tests and measurements.
    Always,
}

/// How transient images share memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub enum Alias {
    /// Each image has its own.
    None,
    /// Images with equal descriptions share a pooled texture.
    Pool,
    /// All images lie in one heap, at offsets; where the backend cannot, the pool.
    Placed,
}

/// A switch of [`Options`] that has no effect on this device or beside another switch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Ignored {
    /// The switch, as the field of [`Options`] is called.
    pub switch: &'static str,
    /// Why.
    pub why: &'static str,
}

impl Options {
    /// The options without those that this device lacks or that another one excludes, and the switches that are ignored
    /// for it. Plans are made with these.
    pub fn granted(self, caps: &Caps) -> (Self, Vec<Ignored>) {
        let (half, subgroups) = (self.why_no_half(caps), self.why_no_subgroups(caps));
        let granted =
            Self { half: self.half && half.is_none(), subgroups: self.subgroups && subgroups.is_none(), ..self };
        let ignored = [("subgroups", subgroups), ("half", half)];
        (granted, ignored.into_iter().filter_map(|(switch, why)| Some(Ignored { switch, why: why? })).collect())
    }

    fn why_no_half(self, caps: &Caps) -> Option<&'static str> {
        match (self.exact, caps.half_arithmetic) {
            _ if !self.half => None,
            (true, _) => Some("`exact` wants all bits"),
            (false, false) => Some("the device has no half-precision arithmetic"),
            (false, true) => None,
        }
    }

    fn why_no_subgroups(self, caps: &Caps) -> Option<&'static str> {
        (self.subgroups && !caps.subgroups).then_some("the device has no operations of subgroups")
    }
}
