//! The recursions against the Lagrange recipe and against each other, on hundreds of random robots.
//!
//! Tolerances: identities without an inverse sum terms along paths of at most 60 joints. 1e-13 of the largest
//! term allows 450 roundings, and the worst robot stays below a tenth of it. Where M is inverted, the
//! tolerance is κ(M) ε times a modest count.

use robot_dynamics::algorithms::{FrameWrench, ReferenceFrame};
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::number::{Dual, Scalar, SplitMix64};
use robot_dynamics::verification::lagrange;

use crate::common::{Family, Robot, dot, families, max_difference, size, times};

const ROUNDING: f64 = 1e-13;

/// M, K and V of the recursions match the Lagrange recipe, and ½ vᵀM v = K.
#[test]
fn energies_match_lagrange() {
    for robot in families().iter().flat_map(Family::robots) {
        let Robot { model, state, .. } = &robot;
        let (q, v) = (&state.q[..], &state.v[..]);
        let w = &mut Workspace::new(model);
        let (mass, oracle) = (robot.mass(), lagrange::mass_matrix(model, q));
        robot.require("M = Σ m J_cᵀJ_c + J_ωᵀ𝓘J_ω", max_difference(&mass, &oracle), ROUNDING * size(&oracle));

        let kinetic = lagrange::kinetic_energy(model, q, v);
        let scale = size(&oracle) * dot(v, v);
        let defect = (robot_dynamics::algorithms::kinetic_energy(model, w, q, v) - kinetic).abs();
        robot.require("K", defect, ROUNDING * scale);
        robot.require("K = ½ vᵀM v", (0.5 * dot(v, &times(&mass, v)) - kinetic).abs(), ROUNDING * scale);

        let potential = lagrange::potential_energy(model, q);
        let defect = (robot_dynamics::algorithms::potential_energy(model, w, q) - potential).abs();
        // V is a sum of terms of either sign; m |g| |c| with |c| of a few metres bounds it.
        let scale = potential.abs() + model.mass() * 9.81;
        robot.require("V", defect, ROUNDING * scale);
    }
}

/// C v, g, C v + g and τ of the recursions match exact derivatives of the energies.
#[test]
fn forces_match_lagrange() {
    for robot in families().iter().flat_map(Family::robots) {
        let Robot { model, state, .. } = &robot;
        let (q, v, a) = (&state.q[..], &state.v[..], &state.a[..]);
        let w = &mut Workspace::new(model);
        let mut found = vec![0.0; model.nv()];

        let product = lagrange::velocity_product(model, q, v);
        // Each term of C v is an inertia times two velocities.
        let product_scale = size(&robot.mass()) * dot(v, v);
        robot_dynamics::algorithms::velocity_product(model, w, q, v, &mut found);
        robot.require("C v", max_difference(&found, &product), ROUNDING * product_scale);

        let gravity = lagrange::gravity(model, q);
        // A force of m |g| on an arm of a metre.
        let gravity_scale = size(&gravity) + model.mass() * 9.81;
        robot_dynamics::algorithms::gravity(model, w, q, &mut found);
        robot.require("g = ∂V/∂q", max_difference(&found, &gravity), ROUNDING * gravity_scale);

        let scale = product_scale + gravity_scale;
        let bias = lagrange::bias(model, q, v);
        robot_dynamics::algorithms::bias(model, w, q, v, &mut found);
        robot.require("C v + g", max_difference(&found, &bias), ROUNDING * scale);

        let tau = lagrange::inverse_dynamics(model, q, v, a);
        robot_dynamics::algorithms::inverse_dynamics(model, w, q, v, a, &mut found);
        let scale = scale + size(&robot.mass()) * dot(a, a).sqrt();
        robot.require("τ", max_difference(&found, &tau), ROUNDING * scale);
    }
}

