//! Equalities in implicit steps, against the explicit constrained run, closed forms, and robots with a joint
//! in place of the equality.

use std::path::Path;

use dynamics::{KnifeEdge, PlanarBody};
use nalgebra::{Matrix3, Vector3, vector};
use robot_dynamics::constraints::{
    Constraint, ConstraintOptions, ConstraintSet, Coupling, DriftCorrection, FrameConstraint, NoSlip,
    PolynomialCoupling, RollingDisc, SpatialAxis, constraint_drift, project_position, project_velocity,
};
use robot_dynamics::contact::{ContactSet, Ground};
use robot_dynamics::description::{
    Base, JointDescription, JointKind, Limits, LinkDescription, LinkShape, MassProperties, PassiveForces,
    Pose, RandomRobotOptions, RobotDescription, Shape, ShapeRole, random_robot,
};
use robot_dynamics::mjcf::{self, LoadOptions};
use robot_dynamics::model::{Model, Workspace, difference, neutral, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::{
    IntegratorError, Method, Run, RunError, RunOptions, SimulationBuilder, StepError, StepForces, StepInfo,
    StepWorkspace, Stepper,
};
use robot_dynamics::verification::admm;

use crate::free_body::{implicit_on, implicit_over, run_watched, stepper};

const G: f64 = 9.81;

fn held(model: &Model, set: &ConstraintSet) -> SimulationBuilder<'static> {
    implicit_over(model, None).constraints(set.clone())
}

/// The largest difference between two states.
fn apart(model: &Model, (q0, v0): (&[f64], &[f64]), (q1, v1): (&[f64], &[f64])) -> f64 {
    let mut way = vec![0.0; model.nv()];
    difference(model, q0, q1, &mut way);
    let of_v = v0.iter().zip(v1).map(|(a, b)| a - b);
    of_v.chain(way).fold(0.0, |most, x| most.max(x.abs()))
}

/// A loop of four bars in the x–z plane, turned by an angle at its first bar, with damping and a spring. Two
/// branches are joined by a pin.
fn four_bars(angle: f64) -> (Model, ConstraintSet, Vec<f64>) {
    let mut robot = RobotDescription::new("four bars");
    robot.links.push(LinkDescription::new("world", None));
    let bar = |name: &str, mass: f64, to: [f64; 3]| {
        let at = Vector3::from(to) * 0.5;
        let moment = Matrix3::identity() * (mass * at.norm_squared() / 3.0);
        LinkDescription::new(name, MassProperties::new(mass, at, moment).unwrap())
    };
    robot.links.push(bar("crank", 1.0, [0.0, 0.0, 0.2]));
    robot.links.push(bar("coupler", 2.0, [0.5, 0.0, 0.1]));
    robot.links.push(bar("rocker", 1.5, [0.0, 0.0, 0.3]));
    let hinge = JointKind::Revolute { axis: [0.0, 1.0, 0.0] };
    for (name, parent, at, damping) in [
        ("crank", "world", [0.0; 3], 0.05),
        ("coupler", "crank", [0.0, 0.0, 0.2], 0.0),
        ("rocker", "world", [0.5, 0.0, 0.0], 0.1),
    ] {
        let passive = PassiveForces::default().with_damping(damping);
        let joint =
            JointDescription::new(format!("turn_{name}"), hinge, parent, name, Pose::from_translation(at));
        robot.joints.push(joint.with_passive(passive));
    }
    for (name, link, at) in [("a", "coupler", [0.5, 0.0, 0.1]), ("b", "rocker", [0.0, 0.0, 0.3])] {
        robot.frames.push(robot_dynamics::description::FrameDescription::new(
            name,
            link,
            Pose::from_translation(at),
        ));
    }
    let model = Model::new(robot).unwrap();
    let [a, b] = ["a", "b"].map(|frame| model.frame(frame).unwrap());
    let set =
        ConstraintSet::new(&model, [("pin", FrameConstraint::between(a, b, &FrameConstraint::BALL).into())])
            .unwrap();
    let mut q = vec![angle, 0.0, 0.0];
    let options = ConstraintOptions::default();
    project_position(&model, &mut Workspace::new(&model), &set, &options, 1e-13, &mut q).unwrap();
    (model, set, q)
}

