//! Inertial parameters are identified from motions of robots with known parameters.

use std::error::Error;

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use robot_dynamics::algorithms::{
    PARAMETERS_PER_LINK, dissipation, forward_dynamics, inertial_parameters, inverse_dynamics,
    joint_torque_regressor,
};
use robot_dynamics::control::{
    BaseParameters, IdentificationError, MotionRecord, inertial_parameter_names, physical_consistency,
    pseudo_inertia,
};
use robot_dynamics::description::{
    JointDescription, JointKind, JointKinds, LinkDescription, MassProperties, Pose, RandomRobotOptions,
    RobotDescription,
};
use robot_dynamics::model::{Model, Workspace, random_state};
use robot_dynamics::number::SplitMix64;

use crate::common::{Family, Robot, size};

type Tested = Result<(), Box<dyn Error>>;

/// Arms, trees and floating bases with springs, armature and friction. If one or two coordinates move all
/// joints, the torques hardly distinguish the links (condition 1e9), so the robots have at least three.
fn robots() -> impl Iterator<Item = Robot> {
    let base = RandomRobotOptions { joints: 5, massless: 0.0, ..RandomRobotOptions::default() };
    let families = [
        ("arms", RandomRobotOptions { chain: 1.0, kinds: JointKinds::Turning, ..base.clone() }),
        ("trees", base.clone()),
        (
            "floating",
            RandomRobotOptions {
                base: robot_dynamics::description::Base::Floating,
                joints: 3,
                ..base.clone()
            },
        ),
        ("mimic joints", RandomRobotOptions { mimic: 0.4, kinds: JointKinds::SingleDof, ..base }),
    ];
    families.into_iter().flat_map(|(name, options)| {
        Family { name, options, count: 6 }.robots().filter(|robot| robot.model.nv() >= 3).collect::<Vec<_>>()
    })
}

/// Measured states: accelerations come from forward dynamics of random torques less damping and friction.
fn record<'a>(model: &'a Model, states: usize, random: &mut SplitMix64, noise: f64) -> MotionRecord<'a> {
    let mut record = MotionRecord::new(model, true);
    let w = &mut Workspace::new(model);
    for _ in 0..states {
        let state = random_state(model, random);
        let (mut a, mut b) = (vec![0.0; model.nv()], vec![0.0; model.nv()]);
        dissipation(model, &state.v, &mut b);
        let free: Vec<f64> = state.tau.iter().zip(&b).map(|(tau, b)| tau - b).collect();
        forward_dynamics(model, w, &state.q, &state.v, &free, &mut a);
        // The sum of four uniform numbers is nearly normal with variance 4/3.
        let mut bell =
            || noise * (0..4).map(|_| random.uniform(-1.0, 1.0)).sum::<f64>() / (4.0f64 / 3.0).sqrt();
        let tau: Vec<f64> = state.tau.iter().map(|tau| tau + bell()).collect();
        record.push(&state.q, &state.v, &a, &tau).expect("a good sample");
    }
    record
}

/// β is accurate to 1e-6 and torques of new motions to 1e-9, for every robot.
#[test]
fn known_parameters_are_identified() -> Tested {
    for robot in robots() {
        let model = &robot.model;
        let base = BaseParameters::of(model, 10 * PARAMETERS_PER_LINK, 1);
        let random = &mut SplitMix64::new(robot.seed ^ 0xda7a);
        let record = record(model, 40 + 20 * model.moving_links().count() / model.nv(), random, 0.0);
        let found = base.identify(&record)?;
        let truth = inertial_parameters(model);
        let expected = base.values(&truth)?;
        let off = (&found.values - &expected).amax();
        robot.require("β", off, 1e-6 * expected.amax());

        // Torques of motions outside the data, from β alone and from the parameters nearest to a wrong guess.
        let guess: Vec<f64> = truth.iter().map(|p| p * 1.1 + 0.01).collect();
        let nearest = base.nearest_parameters(&found.values, &guess)?;
        robot.require(
            "B π = β",
            (base.values(nearest.as_slice())? - &found.values).amax(),
            1e-8 * expected.amax(),
        );
        let mut regressor = vec![0.0; model.nv() * truth.len()];
        for _ in 0..20 {
            let s = random_state(model, random);
            joint_torque_regressor(model, &mut Workspace::new(model), &s.q, &s.v, &s.a, &mut regressor);
            let y = DMatrix::from_row_slice(model.nv(), truth.len(), &regressor);
            let indices: Vec<usize> = base.parameters.iter().map(|parameter| parameter.index).collect();
            let tau = &y * DVector::from_column_slice(&truth);
            // Relative to the terms that are summed.
            let terms = y.abs() * DVector::from_column_slice(&truth).abs();
            let allowed = 1e-9 * (1.0 + terms.amax());
            robot.require("τ of β", (y.select_columns(&indices) * &found.values - &tau).amax(), allowed);
            let terms = (y.abs() * nearest.abs()).amax();
            robot.require("τ of π near the guess", (&y * &nearest - &tau).amax(), 1e-9 * (1.0 + terms));
        }
    }
    Ok(())
}

