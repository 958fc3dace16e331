//! Proven bounds of positions contain sampled positions, and proofs of definiteness agree with eigenvalues.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use robot_dynamics::algorithms::{frame_pose, mass_matrix};
use robot_dynamics::description::{
    JointDescription, JointKind, JointKinds, LinkDescription, MassProperties, Pose, RandomRobotOptions,
    RobotDescription, random_robot,
};
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::number::SplitMix64;
use robot_dynamics_certified::{
    Definiteness, EnclosureError, Interval, ReachableSet, SearchOptions, mass_matrix_definiteness,
};

#[test]
fn reachable_sets_contain_sampled_positions_and_end_near_attained_ones() {
    let mut random = SplitMix64::new(5);
    for seed in 0..12 {
        let kinds = if seed % 2 == 0 { JointKinds::Turning } else { JointKinds::SingleDof };
        let options = RandomRobotOptions { joints: 5, kinds, chain: 1.0, ..Default::default() };
        let model = Model::new(random_robot(seed, &options)).expect("a robot");
        let q: Vec<Interval> = (0..model.nq())
            .map(|_| Interval::around(random.uniform(-1.0, 1.0), random.uniform(0.1, 2.0)))
            .collect();
        let name = model.moving_links().last().expect("a link").to_owned();
        let frame = model.frame(&name).expect("a frame");
        let set = ReachableSet::new(&model, &q, frame, 32, &SearchOptions::default()).expect("a set");
        let bounding_box = set.bounding_box();
        let size = bounding_box.iter().fold(0.0, |most: f64, x| most.max(x.width()));
        let direction = [0.3, -0.5, 0.8];
        let farthest = set.farthest(direction);
        let mut found = f64::NEG_INFINITY;
        for _ in 0..2000 {
            let at: Vec<f64> = q.iter().map(|x| random.uniform(x.lower(), x.upper())).collect();
            let p = frame_pose(&model, &mut Workspace::new(&model), &at, frame).translation;
            // The position in double precision has rounding errors.
            for (x, bound) in p.iter().zip(&bounding_box) {
                assert!(bound.lower() - 1e-13 <= *x && *x <= bound.upper() + 1e-13, "{x} in {bound}");
            }
            found = p.iter().zip(direction).map(|(x, n)| x * n).sum::<f64>().max(found);
        }
        assert!(found <= farthest.proven + 1e-13, "{found} and {farthest:?}");
        assert!(farthest.q.iter().zip(&q).all(|(at, q)| q.contains(*at)));
        // The overestimate of each joint is that of a chord over a step of 1/16: about 1/500 of the length.
        let gap = farthest.proven - farthest.attained;
        assert!((0.0..0.03 * size).contains(&gap), "robot {seed}: {gap} of {size}");
    }
}

#[test]
fn an_interrupted_reachable_set_is_the_whole_space_and_may_own_its_model() {
    let options =
        RandomRobotOptions { joints: 3, kinds: JointKinds::Turning, chain: 1.0, ..Default::default() };
    let model = Model::new(random_robot(4, &options)).expect("a robot");
    let q = vec![Interval::new(-1.0, 1.0); model.nq()];
    let frame = model.frame(model.moving_links().last().expect("a link")).expect("a frame");
    let direction = [0.6, -0.3, 0.2];
    let set = |options: SearchOptions| ReachableSet::new(&model, &q, frame, 8, &options).expect("a set");
    let whole = set(SearchOptions::default());
    let proven = whole.farthest(direction).proven;
    assert!(proven.is_finite());
    assert_eq!(whole.into_owned().farthest(direction).proven, proven);
    let interrupt = Some(Arc::new(AtomicBool::new(true)));
    let early = set(SearchOptions { interrupt, ..Default::default() });
    assert_eq!(early.farthest(direction).proven, f64::INFINITY);
}

#[test]
fn mass_matrices_of_bodies_with_inertia_are_definite_in_all_configurations() {
    let options = RandomRobotOptions { joints: 6, kinds: JointKinds::All, ..Default::default() };
    let mut proven = 0;
    for seed in 0..20 {
        let model = Model::new(random_robot(seed, &options)).expect("a robot");
        let all = vec![Interval::ENTIRE; model.nq()];
        proven += usize::from(matches!(
            mass_matrix_definiteness(&model, &all, &SearchOptions::default()),
            Ok(Definiteness::ByOwnInertias)
        ));
    }
    // Joints with several axes have bodies without inertia between them, which this proof does not cover.
    assert!(proven >= 5, "{proven} of 20 robots");
}

/// Two hinges about x with a body without mass between them, and a third about `third`.
fn with_massless_link(second: [f64; 3]) -> RobotDescription {
    let body = MassProperties::point(1.0, [0.0, 0.3, 0.4].into()).expect("a mass");
    let mut robot = RobotDescription::new("massless");
    robot.links.push(LinkDescription::new("base", None));
    robot.links.push(LinkDescription::new("middle", None));
    robot.links.push(LinkDescription::new("end", body));
    let hinge = |name, axis, parent, child| {
        JointDescription::new(name, JointKind::Continuous { axis }, parent, child, Pose::IDENTITY)
    };
    robot.joints.push(hinge("first", [1.0, 0.0, 0.0], "base", "middle"));
    robot.joints.push(hinge("second", second, "middle", "end"));
    robot
}

#[test]
fn a_body_without_mass_needs_a_division_and_parallel_hinges_disprove() {
    let options = SearchOptions::default();
    let universal = Model::new(with_massless_link([0.0, 1.0, 0.0])).expect("a robot");
    let narrow = [Interval::new(-0.5, 0.5), Interval::new(-0.5, 0.5)];
    match mass_matrix_definiteness(&universal, &narrow, &options) {
        Ok(Definiteness::ByDivision { boxes, tree }) => {
            let parts = tree.preorder().iter().filter(|node| **node < 0).count();
            assert_eq!(boxes, 2 * parts - 1);
        }
        other => panic!("{other:?}"),
    }
    let mut mass = [0.0; 4];
    mass_matrix(&universal, &mut Workspace::new(&universal), &[0.2, 0.3], &mut mass);
    assert!(mass[0] * mass[3] - mass[1] * mass[2] > 1e-3);
    let parallel = Model::new(with_massless_link([1.0, 0.0, 0.0])).expect("a robot");
    let found = mass_matrix_definiteness(&parallel, &narrow, &options);
    assert!(matches!(found, Ok(Definiteness::Disproven { .. })), "{found:?}");
}

#[test]
fn boxes_of_quaternions_and_unbounded_boxes_are_refused() {
    let options = RandomRobotOptions { joints: 3, kinds: JointKinds::SingleDof, ..Default::default() };
    let model = Model::new(random_robot(2, &options)).expect("a robot");
    let name = model.moving_links().last().expect("a link").to_owned();
    let frame = model.frame(&name).expect("a frame");
    let found =
        ReachableSet::new(&model, &vec![Interval::ENTIRE; model.nq()], frame, 8, &SearchOptions::default());
    assert!(matches!(found, Err(EnclosureError::Unbounded)));
}