/// Random trees with a loop, a polynomial coupling of two joints and a linear one, and a start that satisfies
/// them.
fn random_loops(seed: u64) -> Option<(Model, ConstraintSet, Vec<f64>, Vec<f64>)> {
    let mut robot = random_robot(seed, &RandomRobotOptions::default());
    for joint in &mut robot.joints {
        joint.limits = Limits::default();
        joint.passive = PassiveForces::default();
        if !matches!(joint.kind, JointKind::Spherical | JointKind::Floating | JointKind::Planar { .. }) {
            joint.passive = joint.passive.with_damping(0.3);
        }
    }
    let model = Model::new(robot).unwrap();
    let links: Vec<String> = model.description().links.iter().map(|link| link.name.clone()).collect();
    let [a, b] = [&links[links.len() / 3], &links[links.len() - 1]].map(|link| model.frame(link).unwrap());
    let single: Vec<&str> =
        model.joints().iter().filter(|joint| joint.nv == 1).map(|joint| joint.name.as_str()).collect();
    let (&first, &last) = (single.first()?, single.last()?);
    let closure: Constraint =
        FrameConstraint::between(a, b, &[SpatialAxis::X, SpatialAxis::Z, SpatialAxis::Rx]).into();
    let mut all = vec![("loop", closure)];
    if first != last {
        let polynomial = [0.1, 0.5, 0.3, -0.1, 0.05];
        all.push((
            "cam",
            PolynomialCoupling::new(&model, (last, 0.1), Some((first, -0.2)), polynomial).unwrap().into(),
        ));
    }
    let set = ConstraintSet::new(&model, all).unwrap();
    let state = random_state(&model, &mut SplitMix64::new(seed));
    let (mut q, mut v) = (state.q, state.v);
    let (workspace, options) = (&mut Workspace::new(&model), ConstraintOptions::default());
    project_position(&model, workspace, &set, &options, 1e-13, &mut q).ok()?;
    project_velocity(&model, workspace, &set, &options, &q, &mut v).ok()?;
    Some((model, set, q, v))
}

/// Two arms and a free body with equalities of tendons over joints and along straight paths over a pulley,
/// and a start that satisfies them.
fn tied_tendons() -> (Model, ConstraintSet, Vec<f64>, Vec<f64>) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/mjcf/soft/tied_tendons.xml");
    let mut robot = mjcf::load(path, &LoadOptions::default()).unwrap().description;
    robot.equalities.retain(|equality| ["geared", "rope", "mixed"].contains(&equality.name.as_str()));
    let model = Model::new(robot).unwrap();
    let set = ConstraintSet::from_equalities(&model).unwrap();
    assert_eq!(set.row_names(), ["geared.position", "rope.position", "mixed.position"]);
    let mut q = neutral(&model);
    let mut v: Vec<f64> = (0..model.nv()).map(|k| (3.0 * k as f64).cos()).collect();
    let (workspace, options) = (&mut Workspace::new(&model), ConstraintOptions::default());
    project_position(&model, workspace, &set, &options, 1e-13, &mut q).unwrap();
    project_velocity(&model, workspace, &set, &options, &q, &mut v).unwrap();
    (model, set, q, v)
}

/// Against the explicit constrained run (RK4 with its own projections): halving h divides the error by 4.
#[test]
fn loops_have_order_2() {
    let mut cases = 0;
    let (bars, pin, q) = four_bars(0.6);
    let mut all = vec![("four bars".to_owned(), (bars, pin, q, vec![0.0; 3]))];
    all.push(("tied tendons".to_owned(), tied_tendons()));
    all.extend((0..12).filter_map(|seed| Some((format!("robot {seed}"), random_loops(seed)?))));
    for (name, (model, set, q, v)) in &all {
        let time = 0.2;
        let Ok(expected) = SimulationBuilder::new(model)
            .method(Method::Fixed(ConstraintOptions::default().integrator))
            .constraints(set.clone())
            .dt(time / 1000.0)
            .constraint_options(ConstraintOptions::default(), DriftCorrection::default())
            .build()
            .unwrap()
            .run_steps_from(q, v, 1000, RunOptions::new().sample_ends())
        else {
            continue;
        };
        let error = |steps: usize| {
            let run = run_watched(held(model, set), (q, v), (time / steps as f64, steps), |_| {});
            let drift = constraint_drift(model, &mut Workspace::new(model), set, &run.q, &run.v);
            assert!(drift.position < 1e-11, "{name}: {drift:?}");
            let off = apart(model, (&expected.q, &expected.v), (&run.q, &run.v));
            (off, run.energy_account.max_imbalance() / run.energy_account.scale(), drift.velocity)
        };
        let (coarse, fine) = (error(400), error(800));
        let order = (coarse.0 / fine.0).log2();
        let imbalance_order = (coarse.1 / fine.1).log2();
        println!(
            "{name}: error {:.1e}, order {order:.2}; imbalance {:.1e}, order {imbalance_order:.2}; A v {:.1e}",
            fine.0, fine.1, fine.2
        );
        assert!(order > 1.8 || fine.0 < 1e-9, "{name}: {coarse:?}, {fine:?}, order {order}");
        assert!(imbalance_order > 1.7 || fine.1 < 1e-10, "{name}: {coarse:?}, {fine:?}");
        cases += 1;
    }
    assert!(cases >= 6, "{cases}");
}