/// Column j of M is the force for the acceleration eⱼ at rest without gravity.
#[test]
fn columns_of_inverse_dynamics_are_mass_matrix() {
    for robot in families().iter().flat_map(Family::robots) {
        let Robot { model, state, .. } = &robot;
        let nv = model.nv();
        let (mass, w, zero) = (robot.mass(), &mut Workspace::new(model), vec![0.0; nv]);
        let mut at_rest = vec![0.0; nv];
        robot_dynamics::algorithms::inverse_dynamics(model, w, &state.q, &zero, &zero, &mut at_rest);
        let scale = size(&mass) + size(&at_rest);
        for j in 0..nv {
            let mut unit = zero.clone();
            unit[j] = 1.0;
            let mut column = zero.clone();
            robot_dynamics::algorithms::inverse_dynamics(model, w, &state.q, &zero, &unit, &mut column);
            let defect =
                (0..nv).map(|i| (column[i] - at_rest[i] - mass[i * nv + j]).abs()).fold(0.0, f64::max);
            robot.require("inverse dynamics of eⱼ = M eⱼ", defect, ROUNDING * scale);
            for i in 0..j {
                robot.require("M = Mᵀ", (mass[i * nv + j] - mass[j * nv + i]).abs(), 0.0);
            }
        }
    }
}

/// The acceleration that solves M a = f, and its possible rounding error. An error δ in f or in M a changes a
/// by M⁻¹δ, at most κ(M) δ/‖M‖. 64 ε for each, as a tree is at most a few tens of joints deep.
fn acceleration_error(robot: &Robot, force_size: f64, a: &[f64]) -> f64 {
    64.0 * f64::EPSILON * robot.condition() * (force_size / size(&robot.mass()) + dot(a, a).sqrt())
}

/// Articulated bodies, Cholesky and the Lagrange recipe agree, and inverse ∘ forward is the identity.
#[test]
fn forward_dynamics_agree() {
    for robot in families().iter().flat_map(Family::robots) {
        let Robot { model, state, .. } = &robot;
        let (q, v, tau) = (&state.q[..], &state.v[..], &state.tau[..]);
        let (nv, w) = (model.nv(), &mut Workspace::new(model));
        let oracle = lagrange::forward_dynamics(model, q, v, tau);
        let force_size = dot(tau, tau).sqrt()
            + size(&lagrange::gravity(model, q))
            + model.mass() * 9.81
            + size(&robot.mass()) * dot(v, v);
        let allowed = acceleration_error(&robot, force_size, &oracle);

        let mut a = vec![0.0; nv];
        robot_dynamics::algorithms::forward_dynamics_by_cholesky(model, w, q, v, tau, &mut a);
        robot.require("Cholesky = Lagrange", max_difference(&a, &oracle), allowed);
        robot_dynamics::algorithms::forward_dynamics(model, w, q, v, tau, &mut a);
        robot.require("articulated bodies = Lagrange", max_difference(&a, &oracle), allowed);

        let mut back = vec![0.0; nv];
        robot_dynamics::algorithms::inverse_dynamics(model, w, q, v, &a, &mut back);
        let allowed = allowed * size(&robot.mass());
        robot.require("inverse ∘ forward", max_difference(&back, tau), allowed);
    }
}

/// A random wrench on every frame, and Σ Jᵀw with the Jacobians of the reference.
fn wrenches(robot: &Robot) -> (Vec<FrameWrench>, Vec<f64>) {
    let Robot { model, state, seed, .. } = robot;
    let links = lagrange::link_kinematics(model, &state.q);
    let description = model.description();
    let random = &mut SplitMix64::new(seed ^ 0xf0);
    let mut expected = vec![0.0; model.nv()];
    let mut wrenches = Vec::new();
    let on_link = |name: &str| description.links.iter().position(|link| link.name == name).unwrap();
    let of_links = description
        .links
        .iter()
        .map(|link| (&link.name, &link.name, robot_dynamics::description::Pose::IDENTITY));
    let declared = description.frames.iter().map(|f| (&f.name, &f.link, f.link_from_frame));
    for (name, link, link_from_frame) in of_links.chain(declared) {
        let force: [f64; 3] = core::array::from_fn(|_| random.uniform(-3.0, 3.0));
        let moment: [f64; 3] = core::array::from_fn(|_| random.uniform(-3.0, 3.0));
        wrenches.push(FrameWrench {
            frame: model.frame(name).unwrap(),
            force_in_frame: force,
            moment_in_frame: moment,
        });
        let link = &links[on_link(link)];
        let in_world = |x: [f64; 3]| link.rotation().map(|row| dot(&row, &link_from_frame.rotate(x)));
        let (force, moment) = (in_world(force), in_world(moment));
        let (linear, angular) = (link.point_jacobian(link_from_frame.translation), link.angular_jacobian());
        for i in 0..model.nv() {
            expected[i] += dot(&linear[i], &force) + dot(&angular[i], &moment);
        }
    }
    (wrenches, expected)
}

