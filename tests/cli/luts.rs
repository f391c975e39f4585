//! `lut`: a look leaves as a table, with its error.

use afterimage_media::{Picture, Pixels};

use super::{Folder, save_exact};

const LOOK: &str = r#"Pipeline(
    inputs: { "scene": Color, "mask": Data },
    nodes: {
        "bins": Histogram(source: "scene"),
        "meter": AutoExposure(histogram: "bins"),
        "exposed": Exposure(source: "scene", meter: "meter", stops: -1.0),
        "glow": Gaussian(source: "exposed", sigma: 3.0),
        "vignette": Vignette(source: "glow", amount: 0.0),
        "vivid": Saturation(source: "vignette", amount: 1.2),
        "mapped": ToneMap(source: "vivid"),
        "display": Encode(source: "mapped", transfer: Srgb),
        "noise": Dither(source: "display", bits: 8),
        "made": DemoScene(),
    },
    outputs: { "display": "noise", "light": "vivid", "mask": "mask", "other": "made" },
)"#;

/// The nodes of the table of [`LOOK`].
const COLORS: &str = r#"Pipeline(
    inputs: { "scene": Color },
    nodes: {
        "exposed": Exposure(source: "scene", stops: -1.0),
        "vivid": Saturation(source: "exposed", amount: 1.2),
        "mapped": ToneMap(source: "vivid"),
        "display": Encode(source: "mapped", transfer: Srgb),
    },
    outputs: { "display": "display" },
)"#;

/// The node that reads a table.
fn node(file: &str, from: &str) -> String {
    format!("ColorLut(source: \"exposed\", file: \"{file}\", from: {from}, to: Srgb, state: Encoded)")
}

/// A pipeline of a table alone.
fn reading(file: &str, from: &str) -> String {
    let node = node(file, from);
    format!(
        "Pipeline(inputs: {{ \"scene\": Color }}, outputs: {{ \"display\": \"look\" }}, \
         nodes: {{ \"exposed\": Exposure(source: \"scene\"), \"look\": {node} }})"
    )
}

/// Light from 2^-12 to 2^5 in many hues, and grays.
fn lights(folder: &Folder) {
    let mut pixels = Vec::new();
    for index in 0..4096_u32 {
        let share = |factor: u32| f64::from(index.wrapping_mul(factor) % 4093) / 4093.0;
        let level = (17.0 * share(1) - 12.0).exp2();
        let hue = if index % 8 == 0 { [1.0; 3] } else { [share(577), share(1361), share(2851)] };
        pixels.extend(hue.map(|channel| (level * channel) as f32).into_iter().chain([1.0]));
    }
    save_exact(&folder.file("in.exr"), &Picture::new(64, 64, Pixels::Float(pixels)));
}

/// The codes of a PNG of 16 bits, in codes of 8 bits.
fn codes(folder: &Folder, name: &str) -> Vec<f64> {
    let reader = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(folder.file(name)).expect("a picture")));
    let mut reader = reader.read_info().expect("a picture");
    let mut bytes = vec![0; reader.output_buffer_size().expect("a small picture")];
    reader.next_frame(&mut bytes).expect("a picture");
    bytes.as_chunks::<2>().0.iter().map(|code| f64::from(u16::from_be_bytes(*code)) / 257.0).collect()
}

/// The largest error that was printed.
fn stated(printed: &str) -> f64 {
    printed.trim_end().rsplit(' ').next().and_then(|word| word.parse().ok()).unwrap_or_else(|| panic!("{printed}"))
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_table_shows_what_its_nodes_show_within_its_error() {
    let folder = Folder::new("luts");
    lights(&folder);
    folder.with("look.ron", LOOK.as_bytes());
    folder.with("colors.ron", COLORS.as_bytes());
    folder.run("render colors.ron in.exr -o nodes.png --depth 16").good();
    let nodes = codes(&folder, "nodes.png");
    for (file, from, options) in [
        ("log.cube", "LogC3", ""),
        ("log.clf", "LogC3", " --size 17"),
        ("linear.cube", "LinearRec709", " --shaper"),
        ("wide.clf", "AcesCg", " --shaper=5 --size 65"),
    ] {
        let run = folder.run(&format!("lut look.ron -o {file} --from {from}{options}"));
        let (printed, notes) = (run.out.clone(), run.err.clone());
        let error = stated(&run.good());
        assert!(error < 60.0, "{printed}");
        let size = options.split("--size ").nth(1).unwrap_or("33");
        assert!(printed.starts_with(&format!("{file}: {size} entries a side, from {from} to Srgb, of ")), "{printed}");
        let table = std::fs::read_to_string(folder.file(file)).expect("it is written");
        let has = |words: &str| table.contains(words);
        let sides = [format!("LUT_3D_SIZE {size}\n"), format!("dim=\"{size} {size} {size} 3\"")];
        assert!(
            sides.iter().any(|side| has(side))
                && ["TITLE \"look\"", "# look\n", "name=\"look\""].iter().any(|title| has(title)),
            "{file}"
        );
        let errors: Vec<f64> = ["99 % of colors at most ", "99.9 % at most ", "finds is "]
            .map(|words| printed.split(words).nth(1).and_then(|rest| rest.split([',', ';', '\n']).next()))
            .map(|number| number.and_then(|number| number.parse().ok()).expect("a number"))
            .into();
        assert!(printed.contains("error in codes of 8 bits: ") && errors.is_sorted(), "{printed}");
        assert!(printed.contains("`exposed`, `vivid`, `mapped`, `display`"), "{printed}");
        assert!(notes.contains(&node(file, from)), "{notes}");
        assert!(notes.contains("`bins` (Histogram), `meter` (AutoExposure), `glow` (Gaussian)"), "{notes}");
        assert!(!notes.contains("vignette"), "it changes nothing: {notes}");
        folder.with("read.ron", reading(file, from).as_bytes());
        folder.run("render read.ron in.exr -o read.png --depth 16").good();
        let pairs = codes(&folder, "read.png").into_iter().zip(&nodes);
        let found = pairs.map(|(read, exact)| (read - exact).abs()).fold(0.0, f64::max);
        // Half a code of 16 bits in each picture.
        assert!(found <= error + 0.004 && found > 0.05, "{file}: {found}, and {error} was stated");
    }
    let printed = folder.run("lut look.ron -o light.cube --from LogC3 --output light").good();
    assert!(printed.contains("from LogC3 to LinearRec709, of `exposed`, `vivid`"), "{printed}");
    assert!(printed.contains("error in units of its results: "), "{printed}");
    let before = folder.names();
    for (words, error) in [
        ("-o a.3dl --from LogC3", "error: `a.3dl`: a table is a `.cube` or a `.clf` file"),
        ("-o a.cube --from Srgb --shaper", "error: `--shaper` is for linear colors, and Srgb has a curve"),
        ("-o a.cube --from LogC3 --output mask", "error: the output `mask` is made from `mask`, which is data"),
        (
            "-o a.cube --from LogC3 --output other",
            "error: `made` (DemoScene) makes an image of its own, which no table",
        ),
        ("-o a.cube --from LogC3 --output x", "error: the pipeline has no output `x`"),
        ("-o look.ron/a.cube --from LogC3", "error: look.ron/a.cube: "),
    ] {
        folder.run(&format!("lut look.ron {words}")).fails_saying(1, &[error]);
    }
    assert_eq!(folder.names(), before);
}
