//! The equation of motion keeps its accuracy when a robot slides far away.

use nalgebra::Matrix3;
use robot_dynamics::algorithms::{
    ReferenceFrame, bias, center_of_mass_jacobian, christoffel_symbols, coriolis_matrix, forward_dynamics,
    forward_dynamics_by_cholesky, frame_bias_acceleration, frame_jacobian, frame_velocity, inverse_dynamics,
    joint_torque_regressor, kinetic_energy_gradient, kinetic_energy_regressor, mass_matrix, mass_matrix_rate,
    momentum, velocity_product,
};
use robot_dynamics::control::inertial_parameter_names;
use robot_dynamics::derivatives::{
    ForwardDynamicsDerivativesMut, FrameAccelerationDerivativesMut, FrameAccelerationInputs,
    InverseDynamicsDerivativesMut, center_of_mass_velocity_derivative, forward_dynamics_derivatives,
    frame_acceleration_derivatives, frame_velocity_derivative, gravity_derivative,
    inverse_dynamics_derivatives,
};
use robot_dynamics::description::{
    Base, JointDescription, JointKind, Limits, LinkDescription, MassProperties, Pose, RandomRobotOptions,
    RobotDescription, random_robot,
};
use robot_dynamics::model::{InstructionSet, Model, Workspace, random_state};
use robot_dynamics::number::{Dual, SplitMix64};

/// The distances of the slides \[m\].
const FAR: f64 = 1e6;

fn link(name: &str, mass: f64, center: [f64; 3]) -> LinkDescription {
    let inertia = Matrix3::new(0.05, 0.01, 0.0, 0.01, 0.08, -0.01, 0.0, -0.01, 0.06) * mass;
    let properties = MassProperties::new(mass, center.into(), inertia).unwrap();
    LinkDescription::new(name, properties)
}

/// A robot from its joints: kind, parent (0 is the root), origin. Link k + 1 is the child of joint k.
fn robot(name: &str, base: Base, joints: &[(JointKind, usize, [f64; 3])]) -> Model {
    let mut robot = RobotDescription::new(name);
    robot.base = base;
    robot.links.push(match base {
        Base::Fixed => LinkDescription::new("link 0", None),
        Base::Floating => link("link 0", 3.0, [0.1, 0.0, 0.2]),
    });
    for (k, (kind, parent, at)) in joints.iter().enumerate() {
        let (own, mass) = (format!("link {}", k + 1), 0.2 + 3.0 / (k + 1) as f64);
        robot.links.push(link(&own, mass, [0.3, 0.1 - 0.05 * k as f64, 0.05]));
        let pose = Pose::from_xyz_rpy(*at, [0.2, -0.1 * k as f64, 0.3]);
        let joint =
            JointDescription::new(format!("joint {}", k + 1), *kind, format!("link {parent}"), &own, pose);
        robot.joints.push(joint);
    }
    Model::new(robot).unwrap()
}

const X: JointKind = JointKind::Prismatic { axis: [1.0, 0.0, 0.0] };
const Y: JointKind = JointKind::Prismatic { axis: [0.0, 1.0, 0.0] };
const Z: JointKind = JointKind::Prismatic { axis: [0.0, 0.0, 1.0] };
const TURN: JointKind = JointKind::Revolute { axis: [0.0, 0.0, 1.0] };
const BEND: JointKind = JointKind::Revolute { axis: [0.0, 1.0, 0.3] };

