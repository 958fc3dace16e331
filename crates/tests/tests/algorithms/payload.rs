//! The recursive estimate of a payload, against attached bodies and weighted least squares.

use std::error::Error;

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use robot_dynamics::algorithms::{dissipation, inverse_dynamics};
use robot_dynamics::control::identification::{PayloadEstimator, pseudo_inertia};
use robot_dynamics::description::{
    FrameDescription, JointDescription, JointKind, LinkDescription, MassProperties, Pose,
};
use robot_dynamics::model::{Model, Workspace, random_state};
use robot_dynamics::number::SplitMix64;

use crate::common::Robot;
use crate::joint_terms::arms;

type Tested = Result<(), Box<dyn Error>>;

/// Where the payload is held, in its link.
fn grip() -> Pose {
    Pose::from_xyz_rpy([0.1, -0.2, 0.3], [0.4, -0.7, 1.9])
}

/// The arm with a frame on its last link, and the arm that holds a body there.
fn robots(robot: &Robot, body: &MassProperties) -> Result<(Model, Model), Box<dyn Error>> {
    let mut description = robot.model.description().clone();
    let link = robot.model.moving_links().last().ok_or("a link")?.to_owned();
    description.frames.push(FrameDescription::new("grip", &link, grip()));
    let free = Model::new(description.clone())?;
    description.links.push(LinkDescription::new("load", *body));
    description.joints.push(JointDescription::new("held", JointKind::Fixed, link, "load", grip()));
    Ok((free, Model::new(description)?))
}

fn body() -> Result<(MassProperties, [f64; 10]), Box<dyn Error>> {
    let (mass, center) = (1.7, Vector3::new(0.05, 0.02, -0.11));
    let central = Matrix3::new(0.02, 0.001, -0.002, 0.001, 0.015, 0.0005, -0.002, 0.0005, 0.01);
    let shift = Matrix3::identity() * center.norm_squared() - center * center.transpose();
    let about: Matrix3<f64> = central + shift * mass;
    let h = center * mass;
    let parameters = [mass, h.x, h.y, h.z, about.m11, about.m12, about.m22, about.m13, about.m23, about.m33];
    Ok((MassProperties::new(mass, center, central)?, parameters))
}

fn torques(model: &Model, q: &[f64], v: &[f64], a: &[f64]) -> Vec<f64> {
    let mut tau = vec![0.0; model.nv()];
    inverse_dynamics(model, &mut Workspace::new(model), q, v, a, &mut tau);
    tau
}

/// Exact torques give the body that was attached, with friction and offsets, and with missing sensors.
#[test]
fn attached_body_is_found() -> Tested {
    let (attached, expected) = body()?;
    for robot in arms() {
        let (free, loaded) = robots(&robot, &attached)?;
        let frame = free.frame_named("grip")?;
        let random = &mut SplitMix64::new(robot.seed ^ 0x10ad);
        let offsets: Vec<f64> = (0..free.nv()).map(|_| random.uniform(-1.0, 1.0)).collect();
        let mut noise = vec![1e-3; free.nv()];
        noise[0] = f64::INFINITY;
        let mut plain = PayloadEstimator::new(&free, frame, &noise)?;
        let mut rubbing =
            PayloadEstimator::new(&free, frame, &noise)?.with_dissipation_and_offsets(&offsets)?;
        for _ in 0..60 {
            let s = random_state(&free, random);
            let mut tau = torques(&loaded, &s.q, &s.v, &s.a);
            tau[0] = f64::NAN;
            plain.push(&s.q, &s.v, &s.a, &tau)?;
            let mut lost = vec![0.0; free.nv()];
            dissipation(&loaded, &s.v, &mut lost);
            tau.iter_mut().zip(lost.iter().zip(&offsets)).for_each(|(tau, (b, c))| *tau += b + c);
            rubbing.push(&s.q, &s.v, &s.a, &tau)?;
        }
        for estimator in [&plain, &rubbing] {
            for (own, expected) in estimator.parameters().iter().zip(expected) {
                // The prior of 100 against noise of 1e-3 in 60 samples.
                robot.require("π", (own - expected).abs(), 1e-7);
            }
            let payload = estimator.payload();
            robot.require("mass", (payload.mass - 1.7).abs(), 1e-7);
            let center = Vector3::from(payload.center_of_mass) - attached.center_of_mass();
            robot.require("centre", center.amax(), 1e-7);
            robot.require(
                "inertia",
                (payload.inertia - attached.inertia_about_center_of_mass()).amax(),
                1e-7,
            );
            assert!(pseudo_inertia(&estimator.parameters()).symmetric_eigenvalues().min() > 0.0);
        }
    }
    Ok(())
}

