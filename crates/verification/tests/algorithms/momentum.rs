//! Momentum, centre of mass and the inverse of M, on every kind of robot.
//!
//! Tolerance: sums over at most about 60 bodies; 1e-12 of the size of their terms allows 4500 roundings.

use robot_dynamics::algorithms::{
    center_of_mass, center_of_mass_bias_acceleration, center_of_mass_jacobian, center_of_mass_velocity,
    centroidal_momentum, centroidal_momentum_bias_rate, centroidal_momentum_matrix, centroidal_momentum_rate,
    forward_dynamics, inverse_mass_matrix, kinetic_energy, kinetic_energy_gradient, mass_matrix_factor,
    momentum,
};
use robot_dynamics::description::{Base, RandomRobotOptions, random_robot};
use robot_dynamics::model::{Model, Workspace, random_state};
use robot_dynamics::number::{Dual, Scalar, SplitMix64};
use robot_dynamics::verification::lagrange;

use crate::common::{Robot, dot, families, max_difference, size, times};

const ROUNDING: f64 = 1e-12;

/// The robots, and the scale of distances and rates of their parts: metres, m/s, m/s² up to a small factor.
fn robots() -> Vec<(Robot, [f64; 3])> {
    let list = families().into_iter().flat_map(|family| family.robots().collect::<Vec<_>>());
    list.map(|robot| {
        let reach = 2.0 * (robot.model.joints().len() + 1) as f64;
        let sum = |x: &[f64]| x.iter().map(|x| x.abs()).sum::<f64>() + 1.0;
        let speed = sum(&robot.state.v);
        let surge = sum(&robot.state.a) + speed * speed;
        (robot, [reach, reach * speed, reach * surge])
    })
    .collect()
}

/// Mass, first moment in the world, and spin (momentum about the world's origin) of all moving links, from
/// the poses of the Lagrange recipe.
struct Oracle<S> {
    center: [S; 3],
    linear: [S; 3],
    angular: [S; 3],
}

/// Each moving link as six point masses on its principal axes, with the same m, c and I.
fn points(model: &Model) -> Vec<(usize, f64, [f64; 3])> {
    let mut list = Vec::new();
    for (link, described) in model.description().links.iter().enumerate() {
        let Some(properties) = &described.mass_properties else { continue };
        let principal = properties.inertia_about_center_of_mass().symmetric_eigen();
        let moments = principal.eigenvalues;
        for axis in 0..3 {
            // ∫ x² dm along this axis is half the sum of the other moments less this one.
            let second = 0.5 * (moments.sum() - 2.0 * moments[axis]).max(0.0);
            let arm = principal.eigenvectors.column(axis) * (3.0 * second / properties.mass()).sqrt();
            for side in [-1.0, 1.0] {
                let at = properties.center_of_mass() + arm * side;
                list.push((link, properties.mass() / 6.0, at.into()));
            }
        }
    }
    list
}

/// The links that a moving joint carries.
fn moves(model: &Model) -> Vec<bool> {
    let description = model.description();
    let index = |name: &str| description.links.iter().position(|link| link.name == name).expect("a link");
    let mut moving = vec![description.base == Base::Floating; description.links.len()];
    // As many passes as the longest chain may need.
    for _ in 0..description.links.len() {
        for joint in &description.joints {
            moving[index(&joint.child)] |= joint.kind.nv() > 0 || moving[index(&joint.parent)];
        }
    }
    moving
}

