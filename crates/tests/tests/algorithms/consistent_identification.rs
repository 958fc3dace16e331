//! Estimates of parameters that belong to bodies.

use std::error::Error;

use nalgebra::{DMatrix, DVector};
use robot_dynamics::algorithms::{
    PARAMETERS_PER_LINK, dissipation, inertial_parameters, inverse_dynamics, joint_torque_regressor,
};
use robot_dynamics::control::identification::{
    BaseParameters, ConsistentOptions, IdentificationError, JointTerm, JointTermKind, MotionRecord,
    entropic_divergence, identify_consistent, physical_consistency, pseudo_inertia,
};
use robot_dynamics::derivatives::{parameter_values, with_parameters};
use robot_dynamics::description::pendulum;
use robot_dynamics::model::{Model, RandomState, Workspace, random_state};
use robot_dynamics::number::SplitMix64;

use crate::common::Robot;
use crate::joint_terms::arms;

type Tested = Result<(), Box<dyn Error>>;

/// The robot with links that are heavier or lighter, and with other damping and friction.
fn real(model: &Model, random: &mut SplitMix64) -> Result<Model, Box<dyn Error>> {
    let mut values = parameter_values(model);
    let links = PARAMETERS_PER_LINK * model.moving_links().count();
    for link in values[..links].chunks_exact_mut(PARAMETERS_PER_LINK) {
        let factor = random.uniform(0.8, 1.3);
        for value in link {
            *value *= factor;
        }
    }
    for joint in values[links..].chunks_exact_mut(5) {
        for value in &mut joint[..3] {
            *value = random.uniform(0.1, 0.5);
        }
    }
    Ok(Model::new(with_parameters(model, &values)?)?)
}

fn torques(real: &Model, s: &RandomState) -> Vec<f64> {
    let (mut tau, mut lost) = (vec![0.0; real.nv()], vec![0.0; real.nv()]);
    inverse_dynamics(real, &mut Workspace::new(real), &s.q, &s.v, &s.a, &mut tau);
    dissipation(real, &s.v, &mut lost);
    tau.iter().zip(lost).map(|(tau, lost)| tau + lost).collect()
}

/// Data of an arm: the record, the real arm, and W and τ by a route of their own.
struct Data<'a> {
    record: MotionRecord<'a>,
    real: Model,
    rows: DMatrix<f64>,
    right: DVector<f64>,
}

const KINDS: [JointTermKind; 4] = JointTermKind::ALL;
const NOISE: f64 = 0.05;

fn data(robot: &Robot, states: usize, noise: f64) -> Result<Data<'_>, Box<dyn Error>> {
    let model = &robot.model;
    let (nv, terms) = (model.nv(), JointTerm::of_all(model, &KINDS));
    let random = &mut SplitMix64::new(robot.seed ^ 0xc0de);
    let real = real(model, random)?;
    let mut record = MotionRecord::new(model, true).with_terms(&terms)?.with_noise(&vec![NOISE; nv])?;
    let columns = inertial_parameters(model).len();
    let (mut rows, mut right) =
        (DMatrix::zeros(states * nv, columns + terms.len()), DVector::zeros(states * nv));
    let mut regressor = vec![0.0; nv * columns];
    for k in 0..states {
        let s = random_state(model, random);
        let mut tau = torques(&real, &s);
        for tau in &mut tau {
            *tau += noise * random.uniform(-1.7, 1.7);
        }
        record.push(&s.q, &s.v, &s.a, &tau)?;
        joint_torque_regressor(model, &mut Workspace::new(model), &s.q, &s.v, &s.a, &mut regressor);
        for i in 0..nv {
            let at = k * nv + i;
            let joint =
                model.joints().iter().find(|joint| joint.nv == 1 && joint.v_index == i).ok_or("joint")?;
            let elastic = joint.passive.stiffness * (s.q[joint.q_index] - joint.passive.rest);
            right[at] = (tau[i] - elastic) / NOISE;
            for c in 0..columns {
                rows[(at, c)] = regressor[i * columns + c] / NOISE;
            }
            for (c, term) in terms.iter().enumerate().filter(|(_, term)| term.joint == joint.index) {
                rows[(at, columns + c)] = match term.kind {
                    JointTermKind::Damping => s.v[i],
                    JointTermKind::Friction => s.v[i].signum(),
                    JointTermKind::Armature => s.a[i],
                    JointTermKind::Offset => 1.0,
                    JointTermKind::Stribeck { .. } => return Err("no Stribeck term".into()),
                } / NOISE;
            }
        }
    }
    Ok(Data { record, real, rows, right })
}

fn options(regularization: f64) -> ConsistentOptions {
    let options = ConsistentOptions::new(regularization).with_offset_deviation(0.7);
    KINDS[..3].iter().fold(options, |options, kind| options.with_joint_nominal(*kind, 0.3))
}

