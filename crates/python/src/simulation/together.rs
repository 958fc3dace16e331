//! Many simulations that take their steps side by side.

use pyo3::prelude::*;
use rayon::prelude::*;
use robot_dynamics::simulator::Simulation as Stepped;

use super::stepping::Simulation;
use crate::numbers::shaped;
use crate::outcome;
use crate::threads;

/// q (n, nq) and v (n, nv), and which simulations failed.
type States<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>, Vec<usize>);

/// Takes so many steps of each simulation of one robot, under torques (n, nv) and controls (n, controls) that are held.
///
/// A simulation that fails stays where it failed, and the others go on.
#[pyfunction]
#[pyo3(signature = (simulations, torques, controls, count, threads))]
pub(crate) fn _step_together<'py>(
    py: Python<'py>,
    mut simulations: Vec<PyRefMut<'py, Simulation>>,
    torques: &Bound<'py, PyAny>,
    controls: &Bound<'py, PyAny>,
    count: usize,
    threads: Option<&Bound<'py, PyAny>>,
) -> PyResult<States<'py>> {
    let rows = simulations.len();
    let width = |of: fn(&Simulation) -> usize| simulations.first().map_or(0, |one| of(one));
    let (nq, nv) = (width(|one| one.stepped.q().len()), width(|one| one.stepped.v().len()));
    let inputs = width(|one| one.stepped.controls().len());
    let (_, torques) = shaped(py, "torques", torques, &[rows, nv])?;
    let (_, controls) = shaped(py, "controls", controls, &[rows, inputs])?;
    let threads = threads::count_of(threads)?.unwrap_or_else(threads::default_count);
    for (row, simulation) in simulations.iter_mut().enumerate() {
        simulation.stepped.set_torques(&torques[row * nv..(row + 1) * nv]);
        simulation.stepped.set_controls(&controls[row * inputs..(row + 1) * inputs]);
    }
    let fails = |simulation: &mut Stepped| (0..count).try_for_each(|_| simulation.step()).is_err();
    let mut stepped: Vec<_> = simulations.iter_mut().map(|simulation| &mut simulation.stepped).collect();
    let failed: Vec<bool> = py.detach(|| {
        if threads == 1 {
            return Ok(stepped.iter_mut().map(|simulation| fails(simulation)).collect());
        }
        let pool = threads::pool(threads)?;
        PyResult::Ok(pool.install(|| stepped.par_iter_mut().map(|simulation| fails(simulation)).collect()))
    })?;
    py.check_signals()?;
    let (mut q, mut v) = (Vec::with_capacity(rows * nq), Vec::with_capacity(rows * nv));
    for simulation in &stepped {
        q.extend_from_slice(simulation.q());
        v.extend_from_slice(simulation.v());
    }
    let failed = (0..rows).filter(|row| failed[*row]).collect();
    Ok((outcome::filled(py, &[rows, nq], &q)?, outcome::filled(py, &[rows, nv], &v)?, failed))
}