fn oracle<S: Scalar>(model: &Model, q: &[Dual<S, 1>]) -> Oracle<S> {
    let links = lagrange::link_kinematics(model, q);
    let moving = moves(model);
    let points: Vec<_> = points(model).into_iter().filter(|(link, ..)| moving[*link]).collect();
    let whole: f64 = points.iter().map(|(_, mass, _)| mass).sum();
    let zero = [S::zero(); 3];
    let placed: Vec<_> = points
        .iter()
        .map(|(link, mass, at)| (*mass, links[*link].point(at.map(Dual::<S, 1>::from_f64))))
        .collect();
    let sum = |value: &dyn Fn(&[Dual<S, 1>; 3]) -> [S; 3]| {
        placed.iter().fold(zero, |sum, (mass, point)| {
            let part = value(point);
            std::array::from_fn(|i| sum[i] + part[i].scale(*mass))
        })
    };
    let center = sum(&|p| p.map(|p| p.value)).map(|x| x.scale(1.0 / whole));
    let linear = sum(&|p| p.map(|p| p.gradient[0]));
    let angular = sum(&|p| {
        let r: [S; 3] = std::array::from_fn(|i| p[i].value - center[i]);
        let u = p.map(|p| p.gradient[0]);
        [r[1] * u[2] - r[2] * u[1], r[2] * u[0] - r[0] * u[2], r[0] * u[1] - r[1] * u[0]]
    });
    Oracle { center, linear, angular }
}

/// q(t) with two derivatives with respect to time.
fn moving(model: &Model, q: &[f64], v: &[f64], a: &[f64]) -> Vec<Dual<Dual<f64, 1>, 1>> {
    let first: Vec<f64> = lagrange::position_rate(model, q, v);
    let pair = |(&value, &rate): (&f64, &f64)| Dual { value, gradient: [rate] };
    let q: Vec<Dual<f64, 1>> = q.iter().zip(&first).map(pair).collect();
    let v: Vec<Dual<f64, 1>> = v.iter().zip(a).map(pair).collect();
    let rate = lagrange::position_rate(model, &q, &v);
    q.into_iter().zip(rate).map(|(value, rate)| Dual { value, gradient: [rate] }).collect()
}

/// c, ċ, h_G and ḣ_G against point masses on the kinematics of the Lagrange recipe, differentiated.
#[test]
fn momentum_matches_point_masses() {
    for (robot, [reach, speed, surge]) in robots() {
        let model = &robot.model;
        let (q, v, a) = (&robot.state.q[..], &robot.state.v[..], &robot.state.a[..]);
        let (w, mass) = (&mut Workspace::new(model), model.moving_mass());
        let oracle = oracle(model, &moving(model, q, v, a));
        let value = |x: [Dual<f64, 1>; 3]| x.map(|x| x.value);
        let rate = |x: [Dual<f64, 1>; 3]| x.map(|x| x.gradient[0]);
        let near = |law: &str, x: &[f64], y: &[f64], scale: f64| {
            robot.require(law, max_difference(x, y), ROUNDING * scale);
        };
        near("c", &center_of_mass(model, w, q), &value(oracle.center), reach);
        near("ċ", &center_of_mass_velocity(model, w, q, v), &rate(oracle.center), speed);
        let h = centroidal_momentum(model, w, q, v);
        near("linear momentum", &h.linear, &value(oracle.linear), mass * speed);
        near("angular momentum", &h.angular, &value(oracle.angular), mass * speed * reach);
        let rate_of_h = centroidal_momentum_rate(model, w, q, v, a);
        near("rate of linear momentum", &rate_of_h.linear, &rate(oracle.linear), mass * surge);
        near("rate of angular momentum", &rate_of_h.angular, &rate(oracle.angular), mass * surge * reach);
    }
}

