//! Inertial parameters from measured motions.

use std::ffi::{CString, c_char};
use std::sync::Arc;

use robot_dynamics::control::identification::{
    BaseParameters, ConsistentOptions, JointTerm, JointTermKind, MotionRecord, identify_consistent,
};
use robot_dynamics::description::LoadReport;
use robot_dynamics::model::Model;

use crate::Status;
use crate::arrays::{Arrays, c_text, result};
use crate::calls::{call, query};
use crate::failure::Failure;
use crate::handle::{exclusive, insert, object, remove, shared};
use crate::model::{ModelHandle, RobotModel};

/// A record of measured motions.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MotionRecordHandle {
    /// The handle; 0 names no object.
    pub id: u64,
}

pub(crate) struct Record {
    model: Arc<Model>,
    with_dissipation: bool,
    terms: Vec<JointTerm>,
    noise: Option<Vec<f64>>,
    /// (q, v, a, tau) of each sample.
    samples: Vec<[Vec<f64>; 4]>,
    names: Vec<CString>,
}

object!(Record, 10, "the record");

/// The parameters of joints that a record identifies beside the inertial ones: bits of `joint_terms`.
pub const RD_TERM_DAMPING: u32 = 1;
/// Dry friction.
pub const RD_TERM_FRICTION: u32 = 2;
/// The reflected inertia of motors.
pub const RD_TERM_ARMATURE: u32 = 4;
/// A constant torque.
pub const RD_TERM_OFFSET: u32 = 8;

impl Record {
    fn record(&self) -> Result<MotionRecord<'_>, Failure> {
        let mut record = MotionRecord::new(&self.model, self.with_dissipation).with_terms(&self.terms)?;
        if let Some(noise) = &self.noise {
            record = record.with_noise(noise)?;
        }
        for [q, v, a, tau] in &self.samples {
            record.push(q, v, a, tau)?;
        }
        Ok(record)
    }
}

/// Makes an empty record. `dissipation`: not 0 if the torques include damping and friction of the model.
/// `joint_terms`: bits of `RD_TERM_…`. Free it with `rd_motion_record_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_motion_record_new(
    model: ModelHandle,
    dissipation: i32,
    joint_terms: u32,
    record: *mut MotionRecordHandle,
) -> Status {
    call(|| {
        let out = result("the result `record`", record)?;
        let robot = shared::<RobotModel>(model.id)?;
        let all = [
            (RD_TERM_DAMPING, JointTermKind::Damping),
            (RD_TERM_FRICTION, JointTermKind::Friction),
            (RD_TERM_ARMATURE, JointTermKind::Armature),
            (RD_TERM_OFFSET, JointTermKind::Offset),
        ];
        if joint_terms >= 16 {
            return Err(Failure::invalid(format!("the joint terms have unknown bits: {joint_terms}")));
        }
        let kinds: Vec<JointTermKind> =
            all.into_iter().filter(|(bit, _)| joint_terms & bit != 0).map(|(_, kind)| kind).collect();
        let mut record = Record {
            model: Arc::clone(&robot.model),
            with_dissipation: dissipation != 0,
            terms: JointTerm::of_all(&robot.model, &kinds),
            noise: None,
            samples: Vec::new(),
            names: Vec::new(),
        };
        record.names = record.record()?.parameter_names().iter().map(|name| c_text(name)).collect();
        out.id = insert(record)?;
        Ok(())
    })
}

/// Frees a record. The null handle is ignored.
#[unsafe(no_mangle)]
pub extern "C" fn rd_motion_record_free(record: MotionRecordHandle) -> Status {
    call(|| remove::<Record>(record.id))
}

/// States the standard deviation of the noise of each torque, nv positive numbers \[N m or N\].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_motion_record_set_noise(
    record: MotionRecordHandle,
    deviations: *const f64,
    deviations_len: usize,
) -> Status {
    call(|| {
        let mut own = exclusive::<Record>(record.id)?;
        let deviations = Arrays::default().any("the deviations", deviations, deviations_len)?;
        MotionRecord::new(&own.model, own.with_dissipation).with_noise(deviations)?;
        own.noise = Some(deviations.to_vec());
        Ok(())
    })
}

