//! Proven bounds of torques contain the torques of edited robots, which are computed in double precision.

use nalgebra::{Matrix3, Vector3};
use robot_dynamics::algorithms::{dissipation, inverse_dynamics};
use robot_dynamics::description::{
    JointKinds, MassProperties, PassiveForces, RandomRobotOptions, RobotDescription, random_robot,
};
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::number::SplitMix64;
use robot_dynamics_certified::{
    Interval, Payload, PolynomialMotion, SearchOptions, Uncertainty, torque_bounds,
};

fn robot(seed: u64) -> RobotDescription {
    let options =
        RandomRobotOptions { joints: 4, kinds: JointKinds::Turning, chain: 0.7, ..Default::default() };
    let mut robot = random_robot(seed, &options);
    for joint in &mut robot.joints {
        joint.passive = PassiveForces::default().with_damping(0.4).with_friction(0.2).with_armature(0.05);
    }
    robot
}

/// A number of an interval; in one of three cases a bound, as the extremes are there.
fn pick(random: &mut SplitMix64, x: Interval) -> f64 {
    match random.uniform(0.0, 3.0) {
        u if u < 0.5 => x.lower(),
        u if u < 1.0 => x.upper(),
        _ => random.uniform(x.lower(), x.upper()),
    }
}

#[test]
fn bounds_contain_the_torques_of_edited_robots() {
    let mut random = SplitMix64::new(7);
    let masses = Interval::new(0.8, 1.1);
    let friction = Interval::new(0.5, 2.0);
    let gravity = [Interval::new(-0.5, 0.5), Interval::from(0.0), Interval::new(-10.0, -9.0)];
    let mut nearest = f64::INFINITY;
    for seed in 0..6 {
        let description = robot(seed);
        let model = Model::new(description.clone()).expect("a robot");
        let n = model.nv();
        let points: Vec<Vec<f64>> =
            (0..4).map(|_| (0..n).map(|_| random.uniform(-1.0, 1.0)).collect()).collect();
        let motion = PolynomialMotion::spline(&[0.0, 0.7, 1.1, 2.0], &points).expect("a motion");
        let link = model.moving_links().last().expect("a link").to_owned();
        let payload = Payload {
            frame: model.frame(&link).expect("the frame of a link"),
            mass: Interval::new(0.0, 1.0),
            center_of_mass: [Interval::new(-0.1, 0.1), Interval::from(0.05), Interval::new(0.0, 0.2)],
            radius_of_gyration: 0.1,
        };
        let robots = Uncertainty::none(&model)
            .with_mass_factor(masses)
            .and_then(|set| set.with_friction_factor(friction))
            .and_then(|set| set.with_gravity(gravity).with_payload(&model, payload))
            .expect("a set");
        let options = SearchOptions { tolerance: 0.02, ..Default::default() };
        let bounds = torque_bounds(&model, &motion, &robots, &options).expect("bounds");
        assert!(bounds.is_tight);
        let mut sampled = vec![Interval::from(0.0); n];
        for sample in 0..200 {
            let mut edited = description.clone();
            let links: Vec<String> = model.moving_links().map(str::to_owned).collect();
            for link in &links {
                edited.scale_mass(link, pick(&mut random, masses)).expect("a link with mass");
            }
            let mass = pick(&mut random, payload.mass).max(1e-6);
            let center = Vector3::from(payload.center_of_mass.map(|x| pick(&mut random, x)));
            // A sphere, so that its axes do not matter; the principal moments of a ring or rod are others.
            let moment = mass * random.uniform(0.0, 0.01);
            let load = MassProperties::new(mass, center, Matrix3::identity() * moment).expect("a body");
            edited.attach_payload(&link, &load).expect("a payload");
            edited.gravity = gravity.map(|x| pick(&mut random, x));
            let factor = pick(&mut random, friction);
            let edited = Model::new(edited).expect("an edited robot");
            let piece = sample % 3;
            let [q, v, a] = motion.state(piece, random.uniform(0.0, motion.pieces()[piece].duration));
            let (mut tau, mut loss) = (vec![0.0; n], vec![0.0; n]);
            inverse_dynamics(&edited, &mut Workspace::new(&edited), &q, &v, &a, &mut tau);
            dissipation(&edited, &v, &mut loss);
            for j in 0..n {
                let torque = tau[j] + factor * loss[j];
                // The torque in double precision has rounding errors.
                let slack = 1e-12 * bounds.proven[j].magnitude();
                let proven =
                    Interval::new(bounds.proven[j].lower() - slack, bounds.proven[j].upper() + slack);
                assert!(proven.contains(torque), "joint {j} of robot {seed}: {torque} is not in {proven}");
                sampled[j] = if sample == 0 { torque.into() } else { sampled[j].hull(torque.into()) };
            }
        }
        for ((proven, attained), sampled) in bounds.proven.iter().zip(&bounds.attained).zip(&sampled) {
            assert!(proven.contains(attained.least) && proven.contains(attained.greatest));
            // Torques that the search attains are beyond those of random robots.
            assert!(attained.least < sampled.lower() + 0.1 * sampled.width());
            assert!(attained.greatest > sampled.upper() - 0.1 * sampled.width());
            nearest = nearest.min((attained.greatest - attained.least) / proven.width());
        }
    }
    assert!(nearest > 1.0 / 1.5, "attained torques cover {nearest} of a proven range");
}

