//! A trot of a quadruped with phases of held feet, impacts, and friction pyramids.

use std::sync::Arc;

use robot_dynamics::algorithms::{ReferenceFrame, frame_pose, frame_velocity};
use robot_dynamics::constraints::{ConstraintSet, FrameConstraint, RowFeedback};
use robot_dynamics::control::optimal::{
    Activation, ActuationMatrix, ContactForceResidual, ControlResidual, Cost, DiscreteDynamics, Fddp,
    FddpOptions, FrameTranslationResidual, HeldContactStep, ImpactStep, LeastSquares, Problem, StateResidual,
};
use robot_dynamics::description::Pose;
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::{LoadOptions, load_with};

const QUADRUPED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/quadruped.urdf");
const FEET: [&str; 4] = ["front_left_foot", "front_right_foot", "hind_left_foot", "hind_right_foot"];
const FRICTION: f64 = 0.7;
const STEP: f64 = 0.02;
/// The nodes of a swing, and of a stand.
const SWING: usize = 6;
const STAND: usize = 2;

struct Trot {
    model: Arc<Model>,
    x0: Vec<f64>,
    feet: [[f64; 3]; 4],
}

impl Trot {
    fn new() -> Self {
        let options = LoadOptions::default().with_floating_base();
        let model = load_with(QUADRUPED, &options).expect("a quadruped").model;
        let legs = [0.0, 0.7, -1.4].repeat(4);
        let mut x0 = [&[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0][..], &legs, &[0.0; 18]].concat();
        let w = &mut Workspace::new(&model);
        let mut feet = FEET.map(|name| {
            frame_pose(&model, w, &x0[..19], model.frame_named(name).expect("a foot")).translation
        });
        // The feet stand on the ground.
        let height = -feet[0][2];
        x0[2] = height;
        for foot in &mut feet {
            foot[2] += height;
        }
        Self { model: Arc::new(model), x0, feet }
    }

    fn set(&self, feet: &[usize]) -> ConstraintSet {
        let hold = |&foot: &usize| {
            let frame = self.model.frame_named(FEET[foot]).expect("a foot");
            (FEET[foot], FrameConstraint::contact(frame, Pose::IDENTITY, &FrameConstraint::BALL).into())
        };
        ConstraintSet::new(&self.model, feet.iter().map(hold)).expect("a set")
    }

    fn held(&self, feet: &[usize]) -> HeldContactStep {
        let feedback = RowFeedback { position: 0.0, velocity: 50.0 };
        let step = HeldContactStep::new(self.model.clone(), &self.set(feet), feedback, STEP).expect("a step");
        step.with_actuation(ActuationMatrix::actuated(&self.model)).expect("motors")
    }

    fn state_cost(&self, cost: &mut Cost, scale: f64) {
        let space = robot_dynamics::control::optimal::StateSpace::robot(self.model.clone());
        let weights: Vec<f64> = [[0.0; 3], [500.0; 3]].concat().into_iter().chain([0.01; 12]).collect();
        let weights = weights.into_iter().chain([10.0; 6]).chain([1.0; 12]).map(|w| scale * w * w);
        let state = StateResidual::new(&space, &self.x0).expect("a state");
        cost.add(state, weights.collect::<Vec<_>>()).expect("weights");
    }

    /// The pyramids of the forces of `forces`, which is the step of the node or one that equals it.
    fn running(&self, forces: &HeldContactStep, feet: usize, swings: &[(usize, [f64; 3])]) -> Cost {
        let mut cost = Cost::new();
        self.state_cost(&mut cost, 10.0 * STEP);
        cost.add(ControlResidual::new(&[0.0; 12]).expect("controls"), 0.1 * STEP).expect("weights");
        for foot in 0..feet {
            let rows = [3 * foot, 3 * foot + 1, 3 * foot + 2];
            let cone = ContactForceResidual::friction_pyramid(forces, rows, FRICTION).expect("rows");
            let barrier = Activation::QuadraticBarrier { lower: vec![0.0; 5], upper: vec![f64::INFINITY; 5] };
            let cone = LeastSquares::new(cone, 10.0 * STEP).and_then(|term| term.with_activation(barrier));
            cost.add_term(cone.expect("weights"));
        }
        self.track(&mut cost, swings, 1e6 * STEP);
        cost
    }

    fn track(&self, cost: &mut Cost, swings: &[(usize, [f64; 3])], weight: f64) {
        for &(foot, target) in swings {
            let frame = self.model.frame_named(FEET[foot]).expect("a foot");
            let place = FrameTranslationResidual::new(self.model.clone(), frame, target).expect("a place");
            cost.add(place, weight).expect("weights");
        }
    }

