//! Spatial tendons: derivatives of lengths, forces from energies, energy accounts, and stiff springs.

use robot_dynamics::constraints::{
    Baumgarte, ConstraintOptions, ConstraintSet, PolynomialCoupling, constrained_forward_dynamics,
};
use robot_dynamics::derivatives::constrained_forward_dynamics_derivatives;
use robot_dynamics::description::{
    FrameDescription, PassiveForces, Pose, RandomRobotOptions, RobotDescription, SpatialTendonDescription,
    TendonPathElement, TendonSurface, random_robot,
};
use robot_dynamics::mjcf::{LoadOptions, parse};
use robot_dynamics::model::{Model, Workspace, integrate, neutral, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::{Actuation, Effect, Integrator, Method, Run, RunOptions, SimulationBuilder};

fn below(random: &mut SplitMix64, count: usize) -> usize {
    usize::try_from(random.next_u64() % count as u64).unwrap()
}

/// A random robot with tendons through points of its links and around spheres and cylinders, over pulleys,
/// with and without points that give the side.
fn with_tendons(seed: u64) -> RobotDescription {
    let mut robot = random_robot(seed, &RandomRobotOptions::default());
    let mut random = SplitMix64::new(seed);
    let links: Vec<String> = robot.links.iter().map(|link| link.name.clone()).collect();
    let pose = |random: &mut SplitMix64, size: f64| {
        let mut three = |size: f64| core::array::from_fn(|_| random.uniform(-size, size));
        Pose::from_xyz_rpy(three(size), three(3.0))
    };
    for number in 0..4 {
        let point = |robot: &mut RobotDescription, random: &mut SplitMix64| {
            let name = format!("point_{number}_{}", robot.frames.len());
            let link = &links[below(random, links.len())];
            let place = pose(random, 0.5);
            robot.frames.push(FrameDescription::new(name.clone(), link.clone(), place));
            name
        };
        let mut path = vec![TendonPathElement::Point { frame: point(&mut robot, &mut random) }];
        for part in 0..3 {
            if number != 0 {
                let surface = [TendonSurface::Sphere, TendonSurface::Cylinder][part % 2];
                let side = (part == 2).then(|| point(&mut robot, &mut random));
                let link = links[below(&mut random, links.len())].clone();
                let link_from_surface = Pose::from_translation([0.1, 0.0, -0.1]);
                let radius = random.uniform(0.1, 0.4);
                path.push(TendonPathElement::Surface { link, link_from_surface, surface, radius, side });
            }
            path.push(TendonPathElement::Point { frame: point(&mut robot, &mut random) });
        }
        path.push(TendonPathElement::Pulley { divisor: 2.5 });
        for _ in 0..2 {
            path.push(TendonPathElement::Point { frame: point(&mut robot, &mut random) });
        }
        let mut tendon = SpatialTendonDescription::new(format!("tendon_{number}"), path);
        tendon.passive = PassiveForces::default().with_spring(15.0, 0.3);
        tendon.higher_terms.stiffness = [2.0, 1.0];
        tendon.dead_band = 0.1;
        robot.spatial_tendons.push(tendon);
    }
    robot
}

/// A tendon through a removed link is removed with its actuator, and both are reported.
#[test]
fn tendons_through_removed_links_are_removed() {
    let mut robot = parse(ARM, &LoadOptions::default()).unwrap().description;
    let notes = robot.remove_joint("elbow").unwrap();
    assert_eq!(
        robot.spatial_tendons.iter().map(|tendon| tendon.name.as_str()).collect::<Vec<_>>(),
        ["around"]
    );
    for name in ["over", "pulley"] {
        assert!(notes.iter().any(|note| note.place == format!("tendon `{name}`")), "{notes:?}");
    }
    assert_eq!(Model::new(robot).unwrap().nv(), 3);
}

/// A difference of order 4 along one degree of freedom.
fn slope(model: &Model, q: &[f64], k: usize, mut of: impl FnMut(&[f64]) -> f64) -> f64 {
    let mut at = |h: f64| {
        let (mut way, mut moved) = (vec![0.0; model.nv()], q.to_vec());
        way[k] = h;
        integrate(model, q, &way, &mut moved);
        of(&moved)
    };
    let h = 1e-4;
    (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h)
}

/// h⁴ is 1e-16, and rounding over h is 1e-12 of the length. A path that begins to touch a surface within the
/// difference has a jump in the second derivative, an error of up to h.
#[test]
fn rows_are_derivatives_of_lengths() {
    let (mut compared, mut rough, mut touching) = (0, 0, 0);
    for seed in 0..12 {
        let robot = with_tendons(seed);
        let model = Model::new(robot.clone()).unwrap();
        let mut straight = robot;
        for tendon in &mut straight.spatial_tendons {
            tendon.path.retain(|element| !matches!(element, TendonPathElement::Surface { .. }));
        }
        let straight = Model::new(straight).unwrap();
        let (actuation, shortest) = (Actuation::new(&model).unwrap(), Actuation::new(&straight).unwrap());
        let (mut memory, mut other) = (actuation.workspace(), shortest.workspace());
        let q = random_state(&model, &mut SplitMix64::new(seed)).q;
        let nv = model.nv();
        let (mut lengths, mut jacobian) = ([0.0; 4], vec![0.0; 4 * nv]);
        let (mut least, mut unused) = ([0.0; 4], vec![0.0; 4 * nv]);
        actuation.tendon_lengths(&model, &mut memory, &q, &mut lengths, &mut jacobian);
        shortest.tendon_lengths(&straight, &mut other, &q, &mut least, &mut unused);
        for tendon in 0..4 {
            assert!(lengths[tendon] >= least[tendon] - 1e-14, "a path around a surface is not shorter");
            touching += usize::from(lengths[tendon] > least[tendon] + 1e-6);
            for k in 0..nv {
                let expected = slope(&model, &q, k, |q| {
                    let (mut lengths, mut unused) = ([0.0; 4], vec![0.0; 4 * nv]);
                    actuation.tendon_lengths(&model, &mut memory, q, &mut lengths, &mut unused);
                    lengths[tendon]
                });
                let error = (jacobian[tendon * nv + k] - expected).abs();
                assert!(error < 1e-3, "robot {seed}, tendon {tendon}, freedom {k}: {error:e}");
                rough += usize::from(error > 1e-9);
                compared += 1;
            }
        }
    }
    assert!(compared > 300 && rough * 50 < compared && touching > 8, "{compared} {rough} {touching}");
}

#[test]
fn forces_are_derivatives_of_stored_energy() {
    for seed in 0..6 {
        let model = Model::new(with_tendons(seed)).unwrap();
        let actuation = Actuation::new(&model).unwrap();
        let mut memory = actuation.workspace();
        let state = random_state(&model, &mut SplitMix64::new(seed + 100));
        let mut tau = vec![0.0; model.nv()];
        actuation.passive_forces(&model, &mut memory, &state.q, &state.v, &mut tau);
        let largest = tau.iter().fold(1.0_f64, |most, tau| most.max(tau.abs()));
        for (k, tau) in tau.iter().enumerate() {
            let expected = -slope(&model, &state.q, k, |q| actuation.stored_energy(&mut memory, q));
            assert!((tau - expected).abs() < 1e-7 * largest, "robot {seed}, freedom {k}: {tau} {expected}");
        }
    }
}

/// Two links with a cable around the pole at the shoulder, one around the drum at the elbow, and one over a
/// pulley.
const ARM: &str = r#"<mujoco><compiler angle="radian"/><worldbody>
  <site name="hook" pos="-0.3 0.05 1.3"/>
  <geom name="pole" type="cylinder" size="0.08 0.2" pos="0 0 1" euler="1.4 0 0"/>
  <body name="upper" pos="0 0 1"><joint name="shoulder" type="ball"/>
    <geom type="capsule" size="0.03" fromto="0 0 0 0.3 0 0"/><site name="middle" pos="0.15 0.02 0.06"/>
    <body name="fore" pos="0.3 0 0"><joint name="elbow" axis="0 1 0"/>
      <geom name="drum" type="sphere" size="0.05"/><geom size="0.05" pos="0.2 0 0"/>
      <site name="end" pos="0.2 0 -0.02"/>
    </body></body></worldbody>
  <tendon>
    <spatial name="around" stiffness="300 50" damping="2"><site site="hook"/><geom geom="pole"/><site site="middle"/></spatial>
    <spatial name="over" stiffness="200" damping="1 0.5"><site site="middle"/><geom geom="drum"/><site site="end"/></spatial>
    <spatial name="pulley" stiffness="100" springlength="0.1 0.3"><site site="hook"/><site site="middle"/><pulley
      divisor="2"/><site site="hook"/><site site="end"/></spatial>
  </tendon></mujoco>"#;

fn run(model: &Model, method: Method, h: f64, steps: usize) -> Run {
    let mut simulation =
        SimulationBuilder::new(model).dt(h).method(method).without(Effect::Contacts).build().unwrap();
    let v: Vec<f64> = (0..model.nv()).map(|k| 2.0 * (k as f64).cos()).collect();
    simulation.run_steps_from(&neutral(model), &v, steps, RunOptions::new().sample_ends()).unwrap()
}

/// Every method takes the springs and dampers into account, and reaches the motion of the others with its
/// order.
#[test]
fn all_methods_reach_one_motion_and_account_for_its_energy() {
    let model = Model::new(parse(ARM, &LoadOptions::default()).unwrap().description).unwrap();
    let exact = run(&model, Method::Fixed(Integrator::RungeKutta4), 1e-4, 5000);
    let distance = |run: &Run| run.q.iter().zip(&exact.q).map(|(a, b)| (a - b).abs()).fold(0.0_f64, f64::max);
    for (method, order) in [(Method::Implicit, 2), (Method::Mujoco, 1)] {
        let [coarse, fine] = [(1e-3, 500), (5e-4, 1000)].map(|(h, steps)| run(&model, method, h, steps));
        let ratio = distance(&coarse) / distance(&fine);
        println!("{method:?}: {:e} {:e}", distance(&coarse), distance(&fine));
        assert!(ratio > 0.9 * f64::from(1 << order), "{method:?}: {ratio}");
        let (account, bound) = (&fine.energy_account, [0.05, 1e-3][order - 1]);
        let imbalance = account.max_imbalance() / account.scale();
        println!("{method:?}: imbalance {imbalance:e}");
        assert!(imbalance < bound, "{method:?}: {imbalance:e}");
    }
    let account = &exact.energy_account;
    assert!(account.max_imbalance() < 1e-8 * account.scale(), "{:e}", account.max_imbalance());
    #[cfg(feature = "adaptive")]
    {
        let adaptive = run(&model, Method::Adaptive, 1e-2, 50);
        assert!(distance(&adaptive) < 1e-6, "{:e}", distance(&adaptive));
    }
}

/// A and Ȧv of relations between lengths are derivatives of φ along a motion with constant v, by differences
/// of order 4 over 4e-4 s.
#[test]
fn rows_of_coupled_lengths_are_derivatives() {
    const H: f64 = 1e-4;
    let mut curved = 0;
    for seed in 0..40 {
        let model = Model::new(with_tendons(seed)).unwrap();
        let coupling = |own: &str, leader: &str| {
            let polynomial = [0.1, -0.8, 0.3, -0.1, 0.05];
            PolynomialCoupling::of_tendons(&model, (own, 0.3), Some((leader, 0.5)), polynomial)
                .unwrap()
                .into()
        };
        let pairs = [("tendon_0", "tendon_1"), ("tendon_2", "tendon_3")];
        let set =
            ConstraintSet::new(&model, pairs.map(|(own, leader)| (own, coupling(own, leader)))).unwrap();
        let state = random_state(&model, &mut SplitMix64::new(seed));
        let mut workspace = Workspace::new(&model);
        let rows = set.rows(&model, &mut workspace, &state.q, &state.v);
        let way = |h: f64| state.v.iter().map(|v| v * h).collect::<Vec<_>>();
        let at = [-2.0, -1.0, 1.0, 2.0].map(|times| {
            let mut q = state.q.clone();
            integrate(&model, &state.q, &way(times * H), &mut q);
            set.rows(&model, &mut workspace, &q, &state.v)
        });
        let speed = 1.0 + state.v.iter().map(|v| v * v).sum::<f64>();
        let rate = |rows: &robot_dynamics::constraints::ConstraintRows, i: usize| {
            rows.matrix.row(i).iter().zip(&state.v).map(|(entry, v)| entry * v).sum::<f64>()
        };
        let slope = |values: [f64; 4]| (values[0] - values[3] + 8.0 * (values[2] - values[1])) / (12.0 * H);
        for i in 0..2 {
            let found = slope(at.each_ref().map(|rows| rows.position_error[i]));
            assert!((found - rate(&rows, i)).abs() < 1e-8 * speed, "robot {seed}, row {i}: {found}");
            let found = slope(at.each_ref().map(|rows| rate(rows, i)));
            let off = (found - rows.bias[i]).abs();
            assert!(off < 1e-7 * speed, "robot {seed}, row {i}: {found} for {}", rows.bias[i]);
            curved += usize::from(rows.bias[i].abs() > 1e-3);
        }
    }
    assert!(curved > 60, "{curved}");
}

/// ∂a and ∂λ with couplings of lengths are limits of differences of order 4, also where paths touch surfaces
/// from outside and from inside. A path that begins to touch within the difference has a jump there, and a Λ
/// that is nearly singular makes the fifth derivative large: few entries may differ.
#[test]
fn derivatives_with_coupled_lengths_are_limits_of_differences() {
    let (mut compared, mut rough, mut curved) = (0, 0, 0);
    for seed in 0..12 {
        let model = Model::new(with_tendons(seed)).unwrap();
        let coupling = |own: &str, leader: &str| {
            let polynomial = [0.1, -0.8, 0.3, -0.1, 0.05];
            PolynomialCoupling::of_tendons(&model, (own, 0.3), Some((leader, 0.5)), polynomial)
                .unwrap()
                .into()
        };
        let pairs = [("tendon_0", "tendon_1"), ("tendon_2", "tendon_3")];
        let set =
            ConstraintSet::new(&model, pairs.map(|(own, leader)| (own, coupling(own, leader)))).unwrap();
        let state = random_state(&model, &mut SplitMix64::new(seed));
        let (w, nv) = (&mut Workspace::new(&model), model.nv());
        let stabilization = Some(Baumgarte { rate: 2.0 });
        let options = ConstraintOptions { stabilization, ..ConstraintOptions::default() };
        let (q, v, tau) = (&state.q, &state.v, &state.tau);
        let Ok(by) = constrained_forward_dynamics_derivatives(&model, w, &set, &options, q, v, tau) else {
            continue;
        };
        let mut check = |expected: f64, found: f64, scale: f64| {
            compared += 1;
            rough += usize::from((expected - found).abs() > 1e-6 * (1.0 + scale));
        };
        for k in 0..nv {
            let mut motion = |q: &[f64], v: &[f64], i: usize| {
                let motion = constrained_forward_dynamics(&model, w, &set, &options, q, v, tau).unwrap();
                if i < nv { motion.acceleration[i] } else { motion.multipliers[i - nv] }
            };
            for i in 0..nv + set.len() {
                let (by_q, by_v, row) = if i < nv {
                    (&by.acceleration_by_position, &by.acceleration_by_velocity, i)
                } else {
                    (&by.multipliers_by_position, &by.multipliers_by_velocity, i - nv)
                };
                let expected = slope(&model, q, k, |q| motion(q, v, i));
                check(expected, by_q[(row, k)], by_q.amax());
                let mut at = |h: f64| {
                    let mut v = v.clone();
                    v[k] += h;
                    motion(q, &v, i)
                };
                let expected = at(0.5) - at(-0.5); // exact, as a and λ are quadratic in v
                check(expected, by_v[(row, k)], by_v.amax());
            }
        }
        curved += usize::from(by.multipliers_by_position.amax() > 1e-3);
    }
    println!("{compared} {rough} {curved}");
    assert!(compared > 3000 && rough * 50 < compared && curved > 8, "{compared} {rough} {curved}");
}
