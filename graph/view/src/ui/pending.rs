//! What waits for an answer about unsaved changes.

use crate::model::Project;

pub(super) enum Pending {
    Close,
    Open(Box<dyn Project>),
}
