//! Differential steps against the optimality conditions of their quadratic program, computed here.

use nalgebra::{DMatrix, DVector};
use robot_dynamics::control::task_kinematics::{
    KinematicLimits, KinematicObjective, KinematicTask, TaskKinematics,
};
use robot_dynamics::description::Base;
use robot_dynamics::model::{Model, integrate};
use robot_dynamics::number::SplitMix64;

use super::{arm, last_frame, load, moved, random_pose, random_q};

const DT: f64 = 0.01;

/// The bounds of Δq of arms, whose coordinates are plain numbers.
fn bounds(limits: &KinematicLimits, q: &[f64], v: &[f64]) -> Vec<[f64; 2]> {
    let bound = |i: usize| {
        let (most, a) = (limits.velocity[i], limits.acceleration[i]);
        let [low, high] = [-1.0, 1.0].map(|sign: f64| (v[i] + sign * a * DT).clamp(-most, most) * DT);
        let stop = |room: f64| {
            let room = room.max(0.0);
            if a.is_infinite() { room } else { (-DT + (DT * DT + 2.0 * room / a).sqrt()) * a * DT }
        };
        let [least, largest] = limits.position[i];
        let wanted = [-stop(q[i] - least), stop(largest - q[i])];
        // Accelerations win over positions.
        [low.max(wanted[0]).min(high), high.min(wanted[1]).max(low)]
    };
    (0..q.len()).map(bound).collect()
}

/// The tasks of one level as H δ + g.
fn quadratic(
    kinematics: &mut TaskKinematics<&Model>,
    q: &[f64],
    level: usize,
) -> (DMatrix<f64>, DVector<f64>) {
    let (nv, rows) = (q.len(), kinematics.linearized_tasks(q).expect("rows"));
    let (mut h, mut g) = (DMatrix::zeros(nv, nv), DVector::zeros(nv));
    for (index, rows) in rows.iter().enumerate() {
        let task = kinematics.tasks().nth(index).expect("a task");
        if task.level == level {
            h += rows.jacobian.transpose() * &rows.jacobian;
            g += rows.jacobian.transpose() * &rows.residual * task.gain;
            h += DMatrix::identity(nv, nv) * (task.damping * rows.residual.norm_squared());
        }
    }
    (h, g)
}

/// The regularization of H, relative to its mean, times a step below one.
const REGULARIZED: f64 = 1e-9;

#[test]
fn steps_satisfy_the_optimality_conditions() {
    let mut active = 0;
    for seed in 0..60 {
        let model = arm(seed);
        let mut random = SplitMix64::new(seed);
        let mut kinematics = TaskKinematics::new(&model);
        let mut limits = KinematicLimits::of(&model);
        limits.velocity.fill(3.0);
        if seed % 2 == 0 {
            limits.acceleration.fill(20.0);
        }
        kinematics.set_limits(limits.clone()).expect("valid limits");
        let hand = last_frame(&model);
        let q = random_q(&model, &mut random);
        let near = moved(&model, &q, 0.05, &mut random);
        let target = model.frame_pose(&near, hand).expect("a pose");
        let task =
            KinematicTask::new(KinematicObjective::pose(hand, target)).with_gain(0.7).with_damping(0.1);
        kinematics.add_task(task).expect("a task");
        let center =
            KinematicTask::new(KinematicObjective::center_of_mass([0.1, 0.3, 0.2])).with_weight(0.01);
        kinematics.add_task(center).expect("a task");
        let v: Vec<f64> = (0..7).map(|_| random.uniform(-1.0, 1.0)).collect();
        let delta = {
            let step = kinematics.step(&q, &v, DT).expect("a step");
            DVector::from_iterator(7, step.velocity.iter().map(|v| v * DT))
        };
        let (h, g) = quadratic(&mut kinematics, &q, 0);
        let scale = h.trace() + g.amax();
        let gradient = &h * &delta + &g;
        for (i, [low, high]) in bounds(&limits, &q, &v).into_iter().enumerate() {
            let x = delta[i];
            assert!(x >= low - 1e-12 && x <= high + 1e-12, "seed {seed}, {i}: {low} {x} {high}");
            let (at_low, at_high) = (x - low < 1e-12, high - x < 1e-12);
            active += usize::from(at_low || at_high);
            assert!(at_low || gradient[i] <= REGULARIZED * scale, "seed {seed}, {i}: {}", gradient[i]);
            assert!(at_high || gradient[i] >= -REGULARIZED * scale, "seed {seed}, {i}: {}", gradient[i]);
        }
    }
    assert!(active > 60, "{active} bounds are active");
}

