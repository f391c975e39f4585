//! Compiled pipelines, cached by what they are made of.

use std::sync::Mutex;

use afterimage_plan::codegen::Composed;
use afterimage_plan::{Plan, Stage};
use rustc_hash::FxHashMap;

use crate::GpuError;
use crate::drawing::{DrawState, render_pipeline};
use crate::layout::{Pipeline, bind_group_layout};
use crate::platform::{on_threads, watched};

/// Two pipelines with equal keys are the same.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(crate) struct PipelineKey {
    pub(crate) source: String,
    pub(crate) entry: String,
    /// The attachment's format of a draw.
    pub(crate) attachment: Option<wgpu::TextureFormat>,
    /// The state of a drawing pass.
    pub(crate) drawing: Option<DrawState>,
    /// How the bind group layout samples its textures: passes with equal text may differ in which textures are
    /// filterable.
    pub(crate) layout: String,
    /// Whether wgpu adds bounds checks of indices and loops.
    pub(crate) checked: bool,
}

/// A pipeline and the layout of its bind group.
#[derive(Clone)]
pub(crate) struct Built {
    pub(crate) pipeline: Pipeline,
    pub(crate) layout: wgpu::BindGroupLayout,
}

/// A pipeline is dropped after this many calls of [`Pipelines::build`] that did not request it, so that hours of shader
/// editing keep only the latest versions. A loaded plan holds its own pipelines.
const KEPT: u64 = 64;

/// The compiled pipelines, shared by all threads.
#[derive(Default)]
pub(crate) struct Pipelines {
    table: Mutex<PipelineTable<Built>>,
    pub(crate) cache: Option<wgpu::PipelineCache>,
}

/// Pipelines, each with the number of the call that last requested it.
struct PipelineTable<T> {
    calls: u64,
    built: FxHashMap<PipelineKey, (T, u64)>,
}

impl<T> Default for PipelineTable<T> {
    fn default() -> Self {
        Self { calls: 0, built: FxHashMap::default() }
    }
}

impl<T: Clone> PipelineTable<T> {
    /// Counts one more call and drops what has not been requested for [`KEPT`] calls.
    fn begin<'k>(&mut self, asked: impl Iterator<Item = &'k PipelineKey>) {
        self.calls += 1;
        for key in asked {
            if let Some((_, call)) = self.built.get_mut(key) {
                *call = self.calls;
            }
        }
        self.built.retain(|_, (_, call)| *call + KEPT > self.calls);
    }

    fn put(&mut self, key: PipelineKey, built: T) {
        self.built.insert(key, (built, self.calls));
    }

    fn get(&self, key: &PipelineKey) -> Option<T> {
        self.built.get(key).map(|(built, _)| built.clone())
    }
}

/// A pipeline to be built.
pub(crate) struct PipelineRequest<'a> {
    pub(crate) key: PipelineKey,
    pub(crate) composed: &'a Composed,
    pub(crate) plan: &'a Plan,
    pub(crate) stage: Stage,
    /// Bytes of immediates that the shader reads.
    pub(crate) immediate_bytes: u32,
    pub(crate) label: String,
    /// Whether the shader may read workgroup memory before it has written it.
    pub(crate) zero_workgroup_memory: bool,
}

impl Pipelines {
    /// No pipelines yet, with the driver's pipeline cache.
    pub(crate) fn with_cache(cache: Option<wgpu::PipelineCache>) -> Self {
        Self { table: Mutex::default(), cache }
    }

    pub(crate) fn get(&self, key: &PipelineKey) -> Option<Built> {
        self.table.lock().expect(UNBROKEN).get(key)
    }

    /// Compiles the missing pipelines on `threads` threads. Returns the first error of the device, if there is one.
    pub(crate) fn build(
        &self,
        device: &wgpu::Device,
        orders: Vec<PipelineRequest<'_>>,
        threads: usize,
    ) -> Result<(), GpuError> {
        self.table.lock().expect(UNBROKEN).begin(orders.iter().map(|order| &order.key));
        let mut missing: Vec<PipelineRequest<'_>> = Vec::new();
        for order in orders {
            if self.get(&order.key).is_none() && missing.iter().all(|known| known.key != order.key) {
                missing.push(order);
            }
        }
        let threads = threads.min(missing.len());
        let (queue, refused) = (Mutex::new(missing), Mutex::new(None));
        on_threads(threads, || {
            while let Some(order) = pop(&queue) {
                if let Err(error) = self.build_one(device, order) {
                    refused.lock().expect(UNBROKEN).get_or_insert(error);
                }
            }
        });
        refused.into_inner().expect(UNBROKEN).map_or(Ok(()), Err)
    }

    fn build_one(&self, device: &wgpu::Device, order: PipelineRequest<'_>) -> Result<(), GpuError> {
        let what = format!("the shader of `{}`", order.label);
        let built = watched(device, &what, || Ok(compile(device, self.cache.as_ref(), &order)))?;
        self.table.lock().expect(UNBROKEN).put(order.key, built);
        Ok(())
    }
}

