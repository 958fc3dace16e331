//! The machine code of a model: a kernel for each function, scalar type and width.

use std::sync::{Arc, OnceLock};

use robot_dynamics_expression::Arithmetic;
use robot_dynamics_native::{Kernel, Width, best_instructions};

use super::NativeTask;
use super::report::{NativeCode, NativeReport, NativeUse};
use super::size::{estimated_operations, most_operations};
use super::slots::{Kernels, ModelSizes, Slot, tasks};
use crate::model::robot::{Code, Native, Tracer};
use crate::{InstructionSet, Model};

/// A scalar type of kernels.
pub trait Number: robot_dynamics_native::Float {
    const NAME: &'static str;
    fn kernels(code: &Code) -> &Kernels<Self>;
}

impl Number for f64 {
    const NAME: &'static str = "f64";
    fn kernels(code: &Code) -> &Kernels<Self> {
        &code.f64
    }
}

impl Number for f32 {
    const NAME: &'static str = "f32";
    fn kernels(code: &Code) -> &Kernels<Self> {
        &code.f32
    }
}

impl Native {
    pub fn new(tracer: Tracer) -> Self {
        Self(Some(Arc::new(Code::new(tracer, true))))
    }

    /// Switches machine code on or off. A change discards the code; the next calls compile it again.
    pub fn switch(&mut self, on: bool) {
        if let Some(code) = &mut self.0
            && code.is_on != on
        {
            *code = Arc::new(Code::new(code.tracer, on));
        }
    }

    /// The code, if it is switched on.
    #[inline]
    pub fn code(&self) -> Option<&Code> {
        self.0.as_deref().filter(|code| code.is_on)
    }

    pub(super) fn report(&self, model: &Model) -> NativeReport {
        let no_functions = |reason: &str| NativeReport { reason: Some(reason.into()), functions: Vec::new() };
        match self.0.as_deref() {
            None => no_functions("the model has no tracer"),
            Some(_) if is_refused() => no_functions("ROBOT_DYNAMICS_NATIVE=0"),
            Some(code) if !code.is_on => no_functions("switched off for this model"),
            Some(_) if best_instructions() == InstructionSet::Portable => {
                no_functions("there is no encoder for this processor")
            }
            Some(code) => {
                let functions = code.uses::<f64>(model).chain(code.uses::<f32>(model)).collect();
                NativeReport { reason: None, functions }
            }
        }
    }
}

/// Whether the environment switches machine code off.
fn is_refused() -> bool {
    static REFUSED: OnceLock<bool> = OnceLock::new();
    *REFUSED.get_or_init(|| std::env::var("ROBOT_DYNAMICS_NATIVE").is_ok_and(|value| value == "0"))
}

/// The sizes of a model that limit its kernels of frames.
fn counts(model: &Model) -> ModelSizes {
    ModelSizes { frames: model.frames.len(), bodies: model.bodies.len() }
}

impl Code {
    fn new(tracer: Tracer, on: bool) -> Self {
        let is_on = on && !is_refused();
        let (f64, f32) = (Kernels::new(), Kernels::new());
        Self { tracer, is_on, f64, f32 }
    }

    /// The kernel of this function for one state, compiled at the first call.
    #[inline]
    pub fn one<T: Number>(&self, model: &Model, task: impl Into<NativeTask>) -> Option<&Kernel<T>> {
        let task = task.into();
        T::kernels(self).one.kernel(task, || counts(model), || self.compile(model, task, Width::One))
    }

    /// The same for several states.
    pub fn rows<T: Number>(&self, model: &Model, task: impl Into<NativeTask>) -> Option<&Kernel<T>> {
        let task = task.into();
        T::kernels(self).rows.kernel(task, || counts(model), || self.compile(model, task, Width::Lanes))
    }

    #[cold]
    #[inline(never)]
    fn compile<T: Number>(&self, model: &Model, task: NativeTask, width: Width) -> Slot<T> {
        let NativeTask { function, frame } = task;
        let (most, about) = (most_operations(function, width), estimated_operations(model, task));
        if about > most {
            return Err(format!("which needs some {about} operations; machine code pays up to {most}"));
        }
        let arithmetic = Arithmetic::new(T::PRECISION).with_fused();
        let frame = frame.map(|frame| model.frame_of(frame).name.as_str());
        let super::NativeTrace { graph, results, lengths } =
            (self.tracer)(model, function, frame, arithmetic)?;
        let operations = graph.nodes.len();
        if operations > most {
            return Err(format!("which needs {operations} operations; machine code pays up to {most}"));
        }
        Kernel::compile(&graph, &results, &lengths, arithmetic, best_instructions(), width)
            .map_err(|error| error.to_string())
    }

    fn uses<'a, T: Number>(&'a self, model: &'a Model) -> impl Iterator<Item = NativeUse> + use<'a, T> {
        let Kernels { one, rows } = T::kernels(self);
        let of = move |task: NativeTask| {
            [(one.get(task), false), (rows.get(task), true)].into_iter().filter_map(
                move |(slot, is_batch)| {
                    let route = slot?.as_ref().map_err(Clone::clone).map(|kernel| NativeCode {
                        instructions: kernel.target().instructions,
                        operations: kernel.statistics().operations,
                        bytes: kernel.code_len(),
                    });
                    let frame = task.frame.map(|frame| model.frame_of(frame).name.clone());
                    Some(NativeUse { function: task.function, frame, number: T::NAME, is_batch, route })
                },
            )
        };
        let has_frames = one.has_frames() || rows.has_frames();
        let frames = if has_frames { model.frames.len() } else { 0 };
        tasks(frames, model.identity.hash()).flat_map(of)
    }
}
