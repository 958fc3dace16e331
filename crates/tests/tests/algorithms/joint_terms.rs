//! Joint terms, noise, missing torques and external wrenches in the identification of parameters.

use std::error::Error;

use nalgebra::{DMatrix, DVector};
use robot_dynamics::algorithms::{
    FrameWrench, PARAMETERS_PER_LINK, dissipation, forward_dynamics_with_wrenches, inertial_parameters,
    inverse_dynamics, joint_torque_regressor,
};
use robot_dynamics::control::identification::{
    BaseParameters, IdentificationError, JointTerm, JointTermKind, MotionRecord,
};
use robot_dynamics::derivatives::{parameter_values, with_parameters};
use robot_dynamics::description::{Base, JointKinds, RandomRobotOptions};
use robot_dynamics::model::{Model, Workspace, random_state};
use robot_dynamics::number::SplitMix64;

use crate::common::{Family, Robot};

type Tested = Result<(), Box<dyn Error>>;

/// Arms of joints that turn or slide.
pub(crate) fn arms() -> Vec<Robot> {
    let options = RandomRobotOptions {
        joints: 5,
        massless: 0.0,
        chain: 1.0,
        kinds: JointKinds::SingleDof,
        ..RandomRobotOptions::default()
    };
    Family { name: "arms", options, count: 4 }.robots().filter(|robot| robot.model.nv() >= 3).collect()
}

/// The robot with other damping, friction and armature of all joints, and its values.
fn with_other_passive_forces(model: &Model, random: &mut SplitMix64) -> Result<Model, Box<dyn Error>> {
    let mut values = parameter_values(model);
    let passive = PARAMETERS_PER_LINK * model.moving_links().count();
    for joint in values[passive..].chunks_exact_mut(5) {
        for value in &mut joint[..3] {
            *value = random.uniform(0.1, 0.5);
        }
    }
    Ok(Model::new(with_parameters(model, &values)?)?)
}

/// x of a robot with offsets.
fn truth(real: &Model, terms: &[JointTerm], offsets: &[f64]) -> Vec<f64> {
    let mut x = inertial_parameters(real);
    x.extend(terms.iter().map(|term| match term.kind {
        JointTermKind::Offset => offsets[real.joints()[term.joint].v_index],
        _ => term.nominal(real),
    }));
    x
}

/// Torques of another robot with equal geometry: inverse dynamics, its damping and friction, and offsets.
fn torques(real: &Model, q: &[f64], v: &[f64], a: &[f64], offsets: &[f64]) -> Vec<f64> {
    let (mut tau, mut lost) = (vec![0.0; real.nv()], vec![0.0; real.nv()]);
    inverse_dynamics(real, &mut Workspace::new(real), q, v, a, &mut tau);
    dissipation(real, v, &mut lost);
    (0..real.nv()).map(|i| tau[i] + lost[i] + offsets[i]).collect()
}

/// Damping, friction, armature and offsets unknown to the file come out with β, alone and together.
#[test]
fn joint_terms_are_identified() -> Tested {
    for robot in arms() {
        let model = &robot.model;
        let random = &mut SplitMix64::new(robot.seed ^ 0x7e44);
        let real = with_other_passive_forces(model, random)?;
        let offsets: Vec<f64> = (0..model.nv()).map(|_| random.uniform(-1.0, 1.0)).collect();
        let terms = JointTerm::of_all(model, &JointTermKind::ALL);
        assert_eq!(terms.len(), 4 * model.nv());
        let base = BaseParameters::of_with_terms(model, &terms, 100, 1)?;
        let mut record = MotionRecord::new(model, true).with_terms(&terms)?;
        for _ in 0..80 {
            let s = random_state(model, random);
            record.push(&s.q, &s.v, &s.a, &torques(&real, &s.q, &s.v, &s.a, &offsets))?;
        }
        assert_eq!(record.parameter_names().len(), record.nominal().len());
        let expected = base.values(&truth(&real, &terms, &offsets))?;
        let found = base.identify(&record)?;
        robot.require("β", (&found.values - &expected).amax(), 1e-8 * expected.amax());
        // The damping of every joint is a base parameter of its own.
        let index = base.parameters.iter().position(|parameter| parameter.name.ends_with(".damping"));
        assert!(base.parameters[index.ok_or("no damping")?].others.is_empty());
        // The data show the same combinations as random states.
        assert_eq!(BaseParameters::of_record(&record).len(), base.len());
        // Only a part: the description's values of the others are known forces.
        let part = JointTerm::of_all(model, &[JointTermKind::Friction]);
        let base = BaseParameters::of_with_terms(model, &part, 100, 1)?;
        let mut record = MotionRecord::new(model, true).with_terms(&part)?;
        for _ in 0..80 {
            let s = random_state(model, random);
            let mut tau = torques(model, &s.q, &s.v, &s.a, &vec![0.0; model.nv()]);
            for term in &part {
                let i = model.joints()[term.joint].v_index;
                tau[i] += 0.25 * s.v[i].signum();
            }
            record.push(&s.q, &s.v, &s.a, &tau)?;
        }
        let mut expected = truth(model, &part, &[]);
        expected[10 * model.moving_links().count()..].iter_mut().for_each(|friction| *friction += 0.25);
        let (expected, found) = (base.values(&expected)?, base.identify(&record)?);
        robot.require("friction alone", (&found.values - &expected).amax(), 1e-8 * expected.amax());
    }
    Ok(())
}