/// Robots that slide as a whole, with the entries of q on which the equation of motion does not depend.
fn sliding_robots() -> Vec<(Model, Vec<usize>)> {
    let at = [0.2, 0.1, -0.1];
    let cart = robot("cart on cart", Base::Fixed, &[(X, 0, at), (Y, 1, at), (TURN, 2, at), (BEND, 3, at)]);
    let planar = JointKind::Planar { normal: [0.0, 0.0, 1.0] };
    let planar = robot("planar base", Base::Fixed, &[(planar, 0, at), (BEND, 1, at), (TURN, 2, at)]);
    let gantry = [(X, 0, at), (Y, 1, at), (Z, 2, at), (BEND, 3, at), (TURN, 4, at)];
    let gantry = robot("gantry", Base::Fixed, &gantry);
    let twins = [(X, 0, at), (Y, 1, at), (BEND, 2, at), (TURN, 3, at), (Y, 1, at), (TURN, 5, at), (Z, 6, at)];
    let twins = robot("two arms on a bridge", Base::Fixed, &twins);
    let floating = robot(
        "floating base",
        Base::Floating,
        &[(BEND, 0, at), (TURN, 1, at), (JointKind::Spherical, 0, at)],
    );
    let free = [(JointKind::Floating, 0, at), (BEND, 1, at), (X, 0, at), (TURN, 3, at), (BEND, 4, at)];
    let free = robot("a free body beside a cart", Base::Fixed, &free);
    let slides = |model: Model, slides: &[usize]| (model, slides.to_vec());
    vec![
        slides(cart, &[0, 1]),
        slides(planar, &[0, 1]),
        slides(gantry, &[0, 1, 2]),
        slides(twins, &[0, 1, 4]),
        slides(floating, &[0, 1, 2]),
        slides(free, &[0, 1, 2, 8]),
    ]
}

/// A quantity with the size of the units of its rows and columns.
struct Quantity {
    name: &'static str,
    entries: Vec<f64>,
    /// In units of √M_ii, by which rows and columns enter the power.
    powers: [i32; 2],
}

/// All quantities that do not depend on the position of the robot.
#[allow(clippy::too_many_lines)] // a list
fn quantities(
    model: &Model,
    workspace: &mut Workspace,
    q: &[f64],
    [v, a, tau]: [&[f64]; 3],
) -> Vec<Quantity> {
    let n = model.nv();
    let mut all = Vec::new();
    let mut add = |name, powers, entries: Vec<f64>| all.push(Quantity { name, entries, powers });
    let mut square = vec![0.0; n * n];
    mass_matrix(model, workspace, q, &mut square);
    add("M", [1, 1], square.clone());
    coriolis_matrix(model, workspace, q, v, &mut square);
    add("C", [1, 1], square.clone());
    gravity_derivative(model, workspace, q, &mut square);
    add("∂g/∂q", [1, 1], square.clone());
    let mut symbols = vec![0.0; n * n * n];
    christoffel_symbols(model, workspace, q, &mut symbols);
    for slice in symbols.chunks(n * n) {
        add("Γ", [1, 1], slice.to_vec());
    }
    let mut vector = vec![0.0; n];
    bias(model, workspace, q, v, &mut vector);
    add("bias", [1, 0], vector.clone());
    momentum(model, workspace, q, v, &mut vector);
    add("p", [1, 0], vector.clone());
    kinetic_energy_gradient(model, workspace, q, v, &mut vector);
    add("∂K/∂q", [1, 0], vector.clone());
    forward_dynamics(model, workspace, q, v, tau, &mut vector);
    add("forward dynamics", [-1, 0], vector.clone());
    forward_dynamics_by_cholesky(model, workspace, q, v, tau, &mut vector);
    add("forward dynamics by Cholesky", [-1, 0], vector);
    let [mut by_q, mut by_v, mut by_tau] = [(); 3].map(|()| vec![0.0; n * n]);
    let out = InverseDynamicsDerivativesMut { by_position: &mut by_q, by_velocity: &mut by_v };
    inverse_dynamics_derivatives(model, workspace, q, v, a, out);
    add("∂τ/∂q", [1, 1], by_q.clone());
    add("∂τ/∂v", [1, 1], by_v.clone());
    let out = ForwardDynamicsDerivativesMut {
        by_position: &mut by_q,
        by_velocity: &mut by_v,
        by_force: &mut by_tau,
    };
    forward_dynamics_derivatives(model, workspace, q, v, tau, out);
    add("∂a/∂q", [-1, 1], by_q);
    add("∂a/∂v", [-1, 1], by_v);
    add("∂a/∂τ", [-1, -1], by_tau);
    let parameters = inertial_parameter_names(model).len();
    let mut regressor = vec![0.0; n * parameters];
    joint_torque_regressor(model, workspace, q, v, a, &mut regressor);
    add("regressor", [1, 0], regressor);
    let mut regressor = vec![0.0; parameters];
    kinetic_energy_regressor(model, workspace, q, v, &mut regressor);
    add("regressor of K", [0, 0], regressor);
    let mut three = vec![0.0; 3 * n];
    center_of_mass_jacobian(model, workspace, q, &mut three);
    add("J of the centre of mass", [0, 1], three.clone());
    center_of_mass_velocity_derivative(model, workspace, q, v, &mut three);
    add("∂ċ/∂q", [0, 1], three);
    for frame in model.frames().iter().filter(|frame| frame.name != "link 0") {
        let frame = model.frame(&frame.name).unwrap();
        let (mut six, mut other) = (vec![0.0; 6 * n], vec![0.0; 6 * n]);
        frame_jacobian(model, workspace, q, frame, ReferenceFrame::LocalWorldAligned, &mut six);
        add("J world aligned", [0, 0], six.clone());
        frame_jacobian(model, workspace, q, frame, ReferenceFrame::Local, &mut six);
        add("J in frame", [0, 0], six.clone());
        let twist = frame_velocity(model, workspace, q, v, frame, ReferenceFrame::Local);
        add("velocity", [0, 0], [twist.linear, twist.angular].concat());
        let twist = frame_bias_acceleration(model, workspace, q, v, frame, ReferenceFrame::Local);
        add("spatial acceleration", [0, 0], [twist.linear, twist.angular].concat());
        let twist = frame_bias_acceleration(model, workspace, q, v, frame, ReferenceFrame::LocalWorldAligned);
        add("acceleration", [0, 0], [twist.linear, twist.angular].concat());
        frame_velocity_derivative(model, workspace, q, v, frame, ReferenceFrame::LocalWorldAligned, &mut six);
        add("∂velocity/∂q", [0, 0], six.clone());
        frame_acceleration_derivatives(
            model,
            workspace,
            FrameAccelerationInputs { q, v, a, frame, reference_frame: ReferenceFrame::Local },
            FrameAccelerationDerivativesMut { by_position: &mut six, by_velocity: &mut other },
        );
        add("∂acceleration/∂q", [0, 0], six);
        add("∂acceleration/∂v", [0, 0], other);
    }
    all
}

