//! Robots too large for dense matrices.

use multibody::Model;

use crate::failure::Failure;

/// Degrees of freedom whose matrices, some ten of nv × nv numbers, fit into the memory of a machine.
pub(crate) const MOST: usize = 10_000;

/// Refuses a robot whose matrices no machine holds, before memory is taken for them. `inspect` needs none.
pub(crate) fn refuse_beyond_memory(model: &Model) -> Result<(), Failure> {
    let nv = model.nv();
    if nv <= MOST {
        return Ok(());
    }
    let gigabytes = (nv as f64).powi(2) * 8e-9;
    Err(Failure::new(format!(
        "{}: {nv} degrees of freedom, and {MOST} is the most: one of its matrices alone would take {gigabytes:.0} GB \
         (`dynamics inspect` shows a robot of any size)",
        model.name()
    )))
}
