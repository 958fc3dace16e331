//! The wrench that each joint transmits, against the momentum of the links beyond it and against inverse
//! dynamics.
//!
//! The first route takes the poses of the links from the kinematics of the Lagrange recipe over numbers with
//! two time derivatives. The masses come from the description. It merges and compiles nothing. Tolerance:
//! each force sums the terms of about 60 links; 1e-12 of the largest term allows 4500 roundings.

use robot_dynamics::algorithms::{inverse_dynamics_with_wrenches, joint_reactions};
use robot_dynamics::description::{JointKind, PassiveForces};
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::number::Scalar;
use robot_dynamics::verification::lagrange;

use crate::common::{Robot, families, max_difference, size};
use crate::kinematics::{SecondRate, moving};

const ROUNDING: f64 = 1e-12;

type Three<S> = [S; 3];

fn cross<S: Scalar>(a: Three<S>, b: Three<S>) -> Three<S> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn plus<S: Scalar>(a: Three<S>, b: Three<S>) -> Three<S> {
    core::array::from_fn(|i| a[i] + b[i])
}

fn minus<S: Scalar>(a: Three<S>, b: Three<S>) -> Three<S> {
    core::array::from_fn(|i| a[i] - b[i])
}

fn times<S: Scalar>(r: &[Three<S>; 3], x: Three<S>) -> Three<S> {
    r.map(|row| row[0] * x[0] + row[1] * x[1] + row[2] * x[2])
}

fn turned_back(r: &[Three<f64>; 3], x: Three<f64>) -> Three<f64> {
    core::array::from_fn(|j| (0..3).map(|i| r[i][j] * x[i]).sum())
}

/// The value, and the rates of first and second order.
fn value(x: SecondRate) -> f64 {
    x.value.value
}
fn rate(x: SecondRate) -> f64 {
    x.gradient[0].value
}
fn second(x: SecondRate) -> f64 {
    x.gradient[0].gradient[0]
}

/// The rate of momentum of a link less gravity, in world axes: the force, and the moment about the world's
/// origin.
fn momentum_rate(
    model: &Model,
    link: usize,
    pose: &lagrange::LinkKinematics<SecondRate>,
) -> (Three<f64>, Three<f64>) {
    let Some(own) = &model.description().links[link].mass_properties else { return ([0.0; 3], [0.0; 3]) };
    let center: Three<f64> = own.center_of_mass().into();
    let inertia = own.inertia_about_center_of_mass();
    let at = pose.point(center.map(SecondRate::from_f64));
    let (r, g) = (pose.rotation(), model.gravity());
    let force: Three<f64> = core::array::from_fn(|i| own.mass() * (second(at[i]) - g[i]));
    // Σ over the axes eₖ of the pseudo inertia J = ½ tr(I) 1 − I. The rate of the spin is Σ J_kl (R eₖ × R̈
    // e_l).
    let half = 0.5 * inertia.trace();
    let mut spin = [0.0; 3];
    for k in 0..3 {
        for l in 0..3 {
            let weight = if k == l { half - inertia[(k, l)] } else { -inertia[(k, l)] };
            let (axis, swing) = (r.map(|row| value(row[k])), r.map(|row| second(row[l])));
            spin = plus(spin, cross(axis, swing).map(|x| weight * x));
        }
    }
    (force, plus(spin, cross(at.map(value), force)))
}

/// The links of the description beyond a joint, its child included.
fn beyond(model: &Model, child: &str) -> Vec<String> {
    let mut links = vec![child.to_owned()];
    let mut at = 0;
    while at < links.len() {
        let below = model.description().joints.iter().filter(|joint| joint.parent == links[at]);
        let below: Vec<String> = below.map(|joint| joint.child.clone()).collect();
        links.extend(below);
        at += 1;
    }
    links
}

fn robots() -> impl Iterator<Item = Robot> {
    families().into_iter().flat_map(|family| family.robots().take(15).collect::<Vec<_>>())
}

