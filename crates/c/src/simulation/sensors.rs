//! The sensors of the robot's file.

use std::ffi::c_char;

use crate::Status;
use crate::arrays::Arrays;
use crate::calls::{call, query};
use crate::failure::Failure;
use crate::handle::shared;

use super::{RobotSimulation, SimulationHandle, text_of};

/// The number of sensors; 0 if the handle is invalid.
#[unsafe(no_mangle)]
pub extern "C" fn rd_simulation_sensor_count(simulation: SimulationHandle) -> usize {
    query(0, || Ok(shared::<RobotSimulation>(simulation.id)?.sensors.names.len()))
}

/// The name of a sensor; null for any other number.
#[unsafe(no_mangle)]
pub extern "C" fn rd_simulation_sensor_name(simulation: SimulationHandle, sensor: usize) -> *const c_char {
    text_of(simulation, |own| own.sensors.names.get(sensor).map(|name| name.as_ptr()))
}

/// The place of a sensor's values in `rd_simulation_sensors`: the first one and their number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_simulation_sensor_range(
    simulation: SimulationHandle,
    sensor: usize,
    first: *mut usize,
    count: *mut usize,
) -> Status {
    call(|| {
        let own = shared::<RobotSimulation>(simulation.id)?;
        let mut arrays = Arrays::default();
        let first = arrays.result("the result `first`", first)?;
        let count = arrays.result("the result `count`", count)?;
        let sensors = &own.sensors;
        if sensor >= sensors.names.len() {
            let text = format!("there is no sensor {sensor}; there are {}", sensors.names.len());
            return Err(Failure::invalid(text));
        }
        (*first, *count) = (sensors.starts[sensor], sensors.starts[sensor + 1] - sensors.starts[sensor]);
        Ok(())
    })
}

/// The number of values of all sensors; 0 if the handle is invalid.
#[unsafe(no_mangle)]
pub extern "C" fn rd_simulation_sensor_value_count(simulation: SimulationHandle) -> usize {
    query(0, || Ok(shared::<RobotSimulation>(simulation.id)?.sensors.starts.last().copied().unwrap_or(0)))
}

/// The values of all sensors at the end of the last step, in the order of the file. Allocates.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_simulation_sensors(
    simulation: SimulationHandle,
    values: *mut f64,
    values_len: usize,
) -> Status {
    call(|| {
        let own = shared::<RobotSimulation>(simulation.id)?;
        let found: Vec<f64> = own.simulation.sensors().into_iter().flat_map(|(_, values)| values).collect();
        Arrays::default().output("the result", values, values_len, found.len())?.copy_from_slice(&found);
        Ok(())
    })
}
