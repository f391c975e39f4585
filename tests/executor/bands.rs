//! Pictures in bands: bit for bit what the device makes of whole images.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use afterimage::host::PostError;
use afterimage::offline::Session;
use afterimage_gpu::{BandReader, BandStats, BandWriter, FrameStep, Gpu, Opening, Texels, wgpu};

use afterimage_graph::check::Facts;
use afterimage_graph::image::{Format, ImageDesc, Size};
use afterimage_plan::{
    Alias, BandLimits, Caps, Halos, HostImageDesc, HostInputs, HostLimits, Options, Parts, Plan, PlanError,
    PlanRequest, Requirement, When, plan_without_tables,
};
use afterimage_wgsl::{BandedModule, banded};

use crate::support::gpu::{Picture, Run, Shared, built_in, gpu, graph};
use crate::support::sweep;

#[derive(Default)]
struct Inputs(BTreeMap<String, Texels>);

impl BandReader for Inputs {
    type Error = PostError;

    fn read(&mut self, input: &str, rows: Range<u32>, needed: u32, texels: &mut Vec<u8>) -> Result<(), PostError> {
        assert!(needed <= rows.start);
        let Texels { desc, bytes } = &self.0[input];
        let row = desc.size.width as usize * desc.format.bytes() as usize;
        texels.clear();
        texels.extend_from_slice(&bytes[rows.start as usize * row..rows.end as usize * row]);
        Ok(())
    }
}

#[derive(Default)]
struct Outputs {
    bytes: BTreeMap<String, Vec<u8>>,
    first_row: u32,
}

impl BandWriter for Outputs {
    type Error = PostError;

    fn write(&mut self, output: &str, rows: Range<u32>, texels: &mut Vec<u8>) -> Result<(), PostError> {
        let bytes = self.bytes.entry(output.to_owned()).or_default();
        if rows.start == self.first_row {
            bytes.clear();
        }
        bytes.append(texels);
        Ok(())
    }
}

/// A picture with edges, lights, and pixels that are no numbers.
fn scene(width: u32, height: u32) -> Picture {
    Picture::new(width, height, |x, y| {
        let (u, v) = (x as f32 / width as f32, y as f32 / height as f32);
        let light = if (x * 7 + y * 13) % 97 == 0 { 60.0 } else { 0.3 + u * v };
        match (x, y) {
            (5, _) if y % 11 == 3 => [f32::NAN, 0.2, 0.1, 1.0],
            (9, _) if y % 17 == 7 => [f32::INFINITY; 4],
            _ => [light * (0.4 + u), light * (0.6 + 0.4 * (40.0 * v).sin()), light * (1.2 - u), 1.0],
        }
    })
}

/// A picture that is rendered whole, to be compared with its bands.
struct Whole {
    name: String,
    session: Session,
    plan: Plan,
    inputs: Inputs,
    outputs: Vec<Texels>,
    filters: bool,
    _gpu: Shared,
}

impl Whole {
    fn new(name: &str, run: &Run<'_>, picture: &Picture) -> Result<Self, PostError> {
        let gpu = gpu();
        let mut session = run.session(&gpu);
        let texels = Texels::from_floats_as_half(picture.width, picture.height, &picture.pixels);
        let required: Vec<&str> =
            run.graph.inputs.iter().filter(|input| !input.optional).map(|input| input.name.as_str()).collect();
        let (mut images, mut inputs) = (Vec::new(), Inputs::default());
        for name in &required {
            images.push(session.feed(name, texels.desc, &texels.bytes)?);
            inputs.0.insert((*name).to_owned(), texels.clone());
        }
        session.restart();
        session.render(texels.desc.size, &images, FrameStep::FIRST)?;
        let given: Vec<_> = required.iter().map(|name| (*name, texels.desc)).collect();
        let plan = session.plan_in_bands(texels.desc.size, &given)?;
        let outputs = plan.outputs.iter().map(|output| session.output(&output.name)).collect::<Result<_, _>>()?;
        let (name, filters) = (name.to_owned(), gpu.is_processor());
        Ok(Self { name, session, plan, inputs, outputs, filters, _gpu: gpu })
    }