/// The rank is that of the singular values, and a change of invisible parameters changes no torque.
#[test]
fn base_parameters_span_visible_parameters() {
    for robot in robots() {
        let model = &robot.model;
        let base = BaseParameters::of(model, 100, 7);
        let names = inertial_parameter_names(model);
        let columns = names.len();
        let random = &mut SplitMix64::new(99);
        let mut rows = Vec::new();
        let mut regressor = vec![0.0; model.nv() * columns];
        for _ in 0..100 {
            let s = random_state(model, random);
            joint_torque_regressor(model, &mut Workspace::new(model), &s.q, &s.v, &s.a, &mut regressor);
            rows.extend_from_slice(&regressor);
        }
        let mut w = DMatrix::from_row_slice(100 * model.nv(), columns, &rows);
        let indices: Vec<usize> = base.parameters.iter().map(|parameter| parameter.index).collect();
        let left = &w - w.select_columns(&indices) * &base.combinations;
        robot.require("W = W_b B", left.amax(), 1e-9 * w.amax());
        // Columns have length 1; columns that contain only rounding are zero.
        let largest = w.amax();
        for mut column in w.column_iter_mut() {
            let length = column.norm();
            let scale = if length > 1e-9 * largest { length.recip() } else { 0.0 };
            column *= scale;
        }
        let singular = w.singular_values();
        let rank = singular.iter().filter(|x| **x > 1e-9 * singular.max()).count();
        assert_eq!(rank, base.len(), "family {}, seed {}", robot.family, robot.seed);
        for name in &base.invisible {
            let column = names.iter().position(|known| known == name).expect("a parameter");
            robot.require("invisible", w.column(column).amax(), 1e-9);
        }
    }
}

/// Two links in the vertical plane have the six base parameters of the textbooks, by name.
#[test]
fn two_links_have_six_base_parameters() -> Tested {
    let mut robot = RobotDescription::new("two_r");
    robot.links.push(LinkDescription::new("base", None));
    for (i, name) in ["upper", "fore"].into_iter().enumerate() {
        let body = MassProperties::new(2.0, Vector3::new(0.4, 0.1, 0.05), Matrix3::identity() * 0.1)?;
        robot.links.push(LinkDescription::new(name, body));
        let kind = JointKind::Revolute { axis: [0.0, -1.0, 0.0] };
        let at = Pose::from_translation([0.5 * i as f64, 0.0, 0.0]);
        let parent = ["base", "upper"][i];
        robot.joints.push(JointDescription::new(format!("joint{i}"), kind, parent, name, at));
    }
    let model = Model::new(robot)?;
    let base = BaseParameters::of(&model, 50, 3);
    let names: Vec<String> = base.parameters.iter().map(ToString::to_string).collect();
    assert_eq!(
        names,
        [
            "upper.hx + 0.500000·fore.m",
            "upper.hz",
            "upper.Iyy + 0.250000·fore.m",
            "fore.hx",
            "fore.hz",
            "fore.Iyy"
        ]
    );
    assert!(base.invisible.contains(&"upper.m".to_owned()) && !base.invisible.contains(&"fore.m".to_owned()));
    Ok(())
}

/// With noise the errors match the standard deviations, and the residual matches the noise.
#[test]
fn standard_deviations_match_noise() -> Tested {
    let noise = 0.05;
    let (mut inside, mut count) = (0u32, 0u32);
    for robot in robots().filter(|robot| robot.family == "arms") {
        let base = BaseParameters::of(&robot.model, 50, 1);
        let record = record(&robot.model, 400, &mut SplitMix64::new(robot.seed), noise);
        let found = base.identify(&record)?;
        robot.require("residual", (found.residual / noise - 1.0).abs(), 0.1);
        let expected = base.values(&inertial_parameters(&robot.model))?;
        for i in 0..base.len() {
            count += 1;
            let off = (found.values[i] - expected[i]).abs() / found.standard_deviations[i];
            assert!(off < 6.0, "{} is {off} deviations off", base.parameters[i]);
            inside += u32::from(off < 2.0);
        }
    }
    // 95 % of normal errors are within two deviations.
    assert!((0.90..0.99).contains(&(f64::from(inside) / f64::from(count))), "{inside} of {count}");
    Ok(())
}

