//! OcioTransform: views and looks of an OpenColorIO config.

use std::path::{Component, Path};
use std::sync::{Arc, Mutex};

use afterimage_graph::color::{Chromaticities, Colorimetry, GRAPHICS_WHITE, Transfer};
use afterimage_graph::diagnostic::did_you_mean;
use afterimage_graph::image::Signedness;
use afterimage_graph::prelude::*;
use ocio::{
    ColorSpaceTransform, Config, DisplayViewTransform, FileTransform, GroupTransform, LookTransform, Transform,
    TransformDirection,
};

use super::config::{REC709, config, locked, no_space, noted, sentence};
use super::function::Function;

choices! {
    /// What the result is.
    pub enum OcioResult {
        /// The signal of a display, by a view.
        Encoded,
        /// Light as the image is, by looks or a file.
        Source,
    }
}

choices! {
    /// What the numbers of a display are, which labels the file.
    pub enum OcioEncoding {
        /// What the config states by `interop_id`, or by a display that is called as one of the built-in configs.
        Config,
        /// sRGB.
        Srgb,
        /// Display P3.
        DisplayP3,
        /// A power of 2.2, Rec.709.
        Gamma22,
        /// A power of 2.4, Rec.709.
        Gamma24,
        /// A power of 2.6, P3 with D65.
        Gamma26P3,
        /// The perceptual quantizer, Rec.2020.
        Pq,
        /// Hybrid log-gamma, Rec.2020.
        Hlg,
    }
}

node_kind! {
    /// Applies a view, looks or a file of an OpenColorIO config, which `--ocio` names.
    ///
    /// The transform is computed for each pixel, in 32 bits, by the functions that OpenColorIO writes for graphics
    /// cards; nothing is baked into a table. The image enters as linear Rec.709, which the config finds by its role
    /// `aces_interchange`. A view takes the place of `ToneMap` and `Encode`. Looks come before it, in place of its own.
    /// Transforms with dynamic properties are refused.
    pub struct OcioTransform {
        /// The display, as the config calls it. Empty for the first one.
        pub display: Arc<str> = Arc::from("");
        /// The view. Empty for the first one of the display.
        pub view: Arc<str> = Arc::from("");
        /// Looks, as in a config: `first, +second, -third`, where a minus undoes a look.
        pub looks: Arc<str> = Arc::from("");
        /// A file that the config finds in its search path: `.3dl`, `.csp`, `.ctf`, `.lut` and others. It comes first.
        /// For a built-in config the path is the current folder.
        pub file: Arc<str> = Arc::from("");
        /// The color space of the config that `file` is made for.
        pub space: Arc<str> = Arc::from("");
        /// What the result is.
        pub state: OcioResult = OcioResult::Encoded;
        /// What the numbers of the display are.
        pub encoding: OcioEncoding = OcioEncoding::Config;
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "Exposed light.").accepts(&[ColorState::Exposed])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::chosen("state"), "The signal of the display, or the graded light.")
            .or_input("source")];
    const INVARIANTS: Invariants = Invariants::OF_COLOR;
}

impl Node for OcioTransform {
    fn is_identity(&self, _: &InputValues) -> bool {
        self.state == OcioResult::Source && self.looks.is_empty() && self.file.is_empty()
    }

    fn verify(&self) -> Result<(), String> {
        if self.state == OcioResult::Source && !(self.display.is_empty() && self.view.is_empty()) {
            return Err("a view makes the signal of a display: remove `state: Source`, or `display` and `view`".into());
        }
        if self.file.is_empty() != self.space.is_empty() {
            return Err("`file` and `space` belong together: the space is the one that the file is made for".into());
        }
        self.function()?;
        self.colorimetry().map(|_| ())
    }

    fn color(&self) -> ColorChange {
        match self.state {
            OcioResult::Source => ColorChange::Keep,
            // `verify` has refused a display whose numbers are not known.
            OcioResult::Encoded => self.colorimetry().map_or(ColorChange::Keep, ColorChange::Encode),
        }
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        debug_assert_eq!(pass.color("source").state.signedness(), Signedness::Extended, "exposed light is signed");
        let function = self.function().expect("`verify` has made it");
        let mut kernel = pass.function(function.shader.clone(), Function::NAME);
        for table in &function.tables {
            kernel = kernel.read_constant(table.argument.clone(), "table", table.desc, table.bytes.clone());
        }
        kernel.write("result", desc);
    }
}

/// The functions that were made last: a node is recorded more often than it changes.
static KNOWN: Mutex<Vec<(OcioTransform, Arc<Function>)>> = Mutex::new(Vec::new());

/// The most functions that are kept.
const MOST: usize = 16;

/// Forgets the functions: another config makes others.
pub(super) fn forget() {
    locked(&KNOWN).clear();
}

