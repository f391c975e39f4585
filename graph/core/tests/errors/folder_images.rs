//! Node kinds without Rust that have several passes: what works, and what is reported when an image is wrong.

use afterimage_graph::image::{Format, Size};
use afterimage_graph::node::{NodeKind, Recording, contract_with, folder_kind};

/// Calls `seen` with the recordings of a kind that keeps the contract.
fn recordings(kind: &NodeKind, mut seen: impl FnMut(&Recording)) {
    let mut seen = |recording: &Recording| {
        seen(recording);
        Vec::new()
    };
    contract_with(std::slice::from_ref(kind), &mut seen).unwrap_or_else(|violations| panic!("{violations:?}"));
}

pub(super) const DECLARATION: &str = r#"Kind(
    name: "Haze",
    doc: "Spreads light.",
    inputs: {
        "source": Image(doc: "Light."),
        "coarse": Pyramid(doc: "Other light.", optional: true),
    },
    images: {
        "across": Image(format: R16Float, size: Half),
        "levels": Pyramid(down: "across", levels: 3),
        "soft":   Pyramid(each: "levels", function: "haze_soft"),
        "wide":   Image(up: "soft", reads: { "other": Level("coarse", 2) }),
    },
    outputs: {
        "result": Image(doc: "Light.", state: Same("source")),
        "pile":   Pyramid(doc: "Levels.", state: Same("source"), each: "soft", function: "haze_pile"),
    },
)
"#;

pub(super) const SHADER: &str = "\
fn haze_across(source: texture_2d<f32>, at: Point) -> vec4f { return texel(source, at.pixel); }
fn haze_levels(across: texture_2d<f32>, at: Point) -> vec4f { return texel(across, 2 * at.pixel); }
fn haze_soft(levels: vec4f) -> vec4f { return levels; }
fn haze_wide(soft: vec4f, coarser: texture_2d<f32>, other: texture_2d<f32>, at: Point) -> vec4f {
    return soft + texel(coarser, at.pixel / 2) + texel(other, at.pixel);
}
fn haze(source: vec4f, wide: texture_2d<f32>, at: Point) -> vec4f { return source + texel(wide, at.pixel / 4); }
fn haze_pile(soft: vec4f) -> vec4f { return soft; }
";

fn kind(declaration: &str, shader: &str) -> NodeKind {
    folder_kind(("node.ron", declaration), ("haze.wgsl", shader)).unwrap_or_else(|reported| panic!("{reported}"))
}

/// The label, the size and the format of each image that the passes write, for an image of 64x36.
fn written(recording: &Recording) -> Vec<(String, Size, Format)> {
    let images = recording.passes.iter().flat_map(|pass| pass.writes()).filter_map(|written| written.image());
    let images = images.map(|image| recording.image(image));
    images.map(|image| (image.label.clone(), image.desc.size, image.desc.format)).collect()
}

#[test]
fn functions_are_called_for_images_and_levels_in_the_order_of_the_declaration() {
    let mut first = None;
    recordings(&kind(DECLARATION, SHADER), |recording| {
        first.get_or_insert_with(|| written(recording));
    });
    let (half, full) = (Format::Rgba16Float, Size::new(64, 36));
    let [a, b, c] = [full.half().half(), full.half().half().half(), full.half().half().half().half()];
    let level = |name: &str, size| (format!("node.{name}"), size, half);
    let mut wanted = vec![(String::from("node.across"), full.half(), Format::R16Float)];
    wanted.extend([level("levels.0", a), level("levels.1", b), level("levels.2", c)]);
    wanted.extend([level("soft.0", a), level("soft.1", b), level("soft.2", c)]);
    wanted.extend([level("wide.1", b), level("wide.0", a), level("result", full)]);
    wanted.extend([level("pile.0", a), level("pile.1", b), level("pile.2", c)]);
    assert_eq!(first.expect("it records"), wanted);
}

fn reported(declaration: &str, shader: &str) -> String {
    let kind = folder_kind(("node.ron", declaration), ("haze.wgsl", shader));
    kind.map_or_else(|reported| reported.to_string(), |_| panic!("it is accepted:\n{declaration}{shader}"))
}