/// The objective as the documents state it, with determinants and inverses of 4×4 matrices.
fn objective(data: &Data<'_>, x: &[f64], regularization: f64) -> f64 {
    let model = &data.record;
    let nominal = nominal_of(model);
    let count = x.len() - model.terms().len();
    let links = x[..count].as_chunks::<10>().0.iter().zip(nominal[..count].as_chunks::<10>().0);
    let bodies: f64 = links
        .map(|(own, nominal)| {
            let ratio = pseudo_inertia(own) * pseudo_inertia(nominal).try_inverse().expect("a body");
            ratio.trace() - ratio.determinant().ln() - 4.0
        })
        .sum();
    let joints = model.terms().iter().zip(&x[count..]).map(|(term, x)| match term.kind {
        JointTermKind::Offset => 0.5 * (x / 0.7).powi(2),
        _ => x / 0.3 - (x / 0.3).ln() - 1.0,
    });
    let left = &data.rows * DVector::from_column_slice(x) - &data.right;
    0.5 * left.norm_squared() + regularization * (bodies + joints.sum::<f64>())
}

/// x₀ of these options.
fn nominal_of(record: &MotionRecord<'_>) -> Vec<f64> {
    let inertial = record.nominal().len() - record.terms().len();
    let mut nominal = record.nominal()[..inertial].to_vec();
    nominal.extend(record.terms().iter().map(|term| match term.kind {
        JointTermKind::Offset => 0.0,
        _ => 0.3,
    }));
    nominal
}

/// The gradient of the objective, by central differences, is zero at the estimate.
///
/// Tolerance: each derivative, times the size of its parameter, is compared with its value at the nominal
/// parameters. Differences of step 1e-5 leave about 1e-8 of the objective.
#[test]
fn gradient_of_objective_vanishes() -> Tested {
    for robot in arms() {
        let data = data(&robot, 60, NOISE)?;
        for regularization in [1e3, 1.0, 1e-2] {
            let found = identify_consistent(&data.record, &options(regularization))?;
            let start = nominal_of(&data.record);
            let slope = |at: &[f64], i: usize| {
                let link = at[i / 10 * 10..].iter().take(10).fold(0.0, |a: f64, x| a.max(x.abs()));
                let step = 1e-5 * if i < at.len() - data.record.terms().len() { link } else { 0.3 };
                let side = |sign: f64| {
                    let mut moved = at.to_vec();
                    moved[i] += sign * step;
                    objective(&data, &moved, regularization)
                };
                0.5e5 * (side(1.0) - side(-1.0))
            };
            let size = (0..start.len()).map(|i| slope(&start, i).abs()).fold(0.0, f64::max);
            for i in 0..start.len() {
                robot.require("∂F", slope(&found.parameters, i).abs(), 1e-6 * size);
            }
            // A minimum, not a saddle: nothing near it is lower.
            let least = objective(&data, &found.parameters, regularization);
            assert!(least < objective(&data, &start, regularization));
            let links = physical_consistency(
                &robot.model,
                &found.parameters[..10 * robot.model.moving_links().count()],
            )?;
            assert!(links.iter().all(|link| link.smallest > 0.0), "{links:?}");
        }
    }
    Ok(())
}

/// With a small weight and good data, β is that of least squares, and the robot predicts the torques.
#[test]
fn small_regularization_approaches_least_squares() -> Tested {
    for robot in arms() {
        let model = &robot.model;
        let data = data(&robot, 150, 1e-3)?;
        let base = BaseParameters::of_record(&data.record);
        let squares = base.identify(&data.record)?;
        let found = identify_consistent(&data.record, &options(1e-7))?;
        let beta = base.values(&found.parameters)?;
        robot.require("β", (&beta - &squares.values).amax(), 1e-4 * beta.amax());
        robot.require("residual", found.residual - squares.residual, 1e-3 * squares.residual);
        // The model with the identified parameters has the real robot's torques.
        let identified = Model::new(found.description(model)?)?;
        let random = &mut SplitMix64::new(robot.seed ^ 0x77);
        let inertial = 10 * model.moving_links().count();
        for _ in 0..20 {
            let s = random_state(model, random);
            let (own, real) = (torques(&identified, &s), torques(&data.real, &s));
            for (i, (own, real)) in own.iter().zip(&real).enumerate() {
                let offset = data.record.terms().iter().zip(&found.parameters[inertial..]);
                let offset = offset
                    .filter(|(term, _)| term.kind == JointTermKind::Offset)
                    .find(|(term, _)| model.joints()[term.joint].v_index == i);
                let own = own + offset.map_or(0.0, |(_, offset)| *offset);
                // Noise of 1e-3 in 150 states.
                robot.require("τ", (own - real).abs(), 5e-3);
            }
        }
    }
    Ok(())
}

