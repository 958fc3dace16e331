//! Writers of files, one for each target.

mod c;
mod casadi;
mod context;
mod cuda;
mod cuda_kernel;
mod cuda_stages;
mod lanes;
mod placement;
mod rust;
mod sine;
mod wgsl;
mod wgsl_stages;

pub(crate) use c::table as c_table;
pub(crate) use context::Context;
pub use wgsl::WGSL_WORKGROUP;

use self::placement::layout_for_places;
use crate::Target;
use crate::body::every_number;
use crate::generated_files::GeneratedFile;
use crate::layout::Layout;
use crate::program::Program;
use crate::request::Request;

/// The files of a request, except its report.
pub(crate) fn files(context: &Context<'_>) -> Vec<GeneratedFile> {
    match context.request.target {
        Target::Rust => rust::files(context),
        Target::C => c::files(context),
        Target::Casadi => casadi::files(context),
        Target::Wgsl => wgsl::files(context),
        Target::Cuda => cuda::files(context),
    }
}

/// The layout of a program for the target.
pub(crate) fn layout(request: &Request, program: &Program) -> Layout {
    match request.target {
        Target::Casadi => casadi::layout(request, program),
        Target::Rust | Target::C | Target::Wgsl | Target::Cuda => {
            layout_for_places(request, program, &every_number)
        }
    }
}