const UNBROKEN: &str = "no thread panics with the lock";

fn pop<'a>(queue: &Mutex<Vec<PipelineRequest<'a>>>) -> Option<PipelineRequest<'a>> {
    queue.lock().expect(UNBROKEN).pop()
}

/// A module without bounds checks of indices and loops. On an H200, kernels with loops take up to 40 % less time.
#[allow(unsafe_code, reason = "unchecked shaders guarantee what the checks would enforce")]
fn trusted(device: &wgpu::Device, descriptor: wgpu::ShaderModuleDescriptor<'_>) -> wgpu::ShaderModule {
    // SAFETY: every part of the module comes from `Shader::unchecked`, whose callers guarantee that all accesses are in
    // bounds and all loops end, or from code generation, which loads texels only within the result's size.
    unsafe { device.create_shader_module_trusted(descriptor, wgpu::ShaderRuntimeChecks::unchecked()) }
}

fn compile(device: &wgpu::Device, cache: Option<&wgpu::PipelineCache>, order: &PipelineRequest<'_>) -> Built {
    let layout = bind_group_layout(device, order.plan, order.composed, order.stage);
    if order.key.drawing.as_ref().is_some_and(|state| !state.has_geometry()) {
        return Built { pipeline: Pipeline::None, layout };
    }
    let descriptor = wgpu::ShaderModuleDescriptor {
        label: Some(&order.label),
        source: wgpu::ShaderSource::Wgsl(order.composed.source.as_str().into()),
    };
    let module = if order.key.checked { device.create_shader_module(descriptor) } else { trusted(device, descriptor) };
    let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(&order.label),
        bind_group_layouts: &[Some(&layout)],
        immediate_size: order.immediate_bytes,
    });
    let pipeline = match order.stage {
        Stage::Compute => Pipeline::Compute(device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(&order.label),
            layout: Some(&pipeline_layout),
            module: &module,
            entry_point: Some(&order.composed.compute),
            compilation_options: compilation_options(order),
            cache,
        })),
        Stage::Fragment => Pipeline::Render(full_screen_pipeline(device, order, (&module, &pipeline_layout), cache)),
        Stage::Drawing => {
            let state = order.key.drawing.as_ref().expect("a drawing pass has a state");
            Pipeline::Drawing(render_pipeline(device, (&module, order.composed), &pipeline_layout, state, cache))
        }
    };
    Built { pipeline, layout }
}

fn full_screen_pipeline(
    device: &wgpu::Device,
    order: &PipelineRequest<'_>,
    (module, layout): (&wgpu::ShaderModule, &wgpu::PipelineLayout),
    cache: Option<&wgpu::PipelineCache>,
) -> wgpu::RenderPipeline {
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(&order.label),
        layout: Some(layout),
        vertex: full_screen_triangle(module, order.composed),
        primitive: Default::default(),
        depth_stencil: None,
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: order.composed.draw.as_ref().and_then(|draw| draw.fragment.as_deref()),
            compilation_options: compilation_options(order),
            targets: &[Some(order.key.attachment.expect("a draw has an attachment").into())],
        }),
        multiview_mask: None,
        cache,
    })
}

fn compilation_options(order: &PipelineRequest<'_>) -> wgpu::PipelineCompilationOptions<'static> {
    let zero_initialize_workgroup_memory = order.zero_workgroup_memory;
    wgpu::PipelineCompilationOptions { zero_initialize_workgroup_memory, ..Default::default() }
}

fn full_screen_triangle<'a>(module: &'a wgpu::ShaderModule, composed: &'a Composed) -> wgpu::VertexState<'a> {
    let entry_point = composed.draw.as_ref().map(|draw| draw.vertex.as_str());
    wgpu::VertexState { module, entry_point, compilation_options: Default::default(), buffers: &[] }
}

#[cfg(test)]
mod tests {
    use super::{KEPT, PipelineKey, PipelineTable};

    fn key(source: &str) -> PipelineKey {
        PipelineKey {
            source: source.to_owned(),
            entry: "compute".into(),
            attachment: None,
            drawing: None,
            layout: String::new(),
            checked: true,
        }
    }

    #[test]
    fn requested_pipelines_stay_and_old_versions_are_dropped() {
        let mut table = PipelineTable::default();
        let asked = key("asked for by every plan");
        table.begin([&asked].into_iter());
        table.put(asked.clone(), "asked");
        for version in 0..3 * KEPT {
            let edited = key(&version.to_string());
            table.begin([&asked, &edited].into_iter());
            table.put(edited, "edited");
        }
        assert_eq!(table.get(&asked), Some("asked"));
        assert_eq!(table.built.len() as u64, KEPT + 1);
        assert_eq!(table.get(&key(&(2 * KEPT).to_string())), Some("edited"));
        assert_eq!(table.get(&key("0")), None);
    }
}
