//! Storage of the kernels.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use robot_dynamics_native::Kernel;

use super::function::{NativeFunction, NativeTask};
use crate::FrameId;

/// A kernel, or the reason why the function has no code.
pub(in crate::model) type Slot<T> = Result<Kernel<T>, String>;

/// The largest number of frame kernels that a model keeps for each scalar type and width, as each takes a
/// page of memory or more.
const MOST_OF_FRAMES: usize = 256;

/// The least such number, for large robots.
const LEAST_OF_FRAMES: usize = 16;

/// The limit of kernels times bodies: writing a kernel takes time in proportion to the bodies, about 10 µs
/// each.
const MOST_BODIES: usize = 10_000;

/// The kernels over one scalar type.
#[derive(Debug)]
pub struct Kernels<T> {
    pub(in crate::model) one: Slots<T>,
    pub(in crate::model) rows: Slots<T>,
}

impl<T> Kernels<T> {
    pub(in crate::model) fn new() -> Self {
        Self { one: Slots::new(), rows: Slots::new() }
    }
}

/// A kernel for each function, and one for each frame and function of a frame.
#[derive(Debug)]
pub(in crate::model) struct Slots<T> {
    functions: [OnceLock<Slot<T>>; NativeFunction::ALL.len()],
    frames: OnceLock<FrameSlots<T>>,
}

/// The sizes of a model that limit its kernels of frames.
pub(in crate::model) struct ModelSizes {
    pub frames: usize,
    pub bodies: usize,
}

/// Functions of one frame are contiguous, frame after frame.
#[derive(Debug)]
struct FrameSlots<T> {
    kernels: Box<[OnceLock<Box<Slot<T>>>]>,
    compiled: AtomicUsize,
    most: usize,
}

impl<T> Slots<T> {
    pub(in crate::model) fn new() -> Self {
        Self { functions: core::array::from_fn(|_| OnceLock::new()), frames: OnceLock::new() }
    }

    /// The kernel of a task, compiled at the first call.
    #[inline]
    pub(in crate::model) fn kernel(
        &self,
        task: NativeTask,
        counts: impl FnOnce() -> ModelSizes,
        compile: impl FnOnce() -> Slot<T>,
    ) -> Option<&Kernel<T>> {
        let slot = match task.frame {
            None => self.functions[task.function as usize].get_or_init(compile),
            Some(frame) => {
                let frames = self.frames.get_or_init(|| FrameSlots::new(counts()));
                frames.kernels[place(task.function, frame)].get_or_init(|| frames.limited(compile))
            }
        };
        slot.as_ref().ok()
    }

    /// The kernel of a task, if it was called before.
    pub(in crate::model) fn get(&self, task: NativeTask) -> Option<&Slot<T>> {
        match task.frame {
            None => self.functions[task.function as usize].get(),
            Some(frame) => self.frames.get()?.kernels[place(task.function, frame)].get().map(Box::as_ref),
        }
    }

    /// Whether a function of a frame was called.
    pub(in crate::model) fn has_frames(&self) -> bool {
        self.frames.get().is_some()
    }
}

impl<T> FrameSlots<T> {
    #[cold]
    fn new(ModelSizes { frames, bodies }: ModelSizes) -> Self {
        let count = frames * NativeFunction::OF_FRAMES.len();
        let kernels = core::iter::repeat_with(OnceLock::new).take(count).collect();
        let most = (MOST_BODIES / bodies.max(1)).clamp(LEAST_OF_FRAMES, MOST_OF_FRAMES);
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

/// All functions, and the functions of this many frames of the robot with this identity.
pub(in crate::model) fn tasks(frames: usize, robot: u64) -> impl Iterator<Item = NativeTask> {
    let is_plain = |function: &NativeFunction| !NativeFunction::OF_FRAMES.contains(function);
    let plain = NativeFunction::ALL.into_iter().filter(is_plain).map(NativeTask::from);
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
