//! The energy account of a motion as Python's objects.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_dynamics::simulation::{AdaptiveRecord, EnergyAccount, Losses};

use crate::numbers::{object, record};

/// The energy losses by cause; `None` if the method does not separate them.
pub(super) fn losses_of(py: Python<'_>, losses: Option<Losses>) -> PyResult<Bound<'_, PyAny>> {
    let Some(losses) = losses else { return Ok(py.None().into_bound(py)) };
    let fields = [
        ("damping", object(py, losses.damping)?),
        ("friction", object(py, losses.friction)?),
        ("stops", object(py, losses.stops)?),
        ("corrections", object(py, losses.corrections)?),
        ("sliding", object(py, losses.sliding)?),
        ("impacts", object(py, losses.impacts)?),
    ];
    Ok(record(py, fields)?.into_any())
}

/// The energy account at the end of a motion.
pub(super) fn energy_account_of<'py>(
    py: Python<'py>,
    energy_account: &EnergyAccount,
) -> PyResult<Bound<'py, PyDict>> {
    record(
        py,
        [
            ("start", object(py, energy_account.start())?),
            ("kinetic", object(py, energy_account.kinetic())?),
            ("potential", object(py, energy_account.potential())?),
            ("work", object(py, energy_account.work())?),
            ("dissipated", object(py, energy_account.dissipated())?),
            ("imbalance", object(py, energy_account.imbalance())?),
            ("max_imbalance", object(py, energy_account.max_imbalance())?),
            ("energy_moved", object(py, energy_account.energy_moved())?),
            ("relative_imbalance", object(py, energy_account.relative_imbalance())?),
            (
                "drift",
                object(py, if energy_account.is_conservative() { energy_account.drift() } else { f64::NAN })?,
            ),
        ],
    )
}

/// The statistics of the steps of an adaptive run.
pub(super) fn statistics_of<'py>(py: Python<'py>, run: &AdaptiveRecord) -> PyResult<Bound<'py, PyDict>> {
    record(
        py,
        [
            ("accepted", object(py, run.statistics.accepted)?),
            ("rejected", object(py, run.statistics.rejected)?),
            ("evaluations", object(py, run.statistics.evaluations)?),
            ("shortest", object(py, run.statistics.shortest)?),
            ("longest", object(py, run.statistics.longest)?),
            ("quaternion_error", object(py, run.quaternion_error)?),
        ],
    )
}