    /// Stand, swing two feet, impact, stand. With `shares`, force residuals are those of the nodes' steps.
    fn problem(&self, shares: bool) -> Problem {
        let of = |step: &HeldContactStep, feet: &[usize]| if shares { step.clone() } else { self.held(feet) };
        let (all, support, swing) = ([0, 1, 2, 3], [0, 3], [1, 2]);
        let (stand, held) = (self.held(&all), self.held(&support));
        let nodes = 2 * STAND + SWING + 1;
        let mut problem = Problem::new(stand.clone(), &self.x0, nodes).expect("a problem");
        problem.set_dynamics(STAND..STAND + SWING, held.clone()).expect("nodes");
        let touchdown = STAND + SWING;
        let impact = ImpactStep::new(self.model.clone(), &self.set(&swing), 0.0).expect("an impact");
        problem.set_dynamics(touchdown..touchdown + 1, impact).expect("nodes");
        let standing = || self.running(&of(&stand, &all), 4, &[]);
        problem.set_running_cost(0..STAND, standing()).expect("a cost");
        problem.set_running_cost(touchdown + 1..nodes, standing()).expect("a cost");
        let at = |share: f64, height: f64| {
            swing.map(|foot| {
                let [x, y, z] = self.feet[foot];
                (foot, [x + 0.08 * share, y, z + height])
            })
        };
        for k in 0..SWING {
            let share = (k + 1) as f64 / SWING as f64;
            let targets = at(share, 0.05 * (std::f64::consts::PI * share).sin());
            let cost = self.running(&of(&held, &support), 2, &targets);
            problem.set_running_cost(STAND + k..STAND + k + 1, cost).expect("a cost");
        }
        let (mut landing, mut terminal) = (Cost::new(), Cost::new());
        self.track(&mut landing, &at(1.0, 0.0), 1e7);
        self.state_cost(&mut landing, 10.0);
        self.state_cost(&mut terminal, 10.0);
        problem.set_running_cost(touchdown..touchdown + 1, landing).expect("a cost");
        problem.set_terminal_cost(terminal).expect("a cost");
        problem
    }

    fn solve(&self, shares: bool) -> Fddp {
        let mut solver = Fddp::new(self.problem(shares), FddpOptions::default()).expect("options");
        let report = solver.solve().expect("a solution");
        assert!(report.is_solved(), "{report:?} {:#?}", solver.log());
        solver
    }
}

/// The feet land at their targets without slipping before or after, and all forces are within friction.
#[test]
fn a_trot_lands_its_feet() {
    let trot = Trot::new();
    let solver = trot.solve(true);
    let w = &mut Workspace::new(&trot.model);
    let (before, landed) = (solver.state(STAND + SWING), solver.state(STAND + SWING + 1));
    for (foot, name) in FEET.into_iter().enumerate() {
        let frame = trot.model.frame_named(name).expect("a foot");
        let place = frame_pose(&trot.model, w, &landed[..19], frame).translation;
        let [x, _, z] = trot.feet[foot];
        let moved = if [1, 2].contains(&foot) { 0.08 } else { 0.0 };
        // A weight of 1e7 on the place stands against weights of at most 2.5e6 on the trunk.
        assert!((place[0] - x - moved).abs() < 5e-3 && (place[2] - z).abs() < 5e-3, "{name}: {place:?}");
        let axes = ReferenceFrame::LocalWorldAligned;
        let speed = |w: &mut Workspace, x: &[f64]| {
            let twist = frame_velocity(&trot.model, w, &x[..19], &x[19..], frame, axes);
            twist.linear.iter().map(|v| v * v).sum::<f64>().sqrt()
        };
        if [1, 2].contains(&foot) {
            // The impact stops the feet, which moved.
            assert!(speed(w, landed) < 1e-12 && speed(w, before) > 1e-2, "{name}");
        } else {
            // Feedback removes the error of a step of 20 ms, about h² a half.
            assert!(speed(w, before) < 1e-2, "{name}: {}", speed(w, before));
        }
    }
    let mut held = trot.held(&[0, 3]);
    for node in STAND..STAND + SWING {
        held.step(solver.state(node), solver.control(node), &mut trot.x0.clone()).expect("a step");
        let forces = held.contact_forces().expect("forces");
        for force in forces.multipliers.chunks_exact(3) {
            // The barrier is soft: a force may leave the pyramid by a few newtons.
            assert!(force[0].hypot(force[1]) < FRICTION * force[2] * 2.0_f64.sqrt() + 5.0, "{force:?}");
        }
    }
}

/// Forces that a residual reads from its node are those that it would compute.
#[test]
fn shared_forces_change_no_bit() {
    let trot = Trot::new();
    let [shared, own] = [true, false].map(|shares| trot.solve(shares));
    assert_eq!(shared.log(), own.log());
    let last = 2 * STAND + SWING + 1;
    assert_eq!(shared.state(last), own.state(last));
}
