//! The machine code of a model's functions, a kernel for each function, number and width.

use std::sync::{Arc, OnceLock};

use expression::Arithmetic;
use native::{Kernel, Width, best_instructions};

use super::report::{NativeCode, NativeReport, NativeUse};
use super::size::{estimated_operations, most_operations};
use super::{NativeFunction, Tracer};
use crate::{InstructionSet, Model};

/// The machine code of a model, if it has a tracer.
#[derive(Clone, Debug, Default)]
pub(crate) struct Native(Option<Arc<Code>>);

/// All machine code of a model.
#[derive(Debug)]
pub(crate) struct Code {
    tracer: Tracer,
    is_on: bool,
    f64: Kernels<f64>,
    f32: Kernels<f32>,
}

/// The kernels over one number.
#[derive(Debug)]
pub(crate) struct Kernels<T> {
    one: [OnceLock<Slot<T>>; NativeFunction::ALL.len()],
    rows: [OnceLock<Slot<T>>; NativeFunction::ALL.len()],
}

/// A kernel, or why there is none.
type Slot<T> = Result<Kernel<T>, String>;

/// A number that kernels are of.
pub(crate) trait Number: native::Float {
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
    pub(crate) fn new(tracer: Tracer) -> Self {
        Self(Some(Arc::new(Code::new(tracer, true))))
    }

    /// Code that is not made yet, where the model has changed.
    pub(crate) fn switch(&mut self, on: bool) {
        if let Some(code) = &mut self.0
            && code.is_on != on
        {
            *code = Arc::new(Code::new(code.tracer, on));
        }
    }

    /// The code, where it is on.
    #[inline]
    pub(crate) fn code(&self) -> Option<&Code> {
        self.0.as_deref().filter(|code| code.is_on)
    }

    pub(super) fn report(&self) -> NativeReport {
        let no_functions = |reason: &str| NativeReport { reason: Some(reason.into()), functions: Vec::new() };
        match self.0.as_deref() {
            None => no_functions("the model has no tracer"),
            Some(_) if is_refused() => no_functions("ROBOT_DYNAMICS_NATIVE=0"),
            Some(code) if !code.is_on => no_functions("switched off for this model"),
            Some(_) if best_instructions() == InstructionSet::Portable => {
                no_functions("there is no encoder for this processor")
            }
            Some(code) => {
                let functions = code.uses::<f64>().chain(code.uses::<f32>()).collect();
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

impl Code {
    fn new(tracer: Tracer, on: bool) -> Self {
        let is_on = on && !is_refused();
        Self { tracer, is_on, f64: Kernels::new(), f32: Kernels::new() }
    }

    /// The kernel of this function for one state, compiled at the first call.
    #[inline]
    pub(crate) fn one<T: Number>(&self, model: &Model, function: NativeFunction) -> Option<&Kernel<T>> {
        let slot = &T::kernels(self).one[function as usize];
        slot.get_or_init(|| self.compile(model, function, Width::One)).as_ref().ok()
    }

    /// The same for several states.
    #[cfg(feature = "batch")]
    pub(crate) fn rows<T: Number>(&self, model: &Model, function: NativeFunction) -> Option<&Kernel<T>> {
        let slot = &T::kernels(self).rows[function as usize];
        slot.get_or_init(|| self.compile(model, function, Width::Lanes)).as_ref().ok()
    }

    #[cold]
    #[inline(never)]
    fn compile<T: Number>(&self, model: &Model, function: NativeFunction, width: Width) -> Slot<T> {
        let (most, about) = (most_operations(function, width), estimated_operations(model, function));
        if about > most {
            return Err(format!("which needs some {about} operations; machine code pays up to {most}"));
        }
        let arithmetic = Arithmetic::new(T::PRECISION).with_fused();
        let super::NativeTrace { graph, results, lengths } = (self.tracer)(model, function, arithmetic)?;
        let operations = graph.nodes.len();
        if operations > most {
            return Err(format!("which needs {operations} operations; machine code pays up to {most}"));
        }
        Kernel::compile(&graph, &results, &lengths, arithmetic, best_instructions(), width)
            .map_err(|error| error.to_string())
    }

    fn uses<T: Number>(&self) -> impl Iterator<Item = NativeUse> {
        let Kernels { one, rows } = T::kernels(self);
        NativeFunction::ALL.into_iter().flat_map(move |function| {
            let slots = [(&one[function as usize], false), (&rows[function as usize], true)];
            slots.into_iter().filter_map(move |(slot, is_batch)| {
                let route = slot.get()?.as_ref().map_err(Clone::clone).map(|kernel| NativeCode {
                    instructions: kernel.target().instructions,
                    operations: kernel.statistics().operations,
                    bytes: kernel.code_len(),
                });
                Some(NativeUse { function, number: T::NAME, is_batch, route })
            })
        })
    }
}

impl<T> Kernels<T> {
    fn new() -> Self {
        let slots = || core::array::from_fn(|_| OnceLock::new());
        Self { one: slots(), rows: slots() }
    }
}