/// Two sleds on parallel vertical rails, geared 1:1 against each other.
fn hoist(masses: [f64; 2], passive: PassiveForces, limits: Limits) -> (Model, ConstraintSet) {
    let mut robot = RobotDescription::new("hoist");
    robot.links.push(LinkDescription::new("world", None));
    for (k, mass) in masses.into_iter().enumerate() {
        let link = format!("sled{k}");
        robot.links.push(LinkDescription::new(&link, MassProperties::point(mass, Vector3::zeros()).unwrap()));
        let kind = JointKind::Prismatic { axis: [0.0, 0.0, 1.0] };
        let at = Pose::from_translation([k as f64, 0.0, 0.0]);
        let joint =
            JointDescription::new(format!("slide{k}"), kind, "world", &link, at).with_passive(passive);
        robot.joints.push(if k == 0 { joint.with_limits(limits) } else { joint });
        let ball = Shape::Sphere { radius: 0.1 };
        robot.shapes.push(LinkShape::new(&link, ShapeRole::Collision, Pose::IDENTITY, ball));
    }
    let model = Model::new(robot).unwrap();
    let names = model.coordinate_names();
    let gear = Coupling::new(&model, &[(&names[0], 1.0), (&names[1], 1.0)], 0.0).unwrap();
    let set = ConstraintSet::new(&model, [("gear", gear.into())]).unwrap();
    (model, set)
}

/// Atwood's machine: a = (m₂ − m₁)/(m₁ + m₂) g, and the gear carries −2 m₁m₂/(m₁ + m₂) g. A sled that hits
/// its limit stops both and loses ½(m₁ + m₂)v². The friction of both sleds holds up to its bound. With and
/// without contacts.
#[test]
fn gear_works_with_limits_friction_and_ground() {
    let masses = [1.0, 2.0];
    let total = masses[0] + masses[1];
    for ground in [None, Some(Ground::level(-100.0))] {
        let make = |model: &Model, set: &ConstraintSet| implicit_over(model, ground).constraints(set.clone());
        let a = (masses[1] - masses[0]) / total * G;
        let (model, set) = hoist(masses, PassiveForces::default(), Limits::default());
        let run = run_watched(make(&model, &set), (&[0.0; 2], &[0.0; 2]), (1e-3, 1000), |info| {
            assert!((info.q[0] + info.q[1]).abs() < 1e-12, "{:?}", info.q);
        });
        assert!(
            (run.v[0] - a).abs() < 1e-11 && (run.q[0] - 0.5 * a).abs() < 1e-11,
            "{:?} {:?}",
            run.q,
            run.v
        );
        assert!(
            run.energy_account.max_imbalance() < 1e-10 && run.energy_account.dissipated().abs() < 1e-12,
            "{:?}",
            run.energy_account
        );
        let mut implicit = stepper(make(&model, &set));
        let (mut q, mut v, mut workspace) = ([0.0; 2], [0.0; 2], StepWorkspace::new(&model));
        for _ in 0..3 {
            let none = StepForces::new(&[0.0; 2], true);
            implicit.step(&model, &mut workspace, &none, 1e-3, &mut q, &mut v).unwrap();
            let all: Vec<(&str, f64)> = implicit.constraint_forces();
            let expected = 2.0 * masses[0] * masses[1] / total * G;
            assert_eq!(all.len(), 1);
            // The first step has no force of a previous step, and its row yields by 1e-10.
            assert!(all[0].0 == "gear.sum" && (all[0].1 - expected).abs() < 2e-10 * expected, "{all:?}");
        }

        let (model, set) = hoist(masses, PassiveForces::default(), Limits::new(-1.0, 0.4));
        let run = run_watched(make(&model, &set), (&[0.0; 2], &[0.0; 2]), (1e-3, 1000), |_| {});
        // The last 1e-6 to a limit is approached with a time constant of 0.1 s; five time constants have
        // passed.
        assert!((run.q[0] - 0.4).abs() < 1e-8 && (run.q[0] + run.q[1]).abs() < 1e-12, "{:?}", run.q);
        assert!(run.v.iter().all(|v| v.abs() < 1e-7), "{:?}", run.v);
        let lost = 0.5 * total * 2.0 * a * 0.4;
        // The impact is early or late by a sixteenth of a step.
        let late = total * a * (2.0 * a * 0.4_f64).sqrt() * 1e-3 / 16.0;
        assert!((run.losses.unwrap().stops - lost).abs() < late, "{:?} for {lost}", run.losses);
        assert!(run.energy_account.max_imbalance() < late, "{:?}", run.energy_account);

        // Friction of both sleds against the difference of their weights.
        let difference = (masses[1] - masses[0]) * G;
        let with = |part: f64| {
            let passive = PassiveForces::default().with_friction(0.5 * part * difference);
            let (model, set) = hoist(masses, passive, Limits::default());
            run_watched(make(&model, &set), (&[0.0; 2], &[0.0; 2]), (1e-3, 1000), |_| {})
        };
        let (sticks, slides) = (with(1.001), with(0.5));
        assert!(sticks.q.iter().chain(&sticks.v).all(|x| x.abs() < 1e-12), "{:?} {:?}", sticks.q, sticks.v);
        assert!((slides.v[0] - 0.5 * a).abs() < 1e-11, "{:?}", slides.v);
        let lost = 0.5 * difference * slides.q[0];
        assert!((slides.losses.unwrap().friction - lost).abs() < 1e-9, "{:?} for {lost}", slides.losses);
    }
}

