//! Storage of the kernels over one scalar type and of one width.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use robot_dynamics_native::Kernel;

use crate::model::native::{NativeFunction, NativeTask};
use crate::{FrameId, Model};

/// A kernel, or the reason why the function has no code.
pub(super) type Slot<T> = Result<Kernel<T>, String>;

/// The largest number of frame kernels that a model keeps for each scalar type and width, as each takes a
/// page of memory or more.
const MOST_OF_FRAMES: usize = 256;

/// The least such number, for large robots.
const LEAST_OF_FRAMES: usize = 16;

/// The limit of kernels times bodies: writing a kernel takes time in proportion to the bodies, about 10 µs
/// each.
const MOST_BODIES: usize = 10_000;

/// A kernel for each function, and one for each frame and function of a frame.
#[derive(Debug)]
pub(super) struct Slots<T> {
    functions: [OnceLock<Slot<T>>; NativeFunction::ALL.len()],
    frames: OnceLock<OfFrames<T>>,
}

/// Functions of one frame are contiguous, frame after frame.
#[derive(Debug)]
struct OfFrames<T> {
    kernels: Box<[OnceLock<Box<Slot<T>>>]>,
    compiled: AtomicUsize,
    most: usize,
}

impl<T> Slots<T> {
    pub(super) fn new() -> Self {
        Self { functions: core::array::from_fn(|_| OnceLock::new()), frames: OnceLock::new() }
    }

    /// The kernel of a task, compiled at the first call.
    #[inline]
    pub(super) fn kernel(
        &self,
        model: &Model,
        task: NativeTask,
        compile: impl FnOnce() -> Slot<T>,
    ) -> Option<&Kernel<T>> {
        let slot = match task.frame {
            None => self.functions[task.function as usize].get_or_init(compile),
            Some(frame) => {
                let frames = self.frames.get_or_init(|| OfFrames::new(model));
                frames.kernels[place(task.function, frame)].get_or_init(|| frames.limited(compile))
            }
        };
        slot.as_ref().ok()
    }

    /// The kernel of a task, if it was called before.
    pub(super) fn get(&self, task: NativeTask) -> Option<&Slot<T>> {
        match task.frame {
            None => self.functions[task.function as usize].get(),
            Some(frame) => self.frames.get()?.kernels[place(task.function, frame)].get().map(Box::as_ref),
        }
    }

    /// Whether a function of a frame was called.
    pub(super) fn has_frames(&self) -> bool {
        self.frames.get().is_some()
    }
}

impl<T> OfFrames<T> {
    #[cold]
    fn new(model: &Model) -> Self {
        let count = model.frames.len() * NativeFunction::OF_FRAMES.len();
        let kernels = core::iter::repeat_with(OnceLock::new).take(count).collect();
        let most = (MOST_BODIES / model.bodies.len().max(1)).clamp(LEAST_OF_FRAMES, MOST_OF_FRAMES);
        Self { kernels, compiled: AtomicUsize::new(0), most }
    }

    /// The kernel, or the reason for its absence: too many kernels of frames.
    fn limited(&self, compile: impl FnOnce() -> Slot<T>) -> Box<Slot<T>> {
        if self.compiled.fetch_add(1, Ordering::Relaxed) >= self.most {
            return Box::new(Err(format!("as {} functions of frames have machine code already", self.most)));
        }
        Box::new(compile())
    }
}

/// All functions, with the functions of all frames if requested.
pub(super) fn tasks(model: &Model, has_frames: bool) -> impl Iterator<Item = NativeTask> + use<> {
    let is_plain = |function: &NativeFunction| !NativeFunction::OF_FRAMES.contains(function);
    let plain = NativeFunction::ALL.into_iter().filter(is_plain).map(NativeTask::from);
    let (frames, robot) = (if has_frames { model.frames.len() } else { 0 }, model.identity.hash());
    let of_frame =
        move |index| NativeFunction::OF_FRAMES.map(|function| function.of_frame(FrameId { index, robot }));
    plain.chain((0..frames).flat_map(of_frame))
}

/// The index of the kernel of a frame.
#[inline]
fn place(function: NativeFunction, frame: FrameId) -> usize {
    let first = NativeFunction::OF_FRAMES[0] as usize;
    frame.index * NativeFunction::OF_FRAMES.len() + (function as usize - first)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_of_frames_stand_beside_each_other() {
        let frame = FrameId { index: 3, robot: 0 };
        let places = NativeFunction::OF_FRAMES.map(|function| place(function, frame));
        assert_eq!(places, [12, 13, 14, 15]);
        assert!(
            NativeFunction::ALL.into_iter().enumerate().all(|(index, function)| function as usize == index)
        );
    }
}