/// Real bodies are consistent; impossible bodies are not.
#[test]
fn impossible_bodies_are_inconsistent() -> Tested {
    for robot in robots() {
        let parameters = inertial_parameters(&robot.model);
        let links = physical_consistency(&robot.model, &parameters)?;
        assert!(links.iter().all(robot_dynamics::control::LinkConsistency::is_consistent), "{links:?}");
        // The first moment of this link is too large for its mass.
        let mut wrong = parameters.clone();
        wrong[1] += 10.0 * wrong[0];
        let links = physical_consistency(&robot.model, &wrong)?;
        assert!(
            !links[0].is_consistent()
                && links[1..].iter().all(robot_dynamics::control::LinkConsistency::is_consistent),
            "{links:?}"
        );
    }
    // Moments 1, 1, 3 violate the triangle inequality: Σ has an eigenvalue ½(1 + 1 − 3) = −½.
    let flat = pseudo_inertia(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 3.0]);
    assert!((flat.symmetric_eigenvalues().min() + 0.5).abs() < 1e-12);
    // Point masses: J = Σ m (r, 1)(r, 1)ᵀ.
    let points = [(2.0, Vector3::new(0.3, -0.1, 0.2)), (1.0, Vector3::new(-0.5, 0.4, 0.0))];
    let body = MassProperties::point_masses(&points)?;
    let (i, h) = (body.inertia_about_origin(), body.center_of_mass() * body.mass());
    let j = pseudo_inertia(&[
        3.0,
        h.x,
        h.y,
        h.z,
        i[(0, 0)],
        i[(0, 1)],
        i[(1, 1)],
        i[(0, 2)],
        i[(1, 2)],
        i[(2, 2)],
    ]);
    let expected = points
        .iter()
        .map(|(m, r)| r.push(1.0) * r.push(1.0).transpose() * *m)
        .sum::<nalgebra::Matrix4<f64>>();
    assert!((j - expected).amax() < 1e-15);
    Ok(())
}

/// Insufficient data are errors that name the missing part.
#[test]
fn insufficient_data_are_errors() -> Tested {
    let robot = robots().next().ok_or("no robot")?;
    let model = &robot.model;
    let base = BaseParameters::of(model, 50, 1);
    let mut record = MotionRecord::new(model, false);
    let zero = vec![0.0; model.nv()];
    let error = base.identify(&record).unwrap_err();
    assert!(matches!(error, IdentificationError::TooFewData { equations: 0, .. }), "{error}");
    // At rest only gravity appears in the torques.
    let random = &mut SplitMix64::new(4);
    for _ in 0..60 {
        let s = random_state(model, random);
        let mut tau = zero.clone();
        inverse_dynamics(model, &mut Workspace::new(model), &s.q, &zero, &zero, &mut tau);
        record.push(&s.q, &zero, &zero, &tau)?;
    }
    let error = base.identify(&record).unwrap_err();
    assert!(matches!(error, IdentificationError::NotExcited { .. }), "{error}");
    // The parameters that appear at rest are identified.
    let at_rest = BaseParameters::of_record(&record);
    assert!(!at_rest.is_empty() && at_rest.len() < base.len());
    let found = at_rest.identify(&record)?;
    let expected = at_rest.values(&inertial_parameters(model))?;
    assert!((found.values - &expected).amax() < 1e-9 * (1.0 + size(expected.as_slice())));
    let error = record.push(&zero, &[f64::NAN; 5], &zero, &zero).unwrap_err();
    assert_eq!(error.quantity, "sample 60: v");
    Ok(())
}

/// The normal equations, without singular values: the residual of noisy torques is orthogonal to the column
/// of each base parameter.
///
/// Tolerance: rounding of sums over the rows times the condition of columns of length 1, which is below 1e4
/// here.
#[test]
fn residual_is_orthogonal_to_fitted_columns() -> Tested {
    for robot in robots() {
        let model = &robot.model;
        let (nv, columns) = (model.nv(), inertial_parameter_names(model).len());
        let base = BaseParameters::of(model, 10 * PARAMETERS_PER_LINK, 1);
        let random = &mut SplitMix64::new(robot.seed ^ 0x0f17);
        let mut record = MotionRecord::new(model, false);
        let (mut rows, mut torques) = (Vec::new(), Vec::new());
        let (workspace, parameters) =
            (&mut Workspace::new(model), DVector::from_vec(inertial_parameters(model)));
        for _ in 0..40 + 20 * model.moving_links().count() / nv {
            let state = random_state(model, random);
            let mut regressor = vec![0.0; nv * columns];
            joint_torque_regressor(model, workspace, &state.q, &state.v, &state.a, &mut regressor);
            record.push(&state.q, &state.v, &state.a, &state.tau)?;
            // Armature and springs depend on no inertial parameter, so their torques are subtracted.
            let mut whole = vec![0.0; nv];
            inverse_dynamics(model, workspace, &state.q, &state.v, &state.a, &mut whole);
            let shown = DMatrix::from_row_slice(nv, columns, &regressor) * &parameters;
            torques.extend((0..nv).map(|k| state.tau[k] - (whole[k] - shown[k])));
            rows.extend(regressor);
        }
        let all = DMatrix::from_row_slice(torques.len(), columns, &rows);
        let found = base.identify(&record)?;
        let indices: Vec<usize> = base.parameters.iter().map(|parameter| parameter.index).collect();
        let fitted = all.select_columns(&indices);
        let torques = DVector::from_vec(torques);
        let left = &torques - &fitted * &found.values;
        for column in fitted.column_iter() {
            let along = column.dot(&left).abs();
            robot.require("Wᵀ(τ − W β)", along, 1e-11 * column.norm() * torques.norm());
        }
    }
    Ok(())
}

/// The text of the error exists also for data of a robot whose torques depend on no parameter.
#[test]
fn records_without_base_parameters_have_an_error_with_a_text() {
    let error = IdentificationError::TooFewData { equations: 3, unknowns: 0, coordinates: 1 };
    assert!(error.to_string().contains('3'), "{error}");
}