/// A loop of bars falls against the limit of its rocker and comes to rest; damping and limits together
/// dissipate its energy.
#[test]
fn loop_comes_to_rest_at_its_limit() {
    let (free, _, q) = four_bars(0.6);
    let mut robot = free.description().clone();
    robot.joints[2].limits = Limits::new(-3.0, q[2] + 0.3);
    robot.joints[0].passive = PassiveForces::default().with_damping(0.5);
    let model = Model::new(robot).unwrap();
    let [a, b] = ["a", "b"].map(|frame| model.frame(frame).unwrap());
    let set =
        ConstraintSet::new(&model, [("pin", FrameConstraint::between(a, b, &FrameConstraint::BALL).into())])
            .unwrap();
    let mut most = f64::NEG_INFINITY;
    let run = run_watched(held(&model, &set), (&q, &[0.0; 3]), (1e-3, 5000), |info| {
        most = most.max(info.q[2]);
        let drift = constraint_drift(&model, &mut Workspace::new(&model), &set, info.q, info.v);
        assert!(drift.position < 1e-11, "{drift:?}");
    });
    assert!(most < q[2] + 0.3 + 1e-9 && (run.q[2] - most).abs() < 1e-9, "{most} {:?}", run.q);
    assert!(run.v.iter().all(|v| v.abs() < 1e-9), "{:?}", run.v);
    let scale = run.energy_account.scale();
    assert!(
        run.losses.unwrap().stops > 1e-3 && run.energy_account.max_imbalance() < 1e-3 * scale,
        "{:?}",
        run.energy_account
    );
}

/// Two bricks, one hanging from the other or welded to it, dropped on the ground.
fn bricks(fixed: bool) -> RobotDescription {
    let mut robot = RobotDescription::new("bricks");
    let size = [0.3, 0.2, 0.1];
    let brick = MassProperties::solid_box(1000.0, Vector3::from(size)).unwrap();
    if !fixed {
        robot.links.push(LinkDescription::new("world", None));
    }
    let apart = Pose::from_translation([0.0, 0.0, 0.25]);
    for name in ["low", "high"] {
        robot.links.push(LinkDescription::new(name, brick));
        let shape = Shape::Box { size };
        robot.shapes.push(LinkShape::new(name, ShapeRole::Collision, Pose::IDENTITY, shape));
        if !fixed {
            let joint = JointDescription::new(
                format!("free_{name}"),
                JointKind::Floating,
                "world",
                name,
                Pose::IDENTITY,
            );
            robot.joints.push(joint);
        }
    }
    if fixed {
        robot.base = Base::Floating;
        robot.joints.push(JointDescription::new("weld", JointKind::Fixed, "low", "high", apart));
    }
    robot.frames.push(robot_dynamics::description::FrameDescription::new("top", "low", apart));
    robot
}

