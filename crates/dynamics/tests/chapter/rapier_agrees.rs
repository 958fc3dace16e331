//! The two-link arm against a physics engine that does not use the Lagrange recipe.
//!
//! rapier2d integrates every body in maximal coordinates and holds the arm together with joint impulses. It
//! shares no formula with this crate. Its time stepping determines the tolerances, so these settings matter:
//!
//! - two bodies placed at their centres of mass, inertia about it, no colliders, sleeping off;
//! - impulse joints; one solver iteration, which is the number of substeps, so one step is one substep;
//! - 50 inner Gauss–Seidel sweeps: the two joints share a body, so their impulses must converge together;
//! - stiff joints (natural frequency 1e8, damping ratio 1) without stabilisation sweeps: the sweep that finds
//!   the impulses also corrects the position error as a velocity;
//! - linear velocities at the start are J(q − h q̇) q̇, as the engine's velocities satisfy the joint Jacobian
//!   of the previous step. Velocities J(q) q̇ would lose the term J̇ q̇ in the first step.
//!
//! (The engine's multibody joints would work, too, but they damp every free angle by 0.1 N·m·s by default.)

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
use std::thread;

use dynamics::laws::States;
use dynamics::{Dynamics, Reach2R, rk4_step};
use nalgebra::{Vector2, vector};
use rapier2d_f64::prelude::*;

/// The arm inside the engine.
struct EngineArm {
    world: PhysicsWorld,
    links: [RigidBodyHandle; 2],
}

impl EngineArm {
    /// The arm at (q, q̇), with constant joint torques u, ready for steps of h \[s\].
    fn new(arm: &Reach2R, q: Vector2<f64>, qd: Vector2<f64>, u: Vector2<f64>, h: f64) -> Self {
        let mut world = PhysicsWorld::new();
        world.gravity = Vector::new(0.0, -arm.a_g);
        let settings = &mut world.integration_parameters;
        settings.dt = h;
        settings.num_solver_iterations = 1;
        settings.num_internal_pgs_iterations = 50;
        settings.num_internal_stabilization_iterations = 0;

        let here = centres(arm, q);
        let ahead = centre_velocities(arm, q - qd * h, qd);
        let spin = [qd[0], qd[0] + qd[1]];
        let angle = [q[0], q[0] + q[1]];
        let torque = [u[0] - u[1], u[1]];
        let mass = [(arm.m1, arm.i1), (arm.m2, arm.i2)];
        let links = [0, 1].map(|k| {
            let (m, inertia) = mass[k];
            let body = RigidBodyBuilder::dynamic()
                .translation(Vector::new(here[k][0], here[k][1]))
                .rotation(angle[k])
                .linvel(Vector::new(ahead[k][0], ahead[k][1]))
                .angvel(spin[k])
                .can_sleep(false)
                .additional_mass_properties(MassProperties::new(Vector::ZERO, m, inertia));
            let handle = world.insert_body(body);
            world.bodies[handle].add_torque(torque[k], true);
            handle
        });
        let ground = world.insert_body(RigidBodyBuilder::fixed());
        let stiff = SpringCoefficients::new(1e8, 1.0);
        let hinge = |inner: f64, outer: f64| {
            RevoluteJointBuilder::new()
                .local_anchor1(Vector::new(inner, 0.0))
                .local_anchor2(Vector::new(outer, 0.0))
                .softness(stiff)
        };
        world.insert_impulse_joint(ground, links[0], hinge(0.0, -arm.r1));
        world.insert_impulse_joint(links[0], links[1], hinge(arm.l1 - arm.r1, -arm.r2));
        Self { world, links }
    }

    fn step(&mut self) {
        self.world.step();
    }

    /// q̇ from the bodies' angular velocities.
    fn velocity(&self) -> Vector2<f64> {
        let [w1, w2] = self.links.map(|link| self.world.bodies[link].angvel());
        vector![w1, w2 - w1]
    }

    /// The heading of each link, which the engine stores modulo a full turn.
    fn headings(&self) -> [f64; 2] {
        self.links.map(|link| self.world.bodies[link].rotation().angle())
    }
}

/// Positions of the two centres of mass.
fn centres(arm: &Reach2R, q: Vector2<f64>) -> [Vector2<f64>; 2] {
    let along = |angle: f64| vector![angle.cos(), angle.sin()];
    [along(q[0]) * arm.r1, along(q[0]) * arm.l1 + along(q[0] + q[1]) * arm.r2]
}