/// Few and noisy data give impossible bodies by least squares, and bodies by the consistent estimate.
#[test]
fn few_noisy_data_give_bodies() -> Tested {
    let mut impossible = 0;
    for robot in arms() {
        let model = &robot.model;
        let data = data(&robot, 25, 40.0 * NOISE)?;
        let base = BaseParameters::of_record(&data.record);
        let squares = base.identify(&data.record)?;
        let nearest = base.nearest_parameters(&squares.values, data.record.nominal())?;
        let count = 10 * model.moving_links().count();
        let links = physical_consistency(model, &nearest.as_slice()[..count])?;
        impossible += links.iter().filter(|link| !link.is_consistent()).count();
        let found = identify_consistent(&data.record, &options(1e-3))?;
        let links = physical_consistency(model, &found.parameters[..count])?;
        assert!(links.iter().all(|link| link.smallest > 0.0 && link.mass > 0.0), "{links:?}");
        for (term, value) in data.record.terms().iter().zip(&found.parameters[count..]) {
            assert!(term.kind == JointTermKind::Offset || *value > 0.0);
        }
    }
    assert!(impossible > 0, "the data are too good for this test");
    Ok(())
}

/// The covariance is σ² (∂x/∂τ)(∂x/∂τ)ᵀ with the derivative of the estimate by every torque, from
/// differences.
#[test]
fn covariance_is_that_of_the_estimate() -> Tested {
    let robot = &arms()[0];
    let model = &robot.model;
    let terms = JointTerm::of_all(model, &[JointTermKind::Damping]);
    let random = &mut SplitMix64::new(7);
    let states: Vec<RandomState> = (0..25).map(|_| random_state(model, random)).collect();
    let mut all: Vec<Vec<f64>> = states.iter().map(|s| torques(model, s)).collect();
    all.iter_mut().flatten().for_each(|tau| *tau += NOISE * random.uniform(-1.7, 1.7));
    let options = ConsistentOptions::new(1.0).with_joint_nominal(JointTermKind::Damping, 0.3);
    let estimate = |all: &[Vec<f64>]| {
        let mut record =
            MotionRecord::new(model, true).with_terms(&terms)?.with_noise(&vec![NOISE; model.nv()])?;
        for (s, tau) in states.iter().zip(all) {
            record.push(&s.q, &s.v, &s.a, tau)?;
        }
        identify_consistent(&record, &options)
    };
    let found = estimate(&all)?;
    let (n, nv, step) = (found.parameters.len(), model.nv(), 1e-4);
    let mut derivative = DMatrix::zeros(n, states.len() * nv);
    let (mut trace, columns) = (0.0, states.len() * nv);
    for row in 0..columns {
        let side = |sign: f64| {
            let mut moved = all.clone();
            moved[row / nv][row % nv] += sign * step;
            estimate(&moved).map(|found| DVector::from_vec(found.parameters))
        };
        derivative.set_column(row, &((side(1.0)? - side(-1.0)?) / (2.0 * step)));
    }
    // The trace of W ∂x/∂τ.
    for (k, s) in states.iter().enumerate() {
        let count = 10 * model.moving_links().count();
        let mut regressor = vec![0.0; nv * count];
        joint_torque_regressor(model, &mut Workspace::new(model), &s.q, &s.v, &s.a, &mut regressor);
        for i in 0..nv {
            let column = derivative.column(k * nv + i);
            trace += (0..count).map(|c| regressor[i * count + c] * column[c]).sum::<f64>();
            let damping = terms.iter().position(|term| model.joints()[term.joint].v_index == i);
            trace += damping.map_or(0.0, |c| s.v[i] * column[count + c]);
        }
    }
    robot.require("effective", (found.effective_parameters - trace).abs(), 1e-5 * trace);
    let variance = (found.residual * NOISE).powi(2) * columns as f64 / (columns as f64 - trace);
    let expected = &derivative * derivative.transpose() * variance;
    robot.require("covariance", (&found.covariance - &expected).amax(), 1e-5 * expected.amax());
    for i in 0..n {
        let deviation = expected[(i, i)].sqrt();
        robot.require("σ", (found.standard_deviations[i] - deviation).abs(), 1e-4 * deviation + 1e-12);
    }
    Ok(())
}