/// Two bodies welded by an equality fall and land as one body: equal motion and equal ground forces.
#[test]
fn weld_moves_as_one_body() {
    let [one, two] = [true, false].map(|fixed| Model::new(bricks(fixed)).unwrap());
    let [top, high] = ["top", "high"].map(|frame| two.frame(frame).unwrap());
    let set = ConstraintSet::new(
        &two,
        [("weld", FrameConstraint::between(top, high, &FrameConstraint::WELD).into())],
    )
    .unwrap();
    let contacts = |model: &Model| ContactSet::new(model, &[Ground::level(0.0)]).unwrap();
    let (q, v) = ([0.0, 0.0, 0.25, 0.0, 0.0, 0.0, 1.0], [0.5, 0.2, 0.0, 0.3, 1.0, 0.2]);
    let mut both_q = q.to_vec();
    both_q.extend([0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 1.0]);
    let mut both_v = v.to_vec();
    both_v.extend([v[0] + v[4] * 0.25, v[1] - v[3] * 0.25, v[2], v[3], v[4], v[5]]);
    let (h, mut flight, mut ends) = (1e-3, Vec::new(), Vec::new());
    let note = |list: &mut Vec<Vec<f64>>, info: &StepInfo<'_>| list.push(info.q[..7].to_vec());
    let alone = run_watched(implicit_on(&one, contacts(&one)), (&q, &v), (h, 3000), |info| {
        note(&mut flight, info);
    });
    let welded = implicit_on(&two, contacts(&two)).constraints(set.clone());
    let run = run_watched(welded, (&both_q, &both_v), (h, 3000), |info| note(&mut ends, info));
    // In the air, and through the first impact.
    for step in [0, 100, 150] {
        let off = flight[step].iter().zip(&ends[step]).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
        assert!(off < 1e-6, "step {step}: {off}");
    }
    // Both fall over in the same direction and come to rest.
    assert!(run.v.iter().all(|v| v.abs() < 1e-9), "{:?}", run.v);
    let off = alone.q.iter().zip(&run.q).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
    assert!(off < 1e-2, "{off}");
    let drift = constraint_drift(&two, &mut Workspace::new(&two), &set, &run.q, &run.v);
    assert!(drift.position < 1e-9, "{drift:?}");
    let up: f64 = run.contact_forces.iter().map(|force| force[2]).sum();
    let weight = two.mass() * G;
    assert!((up - weight).abs() < 1e-6 * weight, "{up} for {weight}");
    assert!(
        run.energy_account.max_imbalance() < 2e-2 * run.energy_account.scale(),
        "{:?}",
        run.energy_account
    );
}

/// Two bricks connected at a point are thrown on the ground: the alternating direction method solves the
/// problem of each step to the same result.
#[test]
fn alternating_method_agrees_with_equalities() {
    let model = Model::new(bricks(false)).unwrap();
    let [top, high] = ["top", "high"].map(|frame| model.frame(frame).unwrap());
    let set = ConstraintSet::new(
        &model,
        [("pin", FrameConstraint::between(top, high, &FrameConstraint::BALL).into())],
    )
    .unwrap();
    let over = implicit_over(&model, Some(Ground::level(0.0)));
    let mut implicit = stepper(over.constraints(set));
    let mut q = vec![0.0, 0.0, 0.08, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.33, 0.0, 0.0, 0.0, 1.0];
    let mut v = vec![0.5, 0.2, 0.0, 0.0, 0.0, 0.0, 0.5, 0.2, 0.0, 0.3, 0.2, 0.5];
    let (mut workspace, mut compared, mut unsettled) = (StepWorkspace::new(&model), 0, 0);
    let none = vec![0.0; model.nv()];
    for _ in 0..1000 {
        implicit.step(&model, &mut workspace, &StepForces::new(&none, true), 1e-3, &mut q, &mut v).unwrap();
        let Some(problem) = implicit.contact_problem() else { continue };
        let free = problem.laws.iter().filter(|law| {
            matches!(law, robot_dynamics::contact::ContactLaw::Bounds { lower, upper } if lower.is_infinite() && upper.is_infinite())
        });
        assert_eq!(free.count(), 3);
        let other = admm::solve(&problem, &admm::Options::default());
        if !(other.is_settled && problem.is_solved) {
            unsettled += 1;
            continue;
        }
        let off = (&problem.velocity - &other.velocity).amax();
        assert!(off < 1e-7, "{off}");
        compared += 1;
    }
    println!("{compared} problems compared, {unsettled} not settled");
    assert!(compared > 800, "{compared}, {unsettled}");
}