impl OcioTransform {
    fn function(&self) -> Result<Arc<Function>, String> {
        if let Some((_, function)) = locked(&KNOWN).iter().find(|(node, _)| node == self) {
            return Ok(function.clone());
        }
        let config = config()?;
        let result = match self.state {
            OcioResult::Encoded => "clamp(v, vec3f(0.0), vec3f(1.0))",
            OcioResult::Source => "bounded_scene(v)",
        };
        let transform = Transform::Group(self.transform(&config)?);
        let processor = noted(config.get_processor_for_transform(&transform, TransformDirection::Forward))?;
        let function = Arc::new(Function::new(&processor, result)?);
        let mut known = locked(&KNOWN);
        if known.len() == MOST {
            known.remove(0);
        }
        known.push((self.clone(), function.clone()));
        Ok(function)
    }

    /// Linear Rec.709 to the result.
    fn transform(&self, config: &Config) -> Result<GroupTransform, String> {
        let scene = ["aces_interchange", "scene_linear"].into_iter().find(|role| config.has_role(role));
        let scene = scene.ok_or(
            "the config does not state where Rec.709 lies: add `aces_interchange: ACES2065-1` to its roles, or what it \
             calls that space",
        )?;
        let enter = Config::get_processor_from_builtin_color_space(REC709, config, scene);
        let mut steps = enter.map_err(|error| sentence(&error))?.create_group_transform();
        if !self.file.is_empty() {
            self.check_file(config)?;
            steps.append(ColorSpaceTransform::new(scene, &self.space));
            steps.append(FileTransform::new(&self.file));
            steps.append(ColorSpaceTransform::new(&self.space, scene));
        }
        if !self.looks.is_empty() {
            self.check_looks(config)?;
            steps.append(LookTransform::new(scene, scene, &self.looks));
        }
        match self.state {
            OcioResult::Encoded => {
                let (display, view) = self.view(config)?;
                let mut shown = DisplayViewTransform::new(scene, &display, &view);
                shown.looks_bypass = !self.looks.is_empty();
                steps.append(shown);
            }
            OcioResult::Source => {
                let leave = Config::get_processor_to_builtin_color_space(config, scene, REC709);
                steps.append(leave.map_err(|error| sentence(&error))?.create_group_transform());
            }
        }
        Ok(steps)
    }

    /// A pipeline may come from others: of all files it may name those for which the config has folders.
    fn check_file(&self, config: &Config) -> Result<(), String> {
        let file = config.current_context().resolve_string_var(&self.file);
        if Path::new(&file).components().any(|part| !matches!(part, Component::Normal(_) | Component::CurDir)) {
            return Err(format!(
                "`{file}` is not below a folder of the config: add its folder to `search_path` there, and give its name"
            ));
        }
        let space = config.current_context().resolve_string_var(&self.space);
        if config.canonical_name(&space).is_empty() {
            return Err(no_space(config, &space, &[]));
        }
        Ok(())
    }

    /// The display and the view that are meant.
    fn view(&self, config: &Config) -> Result<(String, String), String> {
        let displays: Vec<String> = (0..config.num_displays()).map(|at| config.display(at)).collect();
        let display = chosen("display", &self.display, &displays, || config.default_display())?;
        let views: Vec<String> = (0..config.num_views(&display)).map(|at| config.view(&display, at)).collect();
        let view = chosen("view", &self.view, &views, || config.default_view(&display))?;
        Ok((display, view))
    }

    fn check_looks(&self, config: &Config) -> Result<(), String> {
        let looks: Vec<String> = (0..config.num_looks()).map(|at| config.look_name_by_index(at).to_owned()).collect();
        for look in self.looks.split([',', ':', '|']) {
            let name = look.trim().trim_start_matches(['+', '-']).trim();
            chosen("look", name, &looks, String::new)?;
        }
        Ok(())
    }

    /// The colorimetry of the result.
    fn colorimetry(&self) -> Result<Colorimetry, String> {
        if self.state == OcioResult::Source {
            return Ok(Colorimetry::linear(Chromaticities::REC709));
        }
        let (p3, rec709, rec2020) = (Chromaticities::DISPLAY_P3, Chromaticities::REC709, Chromaticities::REC2020);
        let (primaries, transfer) = match self.encoding {
            OcioEncoding::Config => return self.stated(config()?.as_ref()),
            OcioEncoding::Srgb => (rec709, Transfer::Srgb),
            OcioEncoding::DisplayP3 => (p3, Transfer::Srgb),
            OcioEncoding::Gamma22 => (rec709, Transfer::Gamma(2.2.into())),
            OcioEncoding::Gamma24 => (rec709, Transfer::Gamma(2.4.into())),
            OcioEncoding::Gamma26P3 => (p3, Transfer::Gamma(2.6.into())),
            OcioEncoding::Pq => (rec2020, Transfer::Pq),
            OcioEncoding::Hlg => (rec2020, Transfer::Hlg),
        };
        Ok(encoded(primaries, transfer))
    }

