//! What the last frame has left in images and buffers.

use wgpu::Buffer;

use super::Executor;
use super::loaded::{ImageBinding, ring_place};

impl Executor {
    /// The buffer of a table or value by its label, `node.port`. `None` if the plan has none, for example because the
    /// node is skipped.
    pub fn buffer(&self, label: &str) -> Option<&Buffer> {
        let loaded = self.loaded.as_ref()?;
        let index = loaded.plan.buffers.iter().position(|buffer| buffer.label == label)?;
        loaded.buffers.get(index)
    }

    /// The texture of an image by its label or its name in the plan, as far as it is not the host's. See
    /// [`Post::image`](crate::Post::image).
    pub(crate) fn image(&self, name: &str) -> Option<&wgpu::Texture> {
        let loaded = self.loaded.as_ref()?;
        let by_label = loaded.plan.images.iter().position(|image| image.label == name);
        let index = by_label.or_else(|| loaded.plan.image_names().iter().position(|known| known == name))?;
        let last_frame = self.frame_index.wrapping_sub(1);
        let key = match &loaded.bindings[index] {
            ImageBinding::Output(_, key) | ImageBinding::Fixed(key) => *key,
            ImageBinding::Ring(keys, behind) => keys[ring_place(keys.len(), last_frame, *behind)],
            ImageBinding::Input(_) | ImageBinding::Unused => return None,
        };
        Some(&self.store.get(key).texture)
    }

    /// The timestamps of the frame that is recorded, and the nanoseconds of a tick; `None` if passes are not timed.
    pub(crate) fn timestamps(&self) -> Option<(&Buffer, f32)> {
        Some(self.loaded.as_ref()?.timing.as_ref()?.timestamps())
    }
}
