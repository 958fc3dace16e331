//! Stribeck velocities and the direction of gravity.

use std::error::Error;

use nalgebra::{Rotation3, Vector3};
use robot_dynamics::algorithms::inverse_dynamics;
use robot_dynamics::control::identification::{
    ConsistentOptions, IdentificationError, JointTerm, JointTermKind, MotionRecord, MotionSample,
    NonlinearEstimate, NonlinearOptions, identify_consistent, identify_nonlinear,
};
use robot_dynamics::model::{Model, RandomState, Workspace, random_state};
use robot_dynamics::number::SplitMix64;

use crate::joint_terms::arms;

type Tested = Result<(), Box<dyn Error>>;

const NOISE: f64 = 0.02;
const GAMMA: f64 = 1e-2;

fn kinds() -> [JointTermKind; 3] {
    [JointTermKind::Damping, JointTermKind::Friction, JointTermKind::Stribeck { velocity: 0.3 }]
}

fn consistent() -> ConsistentOptions {
    kinds().iter().fold(ConsistentOptions::new(GAMMA), |own, kind| own.with_joint_nominal(*kind, 0.5))
}

/// The robot with a turned gravity.
fn tilted(model: &Model, turn: Vector3<f64>) -> Result<Model, Box<dyn Error>> {
    let mut description = model.description().clone();
    description.gravity = (Rotation3::new(turn) * Vector3::from(model.gravity())).into();
    Ok(Model::new(description)?)
}

/// States with slow and fast joints, and noisy torques of a robot with Stribeck friction.
fn data(real: &Model, velocities: &[f64], random: &mut SplitMix64) -> Vec<(RandomState, Vec<f64>)> {
    let mut measured = Vec::new();
    for _ in 0..250 {
        let mut s = random_state(real, random);
        let mut tau = vec![0.0; real.nv()];
        for v in &mut s.v {
            *v = random.uniform(-1.0, 1.0);
        }
        inverse_dynamics(real, &mut Workspace::new(real), &s.q, &s.v, &s.a, &mut tau);
        for i in 0..tau.len() {
            let stribeck = 0.8 * (-(s.v[i] / velocities[i]).powi(2)).exp();
            tau[i] += 0.3 * s.v[i] + s.v[i].signum() * (0.6 + stribeck) + NOISE * random.uniform(-1.7, 1.7);
        }
        measured.push((s, tau));
    }
    measured
}

fn samples(measured: &[(RandomState, Vec<f64>)]) -> Vec<MotionSample<'_>> {
    measured.iter().map(|(s, tau)| MotionSample { q: &s.q, v: &s.v, a: &s.a, tau, wrenches: &[] }).collect()
}

fn velocities(found: &NonlinearEstimate) -> Vec<f64> {
    let velocity = |term: &JointTerm| match term.kind {
        JointTermKind::Stribeck { velocity } => Some(velocity),
        _ => None,
    };
    found.terms.iter().filter_map(velocity).collect()
}

/// F of given nonlinear parameters, by the convex problem and the divergences as the documents state them.
fn value(
    model: &Model,
    measured: &[(RandomState, Vec<f64>)],
    terms: &[JointTerm],
    gravity: [f64; 3],
) -> Result<f64, Box<dyn Error>> {
    let mut description = model.description().clone();
    description.gravity = gravity;
    let model = Model::new(description)?;
    let mut record =
        MotionRecord::new(&model, false).with_terms(terms)?.with_noise(&vec![NOISE; model.nv()])?;
    for (s, tau) in measured {
        record.push(&s.q, &s.v, &s.a, tau)?;
    }
    let found = identify_consistent(&record, &consistent())?;
    let ratios = found.parameters[found.parameters.len() - terms.len()..].iter().map(|x| x / 0.5);
    let joints: f64 = ratios.map(|ratio| ratio - ratio.ln() - 1.0).sum();
    let rows = (measured.len() * model.nv()) as f64;
    let bodies: f64 = found.divergences.iter().sum();
    Ok(0.5 * rows * found.residual.powi(2) + GAMMA * (bodies + joints))
}