    /// The colorimetry that the config states for the view.
    fn stated(&self, config: &Config) -> Result<Colorimetry, String> {
        let (display, view) = self.view(config)?;
        let space = match config.display_view_color_space_name(&display, &view) {
            "<USE_DISPLAY_NAME>" => display.as_str(),
            "" => display.as_str(),
            space => space,
        };
        if config.get_color_space(space).is_some_and(|space| space.is_data()) {
            return Err(format!("the view `{view}` shows numbers as they are: without this node they are written"));
        }
        let known = config.get_color_space(space).map(|space| space.interop_id().to_owned());
        let built_in = || Config::create_from_builtin_config("ocio://studio-config-latest").ok();
        let id = known
            .filter(|id| !id.is_empty())
            .or_else(|| Some(built_in()?.get_color_space(space)?.interop_id().to_owned()));
        id.as_deref().and_then(of_interop_id).ok_or_else(|| {
            format!("what the numbers of `{space}` are is not known: state `encoding`, which labels the file")
        })
    }
}

fn encoded(primaries: Chromaticities, transfer: Transfer) -> Colorimetry {
    let color = Colorimetry::new(primaries, transfer);
    Colorimetry { white_nits: color.is_hdr().then_some(GRAPHICS_WHITE), ..color }
}

/// The colorimetry of a display's space (Color Interop Forum): `g24_rec709_display`.
fn of_interop_id(id: &str) -> Option<Colorimetry> {
    let (transfer, primaries) = id.strip_suffix("_display")?.split_once('_')?;
    let transfer = match transfer {
        "srgb" => Transfer::Srgb,
        "g22" => Transfer::Gamma(2.2.into()),
        "g24" => Transfer::Gamma(2.4.into()),
        "g26" => Transfer::Gamma(2.6.into()),
        "pq" => Transfer::Pq,
        "hlg" => Transfer::Hlg,
        _ => return None,
    };
    let primaries = match primaries {
        "rec709" => Chromaticities::REC709,
        "p3d65" => Chromaticities::DISPLAY_P3,
        "rec2020" => Chromaticities::REC2020,
        _ => return None,
    };
    Some(encoded(primaries, transfer))
}

/// The name if the config has it, and the default for none.
fn chosen(what: &str, name: &str, known: &[String], default: impl Fn() -> String) -> Result<String, String> {
    if name.is_empty() {
        return Ok(default());
    }
    if let Some(same) = known.iter().find(|known| known.eq_ignore_ascii_case(name)) {
        return Ok(same.clone());
    }
    let meant = did_you_mean(name, known.iter().map(String::as_str));
    let others = || format!("it has `{}`", known.join("`, `"));
    Err(format!("the config has no {what} `{name}`; {}", meant.unwrap_or_else(others)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn displays_have_labels() {
        let bt1886 = Colorimetry::new(Chromaticities::REC709, Transfer::Gamma(2.4.into()));
        assert_eq!(of_interop_id("g24_rec709_display"), Some(bt1886));
        assert_eq!(of_interop_id("pq_p3d65_display").map(|color| color.white_nits), Some(Some(GRAPHICS_WHITE)));
        for unknown in ["srgbe_p3d65_display", "lin_rec709_scene", "srgb_xyz_display", ""] {
            assert_eq!(of_interop_id(unknown), None, "{unknown}");
        }
    }

    #[test]
    fn built_in_views_are_functions_and_wrong_names_are_told() {
        super::super::config::choose("ocio://studio-config-latest").expect("it is built in");
        let node = OcioTransform::default();
        assert_eq!(node.verify(), Ok(()));
        node.function().expect("it has one").shader.reflect().expect("it is valid");
        assert_eq!(node.colorimetry(), Ok(encoded(Chromaticities::REC709, Transfer::Srgb)));
        let refused = |change: &dyn Fn(&mut OcioTransform)| {
            let mut node = OcioTransform::default();
            change(&mut node);
            node.verify().expect_err("it is wrong")
        };
        let view = refused(&|node| node.view = "Un-tone-maped".into());
        assert_eq!(view, "the config has no view `Un-tone-maped`; did you mean `Un-tone-mapped`?");
        assert!(refused(&|node| node.view = "Raw".into()).starts_with("the view `Raw` shows numbers as they are"));
        assert!(refused(&|node| node.looks = "+Warm".into()).starts_with("the config has no look `Warm`; it has"));
        assert!(refused(&|node| node.display = "Display P3 HDR - Display".into()).contains("state `encoding`"));
        assert!(refused(&|node| node.file = "grade.csp".into()).starts_with("`file` and `space` belong together"));
        let refused_file =
            |file: &str, space: &str| refused(&|node| (node.file, node.space) = (file.into(), space.into()));
        for file in ["/etc/passwd", "../grade.csp", "a/../../grade.csp"] {
            assert!(refused_file(file, "ACEScct").contains("not below a folder of the config"), "{file}");
        }
        let space = "the config has no color space `ACESct`; did you mean `ACEScc`?";
        assert_eq!(refused_file("grade.csp", "ACESct"), space);
        assert!(refused_file("grade.csp", "ACEScct").starts_with("there is no file `"));
    }
}