#[test]
fn later_levels_do_not_change_earlier_ones() {
    for seed in 0..30 {
        let model = arm(seed);
        let mut random = SplitMix64::new(seed);
        let (hand, q, v) = (last_frame(&model), random_q(&model, &mut random), vec![0.0; 7]);
        let mut limits = KinematicLimits::of(&model);
        limits.velocity.fill(5.0);
        let target = model.frame_pose(&moved(&model, &q, 0.02, &mut random), hand).expect("a pose");
        let place = KinematicTask::new(KinematicObjective::pose(hand, target.translation));
        let posture = KinematicObjective::Posture { target: vec![0.0; 7] };
        let mut alone = TaskKinematics::new(&model);
        let mut both = TaskKinematics::new(&model);
        for kinematics in [&mut alone, &mut both] {
            kinematics.set_limits(limits.clone()).expect("valid limits");
            kinematics.add_task(place.clone()).expect("a task");
        }
        both.add_task(KinematicTask::new(posture).with_level(1)).expect("a task");
        let velocity = |kinematics: &mut TaskKinematics<&Model>| {
            DVector::from_column_slice(&kinematics.step(&q, &v, DT).expect("a step").velocity)
        };
        let (first, second) = (velocity(&mut alone), velocity(&mut both));
        let rows = both.linearized_tasks(&q).expect("rows");
        let off = (&rows[0].jacobian * (&first - &second)).amax();
        assert!(off < 1e-8, "seed {seed}: {off:e}");
        let errors = [&first, &second].map(|v| (&rows[1].residual + &rows[1].jacobian * v * DT).norm());
        assert!(errors[1] < errors[0] - 1e-9, "seed {seed}: the posture is nearer, {errors:?}");
        // The second level is optimal: its gradient has no part along motions that keep the first one, except
        // at bounds.
        let basis = rows[0].jacobian.clone().svd(true, true).v_t.expect("V");
        let gradient = rows[1].jacobian.transpose() * (&rows[1].residual + &rows[1].jacobian * &second * DT);
        let is_free = bounds(&limits, q.as_slice(), &v)
            .iter()
            .zip(second.iter())
            .all(|([low, high], v)| v * DT > low + 1e-9 && v * DT < high - 1e-9);
        if is_free {
            let rest = &gradient - basis.transpose() * (&basis * &gradient);
            assert!(rest.amax() < 1e-7 * (1.0 + gradient.amax()), "seed {seed}: {:e}", rest.amax());
        }
    }
}

#[test]
fn steps_of_a_floating_robot_reach_several_targets() {
    let model = load("humanoid.urdf", Base::Floating);
    let q0 = robot_dynamics::model::neutral(&model);
    let mut kinematics = TaskKinematics::new(&model);
    let mut targets = Vec::new();
    let mut random = SplitMix64::new(1);
    let near = moved(&model, &q0, 0.1, &mut random);
    let frames = model.frames();
    for frame in [frames.len() - 1, frames.len() / 2, 3] {
        let frame = model.frame_named(&frames[frame].name).expect("a frame");
        let target = model.frame_pose(&near, frame).expect("a pose");
        kinematics.set_limits(KinematicLimits::none(&model)).expect("limits");
        kinematics.add_task(KinematicObjective::pose(frame, target)).expect("a task");
        targets.push((frame, target));
    }
    let (mut q, mut v) = (q0, vec![0.0; model.nv()]);
    for _ in 0..20 {
        let step = kinematics.step(&q, &v, DT).expect("a step");
        let mut by_hand = q.clone();
        let shift: Vec<f64> = step.velocity.iter().map(|v| v * DT).collect();
        integrate(&model, &q, &shift, &mut by_hand);
        assert!(by_hand.iter().zip(&step.q).all(|(a, b)| (a - b).abs() < 1e-12));
        (q, v) = (step.q.clone(), step.velocity.clone());
    }
    for (frame, target) in targets {
        let reached = model.frame_pose(&q, frame).expect("a pose");
        for i in 0..3 {
            assert!((reached.translation[i] - target.translation[i]).abs() < 1e-9);
            assert!((0..3).all(|j| (reached.rotation[i][j] - target.rotation[i][j]).abs() < 1e-9));
        }
    }
}

#[test]
fn invalid_numbers_are_errors() {
    let model = arm(1);
    let mut kinematics = TaskKinematics::new(&model);
    let mut pose = random_pose(&mut SplitMix64::new(1));
    let hand = last_frame(&model);
    let task = kinematics.add_task(KinematicObjective::pose(hand, pose)).expect("a task");
    assert!(kinematics.step(&[0.0; 7], &[0.0; 7], 0.0).is_err());
    assert!(kinematics.step(&[0.0; 7], &[f64::NAN; 7], DT).is_err());
    assert!(kinematics.step(&[0.0; 6], &[0.0; 7], DT).is_err());
    assert!(kinematics.step(&[0.0; 7], &[0.0; 7], DT).is_ok());
    pose.rotation[0][0] = 3.0;
    *kinematics.objective_mut(task) = KinematicObjective::pose(hand, pose);
    assert!(kinematics.step(&[0.0; 7], &[0.0; 7], DT).is_err());
    let posture = KinematicObjective::Posture { target: vec![0.0; 3] };
    assert!(kinematics.add_task(posture).is_err());
    let good = KinematicTask::new(KinematicObjective::center_of_mass([0.0; 3]));
    assert!(kinematics.add_task(good.clone().with_weight(-1.0)).is_err());
    assert!(kinematics.add_task(good.clone().with_gain(1.5)).is_err());
    assert!(kinematics.add_task(good.with_damping(f64::NAN)).is_err());
    let (frame, point) = (hand, [1.0; 3]);
    assert!(kinematics.add_task(KinematicObjective::LookAt { frame, axis: [2.0, 0.0, 0.0], point }).is_err());
    let mut limits = KinematicLimits::none(&model);
    limits.velocity[0] = -1.0;
    assert!(kinematics.set_limits(limits).is_err());
}