#[test]
fn bounds_without_uncertainty_are_near_the_torques_of_the_motion() {
    let model = Model::new(robot(3)).expect("a robot");
    let motion = PolynomialMotion::rest_to_rest(&[0.0; 4], &[1.0, -0.5, 0.3, 2.0], 1.5).expect("a motion");
    let options = SearchOptions { tolerance: 1e-3, ..Default::default() };
    let bounds = torque_bounds(&model, &motion, &Uncertainty::none(&model), &options).expect("bounds");
    let mut most = vec![Interval::from(0.0); 4];
    for k in 0..=20_000 {
        let [q, v, a] = motion.state(0, 1.5 * f64::from(k) / 20_000.0);
        let mut tau = vec![0.0; 4];
        inverse_dynamics(&model, &mut Workspace::new(&model), &q, &v, &a, &mut tau);
        for (most, tau) in most.iter_mut().zip(&tau) {
            *most = if k == 0 { (*tau).into() } else { most.hull((*tau).into()) };
        }
    }
    for (proven, sampled) in bounds.proven.iter().zip(&most) {
        let slack = 1e-12 * proven.magnitude();
        assert!(proven.lower() <= sampled.lower() + slack && sampled.upper() <= proven.upper() + slack);
        // Both sides may be larger by the tolerance.
        assert!(proven.width() < 1.003 * sampled.width(), "{proven} against {sampled}");
    }
}

#[test]
fn a_spline_has_continuous_accelerations_and_rests_at_its_ends() {
    let times = [0.0, 0.3, 1.0, 1.4];
    let points = [0.0, 1.0, -1.0, 0.5].map(|x| vec![x]);
    let motion = PolynomialMotion::spline(&times, &points).expect("a motion");
    for k in 0..3 {
        let duration = motion.pieces()[k].duration;
        let [q, v, a] = motion.state(k, duration);
        // Values of some units, computed by a few operations.
        assert!((q[0] - points[k + 1][0]).abs() < 1e-13);
        if k < 2 {
            let [_, next_v, next_a] = motion.state(k + 1, 0.0);
            assert!((v[0] - next_v[0]).abs() < 1e-12 && (a[0] - next_a[0]).abs() < 1e-11);
        } else {
            assert!(v[0].abs() < 1e-12);
        }
    }
    assert_eq!(motion.state(0, 0.0)[1][0], 0.0);
}