/// Held links keep their parameters, and the data determine the others.
#[test]
fn held_links_keep_their_parameters() -> Tested {
    for robot in arms() {
        let data = data(&robot, 60, NOISE)?;
        let names: Vec<&str> = robot.model.moving_links().collect();
        let found = identify_consistent(&data.record, &options(1e-2).hold(names[0]))?;
        assert_eq!(found.parameters[..10], data.record.nominal()[..10]);
        assert_ne!(found.parameters[10..20], data.record.nominal()[10..20]);
        assert!(found.divergences[0] == 0.0 && found.divergences[1] > 0.0);
        let own = &found.parameters.as_chunks::<10>().0[1];
        let nominal = &data.record.nominal().as_chunks::<10>().0[1];
        let expected = entropic_divergence(own, nominal).ok_or("a body")?;
        robot.require("divergence", (found.divergences[1] - expected).abs(), 1e-9 * (1.0 + expected));
    }
    Ok(())
}

/// A thin rod needs a thickness; options without meaning are errors.
#[test]
fn flat_nominal_bodies_and_bad_options_are_errors() -> Tested {
    let model = Model::new(pendulum(2.0, 0.5))?;
    let mut record = MotionRecord::new(&model, false);
    let error =
        identify_consistent(&record, &ConsistentOptions::new(1.0).with_least_radius(0.05)).unwrap_err();
    assert!(matches!(error, IdentificationError::TooFewData { .. }), "{error}");
    for i in 0..40 {
        let t = 0.1 * f64::from(i);
        let (q, v, a) = ([t.sin()], [t.cos()], [-t.sin()]);
        record.push(&q, &v, &a, &[1.3 * model.inverse_dynamics(&q, &v, &a)?[0]])?;
    }
    let error = identify_consistent(&record, &ConsistentOptions::new(1.0)).unwrap_err();
    assert_eq!(error, IdentificationError::SingularNominal { link: "rod".into() });
    let found = identify_consistent(&record, &ConsistentOptions::new(1e-6).with_least_radius(0.05))?;
    // m c = 1.3 · 2 kg · 0.5 m, and the moment about the hinge is 1.3 · 2 kg · (0.5 m)². A point on the
    // boundary of the possible bodies is approached from inside.
    assert!(
        (found.parameters[1] - 1.3).abs() < 1e-4 && (found.parameters[6] - 0.65).abs() < 1e-3,
        "{found:?}"
    );
    for regularization in [0.0, -1.0, f64::NAN] {
        assert!(identify_consistent(&record, &ConsistentOptions::new(regularization)).is_err());
    }
    let unknown = ConsistentOptions::new(1.0).hold("tip");
    assert!(matches!(identify_consistent(&record, &unknown), Err(IdentificationError::Input(_))));
    let terms = JointTerm::of_all(&model, &[JointTermKind::Friction]);
    let mut record = MotionRecord::new(&model, true).with_terms(&terms)?;
    record.push(&[0.1], &[0.2], &[0.3], &[0.4])?;
    let error =
        identify_consistent(&record, &ConsistentOptions::new(1.0).with_least_radius(0.05)).unwrap_err();
    assert!(error.to_string().contains("hinge.friction"), "{error}");
    Ok(())
}

/// D does not depend on the axes and the origin in which both bodies are given.
#[test]
fn divergence_does_not_depend_on_axes() -> Tested {
    let random = &mut SplitMix64::new(3);
    for _ in 0..50 {
        let mut body = || {
            let points: Vec<_> = (0..6)
                .map(|_| (random.uniform(0.1, 1.0), [0; 3].map(|_| random.uniform(-1.0, 1.0)).into()))
                .collect();
            points
        };
        let (first, second) = (body(), body());
        let turn = nalgebra::Rotation3::from_euler_angles(0.3, -1.1, 2.0);
        let moved = |points: &[(f64, nalgebra::Vector3<f64>)]| {
            let shift = nalgebra::Vector3::new(0.5, -2.0, 1.0);
            points.iter().map(|(m, r)| (*m, turn * r + shift)).collect::<Vec<_>>()
        };
        let of = |points: &[(f64, nalgebra::Vector3<f64>)]| -> [f64; 10] {
            let m: f64 = points.iter().map(|(m, _)| m).sum();
            let h: nalgebra::Vector3<f64> = points.iter().map(|(m, r)| r * *m).sum();
            let i: nalgebra::Matrix3<f64> = points
                .iter()
                .map(|(m, r)| (nalgebra::Matrix3::identity() * r.norm_squared() - r * r.transpose()) * *m)
                .sum();
            [m, h.x, h.y, h.z, i.m11, i.m12, i.m22, i.m13, i.m23, i.m33]
        };
        let one = entropic_divergence(&of(&first), &of(&second)).ok_or("a body")?;
        let other = entropic_divergence(&of(&moved(&first)), &of(&moved(&second))).ok_or("a body")?;
        assert!(one > 0.0 && (one - other).abs() < 1e-9 * (1.0 + one), "{one} {other}");
    }
    Ok(())
}