/// The knife edge of the chapter as a row without φ: a planar body whose blade does not slip sideways, on a
/// slope.
#[test]
fn row_without_position_holds_blade() {
    let (m, i_zz, a_g, v0, w, time) = (2.0, 0.5, 3.0, 1.5, 4.0, 1.0);
    let mut robot = RobotDescription::new("skate");
    robot.gravity = [0.0, -a_g, 0.0];
    let body = MassProperties::new(m, Vector3::zeros(), Matrix3::identity() * i_zz).unwrap();
    robot.links.push(LinkDescription::new("world", None));
    robot.links.push(LinkDescription::new("body", body));
    let plane = JointKind::Planar { normal: [0.0, 0.0, 1.0] };
    robot.joints.push(JointDescription::new("plane", plane, "world", "body", Pose::IDENTITY));
    let model = Model::new(robot).unwrap();
    let blade = NoSlip::sideways(model.frame("body").unwrap());
    let set = ConstraintSet::new(&model, [("blade", blade.into())]).unwrap();
    let edge = KnifeEdge { body: PlanarBody { m, i_zz, a_g } };
    let (sin, cos) = f64::sin_cos(w * time);
    let x = v0 * sin / w + a_g / w * (0.5 * time + (2.0 * w * time).sin() / (4.0 * w) - sin / w);
    let y = v0 * (1.0 - cos) / w + a_g / w * (0.5 * sin * sin / w - (1.0 - cos) / w);
    let speed = v0 - a_g / w * (1.0 - cos);
    let off = [(4e-3, 250), (2e-3, 500)].map(|(h, steps)| {
        let (mut q, mut v) = (neutral(&model), vec![v0, 0.0, w]);
        let (mut implicit, mut workspace) = (stepper(held(&model, &set)), StepWorkspace::new(&model));
        for _ in 0..steps {
            let none = StepForces::new(&[0.0; 3], true);
            implicit.step(&model, &mut workspace, &none, h, &mut q, &mut v).unwrap();
        }
        let qd = KnifeEdge::velocity(&vector![x, y, w * time], speed, w);
        let side = edge.side_force(&vector![x, y, w * time], &qd, &vector![0.0, 0.0, 0.0]);
        let (name, force) = implicit.constraint_forces()[0];
        assert_eq!(name, "blade.y");
        println!("h = {h}: way off {:e}, force off {:e}", (q[0] - x).hypot(q[1] - y), force + side);
        // The row is along the body's y axis, the side force against it.
        ((q[0] - x).hypot(q[1] - y), (force + side).abs())
    });
    assert!(off[1].0 < 1e-4 && off[0].0 > 3.5 * off[1].0, "{off:?}");
    // The force of a step is its mean, off by half a step of its rate of about 60 N/s.
    assert!(off[1].1 < 0.1, "{off:?}");
}

