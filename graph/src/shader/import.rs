//! `#import name`: the only directive. Brings in a file of `shaders/lib` once, and keeps the map of lines.

use super::{Shader, ShaderError};

/// The shared files, by name.
const LIBRARY: &[(&str, &str)] = &[
    ("color", include_str!("../../../shaders/lib/color.wgsl")),
    ("cube", include_str!("../../../shaders/lib/cube.wgsl")),
    ("grade", include_str!("../../../shaders/lib/grade.wgsl")),
    ("guard", include_str!("../../../shaders/lib/guard.wgsl")),
    ("loft", include_str!("../../../shaders/lib/loft.wgsl")),
    ("loft_lamps", include_str!("../../../shaders/lib/loft_lamps.wgsl")),
    ("loft_outside", include_str!("../../../shaders/lib/loft_outside.wgsl")),
    ("loft_shade", include_str!("../../../shaders/lib/loft_shade.wgsl")),
    ("loft_surfaces", include_str!("../../../shaders/lib/loft_surfaces.wgsl")),
    ("math", include_str!("../../../shaders/lib/math.wgsl")),
    ("metering", include_str!("../../../shaders/lib/metering.wgsl")),
    ("noise", include_str!("../../../shaders/lib/noise.wgsl")),
    ("point", include_str!("../../../shaders/lib/point.wgsl")),
    ("ray", include_str!("../../../shaders/lib/ray.wgsl")),
    ("sampling", include_str!("../../../shaders/lib/sampling.wgsl")),
    ("shaper", include_str!("../../../shaders/lib/shaper.wgsl")),
    ("tent", include_str!("../../../shaders/lib/tent.wgsl")),
    ("transfer", include_str!("../../../shaders/lib/transfer.wgsl")),
];

/// The file that generated lines belong to.
const GENERATED: &str = "(generated)";

/// Which line of which file each line of a composed module came from.
#[derive(Clone, Debug, Default)]
pub struct SourceMap {
    lines: Vec<(&'static str, u32)>,
}

impl SourceMap {
    /// The file and the line, counted from 1, that line `line` (from 1) of the composed text came from.
    pub fn locate(&self, line: u32) -> (&'static str, u32) {
        let index = (line as usize).saturating_sub(1);
        self.lines.get(index).copied().unwrap_or((GENERATED, line))
    }
}

/// Text under construction, with its map.
#[derive(Default)]
pub(super) struct Text {
    pub(super) text: String,
    pub(super) map: SourceMap,
    included: Vec<&'static str>,
}

impl Text {
    /// Adds lines of the framework's own.
    pub(super) fn generated(&mut self, lines: &str) {
        for (index, line) in lines.lines().enumerate() {
            self.line(line, GENERATED, index as u32 + 1);
        }
    }

    fn line(&mut self, line: &str, file: &'static str, number: u32) {
        self.text.push_str(line);
        self.text.push('\n');
        self.map.lines.push((file, number));
    }

    /// Adds a module and, before it, what it imports; each file once.
    pub(super) fn module(&mut self, shader: &Shader) -> Result<(), ShaderError> {
        self.file(shader.file(), shader.source())
    }

    /// Adds a file of the library, unless it is there.
    pub(super) fn library(&mut self, name: &str) -> Option<Result<(), ShaderError>> {
        let (file, source) = LIBRARY.iter().find(|(known, _)| *known == name)?;
        Some(self.file(file, source))
    }

    fn file(&mut self, file: &'static str, source: &'static str) -> Result<(), ShaderError> {
        if self.included.contains(&file) {
            return Ok(());
        }
        self.included.push(file);
        for (number, line) in source.lines().enumerate() {
            let number = number as u32 + 1;
            let Some(name) = line.trim().strip_prefix("#import ") else { continue };
            let known = || LIBRARY.iter().map(|(known, _)| *known).collect::<Vec<_>>().join("`, `");
            self.library(name.trim()).unwrap_or_else(|| {
                Err(ShaderError::at(file, number, format!("no shared file is called `{name}`; there are `{}`", known())))
            })?;
        }
        for (number, line) in source.lines().enumerate() {
            let directive = line.trim().starts_with("#import ");
            self.line(if directive { "" } else { line }, file, number as u32 + 1);
        }
        Ok(())
    }
}