/// The weighted solution, its covariance and its residuals against the pseudo-inverse by singular values.
#[test]
fn noise_weighs_the_rows() -> Tested {
    for robot in arms() {
        let model = &robot.model;
        let nv = model.nv();
        let random = &mut SplitMix64::new(robot.seed ^ 0x0153);
        let noise: Vec<f64> = (0..nv).map(|i| 0.02 * 5.0_f64.powf(i as f64)).collect();
        let base = BaseParameters::of(model, 100, 1);
        let indices: Vec<usize> = base.parameters.iter().map(|parameter| parameter.index).collect();
        let mut record = MotionRecord::new(model, false).with_noise(&noise)?;
        let columns = inertial_parameters(model).len();
        let (mut rows, mut right, mut regressor) = (Vec::new(), Vec::new(), vec![0.0; nv * columns]);
        let workspace = &mut Workspace::new(model);
        for _ in 0..100 {
            let s = random_state(model, random);
            let mut tau = vec![0.0; nv];
            inverse_dynamics(model, workspace, &s.q, &s.v, &s.a, &mut tau);
            joint_torque_regressor(model, workspace, &s.q, &s.v, &s.a, &mut regressor);
            let own = DMatrix::from_row_slice(nv, columns, &regressor);
            let rigid = &own * DVector::from_vec(inertial_parameters(model));
            for i in 0..nv {
                let error = noise[i] * random.uniform(-1.7, 1.7);
                rows.extend(own.row(i).select_columns(&indices).iter().map(|entry| entry / noise[i]));
                right.push((rigid[i] + error) / noise[i]);
                tau[i] += error;
            }
            record.push(&s.q, &s.v, &s.a, &tau)?;
        }
        let found = base.identify(&record)?;
        let matrix = DMatrix::from_row_slice(right.len(), base.len(), &rows);
        let right = DVector::from_vec(right);
        let inverse = matrix.clone().pseudo_inverse(0.0)?;
        let expected = &inverse * &right;
        let scale = expected.amax();
        robot.require("β", (&found.values - &expected).amax(), 1e-9 * scale);
        let left = &right - &matrix * &expected;
        let variance = left.norm_squared() / (right.len() - base.len()) as f64;
        let covariance = &inverse * inverse.transpose() * variance;
        robot.require("covariance", (&found.covariance - &covariance).amax(), 1e-8 * covariance.amax());
        let deviations = covariance.diagonal().map(f64::sqrt);
        robot.require("σ", (&found.standard_deviations - deviations).amax(), 1e-8 * covariance.amax().sqrt());
        for i in 0..nv {
            let own: f64 = left.iter().skip(i).step_by(nv).map(|x| x * x).sum();
            let expected = (own / 100.0).sqrt() * noise[i];
            robot.require("residual", (found.residuals[i] - expected).abs(), 1e-9 * expected);
        }
    }
    Ok(())
}