/// Velocities of the two centres of mass.
fn centre_velocities(arm: &Reach2R, q: Vector2<f64>, qd: Vector2<f64>) -> [Vector2<f64>; 2] {
    let across = |angle: f64| vector![-angle.sin(), angle.cos()];
    let (first, second) = (across(q[0]) * qd[0], across(q[0] + q[1]) * (qd[0] + qd[1]));
    [first * arm.r1, first * arm.l1 + second * arm.r2]
}

/// Δq̇/h of one engine step.
fn engine_acceleration(
    arm: &Reach2R,
    q: Vector2<f64>,
    qd: Vector2<f64>,
    u: Vector2<f64>,
    h: f64,
) -> Vector2<f64> {
    let mut engine = EngineArm::new(arm, q, qd, u, h);
    engine.step();
    (engine.velocity() - qd) / h
}

/// The largest difference between the links' headings along a run, modulo a full turn \[rad\].
fn worst_heading_difference(
    arm: &Reach2R,
    start: (Vector2<f64>, Vector2<f64>),
    u: Vector2<f64>,
    h: f64,
    steps: usize,
) -> f64 {
    let (mut q, mut qd) = start;
    let mut engine = EngineArm::new(arm, q, qd, u, h);
    let mut worst: f64 = 0.0;
    for _ in 0..steps {
        engine.step();
        (q, qd) = rk4_step(arm, &q, &qd, &u, h).unwrap();
        for (found, expected) in engine.headings().into_iter().zip([q[0], q[0] + q[1]]) {
            let turn = found - expected;
            worst = worst.max(turn.sin().atan2(turn.cos()).abs());
        }
    }
    worst
}

/// One step of 1e-4 s and runs of 2 s.
///
/// The engine's step is of first order: Δq̇/h differs from q̈ by h times the change of q̈, whatever the size
/// of q̈. The tolerance is therefore 1e-3 relative for ‖q̈‖ ≥ 5 rad/s². For every state, the step sizes h and
/// h/2 are also extrapolated to h = 0. That removes the first order and leaves 3e-7; the tolerance is 1e-6.
#[test]
fn arm_matches_rapier() {
    let arm = Reach2R::worked_example();
    let mut compared = 0;
    for state in States::<2>::new(20).count(1000).iter() {
        let (q, qd, u) = (state.q, state.qd, state.u);
        let expected = arm.forward(&q, &qd, &u);
        let coarse = engine_acceleration(&arm, q, qd, u, 1e-4);
        let fine = engine_acceleration(&arm, q, qd, u, 5e-5);
        let relative = |found: Vector2<f64>| (found - expected).norm() / expected.norm();
        if expected.norm() >= 5.0 {
            compared += 1;
            assert!(relative(coarse) < 1e-3, "{:e} at state {} of seed 20", relative(coarse), state.index);
        }
        let limit = relative(fine * 2.0 - coarse);
        assert!(limit < 1e-6, "{limit:e} as h → 0 at state {} of seed 20: {state:?}", state.index);
    }
    assert!(compared > 900, "only {compared} of 1000 states accelerate by 5 rad/s² or more");

    let pose = vector![FRAC_PI_4, FRAC_PI_2];
    let runs = [
        ("from rest", vector![0.0, 0.0], vector![0.0, 0.0]),
        ("thrown", vector![1.0, -2.0], vector![0.0, 0.0]),
        ("driven", vector![0.0, 0.0], vector![10.0, 2.0]),
    ];
    let falls = |(name, qd, u): (&str, Vector2<f64>, Vector2<f64>)| {
        let worst = worst_heading_difference(&arm, (pose, qd), u, 1e-4, 20_000);
        assert!(worst < 1e-2, "{name}: {worst:e} rad over 2 s");
        // First order again: half the step, half the difference. The error is that of the engine.
        let finer = worst_heading_difference(&arm, (pose, qd), u, 5e-5, 40_000);
        assert!((worst / finer - 2.0).abs() < 0.1, "{name}: {worst:e} rad, with half the step {finer:e} rad");
    };
    // A panic in a thread is passed on.
    thread::scope(|scope| {
        for run in runs {
            scope.spawn(move || falls(run));
        }
    });
}