/// Adds a sample: a state, its acceleration and the measured torque. Allocates.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_motion_record_push(
    record: MotionRecordHandle,
    q: *const f64,
    nq: usize,
    v: *const f64,
    nv: usize,
    a: *const f64,
    a_len: usize,
    tau: *const f64,
    tau_len: usize,
) -> Status {
    call(|| {
        let mut own = exclusive::<Record>(record.id)?;
        let (n, mut arrays) = (own.model.nv(), Arrays::default());
        let q = arrays.input("q", q, nq, own.model.nq())?;
        let v = arrays.input("v", v, nv, n)?;
        let a = arrays.input("a", a, a_len, n)?;
        let tau = arrays.input("tau", tau, tau_len, n)?;
        MotionRecord::new(&own.model, own.with_dissipation).push(q, v, a, tau)?;
        own.samples.push([q, v, a, tau].map(<[f64]>::to_vec));
        Ok(())
    })
}

/// The number of parameters of a record: inertial ones and joint terms; 0 if the handle is invalid.
#[unsafe(no_mangle)]
pub extern "C" fn rd_motion_record_parameter_count(record: MotionRecordHandle) -> usize {
    query(0, || Ok(shared::<Record>(record.id)?.names.len()))
}

/// The name of a parameter, such as `forearm.m`; null for any other number. It is valid until the record is
/// freed.
#[unsafe(no_mangle)]
pub extern "C" fn rd_motion_record_parameter_name(
    record: MotionRecordHandle,
    parameter: usize,
) -> *const c_char {
    query(std::ptr::null(), || {
        let own = shared::<Record>(record.id)?;
        let missing =
            || Failure::invalid(format!("there is no parameter {parameter}; there are {}", own.names.len()));
        Ok(own.names.get(parameter).ok_or_else(missing)?.as_ptr())
    })
}

/// Estimates the base parameters by least squares: the combinations that the motions determine.
///
/// For base parameter k, `indices[k]` is the number of the parameter that names it, `values[k]` its value and
/// `deviations[k]` its standard deviation. The arrays have room for `capacity` numbers each; `count` is the
/// number of base parameters. `residual` is the root mean square of the torques' errors. Allocates.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_identify(
    record: MotionRecordHandle,
    indices: *mut u32,
    values: *mut f64,
    deviations: *mut f64,
    capacity: usize,
    count: *mut usize,
    residual: *mut f64,
) -> Status {
    call(|| {
        let own = shared::<Record>(record.id)?;
        let mut arrays = Arrays::default();
        let indices = arrays.output("the indices", indices, capacity, capacity)?;
        let values = arrays.output("the values", values, capacity, capacity)?;
        let deviations = arrays.output("the deviations", deviations, capacity, capacity)?;
        let count = arrays.result("the result `count`", count)?;
        let residual = arrays.optional_result("the residual", residual)?;
        let record = own.record()?;
        let base = BaseParameters::of_record(&record);
        let found = base.identify(&record)?;
        *count = base.len();
        if let Some(residual) = residual {
            *residual = found.residual;
        }
        for (k, parameter) in base.parameters.iter().enumerate().take(capacity) {
            indices[k] = parameter.index as u32;
            values[k] = found.values[k];
            deviations[k] = found.standard_deviations[k];
        }
        Ok(())
    })
}

/// Estimates parameters with which every link is a possible body. `regularization` weighs the distance from
/// the described robot, 1e-3 for example. `parameters` has one number for each parameter of the record.
/// `model` may be null; else it is the robot with these parameters. Allocates.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_identify_consistent(
    record: MotionRecordHandle,
    regularization: f64,
    parameters: *mut f64,
    parameters_len: usize,
    residual: *mut f64,
    model: *mut ModelHandle,
) -> Status {
    call(|| {
        let own = shared::<Record>(record.id)?;
        let mut arrays = Arrays::default();
        let out = arrays.output("the parameters", parameters, parameters_len, own.names.len())?;
        let residual = arrays.optional_result("the residual", residual)?;
        let model = arrays.optional_result("the result `model`", model)?;
        let record = own.record()?;
        let found = identify_consistent(&record, &ConsistentOptions::new(regularization))?;
        out.copy_from_slice(&found.parameters[..]);
        if let Some(residual) = residual {
            *residual = found.residual;
        }
        if let Some(model) = model {
            let estimated = Model::new(found.description(&own.model)?)?;
            let estimated = robot_dynamics::with_native_code(estimated);
            model.id = insert(RobotModel::new(estimated, &LoadReport::default()))?;
        }
        Ok(())
    })
}