    /// Renders it in bands, and compares all bytes.
    fn compare(&mut self, limits: BandLimits) -> Result<BandStats, PostError> {
        let limits = BandLimits { filters: self.filters, ..limits };
        let first_row = limits.rows.map_or(0, |[first, _]| first);
        let mut outputs = Outputs { first_row, ..Outputs::default() };
        let files = (&mut self.inputs, &mut outputs);
        let made = self.session.render_in_bands(&self.plan, limits, FrameStep::FIRST, 0, &[], files)?;
        for (output, whole) in self.plan.outputs.iter().zip(&self.outputs) {
            let row = whole.bytes.len() / whole.desc.size.height as usize;
            let [first, end] = limits.rows.unwrap_or([0, whole.desc.size.height]).map(|row_number| row_number as usize);
            let (whole_bytes, banded) = (&whole.bytes[first * row..end * row], &outputs.bytes[&output.name]);
            assert_eq!(whole_bytes.len(), banded.len(), "{}: `{}` has other bytes", self.name, output.name);
            let differing = whole_bytes.chunks(row).zip(banded.chunks(row)).enumerate().filter(|(_, (a, b))| a != b);
            let rows: Vec<usize> = differing.map(|(row, _)| row).collect();
            let (name, output) = (&self.name, &output.name);
            assert!(rows.is_empty(), "{name}, {limits:?}, {made:?}: `{output}` differs in the rows {rows:?}");
        }
        Ok(made)
    }
}

/// Renders a picture whole and in bands, and compares all bytes.
fn compare(name: &str, run: &Run<'_>, picture: &Picture, limits: BandLimits) -> Result<BandStats, PostError> {
    Whole::new(name, run, picture)?.compare(limits)
}