/// With limits that exclude long slides, one reference point is used for a whole tree; without limits each
/// slide has its own. Both give the same equation: on random trees with every kind of joint and mimic joints,
/// every quantity agrees.
///
/// Masses and lengths differ by 1e3 within a robot: 1e-10 of the largest entry.
#[test]
fn reference_points_do_not_change_results() {
    let mut compared = 0;
    for seed in 0..60 {
        let base = if seed % 2 == 0 { Base::Floating } else { Base::Fixed };
        let mimic = if seed % 3 == 0 { 0.3 } else { 0.0 };
        let options = RandomRobotOptions { base, mimic, massless: 0.0, ..Default::default() };
        let limited = random_robot(seed, &options);
        let mut free = limited.clone();
        free.joints.iter_mut().for_each(|joint| joint.limits = Limits::default());
        let slides = |kind| matches!(kind, JointKind::Prismatic { .. } | JointKind::Helical { .. });
        compared += u32::from(free.joints.iter().any(|joint| slides(joint.kind)));
        let [limited, free] = [limited, free].map(|robot| Model::new(robot).unwrap());
        let state = random_state(&limited, &mut SplitMix64::new(seed));
        let vectors = [&state.v[..], &state.a, &state.tau];
        let units = units(&limited, &state.q);
        let expected = quantities(&limited, &mut Workspace::new(&limited), &state.q, vectors);
        for mut workspace in [Workspace::new(&free), Workspace::limited(&free, InstructionSet::Portable)] {
            let found = quantities(&free, &mut workspace, &state.q, vectors);
            for (expected, found) in expected.iter().zip(&found) {
                let off = difference(expected, found, &units);
                assert!(off < 1e-10, "robot {seed}, {}: {off:e}", expected.name);
            }
        }
    }
    assert!(compared > 20, "only {compared} robots slide");
}