/// h = A_G v, ḣ = A_G a + Ȧ_G v, ċ = J v, m J is the linear rows of A_G, and c̈ = ḣ/m at a = 0.
#[test]
fn matrices_give_momentum_vectors() {
    for (robot, [reach, speed, surge]) in robots() {
        let model = &robot.model;
        let (q, v, a) = (&robot.state.q[..], &robot.state.v[..], &robot.state.a[..]);
        let (w, mass, nv) = (&mut Workspace::new(model), model.moving_mass(), model.nv());
        let join = |h: robot_dynamics::algorithms::CentroidalMomentum| [h.linear, h.angular].concat();
        let (mut matrix, mut jacobian) = (vec![0.0; 6 * nv], vec![0.0; 3 * nv]);
        centroidal_momentum_matrix(model, w, q, &mut matrix);
        center_of_mass_jacobian(model, w, q, &mut jacobian);
        let near = |law: &str, x: &[f64], y: &[f64], scale: f64| {
            robot.require(law, max_difference(x, y), ROUNDING * scale);
        };
        let h = join(centroidal_momentum(model, w, q, v));
        near("h = A v", &times(&matrix, v), &h, mass * speed * reach);
        let bias = join(centroidal_momentum_bias_rate(model, w, q, v));
        let sum: Vec<f64> = times(&matrix, a).iter().zip(&bias).map(|(x, y)| x + y).collect();
        let rate = join(centroidal_momentum_rate(model, w, q, v, a));
        near("ḣ = A a + Ȧ v", &sum, &rate, mass * surge * reach);
        near("ċ = J v", &times(&jacobian, v), &center_of_mass_velocity(model, w, q, v), speed);
        let weighed: Vec<f64> = jacobian.iter().map(|j| j * mass).collect();
        near("m J = A", &weighed, &matrix[..3 * nv], mass * reach);
        let c = center_of_mass_bias_acceleration(model, w, q, v).map(|c| c * mass);
        near("m J̇ v = Ȧ v", &c, &bias[..3], mass * surge);
    }
}

/// In free flight ḣ_G = [m g; 0] for any motion of the joints.
#[test]
fn only_gravity_changes_momentum_of_free_robot() {
    let options = RandomRobotOptions { base: Base::Floating, joints: 8, ..RandomRobotOptions::default() };
    for seed in 0..60 {
        let robot = Robot::new("floating trees", seed, &options);
        let model = &robot.model;
        let (q, v, w) = (&robot.state.q[..], &robot.state.v[..], &mut Workspace::new(model));
        let mut tau = robot.state.tau.clone();
        tau[..6].fill(0.0); // only the joints are driven
        let mut a = vec![0.0; model.nv()];
        forward_dynamics(model, w, q, v, &tau, &mut a);
        let rate = centroidal_momentum_rate(model, w, q, v, &a);
        let weight = model.gravity().map(|g| g * model.moving_mass());
        // The error of a is at most κ(M) ε of a; entries of A_G are masses times metres.
        let reach = 2.0 * (model.joints().len() + 1) as f64;
        let allowed = 10.0 * robot.condition() * f64::EPSILON * size(&a) * model.moving_mass() * reach;
        robot.require("ṗ = m g", max_difference(&rate.linear, &weight), allowed);
        robot.require("L̇ = 0", size(&rate.angular), allowed);
    }
}

/// p = M v, and ∂K/∂q at constant v is the derivative of K along each coordinate.
#[test]
fn gradients_of_kinetic_energy_match_duals() {
    for (robot, _) in robots() {
        let (model, q, v) = (&robot.model, &robot.state.q[..], &robot.state.v[..]);
        let (w, nv, mass) = (&mut Workspace::new(model), model.nv(), robot.mass());
        let mut found = vec![0.0; nv];
        momentum(model, w, q, v, &mut found);
        let scale = size(&mass) * size(v) * nv as f64;
        robot.require("p = M v", max_difference(&found, &times(&mass, v)), ROUNDING * scale);
        let twice = 2.0 * kinetic_energy(model, w, q, v);
        robot.require("p·v = 2K", (dot(&found, v) - twice).abs(), ROUNDING * scale * size(v) * nv as f64);

        kinetic_energy_gradient(model, w, q, v, &mut found);
        let dual_v: Vec<Dual<f64, 1>> = v.iter().map(|&v| Dual::constant(v)).collect();
        for k in 0..nv.min(25) {
            let unit: Vec<f64> = (0..nv).map(|i| f64::from(u8::from(i == k))).collect();
            let rate: Vec<f64> = lagrange::position_rate(model, q, &unit);
            let path: Vec<Dual<f64, 1>> =
                q.iter().zip(&rate).map(|(&value, &rate)| Dual { value, gradient: [rate] }).collect();
            let slope = lagrange::kinetic_energy(model, &path, &dual_v).gradient[0];
            let defect = (found[k] - slope).abs();
            robot.require("∂K/∂q", defect, ROUNDING * size(&mass) * dot(v, v) * nv as f64);
        }
    }
}