const UNLIMITED: BandLimits = BandLimits {
    bytes: u64::MAX,
    taken: 0,
    block: 4 << 20,
    side: u32::MAX,
    filters: true,
    least: 1,
    parts: None,
    rows: None,
    host: HostLimits::NONE,
};

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn built_in_pipelines_have_the_same_bits_in_bands() {
    let is_chosen = |name: &str| sweep::is_whole() || ["exposure.ron", "lynx.ron"].contains(&name);
    for name in crate::pipelines::files().into_iter().filter(|name| is_chosen(name)) {
        let graph = built_in(&name, None);
        for (size, least, prefer_fragment) in
            [((157, 1023), 8, false), ((157, 1023), 3, true), ((61, 35), 64, false), ((1, 1), 1, false)]
        {
            let mut run = Run::new(&graph);
            run.prefer_fragment = prefer_fragment;
            let made = compare(&name, &run, &scene(size.0, size.1), BandLimits { least, ..UNLIMITED });
            let made = made.unwrap_or_else(|error| panic!("{name}: {error}"));
            assert!(made.bands as u32 >= least.min(size.1 / 16), "{name}: {made:?}");
        }
        let mut whole =
            Whole::new(&name, &Run::new(&graph), &scene(157, 1023)).unwrap_or_else(|error| panic!("{name}: {error}"));
        for (least, sizes, rows) in [(1, 1, 32), (5, 1, 1), (3, 2, 1), (2, 2, 100)] {
            let limits = BandLimits { least, parts: Some(Parts { sizes, rows }), ..UNLIMITED };
            let made = whole.compare(limits).unwrap_or_else(|error| panic!("{name}: {error}"));
            assert!(made.bands as u32 > least, "{name}: {made:?}");
        }
        let rows = BandLimits { rows: Some([411, 440]), ..UNLIMITED };
        whole.compare(rows).unwrap_or_else(|error| panic!("{name}: {error}"));
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn less_and_less_memory_makes_the_same_bits() {
    // Halvings by rows, taps of the device's filter, a kernel that reads the picture it has made, and two outputs.
    let text = r#"Pipeline(
        inputs: { "scene": Color },
        nodes: {
            "counted": Histogram(source: "scene"),
            "metered": AutoExposure(histogram: "counted"),
            "exposed": Exposure(source: "scene", meter: "metered"),
            "mips": Downsample(source: "exposed", levels: 6, filter: Tap13),
            "bloom": Upsample(source: "mips", blend: Add, filter: Tent),
            "lit": Composite(base: "exposed", bloom: "bloom", blend: Add, strength: 0.05, filter: Tent),
            "mapped": ToneMap(source: "lit"),
            "encoded": Encode(source: "mapped", transfer: Srgb),
            "sharp": Cas(source: "encoded"),
            "display": Dither(source: "sharp", bits: 8, format: Rgba8Unorm),
        },
        outputs: { "display": "display", "light": "lit" },
    )"#;
    let graph = graph(text);
    for row_downsample in [When::Never, When::Always] {
        let mut run = Run::new(&graph);
        run.options.row_downsample = row_downsample;
        let mut whole = Whole::new("bloom", &run, &scene(403, 1501)).unwrap_or_else(|error| panic!("{error}"));
        let mut bytes = u64::MAX;
        let mut limits = Vec::new();
        loop {
            match whole.compare(BandLimits { bytes, block: 0, ..UNLIMITED }) {
                Ok(made) => {
                    assert!(made.bytes <= bytes, "{made:?}");
                    limits.push(made.bytes);
                    bytes = made.bytes / 2;
                }
                Err(PostError::Plan(PlanError::TooMuchMemory { .. })) => break,
                Err(error) => panic!("{error}"),
            }
        }
        let [first, .., last] = limits[..] else { panic!("{limits:?}") };
        assert!(last * 3 < first, "{limits:?}");
    }
}

/// The most bytes that wgpu has taken from the device while something runs.
fn most_taken<T>(device: &wgpu::Device, run: impl FnOnce() -> T) -> (T, u64) {
    let taken = || device.generate_allocator_report().expect("Vulkan knows it").total_reserved_bytes;
    let ends = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let looking = scope.spawn(|| {
            let mut most = taken();
            while !ends.load(Ordering::Relaxed) {
                std::thread::sleep(Duration::from_micros(200));
                most = most.max(taken());
            }
            most
        });
        let made = run();
        ends.store(true, Ordering::Relaxed);
        (made, looking.join().expect("it only looks"))
    })
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn no_more_memory_is_taken_than_is_allowed() {
    let Picture { width, height, pixels } = scene(640, 1500);
    let texels = Texels::from_floats_as_half(width, height, &pixels);
    let (size, given) = (texels.desc.size, [("scene", texels.desc)]);
    for name in sweep::some(["tsushima.ron", "exposure.ron", "cinematic.ron", "hdr.ron"], 2) {
        let graph = built_in(name, None);
        let mut ways = BTreeSet::new();
        for mebibytes in [32, 56, 80, 256] {
            let max_memory = Some(mebibytes << 20);
            let opening =
                Opening { adapter: std::env::var("AFTERIMAGE_ADAPTER").ok(), max_memory, ..Opening::default() };
            let gpu = Shared::of(Gpu::open(&opening).unwrap_or_else(|error| panic!("{error}")));
            let mut session = Run::new(&graph).session(&gpu);
            let needs_bands = session.needs_bands(size, &given).unwrap_or_else(|error| panic!("{error}"));
            let (placed, most) = most_taken(&gpu.device, || {
                if !needs_bands {
                    let images = [session.feed("scene", texels.desc, &texels.bytes)?];
                    session.render(size, &images, FrameStep::FIRST)?;
                    session.feed("scene", texels.desc, &texels.bytes)?;
                    session.render(size, &images, FrameStep::FIRST)?;
                    let plan = session.plan().clone();
                    plan.outputs.iter().try_for_each(|output| session.output(&output.name).map(drop))?;
                    // Vulkan gives the heap of transient images itself.
                    return Ok(plan.memory.bytes(plan.options.alias));
                }
                let mut inputs = Inputs(BTreeMap::from([("scene".to_owned(), texels.clone())]));
                let (plan, limits) = (session.plan_in_bands(size, &given)?, gpu.band_limits());
                let files = (&mut inputs, &mut Outputs::default());
                let made = session.render_in_bands(&plan, limits, FrameStep::FIRST, 0, &[], files)?;
                assert!(made.bytes <= limits.bytes, "{name}: {made:?}");
                Ok(0)
            });
            match placed {
                Ok(placed) => {
                    let taken = most + placed;
                    assert!(taken <= mebibytes << 20, "{name}, in bands: {needs_bands}: {taken} of {mebibytes} MiB");
                    ways.insert(needs_bands);
                }
                Err(PostError::Plan(PlanError::TooMuchMemory { .. })) => {}
                Err(error) => panic!("{name}: {error}"),
            }
        }
        assert_eq!(ways.len(), 2, "{name} is rendered whole, and in bands");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn what_cannot_be_made_in_bands_is_told() {
    let gathers = "fn gathers(source: texture_2d<f32>, s: sampler, uv: vec2f) -> vec4f {
        return textureGather(0, source, s, uv);
    }";
    let module = BandedModule {
        entry: "compute",
        sizes: &[[64, 64]],
        stored: &[],
        workgroups: [1, 64, 1],
        rows: 1,
        first_counter: 0,
    };
    assert_eq!(banded(gathers, &module), Err("calls `textureGather`".to_owned()));
    let graph = built_in("tsushima.ron", None);
    let few = BandLimits { bytes: 1 << 20, ..UNLIMITED };
    let error = compare("tsushima", &Run::new(&graph), &scene(64, 64), few).expect_err("the table alone is larger");
    assert!(error.to_string().contains("may take at most 1.0 MiB"), "{error}");
}

/// The plan of a built-in pipeline for a picture of one gigapixel, on a graphics card.
fn gigapixel(name: &str) -> Plan {
    let graph = built_in(name, None);
    let size = Size::new(32768, 32768);
    let image = HostImageDesc { desc: ImageDesc::new(size), finite: false };
    let (storage, max_side) = (Format::ALL.into(), u32::MAX);
    let request = PlanRequest {
        given: HostInputs::all(size, graph.inputs.iter().filter(|input| !input.optional), image),
        facts: Facts::default(),
        caps: Caps { storage, max_side, fast_workgroup_memory: true, ..Caps::default() },
        options: Options { alias: Alias::None, ..Options::default() },
        dynamic: BTreeSet::new(),
        requirement: &Requirement::typical,
    };
    plan_without_tables(&graph, &request).unwrap_or_else(|error| panic!("{error}"))
}

/// Padding as that of NVIDIA, roughly: rows of 64 bytes by 8, up to 16 of these down.
fn padded(desc: &ImageDesc) -> Requirement {
    let row = (u64::from(desc.size.width) * desc.format.bytes()).next_multiple_of(64);
    let rows = u64::from(desc.size.height);
    let mut block = 128;
    while block > 8 && block / 2 >= rows {
        block /= 2;
    }
    let bytes = row * rows.next_multiple_of(block) * u64::from(desc.size.depth.max(1)) * u64::from(desc.layers.max(1));
    Requirement { bytes: bytes.next_multiple_of(1 << 16), alignment: 1 << 16 }
}

#[test]
fn a_gigapixel_fits_into_a_quarter_of_a_gibibyte() {
    // Those that a card's sampler filters are whole. 108 MiB are the driver's.
    let host = HostLimits { bytes: 1 << 30, decoded: 256, written: 1 };
    let limits = BandLimits { bytes: 256 << 20, taken: 108 << 20, side: 32768, filters: false, host, ..UNLIMITED };
    for name in ["tsushima.ron", "exposure.ron"] {
        let plan = gigapixel(name);
        let banding =
            plan.banding(limits, &Halos::default(), &padded).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(banding.bytes <= limits.bytes && banding.host_bytes <= host.bytes, "{name}");
        // Each output row is made once, from the top to the bottom.
        let made = banding.sweeps.iter().flat_map(|sweep| &sweep.bands).flat_map(|band| &band.outputs);
        let end = made.fold(0, |end, (_, rows)| {
            assert_eq!(rows.start, end, "{name}");
            rows.end
        });
        assert_eq!(end, 32768, "{name}");
    }
}
