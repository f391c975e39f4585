//! `nodes`: kinds are found by words of the field, and each page has a line to copy.

use afterimage_graph::document::parse;
use afterimage_graph::node::Fallback;

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
        for param in kind.params() {
            let facts = of_params.lines().find_map(|line| line.strip_prefix(&format!("  {}: ", param.name)));
            let facts: Vec<&str> = facts.expect("its line").split("; ").collect();
            let told = |fact: &str| facts.contains(&fact);
            assert_eq!(facts[0], format!("default {}", param.default), "{page}");
            assert!(told("a change needs a new plan") == param.replan, "{}: {page}", param.name);
            assert!(told("can change in every frame") != param.replan, "{}: {page}", param.name);
            assert!(told("trades accuracy for speed") == param.quality.is_some(), "{}: {page}", param.name);
            let unit = if param.unit.is_empty() { String::new() } else { format!(" {}", param.unit) };
            let range = param.domain.map(|(least, most)| format!("from {least} to {most}{unit}"));
            assert!(range.is_none_or(|range| told(&range)), "{}: {page}", param.name);
            assert!(param.neutral.as_ref().is_none_or(|value| told(&format!("neutral at {value}"))), "{page}");
        }
        for port in kind.inputs() {
            let line = of_inputs.lines().find(|line| line.starts_with(&format!("  {}: ", port.name)));
            assert_eq!(line.expect("its line").ends_with(", optional"), port.optional, "{page}");
        }
        for port in kind.outputs() {
            let off = match &port.fallback {
                Fallback::Input(input) => format!("  {} is the input `{input}`", port.name),
                Fallback::Zero => format!("  {} is black", port.name),
                Fallback::Absent => format!("  {} is absent, and what needs it is off too", port.name),
            };
            let told = page.split_once("\nWhen it is off\n").expect("a heading").1;
            assert!(told.lines().any(|line| line == off), "{off}: {page}");
        }
        let is_short = |line: &str| !line.starts_with("      ") || line.chars().count() <= 100;
        assert!(page.lines().all(is_short), "{page}");
    }
}

#[test]
fn the_list_has_each_kind_with_its_first_words() {
    let folder = Folder::new("kinds");
    let list = folder.run("nodes").good();
    for kind in afterimage_nodes::ALL {
        let lines = || list.lines().filter(|line| line.split(' ').next() == Some(kind.name()));
        let words: Vec<&str> = lines().flat_map(str::split_whitespace).skip(1).take(4).collect();
        let doc: Vec<&str> = kind.doc().split_whitespace().take(words.len()).collect();
        assert!(lines().count() == 1 && words.len() == 4 && words == doc, "{}: {words:?}", kind.name());
    }
    assert_eq!(folder.run("nodes tonemap").good(), folder.run("nodes ToneMap").good(), "letters may be small");
    folder.run("nodes vignettte").fails_saying(1, &["did you mean `Vignette`?"]);
    folder.run("nodes histogrm").fails_saying(1, &["did you mean `Histogram`?"]);
}
