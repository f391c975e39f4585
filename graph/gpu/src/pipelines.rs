//! Compiled pipelines, cached by what they are made of.

use std::sync::{Arc, Mutex};

use afterimage_base::panics::catch_panic;
use afterimage_graph::node::Subresource;
use afterimage_plan::codegen::{Composed, Draw, SlotKind};
use afterimage_plan::{Plan, Stage};
use afterimage_wgsl::{SourceMap, validate};
use rustc_hash::FxHashMap;

use crate::draw_state::{DrawState, render_pipeline};
use crate::error::GpuError;
use crate::frame_constants;
use crate::full_screen::FullScreenPipeline;
use crate::layout::{Pipeline, layout_entries};
use crate::platform::{TaskPool, on_threads, watched};

/// Two pipelines with equal keys are the same.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(crate) struct PipelineKey {
    pub(crate) source: String,
    pub(crate) entry: String,
    /// The attachment's format of a draw.
    pub(crate) attachment: Option<wgpu::TextureFormat>,
    /// The state of a drawing pass.
    pub(crate) drawing: Option<DrawState>,
    /// The sample modes of the bind group layout: passes with equal text may differ in which textures are
    /// filterable.
    pub(crate) layout: String,
    /// True if wgpu adds bounds checks of indices and loops.
    pub(crate) checked: bool,
}

/// A pipeline and the layout of its bind group.
#[derive(Clone)]
pub(crate) struct Built {
    pub(crate) pipeline: Pipeline,
    pub(crate) layout: wgpu::BindGroupLayout,
}

/// A pipeline is dropped after this many calls of [`Pipelines::build`] that did not request it, so that shader editing
/// keeps the latest versions only: one takes 19 MiB on llvmpipe. A loaded plan holds its own pipelines.
const KEPT: u64 = 8;

/// The compiled pipelines of a device, shared by all executors and threads.
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
pub(crate) struct PipelineRequest {
    pub(crate) key: PipelineKey,
    stage: Stage,
    /// The layout of the bind group.
    entries: Vec<wgpu::BindGroupLayoutEntry>,
    /// The entry points of a draw.
    draw: Option<Draw>,
    /// Bytes of immediates that the shader reads.
    immediate_bytes: u32,
    label: String,
    /// The origin of the text.
    map: SourceMap,
    /// True if the shader may read workgroup memory before it has written it.
    zero_workgroup_memory: bool,
    /// The layout of a second bind group.
    second_layout: Option<wgpu::BindGroupLayout>,
}

impl PipelineRequest {
    /// The pipeline of a pass, which draws if there is an attachment.
    pub(crate) fn new(plan: &Plan, index: usize, composed: &Composed, attachment: Option<wgpu::TextureFormat>) -> Self {
        let pass = &plan.passes[index].pass;
        let stage = match attachment {
            _ if pass.drawing().is_some() => Stage::Drawing,
            Some(_) => Stage::Fragment,
            None => Stage::Compute,
        };
        let sample_modes = composed.slots.iter().map(|slot| match slot.kind {
            SlotKind::Texture(image) | SlotKind::Level(Subresource { image, .. }) => {
                format!("{:?}", plan.image(image).sample_mode)
            }
            _ => String::new(),
        });
        let layout: Vec<String> = sample_modes.collect();
        Self {
            key: PipelineKey {
                source: composed.source.clone(),
                entry: composed.compute.clone(),
                attachment,
                drawing: pass.drawing().map(|drawing| DrawState::new(plan, drawing)),
                layout: layout.join(","),
                checked: plan.options.bounds_checks || !composed.unchecked,
            },
            stage,
            entries: layout_entries(plan, composed, stage),
            draw: composed.draw.clone(),
            immediate_bytes: if composed.immediate { frame_constants::BYTES } else { 0 },
            label: pass.label.clone(),
            map: composed.map.clone(),
            zero_workgroup_memory: composed.zero_workgroup_memory,
            second_layout: None,
        }
    }

    /// The same with the layout of a second bind group, which only shaders of other texts have.
    pub(crate) fn with_second_layout(self, second_layout: Option<wgpu::BindGroupLayout>) -> Self {
        Self { second_layout, ..self }
    }
}

impl Pipelines {
    /// No pipelines yet, with the driver's pipeline cache.
    pub(crate) fn with_cache(cache: Option<wgpu::PipelineCache>) -> Self {
        Self { table: Mutex::default(), cache }
    }

    /// The pipeline that draws a pass's result into an image of this format.
    pub(crate) fn drawing(
        &self,
        device: &wgpu::Device,
        plan: &Plan,
        index: usize,
        composed: &Composed,
        format: wgpu::TextureFormat,
    ) -> Result<Built, GpuError> {
        let request = PipelineRequest::new(plan, index, composed, Some(format));
        match self.begin(std::slice::from_ref(&request)).remove(&request.key) {
            Some(built) => Ok(built),
            None => self.build_one(device, request),
        }
    }

    /// Compiles the missing pipelines on `threads` threads, those of the host if it has a pool. Returns the pipelines
    /// of all requests, which other executors may make the table drop at any time, or an error of the device.
    pub(crate) fn build(
        self: &Arc<Self>,
        device: &wgpu::Device,
        requests: Vec<PipelineRequest>,
        threads: usize,
        pool: Option<&TaskPool>,
    ) -> Result<FxHashMap<PipelineKey, Built>, GpuError> {
        let mut built = self.begin(&requests);
        let mut missing: Vec<PipelineRequest> = Vec::new();
        for request in requests {
            if !built.contains_key(&request.key) && missing.iter().all(|known| known.key != request.key) {
                missing.push(request);
            }
        }
        let threads = threads.min(missing.len());
        let work = Arc::new((Mutex::new(missing), Mutex::new(Vec::new())));
        let (pipelines, device, shared) = (self.clone(), device.clone(), work.clone());
        on_threads(pool, threads, move || {
            let (queue, results) = &*shared;
            while let Some(request) = pop(queue) {
                let key = request.key.clone();
                let result = pipelines.build_one(&device, request);
                results.lock().expect(UNBROKEN).push((key, result));
            }
        })?;
        for (key, result) in std::mem::take(&mut *work.1.lock().expect(UNBROKEN)) {
            built.insert(key, result?);
        }
        Ok(built)
    }

