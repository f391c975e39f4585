//! Handles that hosts keep: keys that are unique in the process, so that one of another pipeline is known as such.

use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};

use slotmap::{Key, SlotMap};

/// The names behind all handles of a type.
pub(super) struct Handles<K: Key + 'static>(LazyLock<Mutex<SlotMap<K, String>>>);

/// The owner of a key, which is valid as long as this.
pub(super) struct Handle<K: Key + 'static> {
    key: K,
    handles: &'static Handles<K>,
}

impl<K: Key + 'static> Handles<K> {
    pub(super) const fn new() -> Self {
        Self(LazyLock::new(Mutex::default))
    }

    pub(super) fn add(&'static self, name: &str) -> Handle<K> {
        Handle { key: self.names().insert(name.to_owned()), handles: self }
    }

    /// The name behind a key; `None` if its owner is gone.
    pub(super) fn name(&self, key: K) -> Option<String> {
        self.names().get(key).cloned()
    }

    fn names(&self) -> MutexGuard<'_, SlotMap<K, String>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<K: Key + 'static> Handle<K> {
    pub(super) fn key(&self) -> K {
        self.key
    }
}

impl<K: Key + 'static> Drop for Handle<K> {
    fn drop(&mut self) {
        self.handles.names().remove(self.key);
    }
}