/// The estimate and its covariance are those of weighted least squares over all rows and the prior, with
/// weights λ to the power of the age. Y comes from differences of inverse dynamics of attached bodies.
#[test]
fn recursion_is_weighted_least_squares() -> Tested {
    let (attached, _) = body()?;
    for robot in arms() {
        let (free, loaded) = robots(&robot, &attached)?;
        let (nv, frame) = (free.nv(), free.frame_named("grip")?);
        for forgetting in [1.0, 0.9] {
            let random = &mut SplitMix64::new(robot.seed ^ 0x20ad);
            let noise: Vec<f64> = (0..nv).map(|i| 0.1 + 0.2 * i as f64).collect();
            let (prior, deviations) = ([1.0, 0.0, 0.1, 0.0, 0.1, 0.0, 0.2, 0.0, 0.0, 0.1], [0.5; 10]);
            let mut estimator = PayloadEstimator::new(&free, frame, &noise)?
                .with_prior(prior, deviations)?
                .with_forgetting(forgetting)?;
            let (states, base) = (40, DVector::from_column_slice(&prior));
            let mut information = DMatrix::<f64>::identity(10, 10) * 4.0;
            let mut right = &information * &base;
            let (own, start) = (information.clone(), right.clone());
            // Ten bodies whose parameters span the space.
            let bodies: Vec<(MassProperties, DVector<f64>)> = (0..10).map(spanning_body).collect();
            let columns = DMatrix::from_columns(&bodies.iter().map(|(_, x)| x.clone()).collect::<Vec<_>>());
            let inverse = columns.try_inverse().ok_or("independent bodies")?;
            let models: Vec<Model> = bodies
                .iter()
                .map(|(body, _)| Ok(robots(&robot, body)?.1))
                .collect::<Result<_, Box<dyn Error>>>()?;
            for _ in 0..states {
                let s = random_state(&free, random);
                let mut tau = torques(&loaded, &s.q, &s.v, &s.a);
                tau.iter_mut().zip(&noise).for_each(|(tau, noise)| *tau += noise * random.uniform(-1.7, 1.7));
                estimator.push(&s.q, &s.v, &s.a, &tau)?;
                let without = DVector::from_vec(torques(&free, &s.q, &s.v, &s.a));
                let with = |model: &Model| DVector::from_vec(torques(model, &s.q, &s.v, &s.a)) - &without;
                let mut rows = DMatrix::from_columns(&models.iter().map(with).collect::<Vec<_>>()) * &inverse;
                let mut left = DVector::from_vec(tau) - without;
                for i in 0..nv {
                    for entry in &mut rows.row_mut(i) {
                        *entry /= noise[i];
                    }
                    left[i] /= noise[i];
                }
                information = information * forgetting + &own * (1.0 - forgetting) + rows.tr_mul(&rows);
                right = right * forgetting + &start * (1.0 - forgetting) + rows.tr_mul(&left);
            }
            let covariance = information.try_inverse().ok_or("information")?;
            let expected = &covariance * right;
            let found = DVector::from_column_slice(&estimator.parameters());
            robot.require("π", (found - &expected).amax(), 1e-8 * (1.0 + expected.amax()));
            let found = DMatrix::from_iterator(10, 10, estimator.covariance().iter().copied());
            robot.require("covariance", (found - &covariance).amax(), 1e-8 * covariance.amax());
            let payload = estimator.payload();
            robot.require("σ(m)", (payload.mass_deviation - covariance[(0, 0)].sqrt()).abs(), 1e-8);
            assert_eq!(estimator.len(), states);
        }
    }
    Ok(())
}

