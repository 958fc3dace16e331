//! Enclosures of motions contain the motions of single states, which another method computes.

use robot_dynamics::algorithms::forward_dynamics;
use robot_dynamics::description::{JointKinds, RandomRobotOptions, pendulum, random_robot};
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::number::SplitMix64;
use robot_dynamics_certified::{EnclosureError, Interval, enclose_motion};

/// The state after a time, by the classical Runge–Kutta method with small steps.
fn runge_kutta(model: &Model, start: &[f64], tau: &[f64], time: f64) -> Vec<f64> {
    let n = model.nv();
    let rate = |x: &[f64]| {
        let mut rate = [&x[n..], &vec![0.0; n]].concat();
        forward_dynamics(model, &mut Workspace::new(model), &x[..n], &x[n..], tau, &mut rate[n..]);
        rate
    };
    let moved =
        |x: &[f64], k: &[f64], h: f64| -> Vec<f64> { x.iter().zip(k).map(|(x, k)| x + h * k).collect() };
    let (steps, mut x) = (2000, start.to_vec());
    let h = time / f64::from(steps);
    for _ in 0..steps {
        let a = rate(&x);
        let b = rate(&moved(&x, &a, 0.5 * h));
        let c = rate(&moved(&x, &b, 0.5 * h));
        let d = rate(&moved(&x, &c, h));
        for i in 0..2 * n {
            x[i] += h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]);
        }
    }
    x
}

#[test]
fn enclosures_contain_the_motions_of_their_states() {
    let mut random = SplitMix64::new(3);
    for seed in 0..5 {
        let options = RandomRobotOptions { joints: 3, kinds: JointKinds::SingleDof, ..Default::default() };
        let model = Model::new(random_robot(seed, &options)).expect("a robot");
        let n = model.nv();
        let mut near = |radius: f64| -> Vec<Interval> {
            (0..n).map(|_| Interval::around(random.uniform(-1.0, 1.0), radius)).collect()
        };
        let (q, v) = (near(1e-6), near(1e-6));
        let tau: Vec<f64> = (0..n).map(|k| 0.3 - 0.2 * k as f64).collect();
        let motion = enclose_motion(&model, &q, &v, &tau, 0.002, 50).expect("an enclosure");
        assert!(motion.is_complete, "robot {seed} ends at {} s", motion.states.last().unwrap().time);
        let end = motion.states.last().expect("a state");
        let found: Vec<Interval> = end.q.iter().chain(&end.v).copied().collect();
        let mut sampled: Vec<Interval> = Vec::new();
        for sample in 0..40 {
            let start: Vec<f64> = q
                .iter()
                .chain(&v)
                .map(|x| {
                    if sample % 2 == 0 {
                        if random.uniform(0.0, 1.0) < 0.5 { x.lower() } else { x.upper() }
                    } else {
                        random.uniform(x.lower(), x.upper())
                    }
                })
                .collect();
            let x = runge_kutta(&model, &start, &tau, 0.1);
            for (found, x) in found.iter().zip(&x) {
                // The error of 2000 steps of order 4 and their rounding is below 1e-11.
                let slack = 1e-11 * (1.0 + x.abs());
                assert!(
                    found.lower() - slack <= *x && *x <= found.upper() + slack,
                    "robot {seed}: {x}, {found}"
                );
            }
            sampled = if sample == 0 {
                x.iter().map(|x| Interval::from(*x)).collect()
            } else {
                sampled.iter().zip(&x).map(|(all, x)| all.hull(Interval::from(*x))).collect()
            };
        }
        for (found, sampled) in found.iter().zip(&sampled) {
            // Twenty corners of a box in six dimensions miss up to half of the range of a linear map, and
            // rotated boxes add as much.
            assert!(found.width() < 5.0 * sampled.width(), "robot {seed}: {found} for {sampled}");
        }
    }
}

#[test]
fn a_point_stays_as_narrow_as_rounding() {
    let model = Model::new(pendulum(2.0, 0.5)).expect("a robot");
    let motion =
        enclose_motion(&model, &[0.3.into()], &[0.0.into()], &[0.0], 0.005, 200).expect("an enclosure");
    let end = motion.states.last().expect("a state");
    // The remainder of order 6 is (0.005 · 5)^6 times a small number.
    assert!(motion.is_complete && end.q[0].width() < 1e-9, "{}", end.q[0]);
    let x = runge_kutta(&model, &[0.3, 0.0], &[0.0], 1.0);
    assert!((end.q[0].middle() - x[0]).abs() < 1e-9);
}

#[test]
fn sets_that_grow_too_wide_end_the_enclosure() {
    let model = Model::new(pendulum(2.0, 0.5)).expect("a robot");
    let wide = [Interval::new(-3.0, 3.0)];
    let motion =
        enclose_motion(&model, &wide, &[Interval::new(-50.0, 50.0)], &[0.0], 0.5, 20).expect("a motion");
    assert!(!motion.is_complete || motion.states.last().unwrap().q[0].width() > 100.0);
    let unbounded = enclose_motion(&model, &[Interval::ENTIRE], &[0.0.into()], &[0.0], 0.1, 1);
    assert!(matches!(unbounded, Err(EnclosureError::Unbounded)));
}