    /// Counts one more call. Returns what is compiled of the requests.
    fn begin(&self, requests: &[PipelineRequest]) -> FxHashMap<PipelineKey, Built> {
        let mut table = self.table.lock().expect(UNBROKEN);
        table.begin(requests.iter().map(|request| &request.key));
        let known = requests.iter().filter_map(|request| Some((request.key.clone(), table.get(&request.key)?)));
        known.collect()
    }

    fn build_one(&self, device: &wgpu::Device, request: PipelineRequest) -> Result<Built, GpuError> {
        let what = format!("the shader of `{}`", request.label);
        let built = watched(device, &what, || {
            // The compiler in wgpu panics over some modules that its validator accepts.
            catch_panic(|| compile(device, self.cache.as_ref(), &request))
                .map_err(|why| GpuError::Refused { what: what.clone(), why })
        });
        let built = built.map_err(|error| at_author(error, &request))?;
        self.table.lock().expect(UNBROKEN).put(request.key, built.clone());
        Ok(built)
    }
}

/// The error with the author's line, if the compiler without a device finds one, too.
fn at_author(error: GpuError, request: &PipelineRequest) -> GpuError {
    if !matches!(error, GpuError::Refused { .. }) {
        return error;
    }
    match validate(&request.key.source, &request.map) {
        Err(shader) => GpuError::Shader(Box::new(shader)),
        Ok(_) => error,
    }
}

const UNBROKEN: &str = "no thread panics with the lock";

fn pop(queue: &Mutex<Vec<PipelineRequest>>) -> Option<PipelineRequest> {
    queue.lock().expect(UNBROKEN).pop()
}

/// A module without bounds checks of indices and loops. On an H200, kernels with loops take up to 40 % less time.
#[allow(unsafe_code, reason = "unchecked shaders guarantee what the checks would enforce")]
fn trusted(device: &wgpu::Device, descriptor: wgpu::ShaderModuleDescriptor<'_>) -> wgpu::ShaderModule {
    // SAFETY: every part of the module comes from `Shader::unchecked`, whose callers guarantee that all accesses are in
    // bounds and all loops end, or from code generation, which loads texels only within the result's size.
    unsafe { device.create_shader_module_trusted(descriptor, wgpu::ShaderRuntimeChecks::unchecked()) }
}

/// The module of a text, with bounds checks or without.
fn shader_module(device: &wgpu::Device, label: &str, source: &str, checked: bool) -> wgpu::ShaderModule {
    let source = wgpu::ShaderSource::Wgsl(source.into());
    let descriptor = wgpu::ShaderModuleDescriptor { label: Some(label), source };
    if checked { device.create_shader_module(descriptor) } else { trusted(device, descriptor) }
}

fn compile(device: &wgpu::Device, cache: Option<&wgpu::PipelineCache>, request: &PipelineRequest) -> Built {
    let entries = &request.entries;
    let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries });
    if request.key.drawing.as_ref().is_some_and(|state| !state.has_geometry()) {
        return Built { pipeline: Pipeline::None, layout };
    }
    let module = shader_module(device, &request.label, &request.key.source, request.key.checked);
    let layouts = [Some(&layout), request.second_layout.as_ref()];
    let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(&request.label),
        bind_group_layouts: if request.second_layout.is_some() { &layouts } else { &layouts[..1] },
        immediate_size: request.immediate_bytes,
    });
    let pipeline = match request.stage {
        Stage::Compute => Pipeline::Compute(device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(&request.label),
            layout: Some(&pipeline_layout),
            module: &module,
            entry_point: Some(&request.key.entry),
            compilation_options: wgpu::PipelineCompilationOptions {
                zero_initialize_workgroup_memory: request.zero_workgroup_memory,
                ..Default::default()
            },
            cache,
        })),
        Stage::Fragment => {
            let draw = request.draw.as_ref().expect("the module of a draw has its entry points");
            let pipeline = FullScreenPipeline {
                label: &request.label,
                module: &module,
                vertex: &draw.vertex,
                fragment: draw.fragment.as_deref().expect("a draw has a fragment entry point"),
                layout: Some(&pipeline_layout),
                format: request.key.attachment.expect("a draw has an attachment"),
                samples: 1,
                cache,
            };
            Pipeline::Render(pipeline.create(device))
        }
        Stage::Drawing => {
            let state = request.key.drawing.as_ref().expect("a drawing pass has a state");
            let draw = request.draw.as_ref().expect("the module of a drawing pass has its entry points");
            Pipeline::Drawing(render_pipeline(device, &module, draw, &pipeline_layout, state, cache))
        }
    };
    Built { pipeline, layout }
}

#[cfg(test)]
mod tests {
    use super::{PipelineKey, PipelineTable};

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
        for version in 0..100 {
            let edited = key(&version.to_string());
            table.begin([&asked, &edited].into_iter());
            table.put(edited, "edited");
        }
        assert_eq!(table.get(&asked), Some("asked"));
        assert_eq!(table.built.len(), 9, "of a hundred versions");
        assert_eq!((table.get(&key("92")), table.get(&key("91"))), (Some("edited"), None));
    }
}