#[test]
fn reactions_are_momentum_rates_of_links_beyond() {
    let mut fixed = 0;
    for robot in robots() {
        let Robot { model, state, .. } = &robot;
        let (q, v, a) = (&state.q[..], &state.v[..], &state.a[..]);
        let mut reactions = vec![0.0; 6 * model.joints().len()];
        let wrenches = robot.wrenches();
        joint_reactions(model, &mut Workspace::new(model), q, v, a, &wrenches, &mut reactions);
        let poses = lagrange::link_kinematics(model, &moving(model, q, v, a));
        let index = |name: &str| {
            model.description().links.iter().position(|link| link.name == name).expect("a link of the robot")
        };
        let each: Vec<_> =
            poses.iter().enumerate().map(|(link, pose)| momentum_rate(model, link, pose)).collect();
        // Wrenches in world axes about the world's origin, by the link of the frame.
        let external: Vec<(String, Three<f64>, Three<f64>)> = wrenches
            .iter()
            .enumerate()
            .map(|(at, wrench)| {
                let frame = &model.frames()[3 * at];
                let own = model.description().frames.iter().find(|own| own.name == frame.name);
                let link = own.map_or(&frame.name, |own| &own.link).clone();
                let pose = model.frame_pose(q, wrench.frame).expect("a valid q");
                let force = times(&pose.rotation, wrench.force_in_frame);
                let moment = times(&pose.rotation, wrench.moment_in_frame);
                (link, force, plus(moment, cross(pose.translation, force)))
            })
            .collect();
        let largest =
            each.iter().flat_map(|(f, n)| f.iter().chain(n)).fold(1.0, |most: f64, x| most.max(x.abs()));
        for (joint, found) in model.joints().iter().zip(reactions.chunks(6)) {
            let (mut force, mut moment) = ([0.0; 3], [0.0; 3]);
            let links = beyond(model, &joint.child_link);
            for link in &links {
                let (f, n) = each[index(link)];
                (force, moment) = (plus(force, f), plus(moment, n));
            }
            for (_, f, n) in external.iter().filter(|(link, ..)| links.contains(link)) {
                (force, moment) = (minus(force, *f), minus(moment, *n));
            }
            let pose = &poses[index(&joint.child_link)];
            let (r, p) = (pose.rotation().map(|row| row.map(value)), pose.origin().map(value));
            let moment = minus(moment, cross(p, force));
            let expected = [turned_back(&r, force), turned_back(&r, moment)].concat();
            let allowed = ROUNDING * largest * (model.joints().len() + 1) as f64;
            robot.require(&format!("reaction of {}", joint.name), max_difference(found, &expected), allowed);
            fixed += usize::from(joint.kind == JointKind::Fixed);
        }
        // Checks that the rates are those of the motion.
        assert!(poses.iter().all(|pose| pose.origin().iter().all(|x| rate(*x).is_finite())));
    }
    assert!(fixed > 20, "{fixed} fixed joints");
}

/// The component of each joint's wrench along its axis, summed over mimic joints, is the generalized force
/// without armature and springs.
#[test]
fn components_along_axes_are_generalized_forces() {
    for mut robot in robots() {
        let mut description = robot.model.description().clone();
        description.tendons.clear();
        for joint in &mut description.joints {
            joint.passive = PassiveForces::default();
        }
        robot.model = Model::new(description).expect("a robot");
        let (q, v, a) = (&robot.state.q[..], &robot.state.v[..], &robot.state.a[..]);
        let (model, wrenches, w) = (&robot.model, robot.wrenches(), &mut Workspace::new(&robot.model));
        let (mut tau, mut sums) = (vec![0.0; model.nv()], vec![0.0; model.nv()]);
        inverse_dynamics_with_wrenches(model, w, q, v, a, &wrenches, &mut tau);
        let mut reactions = vec![0.0; 6 * model.joints().len()];
        joint_reactions(model, w, q, v, a, &wrenches, &mut reactions);
        let mut compared = vec![false; model.nv()];
        for (joint, wrench) in model.joints().iter().zip(reactions.chunks(6)) {
            // The coordinate of the leader and the ratio of this joint to it.
            let (mut leader, mut ratio) = (joint, 1.0);
            while let Some(mimic) = &leader.mimic {
                ratio *= mimic.ratio;
                leader = model.joint(&mimic.joint).expect("its leader");
            }
            let along = |axis: [f64; 3], part: &[f64]| {
                let norm = axis.iter().map(|x| x * x).sum::<f64>().sqrt();
                axis.iter().zip(part).map(|(x, y)| x * y).sum::<f64>() / norm
            };
            let components: Vec<f64> = match joint.kind {
                JointKind::Revolute { axis } | JointKind::Continuous { axis } => {
                    vec![along(axis, &wrench[3..])]
                }
                JointKind::Prismatic { axis } => vec![along(axis, &wrench[..3])],
                JointKind::Helical { axis, pitch } => {
                    vec![pitch * along(axis, &wrench[..3]) + along(axis, &wrench[3..])]
                }
                JointKind::Spherical => wrench[3..].to_vec(),
                JointKind::Floating => wrench.to_vec(),
                _ => continue,
            };
            for (k, component) in components.iter().enumerate() {
                sums[leader.v_index + k] += ratio * component;
                compared[leader.v_index + k] = true;
            }
        }
        let allowed = ROUNDING * size(&reactions).max(1.0) * (model.joints().len() + 1) as f64;
        for k in (0..model.nv()).filter(|&k| compared[k]) {
            robot.require("component along the axis", (sums[k] - tau[k]).abs(), allowed);
        }
    }
}
