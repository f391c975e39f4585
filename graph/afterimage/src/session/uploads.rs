//! Images and host blocks for the inputs of a pipeline.

use std::collections::BTreeMap;

use afterimage_gpu::wgpu::TextureView;
use afterimage_gpu::{Feed, Frame, FrameStep, Gpu, GpuError, InputImage, input_image};
use afterimage_graph::image::{ImageDesc, Size};
use afterimage_graph::node::BlockData;
use afterimage_plan::{HostImageDesc, HostInputs};

/// The uploaded images and the host blocks, by the names of the inputs.
#[derive(Default)]
pub(super) struct Uploads {
    feeds: BTreeMap<String, Feed>,
    pub(super) blocks: BTreeMap<String, BlockData>,
}

impl Uploads {
    /// Uploads an image into the texture of an input: that of the image before, if it had the same size and format.
    pub(super) fn image(
        &mut self,
        gpu: &Gpu,
        input: &str,
        desc: ImageDesc,
        bytes: &[u8],
    ) -> Result<InputImage, GpuError> {
        gpu.check_fits(desc)?;
        if desc.samples > 1 {
            // A draw fills it, and no command of a transfer does.
            return input_image(gpu, input, desc, bytes);
        }
        let mut feed = match self.feeds.remove(input) {
            Some(feed) if feed.desc() == desc => feed,
            _ => Feed::new(&gpu.device, &gpu.queue, desc)?,
        };
        feed.fill(bytes)?;
        let image = InputImage { input: input.to_owned(), view: feed.view().clone(), desc, finite: false };
        self.feeds.insert(input.to_owned(), feed);
        Ok(image)
    }

    /// The inputs of a plan for these images and the present blocks.
    pub(super) fn host_inputs<'i>(
        &self,
        size: Size,
        images: impl Iterator<Item = (&'i str, ImageDesc, bool)>,
    ) -> HostInputs {
        let inputs = images.map(|(name, desc, finite)| (name.to_owned(), HostImageDesc { desc, finite })).collect();
        HostInputs { inputs, blocks: self.blocks.keys().cloned().collect(), ..HostInputs::none(size) }
    }

    /// Calls `use_frame` with the executor's description of a frame with these images and the present blocks.
    pub(super) fn with_frame<T>(
        &self,
        images: &[InputImage],
        step: FrameStep,
        use_frame: impl FnOnce(&Frame<'_>) -> T,
    ) -> T {
        let inputs: Vec<(&str, &TextureView)> = images.iter().map(|image| (&*image.input, &image.view)).collect();
        let blocks: Vec<(&str, &BlockData)> = self.blocks.iter().map(|(name, data)| (&**name, data)).collect();
        let FrameStep { time, dt, kind } = step;
        use_frame(&Frame { inputs: &inputs, blocks: &blocks, time, dt, kind, ..Frame::default() })
    }
}