#[test]
fn mistakes_in_images_are_reported_at_their_places() {
    for (from, to, message, location) in [
        ("\"across\": Image", "\"Across\": Image", "`Across` is not a valid name of an image", "node.ron:9:9"),
        ("\"across\": Image", "\"source\": Image", "the name `source` is given twice", "node.ron:9:9"),
        (
            "\"across\": Image(format",
            "\"across\": Volume(format",
            "no type of image is called `Volume`",
            "node.ron:9:19",
        ),
        ("R16Float", "R17Float", "no format is called `R17Float`", "node.ron:9:33"),
        ("levels: 3", "levels: 17", "`levels` is a whole number from 1 to 16", "node.ron:10:51"),
        ("down: \"across\", ", "", "an image needs `down`", "node.ron:10:19"),
        ("down: \"across\"", "down: \"acros\"", "nothing before this one is called `acros`", "node.ron:10:33"),
        ("down: \"across\"", "down: \"wide\"", "nothing before this one is called `wide`", "node.ron:10:33"),
        ("down: \"across\"", "down: \"coarse\"", "`coarse` is a Pyramid, and not one of `Image`", "node.ron:10:33"),
        ("each: \"levels\"", "each: \"across\"", "`across` is a Image, and not one of `Pyramid`", "node.ron:11:33"),
        ("up: \"soft\"", "up: \"soft\", size: Half", "an image has no field `size`", "node.ron:12:37"),
        ("Level(\"coarse\", 2)", "Level(\"coarse\")", "`reads` is a map of names", "node.ron:12:55"),
        (
            "Level(\"coarse\", 2)",
            "Level(\"source\", 2)",
            "`source` is a Image, and not one of `Pyramid`",
            "node.ron:12:61",
        ),
        ("\"other\": Level", "\"another\": Level", "`haze_wide` has no argument `another`", "node.ron:12:46"),
        (
            "\"soft\":   P",
            "\"idle\": Image(function: \"haze_across\"), \"soft\":   P",
            "the image `idle`",
            "node.ron:11:9",
        ),
    ] {
        let reported = reported(&DECLARATION.replacen(from, to, 1), SHADER);
        assert!(reported.contains(message) && reported.contains(location), "{from} -> {to}:\n{reported}");
    }
}

#[test]
fn mistakes_in_what_functions_read_are_reported_at_their_places() {
    for (from, to, message, location) in [
        ("fn haze_levels", "fn haze_level", "the shader has no function `haze_levels`", "node.ron:10:9"),
        (
            "(soft: vec4f, c",
            "(sofd: vec4f, soft: vec4f, c",
            "the argument `sofd` is not an input of the node, nor an image made before it",
            "haze.wgsl:4:14",
        ),
        (
            "(across: texture_2d<f32>, at",
            "(wide: texture_2d<f32>, across: texture_2d<f32>, at",
            "the argument `wide` is not an input of the node, nor an image made before it",
            "haze.wgsl:2:16",
        ),
        (
            "haze_pile(soft: vec4f",
            "haze_pile(wide: vec4f, soft: vec4f",
            "the argument `wide` is a pixel of an image that may have another size",
            "haze.wgsl:8:14",
        ),
        (
            "wide: texture_2d<f32>, at: Point) -> vec4f { return source +",
            "wide: texture_2d<f32>, levels: texture_2d<f32>, at: Point) -> vec4f { return source +",
            "the argument `levels` is a Pyramid and needs the type of a level",
            "haze.wgsl:7:47",
        ),
    ] {
        let reported = reported(DECLARATION, &SHADER.replacen(from, to, 1));
        assert!(reported.contains(message) && reported.contains(location), "{from} -> {to}:\n{reported}");
    }
}

#[test]
fn a_pixel_of_another_size_is_an_error_also_for_outputs() {
    let half = DECLARATION.replace("state: Same(\"source\"))", "state: Same(\"source\"), size: Half)");
    let reported = reported(&half, SHADER);
    assert!(reported.contains("the argument `source` is a pixel of an image that may have another size"), "{reported}");
}

/// A pixel is one of an image of the result's size, whatever made it.
#[test]
fn a_pixel_of_an_image_of_the_same_size_is_none_of_another() {
    let declared = |made: &str, read: &str| {
        format!(
            r#"Kind(name: "Haze", doc: "Reads.", inputs: {{ "source": Image(doc: "Light.") }},
            images: {{ "one": Image({made}) }},
            outputs: {{ "result": Image(doc: "Light.", state: Same("source"){read}) }})"#
        )
    };
    let shader = "fn haze_one(source: texture_2d<f32>, at: Point) -> vec4f { return texel(source, at.pixel); }
        fn haze(one: vec4f) -> vec4f { return one; }";
    for (made, read, fits) in [
        ("", "", true),
        ("size: Half", ", size: Half", true),
        ("size: Fixed(64, 32)", ", size: Fixed(64, 32)", true),
        ("size: Half", "", false),
        ("", ", size: Half", false),
        ("size: Double", ", size: Half", false),
        ("size: Fixed(64, 32)", ", size: Fixed(64, 33)", false),
    ] {
        let kind = folder_kind(("node.ron", &declared(made, read)), ("haze.wgsl", shader));
        assert_eq!(kind.is_ok(), fits, "{made}{read}: {:?}", kind.err().map(|errors| errors.to_string()));
    }
}

