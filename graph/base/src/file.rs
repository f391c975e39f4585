//! Files that parameters name, and what nodes have read from them.

use std::any::Any;
use std::ops::Deref;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A file that a parameter names.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FileValue {
    /// The path as written in the pipeline file. Empty for no file.
    pub path: Arc<str>,
    /// The content of the file. `None` before loading.
    pub bytes: Option<FileBytes>,
}

/// The bytes of a file, with what was [read](Self::read) from them. All copies share both, and the last one frees them.
/// A file that is loaded again has bytes of its own.
#[derive(Clone)]
pub struct FileBytes(Arc<Content>);

struct Content {
    bytes: Arc<[u8]>,
    /// Results of `read`, the oldest first.
    read: Mutex<Vec<Arc<Kept>>>,
}

type Kept = dyn Any + Send + Sync;

/// Number of results that are kept with a file. One plan needs one or two; a few more serve plans that are made by
/// turns.
const MOST: usize = 4;

impl FileBytes {
    /// Decodes the bytes by `read`. The result is kept with them, so that a file is not read again for each new value
    /// of another parameter: the next caller whose `accepts` accepts a result of that type gets the same. The last few
    /// are kept, of all types.
    pub fn read<T: Any + Send + Sync>(&self, accepts: impl Fn(&T) -> bool, read: impl FnOnce(&[u8]) -> T) -> Arc<T> {
        let is_known = |kept: &&Arc<Kept>| kept.downcast_ref().is_some_and(&accepts);
        let known = self.kept().iter().find(is_known).cloned();
        if let Some(known) = known.and_then(|known| known.downcast().ok()) {
            return known;
        }
        // To read takes long, so nobody waits for the lock meanwhile.
        let new = Arc::new(read(&self.0.bytes));
        let mut kept = self.kept();
        if kept.len() == MOST {
            kept.remove(0);
        }
        kept.push(new.clone());
        new
    }

    fn kept(&self) -> MutexGuard<'_, Vec<Arc<Kept>>> {
        self.0.read.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl From<Arc<[u8]>> for FileBytes {
    fn from(bytes: Arc<[u8]>) -> Self {
        Self(Arc::new(Content { bytes, read: Mutex::default() }))
    }
}

impl Deref for FileBytes {
    type Target = [u8];
    fn deref(&self) -> &[u8] {
        &self.0.bytes
    }
}

impl PartialEq for FileBytes {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || Arc::ptr_eq(&self.0.bytes, &other.0.bytes) || **self == **other
    }
}

impl std::fmt::Debug for FileBytes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} bytes", self.len())
    }
}
