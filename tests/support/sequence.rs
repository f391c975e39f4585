//! A session on the shared device, frame by frame.

use std::sync::{Mutex, MutexGuard};

use afterimage::offline::Session;
use afterimage_gpu::{FrameKind, FrameStep, InputImage};
use afterimage_graph::node::Camera;

use super::gpu::{Picture, Run, Shared, gpu};

pub struct Sequence<'r> {
    run: &'r Run<'r>,
    session: Option<Session>,
    _gpu: Shared,
}

/// Sessions that no test uses, each with what it has compiled.
static IDLE: Mutex<Vec<Session>> = Mutex::new(Vec::new());

fn idle() -> MutexGuard<'static, Vec<Session>> {
    IDLE.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

impl Drop for Sequence<'_> {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            idle().extend(self.session.take());
        }
    }
}

impl<'r> Sequence<'r> {
    pub fn new(run: &'r Run<'r>) -> Self {
        let gpu = gpu();
        let is_fit = |session: &Session| session.gpu().caps.prefer_fragment == run.prefer_fragment;
        let last = |idle: &mut Vec<Session>| idle.iter().rposition(is_fit).map(|index| idle.remove(index));
        let session = match last(&mut idle()) {
            Some(session) => run.reset(session),
            None => run.session(&gpu),
        };
        Self { run, session: Some(session), _gpu: gpu }
    }

    fn session(&mut self) -> &mut Session {
        self.session.as_mut().expect("it is taken when this is dropped")
    }

    /// The next frame is the first one, also for noise.
    pub fn restart(&mut self) {
        self.session().restart();
    }

    /// The camera of the frames from now on, for the input `camera`.
    pub fn camera(&mut self, camera: &Camera) {
        self.session().set_block("camera", camera.data().expect("its matrices have inverses"));
    }

    /// One frame with these pictures.
    pub fn frame(&mut self, inputs: &[(&str, &Picture)], dt: f32, reset: bool) {
        let images: Vec<InputImage> = inputs.iter().map(|(name, picture)| self.feed(name, picture)).collect();
        let step = FrameStep { time: self.run.time, dt, kind: FrameKind::cut_if(reset) };
        let size = self.run.size_for(inputs);
        let rendered = self.session().render(size, &images, step);
        rendered.unwrap_or_else(|error| panic!("{error}"));
    }

    fn feed(&mut self, name: &str, picture: &Picture) -> InputImage {
        let texels = self.run.texels(name, picture);
        self.session().feed(name, texels.desc, &texels.bytes).unwrap_or_else(|error| panic!("{error}"))
    }

    /// An output of the last frame.
    pub fn output(&mut self, name: &str) -> Picture {
        Picture::of(&self.session().output(name).unwrap_or_else(|error| panic!("{error}")))
    }

    /// All outputs of the last frame, in the order of the file.
    pub fn outputs(&mut self) -> Vec<Picture> {
        let names: Vec<String> = self.session().plan().outputs.iter().map(|output| output.name.clone()).collect();
        names.iter().map(|name| self.output(name)).collect()
    }
}