/// A camera is taken in the struct of the library, or in one with all its members.
#[test]
fn a_block_has_the_members_of_its_struct() {
    let declaration = r#"Kind(name: "Haze", doc: "Reads.",
        inputs: { "source": Image(doc: "Light."), "eye": Camera(doc: "The camera.") },
        outputs: { "result": Image(doc: "Light.", state: Same("source")) })"#;
    let matrices = "view: mat4x4f, projection: mat4x4f, inverse_view: mat4x4f, inverse_projection: mat4x4f, \
        previous_view: mat4x4f, previous_projection: mat4x4f, jitter: vec2f, previous_jitter: vec2f";
    let shader = |members: &str| {
        format!("struct Eye {{ {members} }}\nfn haze(source: vec4f, eye: Eye) -> vec4f {{ return eye.view * source; }}")
    };
    let reported = |shader: &str| folder_kind(("node.ron", declaration), ("haze.wgsl", shader)).err();
    assert!(reported(&shader(matrices)).is_none());
    let library = "import afterimage::camera::Camera;
        fn haze(source: vec4f, eye: Camera) -> vec4f { return eye.view * source; }";
    assert!(reported(library).is_none());
    for (from, to) in [
        (", previous_jitter: vec2f", ""),
        ("previous_jitter: vec2f", "previous_jitter: vec2f, more: f32"),
        ("previous_jitter: vec2f", "previous_jitter: vec2i"),
        ("previous_jitter: vec2f", "previous_jitter: f32"),
        ("jitter: vec2f", "jitter: vec3f"),
        ("projection: mat4x4f", "projection: vec4f"),
        ("inverse_view: mat4x4f", "inverse_view: mat4x3f"),
        ("inverse_view: mat4x4f", "inverse_view: mat2x2f"),
        ("jitter: vec2f", "@size(16) jitter: vec2f"),
        ("projection: mat4x4f", "projektion: mat4x4f"),
        ("view: mat4x4f, projection: mat4x4f", "projection: mat4x4f, view: mat4x4f"),
    ] {
        let errors = reported(&shader(&matrices.replacen(from, to, 1))).expect("it is another struct").to_string();
        let message = "the type of `eye` has not the members of the block `Camera`";
        assert!(errors.contains(message) && errors.contains("haze.wgsl:2:24"), "{from} -> {to}:\n{errors}");
    }
    let no_struct = "fn haze(source: vec4f, eye: vec4f) -> vec4f { return eye * source; }";
    let errors = reported(no_struct).expect("a block is a struct").to_string();
    assert!(errors.contains("the argument `eye` is a Block and needs the type of the struct"), "{errors}");
}

#[test]
fn images_and_textures_are_limited() {
    let images: String = (0..9).map(|at| format!("\"i{at}\": Image(function: \"haze_across\"), ")).collect();
    let many = DECLARATION.replace("images: {", &format!("images: {{ {images}"));
    assert!(reported(&many, SHADER).contains("too many images of a kind: the limit is 8"));
    let names: Vec<String> = (0..13).map(|at| format!("t{at}")).collect();
    let reads: String = names.iter().map(|name| format!("\"{name}\": \"source\", ")).collect();
    let args: String = names.iter().map(|name| format!("{name}: texture_2d<f32>, ")).collect();
    let declaration = DECLARATION.replace("size: Half)", &format!("size: Half, reads: {{ {reads} }})"));
    let shader = SHADER.replace("haze_across(", &format!("haze_across({args}"));
    assert!(reported(&declaration, &shader).contains("too many textures that a function reads: the limit is 12"));
}

#[test]
fn a_table_is_a_texture_also_under_another_name() {
    let counts = |ty: &str, arg: &str| {
        let declaration = format!(
            r#"Kind(
                name: "Haze", doc: "Reads.",
                inputs: {{ "counts": Table(doc: "Counts.", content: "counts") }},
                outputs: {{
                    "result": Image(doc: "One.", state: Data, size: Fixed(4, 1), reads: {{ "{arg}": "counts" }}),
                }},
            )"#
        );
        let shader = format!(
            "import afterimage::table;\nfn haze({arg}: {ty}, at: Point) -> vec4f {{ return vec4f(at.uv, 0.0, 1.0); }}"
        );
        (declaration, shader)
    };
    let (declaration, shader) = counts("texture_2d<f32>", "words");
    let mut labels = Vec::new();
    recordings(&kind(&declaration, &shader), |recording| {
        labels = recording.passes.iter().map(|pass| pass.label.clone()).collect();
    });
    assert_eq!(labels, ["table_words", "haze"]);
    let (declaration, shader) = counts("vec4f", "words");
    assert!(
        reported(&declaration, &shader)
            .contains("the argument `words` is a Table and needs the type `texture_2d<f32>`")
    );
}

#[test]
fn no_cut_makes_it_panic() {
    for cut in (0..DECLARATION.len() - 2).filter(|cut| cut % 5 == 0) {
        reported(&DECLARATION[..cut], SHADER);
    }
}
