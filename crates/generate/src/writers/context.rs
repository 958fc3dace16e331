//! The input of all writers.

use robot_dynamics::model::Model;
use robot_dynamics_expression::Arithmetic;

use crate::Request;
use crate::layout::Layout;
use crate::program::Program;
use crate::syntax::Helpers;

/// The input of all writers of files.
pub(crate) struct Context<'a> {
    pub(crate) model: &'a Model,
    pub(crate) request: &'a Request,
    /// The name of files and functions.
    pub(crate) name: &'a str,
    pub(crate) programs: &'a [Program],
    /// The layout of each program.
    pub(crate) layouts: &'a [Layout],
}

impl Context<'_> {
    /// The programs with their layouts.
    pub(crate) fn functions(&self) -> impl Iterator<Item = (&Program, &Layout)> {
        self.programs.iter().zip(self.layouts)
    }

    /// Whether a function has loops over bodies.
    pub(crate) fn has_loops(&self) -> bool {
        self.layouts.iter().any(Layout::has_loops)
    }

    pub(crate) fn arithmetic(&self) -> Arithmetic {
        self.request.arithmetic
    }

    pub(crate) fn helpers(&self) -> Helpers {
        let stages = self.programs.iter().filter_map(|program| program.stages.as_ref());
        let stages = stages.flat_map(|stages| &stages.stages).map(|stage| &stage.program);
        let programs = self.programs.iter().chain(stages);
        Helpers::of(programs.map(|program| (&program.graph, &program.plan)), self.arithmetic())
    }
}