/// √M_ii.
fn units(model: &Model, q: &[f64]) -> Vec<f64> {
    let n = model.nv();
    let mut mass = vec![0.0; n * n];
    mass_matrix(model, &mut Workspace::new(model), q, &mut mass);
    mass.iter().step_by(n + 1).map(|m| m.sqrt()).collect()
}

/// The largest difference of two quantities over the largest entry, entries in units of √M_ii.
fn difference(one: &Quantity, other: &Quantity, units: &[f64]) -> f64 {
    let columns = if one.powers[1] == 0 { one.entries.len() / units.len() } else { units.len() };
    let unit = |k: usize| {
        let row = units.get(k / columns.max(1)).map_or(1.0, |unit| unit.powi(one.powers[0]));
        let column = units.get(k % columns.max(1)).map_or(1.0, |unit| unit.powi(one.powers[1]));
        row * column
    };
    let largest = |entry: &dyn Fn(usize) -> f64| {
        (0..one.entries.len())
            .map(|k| (entry(k) / unit(k)).abs())
            .fold(0.0, |most: f64, x| if x.is_nan() { f64::NAN } else { most.max(x) })
    };
    let size = largest(&|k| one.entries[k]);
    let off = largest(&|k| one.entries[k] - other.entries[k]);
    if off == 0.0 { 0.0 } else { off / size }
}

/// The equation of motion does not depend on the position of the robot. 10⁶ m away every entry is the same to
/// 1e-12 of √(M_ii M_jj). The same holds for its derivatives and for the quantities of frames, on every
/// route.
#[test]
fn results_are_exact_far_from_origin() {
    for (model, slides) in sliding_robots() {
        let state = random_state(&model, &mut SplitMix64::new(7));
        let (mut near, mut far) = (state.q.clone(), state.q.clone());
        for (k, &slide) in slides.iter().enumerate() {
            near[slide] = 0.0;
            far[slide] = FAR * (1.0 - 0.377_123 * k as f64);
        }
        let vectors = [&state.v[..], &state.a, &state.tau];
        let units = units(&model, &near);
        for mut workspace in [Workspace::new(&model), Workspace::limited(&model, InstructionSet::Portable)] {
            let expected = quantities(&model, &mut workspace, &near, vectors);
            let found = quantities(&model, &mut workspace, &far, vectors);
            for (expected, found) in expected.iter().zip(&found) {
                let off = difference(expected, found, &units);
                println!("{:26} {:30} {off:e}", model.name(), expected.name);
                assert!(off < 1e-12, "{}, {}: {off:e}", model.name(), expected.name);
            }
        }
    }
}

/// Robots with long slides behind joints that turn, and the entry of q that is far away, with its value.
fn turning_robots() -> Vec<(Model, Vec<usize>)> {
    let at = [0.2, 0.1, -0.1];
    let turret = [(TURN, 0, at), (X, 1, at), (BEND, 2, at), (TURN, 3, at), (BEND, 1, at), (TURN, 5, at)];
    let turret = robot("turret with a boom and an arm", Base::Fixed, &turret);
    let twice = [(BEND, 0, at), (Y, 1, at), (TURN, 2, at), (X, 3, at), (Z, 4, at), (BEND, 5, at)];
    let twice = robot("boom on boom", Base::Fixed, &twice);
    let planar = JointKind::Planar { normal: [0.0, 0.6, 0.8] };
    let planar = [(X, 0, at), (TURN, 1, at), (planar, 2, at), (BEND, 3, at), (Y, 2, at), (BEND, 5, at)];
    let planar = robot("a plane on a turning cart", Base::Fixed, &planar);
    let screw = JointKind::Helical { axis: [1.0, 0.0, 0.2], pitch: 1e5 };
    let screws = [(screw, 0, at), (BEND, 1, at), (screw, 2, at), (TURN, 3, at), (BEND, 4, at)];
    let screws = robot("coarse screws", Base::Fixed, &screws);
    let slides = |model: Model, slides: &[usize]| (model, slides.to_vec());
    vec![slides(turret, &[1]), slides(twice, &[1, 3, 4]), slides(planar, &[0, 2, 3, 6]), slides(screws, &[])]
}

