//! A small world of node kinds that stays as it is, so that messages which list kinds and parameters do too.

use afterimage_graph::prelude::*;

choices! {
    /// Tone curves.
    pub enum Curve {
        /// The film industry's.
        Aces,
        /// x / (1 + x).
        Reinhard,
    }
}

const LIGHT: &[ColorState] = &[ColorState::Scene, ColorState::Exposed];
const SOURCE: Input = Input::image("source", "The picture.");
const SAME: Output = Output::image("result", OutputState::same("source"), "The picture.");

node_kind! {
    /// Multiplies light by a power of two.
    pub struct Exposure {
        /// Powers of two; 0 changes nothing.
        pub stops: f32 = 0.0 => within(-32.0..=32.0), unit("stops"), neutral(0.0);
    }

    const INPUTS: &'static [Input] = &[
        SOURCE.accepts(&[ColorState::Scene]),
        Input::new("meter", PortType::Value, "Measured light.").content("exposure").optional()
    ];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::Always(ColorState::Exposed), "The exposed picture.")];
}

node_kind! {
    /// Measures light.
    pub struct Meter {
    }

    const INPUTS: &'static [Input] = &[SOURCE.accepts(LIGHT)];
    const OUTPUTS: &'static [Output] = &[
        Output::new("histogram", PortType::Table, OutputState::Nothing, "How often each brightness occurs.")
            .content("histogram"),
        Output::new("exposure", PortType::Value, OutputState::Nothing, "The exposure that fits.").content("exposure"),
        Output::new("light", PortType::Value, OutputState::Nothing, "The light in lux.").content("lux")
    ];
}

node_kind! {
    /// Keeps bright light.
    pub struct Extract {
        /// Light below this is dropped.
        pub threshold: f32 = 1.0 => within(0.0..=65504.0);
        /// Width of the soft step.
        pub knee: f32 = 0.1 => within(0.0..=1.0);
    }

    const INPUTS: &'static [Input] = &[SOURCE.accepts(LIGHT)];
    const OUTPUTS: &'static [Output] = &[SAME];
}

node_kind! {
    /// Makes one sample of several.
    pub struct Resolve {
    }

    const INPUTS: &'static [Input] = &[Input::multisampled("source", "The samples.")];
    const OUTPUTS: &'static [Output] = &[SAME];
}

node_kind! {
    /// Halves a picture again and again.
    pub struct Downsample {
        /// How often.
        pub levels: u32 = 5 => within(1.0..=12.0);
    }

    const INPUTS: &'static [Input] = &[SOURCE];
    const OUTPUTS: &'static [Output] =
        &[Output::new("result", PortType::Pyramid, OutputState::same("source"), "The levels.")];
}

node_kind! {
    /// Adds up a pyramid.
    pub struct Upsample {
        /// Width of the filter.
        pub radius: f32 = 0.85 => within(0.0..=4.0);
    }

    const INPUTS: &'static [Input] = &[Input::new("source", PortType::Pyramid, "The levels.")];
    const OUTPUTS: &'static [Output] = &[SAME];
}

node_kind! {
    /// Adds light to a picture.
    pub struct Composite {
        /// Share of the light; 0 changes nothing.
        pub strength: f32 = 0.5 => within(0.0..=16.0), neutral(0.0);
    }

    const INPUTS: &'static [Input] = &[
        Input::image("base", "The picture.").accepts(LIGHT),
        Input::image("bloom", "The light.").accepts(LIGHT),
    ];
    const OUTPUTS: &'static [Output] = &[Output::image("result", OutputState::same("base"), "Their sum.")];
}

node_kind! {
    /// Colors a picture.
    pub struct Tint {
        /// Factors of red, green and blue.
        pub color: [f32; 3] = [1.0, 1.0, 1.0] => within(0.0..=16.0);
        /// Whether brightness stays.
        pub keep: bool = true;
    }

    const INPUTS: &'static [Input] = &[SOURCE];
    const OUTPUTS: &'static [Output] = &[SAME];
}

node_kind! {
    /// Maps colors by a table.
    pub struct Grade {
        /// The table.
        pub table: FileValue = FileValue::default();
    }

    const INPUTS: &'static [Input] = &[SOURCE];
    const OUTPUTS: &'static [Output] = &[SAME];
}

node_kind! {
    /// Bends scene light into what a display can show.
    pub struct ToneMap {
        /// The curve.
        pub curve: Curve = Curve::Aces;
    }

    const INPUTS: &'static [Input] = &[SOURCE.accepts(&[ColorState::Exposed])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::Always(ColorState::DisplayLinear), "The picture for a display.")];
}

node_kind! {
    /// Applies the transfer function of a display.
    pub struct Encode {
    }

    const INPUTS: &'static [Input] = &[SOURCE.accepts(&[ColorState::DisplayLinear])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::Always(ColorState::Encoded), "The picture for a file.")];
}

/// Kinds that record nothing.
macro_rules! record_nothing {
    ($($kind:ident),*) => { $(impl Node for $kind {
        fn record(&self, _: &mut Recorder<'_>) {}
    })* };
}

record_nothing!(Exposure, Meter, Extract, Downsample, Resolve, Upsample, Composite, Tint, ToneMap, Encode);

impl Node for Grade {
    fn verify(&self) -> Result<(), String> {
        let bytes = self.table.bytes.as_deref().unwrap_or(b"1");
        if bytes.is_empty() { Err("the table is empty".into()) } else { Ok(()) }
    }

    fn record(&self, _: &mut Recorder<'_>) {}
}

/// All of them.
pub(super) const ALL: &[NodeKind] = &[
    NodeKind::of::<Composite>(),
    NodeKind::of::<Downsample>(),
    NodeKind::of::<Encode>(),
    NodeKind::of::<Exposure>(),
    NodeKind::of::<Extract>(),
    NodeKind::of::<Grade>(),
    NodeKind::of::<Meter>(),
    NodeKind::of::<Resolve>(),
    NodeKind::of::<Tint>(),
    NodeKind::of::<ToneMap>(),
    NodeKind::of::<Upsample>(),
];
