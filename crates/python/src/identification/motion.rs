//! Records of motions from arrays.

use pyo3::prelude::*;
use robot_dynamics::InvalidInput;
use robot_dynamics::algorithms::FrameWrench;
use robot_dynamics::control::IdentificationError;
use robot_dynamics::control::identification::{JointTerm, JointTermKind, MotionRecord, MotionSample};
use robot_dynamics::model::Model;

use crate::errors::exception_of;
use crate::numbers::{halves, shaped};
use crate::robot::Robot;

/// q, v, a and τ.
pub(super) type MotionArrays<'py> =
    (Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>);

/// Whether τ contains damping and friction, the joint terms, the noise, and frames with their wrenches.
pub(super) type RecordSetup<'py> =
    (bool, Vec<String>, Option<Bound<'py, PyAny>>, Vec<(Bound<'py, PyAny>, Bound<'py, PyAny>)>);

/// The kind of a joint term by its name.
pub(super) fn kind_of(name: &str) -> Result<JointTermKind, InvalidInput> {
    let all = JointTermKind::ALL;
    all.into_iter().find(|kind| kind.name() == name).ok_or_else(|| {
        InvalidInput::unknown_name("joint term", name, "a joint", all.map(JointTermKind::name))
    })
}

/// The joint terms of names such as `friction`, for all joints, and `elbow.friction`.
pub(super) fn terms_of(model: &Model, names: &[String]) -> Result<Vec<JointTerm>, InvalidInput> {
    let mut terms = Vec::new();
    for name in names {
        match name.rsplit_once('.') {
            None => terms.extend(JointTerm::of_all(model, &[kind_of(name)?])),
            Some((joint, kind)) => {
                let found = model.joint(joint).ok_or_else(|| {
                    let joints = model.joints().iter().map(|joint| joint.name.as_str());
                    InvalidInput::unknown_name("joint", joint, format!("robot `{}`", model.name()), joints)
                })?;
                terms.push(JointTerm { joint: found.index, kind: kind_of(kind)? });
            }
        }
    }
    Ok(terms)
}

/// A motion as rows of numbers.
pub(super) struct Motion {
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    tau: Vec<f64>,
    /// The wrenches at each state.
    wrenches: Vec<Vec<FrameWrench>>,
}

impl Motion {
    /// Reads arrays of a row for each state, and the wrenches on frames.
    pub(super) fn read(
        py: Python<'_>,
        robot: &Robot,
        (q, v, a, tau): &MotionArrays<'_>,
        wrenches: &[(Bound<'_, PyAny>, Bound<'_, PyAny>)],
    ) -> PyResult<Self> {
        let (nq, nv) = (robot.model.nq(), robot.model.nv());
        let (shape, q) = shaped(py, "q", q, &[usize::MAX, nq])?;
        let states = shape[0];
        let read = |name: &str, given| shaped(py, name, given, &[states, nv]).map(|(_, numbers)| numbers);
        let (v, a, tau) = (read("v", v)?, read("a", a)?, read("tau", tau)?);
        let mut of_states = vec![Vec::new(); states];
        for (frame, wrenches) in wrenches {
            let frame = robot.frame_of(frame)?;
            let (_, numbers) = shaped(py, "wrenches", wrenches, &[states, 6])?;
            for (of_state, numbers) in of_states.iter_mut().zip(numbers.as_chunks::<6>().0) {
                let [force_in_frame, moment_in_frame] = halves(*numbers);
                of_state.push(FrameWrench { frame, force_in_frame, moment_in_frame });
            }
        }
        Ok(Self { q, v, a, tau, wrenches: of_states })
    }

    /// The states.
    pub(super) fn samples(&self) -> impl Iterator<Item = MotionSample<'_>> {
        let count = self.wrenches.len().max(1);
        let (nq, nv) = (self.q.len() / count, self.v.len() / count);
        self.wrenches.iter().enumerate().map(move |(k, wrenches)| {
            let row = k * nv..(k + 1) * nv;
            MotionSample {
                q: &self.q[k * nq..(k + 1) * nq],
                v: &self.v[row.clone()],
                a: &self.a[row.clone()],
                tau: &self.tau[row],
                wrenches,
            }
        })
    }
}

/// The record of a motion.
pub(super) fn motion_record<'a>(
    py: Python<'_>,
    robot: &'a Robot,
    arrays: &MotionArrays<'_>,
    (dissipation, terms, noise, wrenches): &RecordSetup<'_>,
) -> PyResult<MotionRecord<'a>> {
    let motion = Motion::read(py, robot, arrays, wrenches)?;
    let invalid = exception_of::<IdentificationError>;
    let terms = terms_of(&robot.model, terms).map_err(invalid)?;
    let mut record = MotionRecord::new(&robot.model, *dissipation).with_terms(&terms).map_err(invalid)?;
    if let Some(noise) = noise {
        let (_, noise) = shaped(py, "noise", noise, &[robot.model.nv()])?;
        record = record.with_noise(&noise).map_err(invalid)?;
    }
    for (k, sample) in motion.samples().enumerate() {
        let MotionSample { q, v, a, tau, wrenches } = sample;
        record.push_with_wrenches(q, v, a, tau, wrenches).map_err(invalid)?;
        if k % 256 == 0 {
            py.check_signals()?;
        }
    }
    Ok(record)
}