/// A floating robot pushed at a frame: the six rows of its base, without joint torques, determine β.
#[test]
fn base_rows_with_contact_forces_suffice() -> Tested {
    let options = RandomRobotOptions {
        base: Base::Floating,
        joints: 4,
        massless: 0.0,
        kinds: JointKinds::SingleDof,
        ..RandomRobotOptions::default()
    };
    for robot in (Family { name: "floating", options, count: 4 }).robots() {
        let model = &robot.model;
        let nv = model.nv();
        let random = &mut SplitMix64::new(robot.seed ^ 0xba5e);
        let mut noise = vec![f64::INFINITY; nv];
        noise[..6].fill(1.0);
        let mut record = MotionRecord::new(model, false).with_noise(&noise)?;
        let frame = model.frame(&model.frames().last().ok_or("no frame")?.name).ok_or("no frame")?;
        let workspace = &mut Workspace::new(model);
        for _ in 0..60 {
            let s = random_state(model, random);
            let mut wrench = || [0; 3].map(|_| random.uniform(-20.0, 20.0));
            let push = [FrameWrench { frame, force_in_frame: wrench(), moment_in_frame: wrench() }];
            let (mut tau, mut a) = (s.tau.clone(), vec![0.0; nv]);
            tau[..6].fill(0.0);
            forward_dynamics_with_wrenches(model, workspace, &s.q, &s.v, &tau, &push, &mut a);
            tau[6..].fill(f64::NAN);
            record.push_with_wrenches(&s.q, &s.v, &a, &tau, &push)?;
        }
        assert_eq!(record.len(), 60);
        let base = BaseParameters::of_record(&record);
        let found = base.identify(&record)?;
        let expected = base.values(&inertial_parameters(model))?;
        robot.require("β", (&found.values - &expected).amax(), 1e-7 * expected.amax());
        assert!(found.residuals[6..].iter().all(|residual| residual.is_nan()));
        // The base's rows see all that the torques of all coordinates see (Ayusawa, Venture, Nakamura 2014).
        assert_eq!(base.len(), BaseParameters::of(model, 100, 1).len());
    }
    Ok(())
}

/// Hidden directions change no torque, and there is one for each parameter that is not a base parameter.
#[test]
fn hidden_directions_change_no_torque() -> Tested {
    for robot in arms() {
        let model = &robot.model;
        let base = BaseParameters::of(model, 100, 1);
        let names = robot_dynamics::control::inertial_parameter_names(model);
        let hidden = base.hidden();
        assert_eq!(hidden.len() + base.len(), names.len());
        let random = &mut SplitMix64::new(robot.seed);
        let s = random_state(model, random);
        let mut regressor = vec![0.0; model.nv() * names.len()];
        joint_torque_regressor(model, &mut Workspace::new(model), &s.q, &s.v, &s.a, &mut regressor);
        let rows = DMatrix::from_row_slice(model.nv(), names.len(), &regressor);
        for direction in &hidden {
            let mut change = DVector::zeros(names.len());
            change[direction.index] = 1.0;
            for (name, part) in &direction.others {
                change[names.iter().position(|own| own == name).ok_or("a parameter")?] = *part;
            }
            let terms = (rows.abs() * change.abs()).amax();
            robot.require("hidden", (&rows * change).amax(), 1e-9 * (1.0 + terms));
        }
    }
    Ok(())
}

/// Errors name the option at fault.
#[test]
fn records_refuse_invalid_terms_and_noise() -> Tested {
    let robot = &arms()[0];
    let model = &robot.model;
    let term = JointTerm { joint: model.joints().len(), kind: JointTermKind::Offset };
    assert!(MotionRecord::new(model, true).with_terms(&[term]).is_err());
    let term = JointTerm::of_all(model, &[JointTermKind::Offset])[0];
    let error = MotionRecord::new(model, true).with_terms(&[term; 2]).unwrap_err();
    assert!(error.quantity.contains(&term.label(model)), "{error}");
    for noise in [vec![0.0; model.nv()], vec![f64::NAN; model.nv()], vec![1.0; model.nv() + 1]] {
        assert!(MotionRecord::new(model, true).with_noise(&noise).is_err());
    }
    let mut record = MotionRecord::new(model, true);
    let s = random_state(model, &mut SplitMix64::new(1));
    record.push(&s.q, &s.v, &s.a, &s.tau)?;
    assert!(record.clone().with_terms(&[term]).is_err() && record.clone().with_noise(&s.v).is_err());
    // Base parameters with terms do not fit a record without them.
    let base = BaseParameters::of_with_terms(model, &[term], 50, 1)?;
    assert!(matches!(base.identify(&record), Err(IdentificationError::Input(_))));
    Ok(())
}
