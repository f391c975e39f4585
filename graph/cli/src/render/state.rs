//! The state between two parts of a sequence: the file of `--state-out` and `--state-in`.
//!
//! A file is a line of JSON, the [`Header`], and the bytes of all items after it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use afterimage_gpu::StateBytes;
use afterimage_media::read_bytes;
use afterimage_plan::{Plan, StateItem};
use serde::{Deserialize, Serialize};

use crate::cameras::CameraFile;
use crate::failure::Failure;

/// The most bytes of a state. The largest has a few images of the size of a frame.
const MAX_BYTES: u64 = 8 << 30;
/// The version of the format.
const VERSION: u32 = 1;

/// What a file of state begins with.
#[derive(Deserialize, Serialize)]
struct Header {
    /// The version of the format.
    afterimage_state: u32,
    /// The hash of the plan.
    plan: String,
    /// The number of the last frame.
    frame: u32,
    items: Vec<ItemHeader>,
    /// The cameras of the last frame, by the names of inputs.
    cameras: BTreeMap<String, CameraFile>,
}

/// An item of the state.
#[derive(Deserialize, Serialize)]
struct ItemHeader {
    name: String,
    /// Its size and format in words.
    content: String,
    bytes: usize,
}

/// The state after a frame, from a file.
pub(super) struct SavedState {
    path: PathBuf,
    header: Header,
    /// The bytes of all items.
    bytes: Vec<u8>,
}

impl SavedState {
    pub(super) fn read(path: &Path) -> Result<Self, Failure> {
        let wrong =
            |why: &str| Failure::unreadable(format!("{}: this is no state of a sequence: {why}", path.display()));
        let mut file = read_bytes(path, MAX_BYTES)?;
        let end = file.iter().position(|byte| *byte == b'\n').ok_or_else(|| wrong("it has no header"))?;
        let header: Header = serde_json::from_slice(&file[..end]).map_err(|error| wrong(&error.to_string()))?;
        if header.afterimage_state != VERSION {
            return Err(wrong("another version of the program wrote it"));
        }
        let bytes = file.split_off(end + 1);
        let expected = header.items.iter().try_fold(0_usize, |sum, item| sum.checked_add(item.bytes));
        if expected != Some(bytes.len()) {
            return Err(wrong("it is not whole"));
        }
        Ok(Self { path: path.to_owned(), header, bytes })
    }

    /// The number of the last frame.
    pub(super) fn frame(&self) -> u32 {
        self.header.frame
    }

    /// The cameras of the last frame, by the names of inputs.
    pub(super) fn cameras(&self) -> &BTreeMap<String, CameraFile> {
        &self.header.cameras
    }

    /// The state for this plan.
    ///
    /// # Errors
    /// It is the state of another plan.
    pub(super) fn for_plan(&self, plan: &Plan) -> Result<Vec<StateBytes>, Failure> {
        let refused = |why: String| {
            Failure::user(format!("{}: this state does not fit the run: {why}", self.path.display()))
                .hint("a sequence continues with the same pipeline, options, size, adapter and program")
        };
        let items = plan.state();
        for item in &items {
            let known = self.header.items.iter().find(|known| known.name == item.name);
            let known = known.ok_or_else(|| refused(format!("it has no `{}`", item.name)))?;
            if known.content != item.described() {
                let (name, old, new) = (&item.name, &known.content, item.described());
                return Err(refused(format!("its `{name}` is {old}, and here it is {new}")));
            }
        }
        if let Some(other) = self.header.items.iter().find(|known| items.iter().all(|item| item.name != known.name)) {
            return Err(refused(format!("it has `{}`, which this plan does not keep", other.name)));
        }
        let hash = plan.hash().to_string();
        if self.header.plan != hash {
            return Err(refused(format!("the hash of its plan is {}, and here it is {hash}", self.header.plan)));
        }
        // Equal plans list their state in one order.
        let mut rest = self.bytes.as_slice();
        let mut state = Vec::new();
        for (item, known) in items.into_iter().zip(&self.header.items) {
            let (bytes, after) = rest.split_at(known.bytes);
            rest = after;
            state.push(StateBytes { item, bytes: bytes.to_vec() });
        }
        Ok(state)
    }
}

/// The bytes of a file with the state after a frame.
pub(super) fn encode(plan: &Plan, frame: u32, cameras: &BTreeMap<String, CameraFile>, state: &[StateBytes]) -> Vec<u8> {
    let mut items = Vec::new();
    for StateBytes { item, bytes } in state {
        items.push(ItemHeader { name: item.name.clone(), content: item.described(), bytes: bytes.len() });
    }
    let (plan, cameras) = (plan.hash().to_string(), cameras.clone());
    let header = Header { afterimage_state: VERSION, plan, frame, items, cameras };
    let mut file = serde_json::to_vec(&header).expect("a header has names and numbers only");
    file.push(b'\n');
    for StateBytes { bytes, .. } in state {
        file.extend_from_slice(bytes);
    }
    file
}

/// The names of items as a list.
pub(super) fn names<'a>(items: impl IntoIterator<Item = &'a StateItem>) -> String {
    let names: Vec<String> = items.into_iter().map(|item| format!("`{}`", item.name)).collect();
    names.join(", ")
}