/// The velocities and the tilt of a simulated robot come out within five standard deviations, and F is
/// stationary there.
#[test]
fn stribeck_velocities_and_gravity_are_identified() -> Tested {
    for robot in arms().into_iter().take(2) {
        let model = &robot.model;
        let random = &mut SplitMix64::new(robot.seed ^ 0x57b);
        let turn = Vector3::new(0.05, -0.08, 0.0);
        let truth: Vec<f64> = (0..model.nv()).map(|_| random.uniform(0.1, 0.5)).collect();
        let measured = data(&tilted(model, turn)?, &truth, random);
        let terms = JointTerm::of_all(model, &kinds());
        let mut options = NonlinearOptions::new(consistent(), &terms)
            .with_noise(&vec![NOISE; model.nv()])
            .with_gravity_direction(true);
        options.with_dissipation = false;
        let found = identify_nonlinear(model, &samples(&measured), &options)?;
        for (i, (own, truth)) in velocities(&found).iter().zip(&truth).enumerate() {
            let error = (own / truth).ln().abs();
            assert!(error < 5.0 * found.standard_deviations[i] && error < 0.1, "{own} {truth} {found:?}");
        }
        let expected = Rotation3::new(turn) * Vector3::from(model.gravity());
        let angle = Vector3::from(found.gravity).angle(&expected);
        let deviations = &found.standard_deviations[model.nv()..];
        assert!(angle < 5.0 * (deviations[0] + deviations[1]) && angle < 2e-3, "{angle} {deviations:?}");
        robot.require("|g|", Vector3::from(found.gravity).norm() - expected.norm(), 1e-12 * expected.norm());
        assert!((found.linear.residual - 1.0).abs() < 0.1, "{}", found.linear.residual);
        // F against differences.
        let least = value(model, &measured, &found.terms, found.gravity)?;
        let step = 1e-3;
        for (i, term) in found.terms.iter().enumerate() {
            let JointTermKind::Stribeck { velocity } = term.kind else { continue };
            let side = |sign: f64| {
                let mut moved = found.terms.clone();
                moved[i].kind = JointTermKind::Stribeck { velocity: velocity * (sign * step).exp() };
                value(model, &measured, &moved, found.gravity)
            };
            let (above, below) = (side(1.0)?, side(-1.0)?);
            // The minimum of the parabola is less than a hundredth of a step away, and it is a minimum.
            assert!(above > least && below > least);
            assert!((above - below).abs() < 0.04 * (above + below - 2.0 * least), "{above} {below} {least}");
        }
        for axis in [Vector3::x(), Vector3::y()] {
            let side = |sign: f64| {
                let gravity = Rotation3::new(axis * sign * step) * Vector3::from(found.gravity);
                value(model, &measured, &found.terms, gravity.into())
            };
            let (above, below) = (side(1.0)?, side(-1.0)?);
            assert!(above > least && below > least);
            assert!((above - below).abs() < 0.04 * (above + below - 2.0 * least), "{above} {below} {least}");
        }
    }
    Ok(())
}

/// Without nonlinear parameters, or with an invalid velocity, there is nothing to search.
#[test]
fn missing_nonlinear_parameters_are_errors() {
    let robot = &arms()[0];
    let model = &robot.model;
    let measured = data(model, &vec![0.2; model.nv()], &mut SplitMix64::new(1));
    let options = NonlinearOptions::new(consistent(), &JointTerm::of_all(model, &kinds()[..2]));
    let error = identify_nonlinear(model, &samples(&measured), &options).unwrap_err();
    assert!(error.to_string().contains("Stribeck term"), "{error}");
    for velocity in [0.0, -0.1, f64::NAN] {
        let terms = JointTerm::of_all(model, &[JointTermKind::Stribeck { velocity }]);
        let options = NonlinearOptions::new(consistent(), &terms);
        let error = identify_nonlinear(model, &samples(&measured), &options).unwrap_err();
        assert!(matches!(error, IdentificationError::Input(_)), "{error}");
        assert!(MotionRecord::new(model, true).with_terms(&terms).is_err());
    }
}