/// External wrenches w act as the generalized forces Jᵀw, in inverse and in forward dynamics.
#[test]
fn external_wrenches_act_through_jacobian_transposes() {
    for robot in families().iter().flat_map(Family::robots) {
        let Robot { model, state, .. } = &robot;
        let (q, v, a, tau) = (&state.q[..], &state.v[..], &state.a[..], &state.tau[..]);
        let (nv, w) = (model.nv(), &mut Workspace::new(model));
        let (wrenches, generalized) = wrenches(&robot);

        let (mut with, mut without) = (vec![0.0; nv], vec![0.0; nv]);
        robot_dynamics::algorithms::inverse_dynamics_with_wrenches(model, w, q, v, a, &wrenches, &mut with);
        robot_dynamics::algorithms::inverse_dynamics(model, w, q, v, a, &mut without);
        let expected: Vec<f64> = without.iter().zip(&generalized).map(|(tau, g)| tau - g).collect();
        let scale =
            size(&without) + size(&generalized) + size(&robot.mass()) * (dot(v, v) + dot(a, a).sqrt());
        robot.require("τ − Σ Jᵀw", max_difference(&with, &expected), ROUNDING * scale);

        let pushed: Vec<f64> = tau.iter().zip(&generalized).map(|(tau, g)| tau + g).collect();
        robot_dynamics::algorithms::forward_dynamics_with_wrenches(model, w, q, v, tau, &wrenches, &mut with);
        robot_dynamics::algorithms::forward_dynamics_by_cholesky(model, w, q, v, &pushed, &mut without);
        let force_size = size(&pushed) + model.mass() * 9.81 + size(&robot.mass()) * dot(v, v) + scale;
        let allowed = acceleration_error(&robot, force_size, &without);
        robot.require("a under τ + Σ Jᵀw", max_difference(&with, &without), allowed);
    }
}

/// M_y = GᵀMG and Gᵀ(C v + g) of the same robot without its mimic couplings, q = G y + c.
#[test]
fn mimic_joints_project_uncoupled_robot() {
    let families = families();
    let family = families.iter().find(|family| family.name == "mimic joints").unwrap();
    let mut mimic_joints = 0;
    for robot in family.robots() {
        let Robot { model, state, .. } = &robot;
        let mut loose = model.description().clone();
        loose.joints.iter_mut().for_each(|joint| joint.mimic = None);
        let loose = Model::new(loose).unwrap();
        // The leader and the ratio of each uncoupled coordinate, by following the names.
        let (n, m) = (model.nv(), loose.nv());
        let mut g = vec![0.0; m * n];
        let mut q = vec![0.0; loose.nq()];
        for free in loose.joints() {
            let (mut ratio, mut offset) = (1.0, 0.0);
            let mut joint = model.joint(&free.name).unwrap();
            while let Some(mimic) = &joint.mimic {
                offset += ratio * mimic.offset;
                ratio *= mimic.ratio;
                joint = model.joint(&mimic.joint).unwrap();
                mimic_joints += 1;
            }
            (0..free.nv).for_each(|k| g[(free.v_index + k) * n + joint.v_index + k] = ratio);
            (0..free.nq).for_each(|k| q[free.q_index + k] = ratio * state.q[joint.q_index + k] + offset);
        }
        let v = times(&g, &state.v);
        let w = &mut Workspace::new(&loose);
        let (mut mass, mut bias) = (vec![0.0; m * m], vec![0.0; m]);
        robot_dynamics::algorithms::mass_matrix(&loose, w, &q, &mut mass);
        robot_dynamics::algorithms::bias(&loose, w, &q, &v, &mut bias);
        let mut reduced_mass = vec![0.0; n * n];
        let mut reduced_bias = vec![0.0; n];
        for i in 0..n {
            for a in 0..m {
                reduced_bias[i] += g[a * n + i] * bias[a];
                for j in 0..n {
                    for b in 0..m {
                        reduced_mass[i * n + j] += g[a * n + i] * mass[a * m + b] * g[b * n + j];
                    }
                }
            }
        }
        let found = robot.mass();
        robot.require("M_y = GᵀMG", max_difference(&found, &reduced_mass), ROUNDING * size(&found));
        let mut found_bias = vec![0.0; n];
        robot_dynamics::algorithms::bias(
            model,
            &mut Workspace::new(model),
            &state.q,
            &state.v,
            &mut found_bias,
        );
        let scale = size(&found) * dot(&v, &v) + size(&found_bias) + model.mass() * 9.81;
        robot.require("Gᵀ(C v + g)", max_difference(&found_bias, &reduced_bias), ROUNDING * scale);
    }
    assert!(mimic_joints > 100, "only {mimic_joints} mimic joints");
}