/// M M⁻¹ = 1. A Cholesky solve leaves a residual of n ε |M||M⁻¹|, at most a few times over (Higham, *Accuracy
/// and Stability of Numerical Algorithms*, thm 10.4).
#[test]
fn inverse_mass_matrix_inverts() {
    for (robot, _) in robots() {
        let (model, nv, mass) = (&robot.model, robot.model.nv(), robot.mass());
        let mut inverse = vec![0.0; nv * nv];
        inverse_mass_matrix(model, &mut Workspace::new(model), &robot.state.q, &mut inverse);
        let norm = |m: &[f64]| m.chunks(nv).map(|row| row.iter().map(|x| x.abs()).sum()).fold(0.0, f64::max);
        let allowed = 10.0 * f64::EPSILON * nv as f64 * norm(&mass) * norm(&inverse);
        for j in 0..nv {
            let column: Vec<f64> = inverse[j * nv..(j + 1) * nv].to_vec();
            let unit: Vec<f64> = (0..nv).map(|i| f64::from(u8::from(i == j))).collect();
            robot.require("M M⁻¹ = 1", max_difference(&times(&mass, &column), &unit), allowed);
        }
    }
}

/// LᵀDL = M, and L has the zeros of the tree. A factorisation without pivoting of a positive definite matrix
/// has an error of n ε |L|ᵀD|L|. Its entries are below n times the largest entry of M (Higham, thm 10.3).
#[test]
fn mass_matrix_is_product_of_its_factors() {
    for (robot, _) in robots() {
        let (model, nv, mass) = (&robot.model, robot.model.nv(), robot.mass());
        let mut factor = vec![f64::NAN; nv * nv];
        mass_matrix_factor(model, &mut Workspace::new(model), &robot.state.q, &mut factor);
        let l = |k: usize, i: usize| if i == k { 1.0 } else { factor[k * nv + i] };
        for i in 0..nv {
            for j in 0..=i {
                let terms = (i..nv).map(|k| l(k, i) * factor[k * nv + k] * l(k, j));
                let off = (terms.sum::<f64>() - mass[i * nv + j]).abs();
                robot.require("LᵀDL = M", off, ROUNDING * nv as f64 * size(&mass));
                assert!(j == i || factor[j * nv + i] == 0.0, "above the diagonal");
                if !model.has_mimic() && mass[i * nv + j] == 0.0 && factor[i * nv + j] != 0.0 {
                    let related = robot_dynamics::algorithms::mass_matrix_related_entries(model);
                    assert!(
                        related.contains(&(j, i)),
                        "L_{i}{j} of coordinates that do not carry each other"
                    );
                }
            }
        }
    }
}

/// A tree of 40 joints with a seed that the families do not use.
#[test]
fn momentum_is_exact_far_from_origin() {
    let options = RandomRobotOptions { base: Base::Floating, joints: 40, ..RandomRobotOptions::default() };
    let model = Model::new(random_robot(4711, &options)).expect("a robot");
    let mut state = random_state(&model, &mut SplitMix64::new(4711));
    let w = &mut Workspace::new(&model);
    let near = centroidal_momentum(&model, w, &state.q, &state.v);
    state.q[1] += 1e5;
    // No term depends on the world's origin, so the results are equal bit for bit.
    assert_eq!(near, centroidal_momentum(&model, w, &state.q, &state.v));
}
