//! Kinds of folders that are part of a program.

use std::sync::{Arc, OnceLock};

use super::block::HostBlock;
use super::camera::CAMERA;
use super::folder::folder_kind_sharing;
use super::invariants::Invariants;
use super::kind::{Kind, Node, NodeKind};
use super::ports::{Input, Output};
use afterimage_base::Shared;
use afterimage_base::value::{Param, Value};

/// The texts of a folder that is part of the program, as [`NodeKind::embedded`] takes them.
///
/// They are read when something asks for more than the kind's name, so a table with many such kinds costs nothing at
/// the start. A program tests its own folders with [`contract`](crate::node::contract).
///
/// ```
/// use afterimage_graph::node::{EmbeddedKind, NodeKind, Registry};
///
/// const DECLARATION: &str = r#"Kind(
///     name: "Invert",
///     doc: "Inverts colors.",
///     inputs: { "source": Image(doc: "The picture.", accepts: [DisplayLinear]) },
///     outputs: { "result": Image(doc: "The negative.", state: Same("source")) },
/// )"#;
/// const SHADER: &str = "fn invert(source: vec4f) -> vec4f { return vec4f(1.0 - source.rgb, source.a); }";
///
/// static INVERT: EmbeddedKind =
///     EmbeddedKind::new("Invert", ("invert/node.ron", DECLARATION), &[("invert/invert.wgsl", SHADER)], &[]);
/// const ALL: &[NodeKind] = &[NodeKind::embedded(&INVERT)];
///
/// let registry = Registry::new(&[ALL])?;
/// assert_eq!(registry.get("Invert").unwrap().doc(), "Inverts colors.");
/// # Ok::<(), afterimage_graph::node::RegistryError>(())
/// ```
pub struct EmbeddedKind {
    name: &'static str,
    declaration: (&'static str, &'static str),
    shaders: &'static [(&'static str, &'static str)],
    library: &'static [(&'static str, &'static str)],
    kind: OnceLock<NodeKind>,
}

impl EmbeddedKind {
    /// From the kind's name, and from names and texts of the files as [`folder_kind_sharing`] takes them.
    pub const fn new(
        name: &'static str,
        declaration: (&'static str, &'static str),
        shaders: &'static [(&'static str, &'static str)],
        library: &'static [(&'static str, &'static str)],
    ) -> Self {
        Self { name, declaration, shaders, library, kind: OnceLock::new() }
    }

    /// The kind that the texts declare.
    ///
    /// # Panics
    /// If they are wrong, or declare a kind of another name: they are as much a part of the program as its code.
    fn kind(&self) -> &NodeKind {
        self.kind.get_or_init(|| {
            let kind = folder_kind_sharing(self.declaration, self.shaders, self.library)
                .unwrap_or_else(|errors| panic!("the folder of `{}` in this program is wrong:\n{errors}", self.name));
            assert_eq!(kind.name(), self.name, "the folder declares a kind of another name than its table");
            kind
        })
    }
}

impl Kind for EmbeddedKind {
    fn name(&self) -> &str {
        self.name
    }
    fn doc(&self) -> &str {
        self.kind().doc()
    }
    fn params(&self) -> &[Param] {
        self.kind().params()
    }
    fn inputs(&self) -> &[Input] {
        self.kind().inputs()
    }
    fn outputs(&self) -> &[Output] {
        self.kind().outputs()
    }
    fn invariants(&self) -> Invariants {
        self.kind().invariants()
    }
    fn blocks(&self) -> Vec<&'static HostBlock> {
        // Folders have no other block, and checking a pipeline with a camera asks all kinds.
        if self.declaration.1.contains(CAMERA.name) { vec![&CAMERA] } else { Vec::new() }
    }
    fn instantiate(&self, values: &[Value]) -> Arc<dyn Node> {
        self.kind().instantiate(values)
    }
    fn set(&self, node: &mut dyn Node, index: usize, value: &Value) -> bool {
        self.kind().set(node, index, value)
    }
}

impl NodeKind {
    /// The kind of a folder that is part of the program.
    pub const fn embedded(kind: &'static EmbeddedKind) -> Self {
        Self(Shared::Static(kind))
    }
}