/// d/dt (K + V) = vᵀτ along the motion that τ causes, by dual numbers that move with (q̇, v̇).
#[test]
fn energy_balances_power() {
    for robot in families().iter().flat_map(Family::robots) {
        let Robot { model, state, .. } = &robot;
        let (q, v, tau) = (&state.q[..], &state.v[..], &state.tau[..]);
        let mut a = vec![0.0; model.nv()];
        robot_dynamics::algorithms::forward_dynamics(model, &mut Workspace::new(model), q, v, tau, &mut a);
        let moving = |at: &[f64], rate: &[f64]| -> Vec<Dual<f64, 1>> {
            at.iter().zip(rate).map(|(&value, &rate)| Dual { value, gradient: [rate] }).collect()
        };
        let (q_moving, v_moving) = (moving(q, &lagrange::position_rate(model, q, v)), moving(v, &a));
        let w = &mut Workspace::<Dual<f64, 1>>::new(model);
        let energy = robot_dynamics::algorithms::kinetic_energy(model, w, &q_moving, &v_moving)
            + robot_dynamics::algorithms::potential_energy(model, w, &q_moving);
        let speed = dot(v, v).sqrt();
        let force_size = size(tau) + model.mass() * 9.81 + size(&robot.mass()) * speed * speed;
        // a is off by `acceleration_error`; that error changes K̇ by vᵀM times it.
        let allowed = speed * size(&robot.mass()) * acceleration_error(&robot, force_size, &a)
            + ROUNDING * speed * force_size;
        robot.require("K̇ + V̇ = vᵀτ", (energy.gradient[0] - dot(v, tau)).abs(), allowed);
    }
}

/// Every recursion over another scalar type: M, τ, g, C v and b, each with its scale, and the acceleration.
/// The state is converted, and the results are converted back.
fn over<S: Scalar>(robot: &Robot, value: impl Fn(S) -> f64) -> (Vec<Vec<f64>>, Vec<f64>) {
    let Robot { model, state, .. } = robot;
    let convert = |x: &[f64]| x.iter().map(|&x| S::from_f64(x)).collect::<Vec<S>>();
    let (q, v, a, tau) = (convert(&state.q), convert(&state.v), convert(&state.a), convert(&state.tau));
    let (nv, w) = (model.nv(), &mut Workspace::<S>::new(model));
    let mut mass = vec![S::zero(); nv * nv];
    let mut rows = vec![vec![S::zero(); nv]; 4];
    robot_dynamics::algorithms::mass_matrix(model, w, &q, &mut mass);
    robot_dynamics::algorithms::inverse_dynamics(model, w, &q, &v, &a, &mut rows[0]);
    robot_dynamics::algorithms::gravity(model, w, &q, &mut rows[1]);
    robot_dynamics::algorithms::velocity_product(model, w, &q, &v, &mut rows[2]);
    robot_dynamics::algorithms::dissipation(model, &v, &mut rows[3]);
    let mut acceleration = vec![S::zero(); nv];
    robot_dynamics::algorithms::forward_dynamics(model, w, &q, &v, &tau, &mut acceleration);
    rows.push(mass);
    let back = |row: Vec<S>| row.into_iter().map(&value).collect::<Vec<f64>>();
    (rows.into_iter().map(back).collect(), acceleration.into_iter().map(value).collect())
}

