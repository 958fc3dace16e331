//! The limit on the size of robots that need dense matrices.

use robot_dynamics::model::Model;

use crate::failure::Failure;

/// Degrees of freedom whose matrices, about ten of nv × nv numbers, fit into memory.
pub(crate) const MAX_DOFS: usize = 10_000;

/// Rejects a robot whose matrices do not fit into memory, before they are allocated. `inspect` needs none.
pub(crate) fn refuse_beyond_memory(model: &Model) -> Result<(), Failure> {
    let nv = model.nv();
    if nv <= MAX_DOFS {
        return Ok(());
    }
    let gigabytes = (nv as f64).powi(2) * 8e-9;
    Err(Failure::new(format!(
        "{}: {nv} degrees of freedom, at most {MAX_DOFS} are supported: each dense matrix would take \
         {gigabytes:.0} GB (`dynamics inspect` works for any size)",
        model.name()
    )))
}
