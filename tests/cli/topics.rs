//! `nodes`: kinds are found by words of the field, and each page has a line to copy.

use afterimage_graph::document::parse;

use super::Folder;

#[test]
fn kinds_are_found_by_topics() {
    let folder = Folder::new("topics");
    for (words, kinds) in [
        ("bloom", &["Extract", "Composite"][..]),
        ("glow", &["Extract", "Composite"]),
        ("anti-aliasing", &["Fxaa", "Smaa", "Taa"]),
        ("ambient occlusion", &["Gtao", "Ssao"]),
        ("ao", &["Gtao", "Ssao"]),
        ("night", &["Purkinje"]),
        ("flare", &["LensFlare"]),
        ("grading", &["Cdl", "ColorLut"]),
        ("shadow", &["ShadowMask", "SplitToning"]),
        ("tonemapping", &["ToneMap"]),
        ("mips", &["Downsample", "Upsample"]),
        ("noise", &["Denoise", "Dither"]),
        ("mask", &["LumaKey", "ColorKey"]),
        ("saturation", &["Saturation"]),
    ] {
        let listed = folder.run(&format!("nodes {words}")).good();
        for kind in kinds {
            assert!(
                listed.lines().any(|line| line.split(' ').next() == Some(kind)),
                "{words}: {kind} is not in\n{listed}"
            );
        }
    }
}

/// A topic of one kind is explained at once.
#[test]
fn every_word_of_a_user_leads_to_a_page() {
    let folder = Folder::new("words");
    for (words, kind) in [
        ("dof", "DepthOfField"),
        ("bokeh", "DepthOfField"),
        ("depth of field", "DepthOfField"),
        ("lut", "ColorLut"),
        ("grain", "FilmGrain"),
        ("fisheye", "LensDistortion"),
        ("velocity", "MotionBlur"),
        ("crop", "Transform"),
        ("upscale", "Fsr1"),
        ("fireflies", "Extract"),
        ("lightshafts", "GodRays"),
        ("eye adaptation", "Adapt"),
        ("resize", "Transform"),
        ("posterize", "OrderedDither"),
        ("msaa", "Resolve"),
        ("bw", "Saturation"),
        ("tilt-shift", "VariableBlur"),
        ("miniature", "VariableBlur"),
        ("zoom blur", "RadialBlur"),
        ("vibrance", "SaturationCurves"),
        ("paint", "Kuwahara"),
        ("comic", "Newsprint"),
        ("halftone", "Newsprint"),
        ("duotone", "GradientMap"),
        ("star", "Streaks"),
        ("clarity", "LocalToneMap"),
        ("warmer", "WhiteBalance"),
        ("brighter", "Exposure"),
        ("dark corners", "Vignette"),
        ("blurry background", "DepthOfField"),
        ("black and white", "Saturation"),
        ("sepia", "GradientMap"),
        ("old movie", "FilmGrain"),
    ] {
        let told = folder.run(&format!("nodes {words}")).good();
        assert!(told.contains(kind), "{words}:\n{told}");
    }
}

#[test]
fn each_page_has_a_node_to_copy() {
    let folder = Folder::new("copy");
    for kind in afterimage_nodes::ALL {
        let page = folder.run(&format!("nodes {}", kind.name())).good();
        let line = page.split_once("In a pipeline\n").expect("the last heading").1.trim();
        let text = format!("Pipeline(inputs: {{}}, nodes: {{ {line} }}, outputs: {{ \"a\": \"name\" }})");
        let document = parse("copied.ron", &text).unwrap_or_else(|errors| panic!("{errors}"));
        assert_eq!(document.nodes[0].kind.value, kind.name());
        let part = |from: &str, to: &str| {
            let (_, rest) = page.split_once(&format!("\n{from}\n")).expect("a heading");
            rest.split_once(&format!("\n{to}\n")).expect("the next heading").0
        };
        // Names stand at the beginning of a line; under a heading without any is that there are none.
        let named = |part: &str| -> Vec<String> {
            let lines = part.lines().filter_map(|line| line.strip_prefix("  ")).filter(|line| !line.starts_with(' '));
            lines.filter_map(|line| line.split_once(": ")).map(|(name, _)| name.to_owned()).collect()
        };
        let names = |names: &mut dyn Iterator<Item = &str>| names.map(str::to_owned).collect::<Vec<_>>();
        let inputs = names(&mut kind.inputs().iter().map(|port| &*port.name));
        let (of_inputs, of_params) = (part("Inputs", "Outputs"), part("Parameters", "When it is off"));
        match inputs.as_slice() {
            [] => assert_eq!(of_inputs.trim(), "none: it makes its picture from nothing"),
            _ => assert_eq!(named(of_inputs), inputs, "{page}"),
        }
        assert_eq!(named(part("Outputs", "Parameters")), names(&mut kind.outputs().iter().map(|port| &*port.name)));
        let params = names(&mut kind.params().iter().map(|param| &*param.name));
        assert!(named(of_params) == params && (of_params.trim() == "none") == params.is_empty(), "{page}");
        let is_short = |line: &str| !line.starts_with("      ") || line.chars().count() <= 100;
        assert!(page.lines().all(is_short), "{page}");
    }
}