/// Requires that another scalar type of precision `epsilon` gives the results of f64. The tolerance is 256 of
/// its roundings (paths of a few tens of joints), times κ(M) where M is inverted.
fn require_same<S: Scalar>(robot: &Robot, epsilon: f64, value: impl Fn(S) -> f64) {
    let Robot { model, state, .. } = robot;
    let (rows, acceleration) = over::<f64>(robot, |x| x);
    let (other_rows, other_acceleration) = over::<S>(robot, value);
    let (mass, v) = (size(&robot.mass()), &state.v);
    let force_size =
        mass * (dot(v, v) + dot(&state.a, &state.a).sqrt()) + size(&rows[1]) + model.mass() * 9.81;
    for (row, other) in rows.iter().zip(&other_rows) {
        // M has other units than forces; both scales bound it.
        robot.require("forces", max_difference(row, other), 256.0 * epsilon * (force_size + mass));
    }
    let allowed = 256.0 * epsilon * robot.condition() * (force_size / mass + size(&acceleration));
    robot.require("accelerations", max_difference(&acceleration, &other_acceleration), allowed);
}

/// Dual numbers have the same values; only `scale` and division may round differently.
#[test]
fn dual_numbers_have_same_values() {
    for robot in families().iter().flat_map(|family| family.robots().take(10)) {
        require_same::<Dual<f64, 3>>(&robot, f64::EPSILON, |x| x.value);
    }
}

/// Single precision satisfies the same bounds with ε = 2⁻²³.
#[test]
fn single_precision_agrees_to_its_precision() {
    for robot in families().iter().flat_map(|family| family.robots().take(10)) {
        // Beyond this condition an f32 acceleration has no digits left, and the recursion may find a
        // pivot ≤ 0.
        if robot.condition() < 1e5 {
            require_same::<f32>(&robot, f64::from(f32::EPSILON), f64::from);
        }
    }
}

/// ∂g/∂q and ∂τ/∂q of the recursions over dual numbers match the Lagrange recipe over dual numbers.
#[test]
fn derivatives_through_recursions_match_lagrange() {
    type D = Dual<f64, 1>;
    for robot in families().iter().flat_map(|family| family.robots().take(10)) {
        let Robot { model, state, .. } = &robot;
        let rate = lagrange::position_rate(model, &state.q, &state.v);
        let q: Vec<D> = state.q.iter().zip(&rate).map(|(&value, &r)| Dual { value, gradient: [r] }).collect();
        let constant = |x: &[f64]| x.iter().map(|&x| D::constant(x)).collect::<Vec<D>>();
        let (v, a) = (constant(&state.v), constant(&state.a));
        let mut tau = vec![D::zero(); model.nv()];
        robot_dynamics::algorithms::inverse_dynamics(model, &mut Workspace::new(model), &q, &v, &a, &mut tau);
        let slope: Vec<f64> = tau.iter().map(|tau| tau.gradient[0]).collect();
        let oracle: Vec<f64> =
            lagrange::inverse_dynamics(model, &q, &v, &a).iter().map(|tau| tau.gradient[0]).collect();
        let (speed, push) = (dot(&state.v, &state.v).sqrt(), dot(&state.a, &state.a).sqrt());
        let scale = size(&oracle) + size(&robot.mass()) * speed * (speed * speed + push);
        robot.require("∂τ/∂q q̇", max_difference(&slope, &oracle), ROUNDING * scale);
    }
}