/// A body, and its ten parameters about the origin of its frame.
fn spanning_body(k: usize) -> (MassProperties, DVector<f64>) {
    let random = &mut SplitMix64::new(k as u64 + 11);
    let points: Vec<(f64, Vector3<f64>)> = (0..5)
        .map(|_| (random.uniform(0.5, 2.0), Vector3::from([0; 3].map(|_| random.uniform(-1.0, 1.0)))))
        .collect();
    let body = MassProperties::point_masses(&points).expect("a body");
    let (h, i) = (body.center_of_mass() * body.mass(), body.inertia_about_origin());
    let x = vec![body.mass(), h.x, h.y, h.z, i.m11, i.m12, i.m22, i.m13, i.m23, i.m33];
    (body, DVector::from_vec(x))
}

/// With forgetting the estimate follows an exchange of payloads, and without excitation it returns to the
/// prior.
#[test]
fn forgetting_follows_a_change() -> Tested {
    let robot = &arms()[0];
    let (free, loaded) = robots(robot, &body()?.0)?;
    let frame = free.frame_named("grip")?;
    let noise = vec![0.01; free.nv()];
    let mut estimator = PayloadEstimator::new(&free, frame, &noise)?.with_forgetting(0.95)?;
    let random = &mut SplitMix64::new(5);
    for _ in 0..200 {
        let s = random_state(&free, random);
        estimator.push(&s.q, &s.v, &s.a, &torques(&loaded, &s.q, &s.v, &s.a))?;
    }
    assert!((estimator.payload().mass - 1.7).abs() < 1e-4);
    for _ in 0..600 {
        let s = random_state(&free, random);
        estimator.push(&s.q, &s.v, &s.a, &torques(&free, &s.q, &s.v, &s.a))?;
    }
    // 0.95⁶⁰⁰ = 4e-14 of the past is left.
    assert!(estimator.parameters().iter().all(|x| x.abs() < 1e-6));
    // At rest in one pose the torques show no inertia: its covariance approaches the prior's, and no further.
    let (rest, s) = (vec![0.0; free.nv()], random_state(&free, random));
    for _ in 0..4000 {
        estimator.push(&s.q, &rest, &rest, &torques(&free, &s.q, &rest, &rest))?;
    }
    let covariance = estimator.covariance();
    assert!((covariance[(4, 4)] / 1e4 - 1.0).abs() < 1e-6, "{covariance}");
    estimator.reset();
    assert!(estimator.is_empty() && estimator.parameters() == [0.0; 10]);
    Ok(())
}

/// Invalid frames, noise and samples are errors, and leave the estimate as it is.
#[test]
fn invalid_input_is_refused() -> Tested {
    let robot = &arms()[0];
    let (free, _) = robots(robot, &body()?.0)?;
    let frame = free.frame_named("grip")?;
    let root = free.frame_named(&free.joints()[0].parent_link)?;
    let noise = vec![1.0; free.nv()];
    assert!(PayloadEstimator::new(&free, root, &noise).is_err());
    assert!(PayloadEstimator::new(&free, frame, &noise[1..]).is_err());
    assert!(PayloadEstimator::new(&free, frame, &vec![0.0; free.nv()]).is_err());
    let mut estimator = PayloadEstimator::new(&free, frame, &noise)?;
    for forgetting in [0.0, 1.1, f64::NAN] {
        assert!(estimator.clone().with_forgetting(forgetting).is_err());
    }
    assert!(estimator.clone().with_prior([0.0; 10], [0.0; 10]).is_err());
    let s = random_state(&free, &mut SplitMix64::new(1));
    estimator.push(&s.q, &s.v, &s.a, &s.tau)?;
    let before = estimator.parameters();
    let nan = vec![f64::NAN; free.nv()];
    assert_eq!(estimator.push(&s.q, &s.v, &s.a, &nan).unwrap_err().quantity, "tau");
    assert_eq!(estimator.push(&s.q, &nan, &s.a, &s.tau).unwrap_err().quantity, "v");
    assert_eq!(estimator.push(&s.q, &s.v, &s.a, &s.tau[1..]).unwrap_err().quantity, "tau");
    assert!(estimator.parameters() == before && estimator.len() == 1);
    Ok(())
}