/// Behind joints that turn the inertia depends on the slide. The Newton–Euler recursion, which passes forces
/// from body to body, is the reference. Each identity holds to 1e-12 of its terms, in units of √M_ii.
#[test]
fn long_slides_within_tree_keep_accuracy() {
    for (model, slides) in turning_robots() {
        let model = {
            let mut robot = model.description().clone();
            robot.gravity = [0.0; 3];
            Model::new(robot).unwrap()
        };
        let n = model.nv();
        let mut state = random_state(&model, &mut SplitMix64::new(11));
        for (k, &slide) in slides.iter().enumerate() {
            state.q[slide] = FAR * (1.0 - 0.377_123 * k as f64);
        }
        let (q, v, a) = (&state.q, &state.v, &state.a);
        let units = units(&model, q);
        // Velocities and accelerations with equal shares of the energy.
        let in_units = |x: &[f64]| -> Vec<f64> { x.iter().zip(&units).map(|(x, unit)| x / unit).collect() };
        let (v, a) = (in_units(v), in_units(a));
        let forces = |x: &[f64]| -> Vec<f64> { x.iter().zip(&units).map(|(x, unit)| x * unit).collect() };
        let tau = forces(&state.tau);
        for mut workspace in [Workspace::new(&model), Workspace::limited(&model, InstructionSet::Portable)] {
            let workspace = &mut workspace;
            let check = |what: &str, left: &[f64], right: &[f64], powers: [i32; 2]| {
                let (one, other) = (left.to_vec(), right.to_vec());
                let [one, other] = [one, other].map(|entries| Quantity { name: "", entries, powers });
                let off = difference(&one, &other, &units);
                println!("{:32} {what:20} {off:e}", model.name());
                assert!(off < 1e-12, "{}: {what} is off by {off:e}", model.name());
            };
            let mut mass = vec![0.0; n * n];
            mass_matrix(&model, workspace, q, &mut mass);
            let mut columns = vec![0.0; n * n];
            for j in 0..n {
                let (mut unit, mut column) = (vec![0.0; n], vec![0.0; n]);
                unit[j] = 1.0;
                inverse_dynamics(&model, workspace, q, &vec![0.0; n], &unit, &mut column);
                (0..n).for_each(|i| columns[i * n + j] = column[i]);
            }
            check("M", &mass, &columns, [1, 1]);
            let product = |matrix: &[f64], x: &[f64]| -> Vec<f64> {
                matrix.chunks(n).map(|row| row.iter().zip(x).map(|(m, x)| m * x).sum()).collect()
            };
            let (mut c, mut found) = (vec![0.0; n * n], vec![0.0; n]);
            momentum(&model, workspace, q, &v, &mut found);
            check("p = M v", &product(&mass, &v), &found, [1, 0]);
            coriolis_matrix(&model, workspace, q, &v, &mut c);
            velocity_product(&model, workspace, q, &v, &mut found);
            check("C v", &product(&c, &v), &found, [1, 0]);
            let mut rate = vec![0.0; n * n];
            mass_matrix_rate(&model, &mut Workspace::new(&model), q, &v, &mut rate);
            let sum: Vec<f64> = (0..n * n).map(|k| c[k] + c[k % n * n + k / n]).collect();
            check("Ṁ", &sum, &rate, [1, 1]);
            let mut symbols = vec![0.0; n * n * n];
            christoffel_symbols(&model, workspace, q, &mut symbols);
            let sum: Vec<f64> =
                symbols.chunks(n).map(|row| row.iter().zip(&v).map(|(s, v)| s * v).sum()).collect();
            check("Γ v", &c, &sum, [1, 1]);
            let mut acceleration = vec![0.0; n];
            forward_dynamics(&model, workspace, q, &v, &tau, &mut acceleration);
            inverse_dynamics(&model, workspace, q, &v, &acceleration, &mut found);
            check("forward dynamics", &tau, &found, [1, 0]);
            let [mut by_q, mut by_v] = [(); 2].map(|()| vec![0.0; n * n]);
            let out = InverseDynamicsDerivativesMut { by_position: &mut by_q, by_velocity: &mut by_v };
            inverse_dynamics_derivatives(&model, workspace, q, &v, &a, out);
            let (dual_q, dual_v) = dual_derivatives(&model, q, &v, &a);
            check("∂τ/∂q", &by_q, &dual_q, [1, 1]);
            check("∂τ/∂v", &by_v, &dual_v, [1, 1]);
            let [mut a_by_q, mut a_by_v, mut a_by_tau] = [(); 3].map(|()| vec![0.0; n * n]);
            let out = ForwardDynamicsDerivativesMut {
                by_position: &mut a_by_q,
                by_velocity: &mut a_by_v,
                by_force: &mut a_by_tau,
            };
            forward_dynamics_derivatives(&model, workspace, q, &v, &tau, out);
            // M ∂a/∂x = −∂τ/∂x at the acceleration.
            inverse_dynamics_derivatives(
                &model,
                workspace,
                q,
                &v,
                &acceleration,
                InverseDynamicsDerivativesMut { by_position: &mut by_q, by_velocity: &mut by_v },
            );
            let times = |matrix: &[f64]| -> Vec<f64> {
                let entry =
                    |i: usize, j: usize| -> f64 { (0..n).map(|k| mass[i * n + k] * matrix[k * n + j]).sum() };
                (0..n * n).map(|k| entry(k / n, k % n)).collect()
            };
            let minus = |x: &[f64]| -> Vec<f64> { x.iter().map(|x| -x).collect() };
            check("∂a/∂q", &times(&a_by_q), &minus(&by_q), [1, 1]);
            check("∂a/∂v", &times(&a_by_v), &minus(&by_v), [1, 1]);
            let one: Vec<f64> = (0..n * n).map(|k| f64::from(u8::from(k % (n + 1) == 0))).collect();
            check("M M⁻¹", &times(&a_by_tau), &one, [1, -1]);
            for frame in model.frames() {
                let frame = model.frame(&frame.name).unwrap();
                let mut jacobian = vec![0.0; 6 * n];
                frame_jacobian(&model, workspace, q, frame, ReferenceFrame::Local, &mut jacobian);
                let twist = frame_velocity(&model, workspace, q, &v, frame, ReferenceFrame::Local);
                let found = [twist.linear, twist.angular].concat();
                // A lever is accurate to the rounding of the size of the links, 1 m, or of itself.
                for part in [0..3, 3..6] {
                    let product = product(&jacobian[part.start * n..part.end * n], &v);
                    let jacobian = jacobian[part.start * n..part.end * n].chunks(n);
                    let size = jacobian
                        .flat_map(|row| row.iter().zip(&v))
                        .map(|(j, v)| (j.abs().max(1.0) * v).abs());
                    let size = size.fold(0.0, f64::max);
                    let off = product.iter().zip(&found[part]).map(|(a, b)| (a - b).abs());
                    let off = off.fold(0.0, f64::max);
                    assert!(off <= 1e-12 * size, "{}: J v is off by {off:e} of {size:e}", model.name());
                }
            }
        }
    }
}

/// ∂τ/∂q and ∂τ/∂v of the Newton–Euler recursion over dual numbers, for q without quaternions.
fn dual_derivatives(model: &Model, q: &[f64], v: &[f64], a: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let n = model.nv();
    let mut workspace = Workspace::<Dual<f64, 1>>::new(model);
    let constant = |x: &[f64]| -> Vec<Dual<f64, 1>> { x.iter().map(|&x| Dual::constant(x)).collect() };
    let (mut by_q, mut by_v) = (vec![0.0; n * n], vec![0.0; n * n]);
    for j in 0..n {
        for (matrix, by_position) in [(&mut by_q, true), (&mut by_v, false)] {
            let (mut q, mut v) = (constant(q), constant(v));
            if by_position { &mut q[j] } else { &mut v[j] }.gradient = [1.0];
            let mut tau = constant(&vec![0.0; n]);
            inverse_dynamics(model, &mut workspace, &q, &v, &constant(a), &mut tau);
            (0..n).for_each(|i| matrix[i * n + j] = tau[i].gradient[0]);
        }
    }
    (by_q, by_v)
}