/// C v from the Christoffel symbols of the reference is its Euler–Poincaré C v, and Ṁ − 2C is skew-symmetric.
#[test]
fn christoffel_symbols_give_velocity_product() {
    let mut checked = 0;
    for robot in families().iter().filter(|f| f.name != "large").flat_map(Family::robots) {
        let Robot { model, state, .. } = &robot;
        if !model.is_vector_space() {
            continue;
        }
        checked += 1;
        let (q, v, nv) = (&state.q[..], &state.v[..], model.nv());
        let coriolis = lagrange::coriolis_matrix(model, q, v);
        let product = lagrange::velocity_product(model, q, v);
        let scale = size(&robot.mass()) * dot(v, v).sqrt();
        let defect = max_difference(&times(&coriolis, v), &product);
        robot.require("Σ Γⁱⱼₖ vⱼ vₖ = C v", defect, ROUNDING * scale * dot(v, v).sqrt());
        let rate = lagrange::mass_rate(model, q, v);
        let skew = |i: usize, j: usize| rate[i * nv + j] - 2.0 * coriolis[i * nv + j];
        let defect =
            (0..nv * nv).map(|k| (skew(k / nv, k % nv) + skew(k % nv, k / nv)).abs()).fold(0.0, f64::max);
        robot.require("Ṁ − 2C skew", defect, ROUNDING * scale);
    }
    assert!(checked > 100, "only {checked} robots have q̇ = v");
}

/// The Christoffel symbols and the Coriolis matrix of the recursions match exact derivatives of M.
#[test]
fn coriolis_terms_match_lagrange() {
    for robot in families().iter().filter(|f| f.name != "large").flat_map(Family::robots) {
        let Robot { model, state, .. } = &robot;
        if !model.is_vector_space() {
            continue;
        }
        let (q, v, nv) = (&state.q[..], &state.v[..], model.nv());
        let w = &mut Workspace::new(model);
        let scale = size(&robot.mass());
        let oracle = lagrange::christoffel(model, q);
        let mut symbols = vec![0.0; nv * nv * nv];
        robot_dynamics::algorithms::christoffel_symbols(model, w, q, &mut symbols);
        let expected: Vec<f64> =
            (0..nv * nv * nv).map(|n| oracle.get(n / (nv * nv), n / nv % nv, n % nv)).collect();
        robot.require("Γ", max_difference(&symbols, &expected), ROUNDING * scale);
        // C v is the same with the symbols' C and with any other C.
        let mut coriolis = vec![0.0; nv * nv];
        robot_dynamics::algorithms::coriolis_matrix(model, w, q, v, &mut coriolis);
        let product = lagrange::velocity_product(model, q, v);
        robot.require(
            "C(q,v) v",
            max_difference(&times(&coriolis, v), &product),
            ROUNDING * scale * dot(v, v),
        );
    }
}

/// Poses, Jacobians and the rate of q of the compiled model match the links as described.
#[test]
fn kinematics_match_lagrange() {
    for robot in families().iter().flat_map(Family::robots) {
        let Robot { model, state, .. } = &robot;
        let (q, nv) = (&state.q[..], model.nv());
        let w = &mut Workspace::new(model);
        // Lengths add up along the tree, at most one metre a joint.
        let reach = 1.0 + model.joints().len() as f64;
        let described = &model.description().links;
        for (link, oracle) in described.iter().zip(lagrange::link_kinematics(model, q)) {
            let frame = model.frame(&link.name).unwrap();
            let pose = robot_dynamics::algorithms::frame_pose(model, w, q, frame);
            let (found, expected) = (pose.rotation.as_flattened(), oracle.rotation());
            robot.require("R", max_difference(found, expected.as_flattened()), ROUNDING);
            robot.require("p", max_difference(&pose.translation, &oracle.origin()), ROUNDING * reach);
            let mut jacobian = vec![0.0; 6 * nv];
            robot_dynamics::algorithms::frame_jacobian(
                model,
                w,
                q,
                frame,
                ReferenceFrame::LocalWorldAligned,
                &mut jacobian,
            );
            let (linear, angular) = (oracle.point_jacobian([0.0; 3]), oracle.angular_jacobian());
            let expected: Vec<f64> = (0..6 * nv)
                .map(|n| if n / nv < 3 { linear[n % nv][n / nv] } else { angular[n % nv][n / nv - 3] })
                .collect();
            robot.require("J", max_difference(&jacobian, &expected), ROUNDING * reach);
        }
    }
}
