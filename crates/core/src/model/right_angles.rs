//! Exact right angles, for code generated for one robot.

use crate::Model;

/// Entries of a rotation this close to −1, 0 or 1 are taken as exact: four ε. Rounding an angle of up to π to
/// a double changes its sine and cosine by up to ε. A rotation between two bodies is a product of several
/// from the file.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// More than the error of a file with 1.571 for π/2, and less than that of most calibrations.
const FEW_DIGITS: f64 = 1e-3;

impl Model {
    /// Joints whose placement is off a right angle by more than rounding and less than 1e-3 rad. Generated
    /// code multiplies by such an entry instead of leaving it out.
    #[doc(hidden)]
    pub fn joints_near_right_angles(&self) -> Vec<&str> {
        let is_near = |x: &f64| (ROUNDING..FEW_DIGITS).contains(&(x - x.round()).abs());
        let mut near: Vec<usize> = (self.dofs.iter())
            .filter(|dof| self.bodies[dof.body].rotation.as_flattened().iter().any(is_near))
            .map(|dof| dof.joint)
            .collect();
        near.dedup();
        near.into_iter().map(|joint| self.joints[joint].name.as_str()).collect()
    }

    /// This robot with exact right angles where rotations of bodies and frames are right angles up to
    /// rounding. Files write π/2 as a decimal number, whose cosine is 6e-17, and generated code would
    /// multiply by that. Results agree up to rounding, and the description remains the original one.
    #[doc(hidden)]
    #[must_use]
    pub fn with_right_angles(&self) -> Self {
        let mut model = self.without_native_code();
        model.bodies.iter_mut().for_each(|body| round_right_angles(&mut body.rotation));
        for frame in &mut model.frames {
            round_right_angles(&mut frame.rotation);
            round_right_angles(&mut frame.body_from_frame.rotation);
        }
        model
    }
}

fn round_right_angles<const N: usize>(rotation: &mut [[f64; N]; 3]) {
    for entry in rotation.as_flattened_mut() {
        // No negative zero.
        let whole = entry.round() + 0.0;
        if (*entry - whole).abs() <= ROUNDING {
            *entry = whole;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use robot_dynamics_description::{JointKind, Pose, RandomRobotOptions, random_robot};
    use robot_dynamics_number::SplitMix64;

    use super::*;
    use crate::{RandomState, Workspace, forward_dynamics, inverse_dynamics, random_state};

    /// Trees whose joints and frames are placed by quarter and half turns, written as the nearest doubles;
    /// axes stay skew.
    fn squared(seed: u64) -> Model {
        let mut robot = random_robot(seed, &RandomRobotOptions::default());
        let mut turns = [0.0, FRAC_PI_2, -FRAC_PI_2, PI, -PI].into_iter().cycle();
        for joint in &mut robot.joints {
            let mut next = || turns.next().unwrap();
            let at = joint.parent_from_joint.translation;
            joint.parent_from_joint = Pose::from_xyz_rpy(at, [next(), next(), next()]);
            turns.next();
        }
        Model::new(robot).unwrap()
    }

    /// Inverse and forward dynamics agree up to the rounding of sums of about a hundred terms of the size of
    /// the largest. q̈ is divided by M, with a condition number below 1e5.
    #[test]
    fn the_motion_stays() {
        for seed in 0..20 {
            let model = squared(seed);
            let RandomState { q, v, a, tau } = random_state(&model, &mut SplitMix64::new(seed));
            let dynamics = |model: &Model| {
                let w = &mut Workspace::new(model);
                let mut found = [vec![0.0; model.nv()], vec![0.0; model.nv()]];
                inverse_dynamics(model, w, &q, &v, &a, &mut found[0]);
                forward_dynamics(model, w, &q, &v, &tau, &mut found[1]);
                found
            };
            let (as_written, exact) = (dynamics(&model), dynamics(&model.with_right_angles()));
            for ((one, other), allowed) in as_written.iter().zip(&exact).zip([1e-13, 1e-10]) {
                let largest = one.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
                for (x, y) in one.iter().zip(other) {
                    assert!((x - y).abs() <= allowed * largest, "seed {seed}: {x:e}, {y:e}");
                }
            }
        }
    }

    /// Quarter and half turns, by angles and by a quaternion, alone and combined, become signed permutations.
    /// An angle with an error of a file's sixth digit stays unchanged.
    #[test]
    fn only_rounding_is_taken_away() {
        let quarter = Pose::from_xyz_rpy([0.0; 3], [FRAC_PI_2, 0.0, FRAC_PI_2]);
        let half = Pose::from_xyz_rpy([0.0; 3], [PI, -FRAC_PI_2, PI]);
        let by_quaternion = Pose::from_translation_quaternion_xyzw([0.0; 3], [0.7, 0.0, 0.0, 0.7]);
        for pose in [quarter, half, by_quaternion, quarter.compose(&half), half.compose(&by_quaternion)] {
            let mut rotation = pose.rotation;
            round_right_angles(&mut rotation);
            assert_ne!(rotation, pose.rotation);
            for row in rotation {
                assert_eq!(row.map(f64::abs).iter().sum::<f64>(), 1.0, "{row:?}");
                assert!(row.iter().all(|x| [0.0, 1.0].contains(&x.abs())), "{row:?}");
                assert!(row.iter().all(|x| x.to_bits() != (-0.0_f64).to_bits()), "{row:?}");
            }
        }
        let written = Pose::from_xyz_rpy([0.0; 3], [FRAC_PI_2 - 3e-7, 0.1, PI + 7e-6]).rotation;
        let mut rotation = written;
        round_right_angles(&mut rotation);
        assert_eq!(rotation, written);
    }

    /// Reports joints that a file places by few digits of π/2, but not those with all digits or with another
    /// angle.
    #[test]
    fn few_digits_are_told() {
        let mut robot = random_robot(1, &RandomRobotOptions { joints: 5, fixed: 0.0, ..Default::default() });
        let angles = [FRAC_PI_2, FRAC_PI_2 + 4e-6, 0.3, 1.571, 0.0];
        for (joint, angle) in robot.joints.iter_mut().zip(angles) {
            joint.kind = JointKind::Revolute { axis: [0.0, 0.0, 1.0] };
            joint.parent_from_joint = Pose::from_xyz_rpy([0.1; 3], [angle, 0.0, 0.0]);
        }
        let names: Vec<String> = robot.joints.iter().map(|joint| joint.name.clone()).collect();
        let model = Model::new(robot).unwrap();
        assert_eq!(model.joints_near_right_angles(), [&names[1], &names[3]]);
        assert_eq!(model.with_right_angles().joints_near_right_angles(), [&names[1], &names[3]]);
    }

    /// The rotations of bodies and of frames are both rounded.
    #[test]
    fn bodies_and_frames_are_rounded() {
        let is_small = |x: &f64| *x != 0.0 && x.abs() <= ROUNDING;
        let small = |model: &Model| {
            let bodies = model.bodies.iter().flat_map(|body| body.rotation.as_flattened());
            let frames = model.frames.iter().flat_map(|frame| {
                frame.rotation.as_flattened().iter().chain(frame.body_from_frame.rotation.as_flattened())
            });
            [bodies.filter(|x| is_small(x)).count(), frames.filter(|x| is_small(x)).count()]
        };
        let mut found = [0; 2];
        for model in (0..20).map(squared) {
            let here = small(&model);
            (found[0], found[1]) = (found[0] + here[0], found[1] + here[1]);
            assert_eq!(small(&model.with_right_angles()), [0, 0]);
        }
        assert!(found.iter().all(|&count| count > 20), "{found:?}");
    }
}