/// A coin rolls as in the explicit constrained run.
#[test]
fn coin_rolls_as_in_constrained_run() {
    let mut robot = RobotDescription::new("coin");
    robot.base = Base::Floating;
    let moments = Matrix3::from_diagonal(&Vector3::new(2.5e-3, 5e-3, 2.5e-3));
    robot
        .links
        .push(LinkDescription::new("coin", MassProperties::new(1.0, Vector3::zeros(), moments).unwrap()));
    let model = Model::new(robot).unwrap();
    let disc = RollingDisc::on_floor(model.frame("coin").unwrap(), [0.0, 1.0, 0.0], 0.1);
    let set = ConstraintSet::new(&model, [("roll", disc.into())]).unwrap();
    let mut q = vec![0.0, 0.0, 0.1, 0.15_f64.sin(), 0.0, 0.0, 0.15_f64.cos()];
    let mut v = vec![0.0, 0.0, 0.0, 0.2, 15.0, 1.0];
    let (workspace, options) = (&mut Workspace::new(&model), ConstraintOptions::default());
    project_position(&model, workspace, &set, &options, 1e-13, &mut q).unwrap();
    project_velocity(&model, workspace, &set, &options, &q, &mut v).unwrap();
    let expected = SimulationBuilder::new(&model)
        .method(Method::Fixed(ConstraintOptions::default().integrator))
        .constraints(set.clone())
        .dt(1e-4)
        .constraint_options(ConstraintOptions::default(), DriftCorrection::default())
        .build()
        .unwrap()
        .run_steps_from(&q, &v, 5000, RunOptions::new().sample_ends())
        .unwrap();
    let error = |h: f64, steps: usize| {
        let run = run_watched(held(&model, &set), (&q, &v), (h, steps), |_| {});
        apart(&model, (&expected.q, &expected.v), (&run.q, &run.v))
    };
    let (coarse, fine) = (error(1e-3, 500), error(5e-4, 1000));
    println!("coin: {coarse:e}, {fine:e}");
    assert!(fine < 1e-3 && coarse > 3.5 * fine, "{coarse:e} {fine:e}");
}

/// A loop with duplicate rows, one of them off by a millionth across its plane, moves as with single rows.
#[test]
fn duplicate_rows_are_left_out() {
    let (model, set, q) = four_bars(0.6);
    let (once_model, once_set, start) = (model.clone(), set.clone(), q.clone());
    let once = run_watched(held(&model, &set), (&q, &[0.0; 3]), (1e-3, 500), |_| {});
    let mut robot = model.description().clone();
    // An axis with the error of six decimal digits.
    robot.joints[2].parent_from_joint = Pose::from_xyz_rpy([0.5, 0.0, 0.0], [1e-7, 0.0, 1e-7]);
    let model = Model::new(robot).unwrap();
    let [a, b] = ["a", "b"].map(|frame| model.frame(frame).unwrap());
    let pin = || FrameConstraint::between(a, b, &FrameConstraint::BALL).into();
    let set = ConstraintSet::new(&model, [("pin", pin()), ("again", pin())]).unwrap();
    let twice = run_watched(held(&model, &set), (&q, &[0.0; 3]), (1e-3, 500), |_| {});
    let off = apart(&model, (&once.q, &once.v), (&twice.q, &twice.v));
    assert!(off < 1e-5 && once.v[0].abs() > 0.1, "{off} {:?}", once.v);
    let mut implicit = stepper(held(&model, &set));
    let (mut q, mut v) = (q, vec![0.0; 3]);
    let none = StepForces::new(&[0.0; 3], true);
    implicit.step(&model, &mut StepWorkspace::new(&model), &none, 1e-3, &mut q, &mut v).unwrap();
    // Both duplicates share the load of the single row; the rows across the plane carry none.
    let forces = implicit.constraint_forces();
    let mut alone = stepper(held(&once_model, &once_set));
    let (mut q, mut v) = (start, vec![0.0; 3]);
    alone.step(&once_model, &mut StepWorkspace::new(&once_model), &none, 1e-3, &mut q, &mut v).unwrap();
    let alone = alone.constraint_forces();
    let scale = alone.iter().fold(0.0_f64, |most, (_, force)| most.max(force.abs()));
    for axis in ["x", "y", "z"] {
        let force = |forces: &[(&str, f64)], name: &str| {
            forces.iter().find(|(own, _)| *own == format!("{name}.{axis}")).unwrap().1
        };
        let [pin, again] = ["pin", "again"].map(|name| force(&forces, name));
        let whole = force(&alone, "pin");
        assert!((pin - again).abs() < 1e-12 * scale, "{axis}: {forces:?}");
        assert!((pin + again - whole).abs() < 1e-5 * scale, "{axis}: {forces:?} for {whole}");
    }
    assert_eq!(forces.iter().filter(|(_, force)| *force == 0.0).count(), 2, "{forces:?}");
}

/// A floating box is connected to the world at the four corners of its sole. Each corner carries a quarter of
/// the weight and of the applied force.
#[test]
fn corners_of_sole_share_load() {
    let mut robot = RobotDescription::new("shoe");
    robot.base = Base::Floating;
    let inertia = Matrix3::from_diagonal(&Vector3::new(0.02, 0.03, 0.04));
    let mass = MassProperties::new(6.0, Vector3::new(0.0, 0.0, 0.05), inertia).unwrap();
    robot.links.push(LinkDescription::new("shoe", mass));
    let corners = [[0.1, 0.04], [0.1, -0.04], [-0.1, 0.04], [-0.1, -0.04]];
    let names = ["a", "b", "c", "d"];
    for (name, [x, y]) in names.into_iter().zip(corners) {
        robot.frames.push(robot_dynamics::description::FrameDescription::new(
            name,
            "shoe",
            Pose::from_translation([x, y, 0.0]),
        ));
    }
    let model = Model::new(robot).unwrap();
    let held_at = |(name, [x, y]): (&'static str, [f64; 2])| {
        (name, FrameConstraint::point_contact(model.frame(name).unwrap(), [x, y, 0.0]).into())
    };
    let set = ConstraintSet::new(&model, names.into_iter().zip(corners).map(held_at)).unwrap();
    let mut implicit = stepper(held(&model, &set));
    let (mut q, mut v) = (neutral(&model), vec![0.0; 6]);
    // A force at the centre of mass, with its moment about the origin of the frame.
    let tau = [8.0, -4.0, 0.0, 0.05 * 4.0, 0.05 * 8.0, 0.0];
    for _ in 0..3 {
        let forces = StepForces::new(&tau, true);
        implicit.step(&model, &mut StepWorkspace::new(&model), &forces, 1e-3, &mut q, &mut v).unwrap();
    }
    let forces = implicit.constraint_forces();
    let of = |axis: &str| -> Vec<f64> {
        names.map(|name| forces.iter().find(|(own, _)| *own == format!("{name}.{axis}")).unwrap().1).to_vec()
    };
    // Pairs of corners carry the tipping moments 0.05·8 about y and 0.05·4 about x; along the sole all four
    // share equally. A row yields by 1e-10 of its force.
    let (weight, pitch, roll) = (6.0 * 9.81 / 4.0, 0.4 / 0.4, 0.2 / 0.16);
    for (k, [x, y]) in corners.into_iter().enumerate() {
        let z = weight + pitch * f64::signum(x) - roll * f64::signum(y);
        let expected = [-2.0, 1.0, z];
        for (axis, expected) in ["x", "y", "z"].into_iter().zip(expected) {
            assert!((of(axis)[k] - expected).abs() < 1e-6, "{axis} at {x}, {y}: {forces:?} for {expected}");
        }
    }
}

/// A run rejects a start off the constraint and names the row. A single step accepts it and corrects it over
/// 0.1 s.
#[test]
fn start_off_the_loop_is_an_error() {
    let (model, set, mut q) = four_bars(0.6);
    q[2] += 0.01;
    let failure: Result<Run, _> =
        held(&model, &set).build().unwrap().run_steps_from(&q, &[0.0; 3], 10, RunOptions::new());
    match failure.unwrap_err().error {
        RunError::Step {
            source: StepError::Integrator(IntegratorError::OffConstraint { quantity, name, error }),
            ..
        } => {
            assert!(quantity == "position" && name.starts_with("pin.") && error > 1e-4, "{name} {error}");
        }
        other => panic!("{other:?}"),
    }
    let drift =
        |q: &[f64]| constraint_drift(&model, &mut Workspace::new(&model), &set, q, &[0.0; 3]).position;
    let (start, mut v) = (drift(&q), vec![0.0; 3]);
    let (mut implicit, mut workspace) = (stepper(held(&model, &set)), StepWorkspace::new(&model));
    for _ in 0..100 {
        implicit
            .step(&model, &mut workspace, &StepForces::new(&[0.0; 3], true), 1e-3, &mut q, &mut v)
            .unwrap();
    }
    assert!((drift(&q) / start - (-1.0_f64).exp()).abs() < 1e-6, "{} of {start}", drift(&q));
}

/// A negative tolerance is an error, also without constraints.
#[test]
fn projections_with_a_negative_tolerance_are_errors() {
    let model = Model::new(random_robot(3, &RandomRobotOptions::default())).unwrap();
    let (set, options) = (ConstraintSet::from_equalities(&model).unwrap(), ConstraintOptions::default());
    let mut q = neutral(&model);
    let error =
        project_position(&model, &mut Workspace::new(&model), &set, &options, -1e-9, &mut q).unwrap_err();
    assert!(error.to_string().contains("the tolerance"), "{error}");
}
