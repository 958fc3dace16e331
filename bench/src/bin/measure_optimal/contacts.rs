//! Problems with held contacts: a trot of the quadruped and a reach of the humanoid, as those of
//! `bench/peers/crocoddyl_contacts.py`.

use std::error::Error;
use std::sync::Arc;

use robot_dynamics::algorithms::frame_pose;
use robot_dynamics::constraints::{ConstraintSet, FrameConstraint, RowFeedback};
use robot_dynamics::control::optimal::{
    Activation, ActuationMatrix, CenterOfMassResidual, ContactForceResidual, ControlResidual, Cost,
    FrameTranslationResidual, HeldContactStep, ImpactStep, LeastSquares, Problem, StateResidual, StateSpace,
};
use robot_dynamics::description::Pose;
use robot_dynamics::model::{Model, Workspace, neutral};
use robot_dynamics::{LoadOptions, load_with};

const ROBOTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../robots/");

/// The feedback on the velocity of held rows \[1/s\].
const FEEDBACK: RowFeedback = RowFeedback { position: 0.0, velocity: 50.0 };

/// A robot with a floating base that stands on its feet, at height 0.
struct Standing {
    model: Arc<Model>,
    x0: Vec<f64>,
    feet: Vec<(&'static str, [f64; 3])>,
    step: f64,
}

impl Standing {
    fn new(file: &str, joints: &[f64], feet: &[&'static str], step: f64) -> Result<Self, Box<dyn Error>> {
        let robot = load_with(format!("{ROBOTS}{file}"), &LoadOptions::default().with_floating_base())?;
        let model = Arc::new(robot.model);
        let mut q = neutral(&model);
        q[7..].iter_mut().zip(joints.iter().cycle()).for_each(|(q, joint)| *q = *joint);
        let w = &mut Workspace::new(&model);
        let mut places = Vec::new();
        for name in feet {
            places.push((*name, frame_pose(&model, w, &q, model.frame_named(name)?).translation));
        }
        let height = places[0].1[2];
        q[2] -= height;
        for (_, place) in &mut places {
            place[2] -= height;
        }
        q.resize(model.nq() + model.nv(), 0.0);
        Ok(Self { model, x0: q, feet: places, step })
    }

    fn set(&self, feet: &[usize], is_flat: bool) -> Result<ConstraintSet, Box<dyn Error>> {
        let mut held = Vec::new();
        for &foot in feet {
            let (name, place) = self.feet[foot];
            let frame = self.model.frame_named(name)?;
            let hold = if is_flat {
                FrameConstraint::contact(frame, Pose::from_translation(place), &FrameConstraint::WELD)
            } else {
                FrameConstraint::point_contact(frame, place)
            };
            held.push((name, hold.into()));
        }
        Ok(ConstraintSet::new(&self.model, held)?)
    }

    fn held(&self, feet: &[usize], is_flat: bool) -> Result<HeldContactStep, Box<dyn Error>> {
        let step = HeldContactStep::new(self.model.clone(), &self.set(feet, is_flat)?, FEEDBACK, self.step)?;
        Ok(step.with_actuation(ActuationMatrix::actuated(&self.model))?)
    }

    /// ½ Σ scale w² (x ⊖ x₀)², with weights of the base's rotation, the joints, and the velocities of both.
    fn state_cost(&self, cost: &mut Cost, scale: f64, weights: [f64; 5]) -> Result<(), Box<dyn Error>> {
        let joints = self.model.nv() - 6;
        let [place, rotation, joint, base_speed, speed] = weights;
        let all = [(place, 3), (rotation, 3), (joint, joints), (base_speed, 6), (speed, joints)];
        let weights: Vec<f64> = all.into_iter().flat_map(|(w, count)| vec![scale * w * w; count]).collect();
        cost.add(StateResidual::new(&StateSpace::robot(self.model.clone()), &self.x0)?, weights)?;
        Ok(())
    }

    fn track(
        &self,
        cost: &mut Cost,
        name: &str,
        target: [f64; 3],
        weight: f64,
    ) -> Result<(), Box<dyn Error>> {
        let frame = self.model.frame_named(name)?;
        cost.add(FrameTranslationResidual::new(self.model.clone(), frame, target)?, weight)?;
        Ok(())
    }
}

const TROT: [&str; 4] = ["front_left_foot", "front_right_foot", "hind_left_foot", "hind_right_foot"];
const STAND_NODES: usize = 2;
const SWING_NODES: usize = 17;

/// Weights of a phase, in the order of [`Standing::state_cost`].
const PHASE: [f64; 5] = [0.0, 500.0, 0.01, 10.0, 1.0];

/// The running cost of a phase, for feet that are held and feet that swing to places.
fn phase_cost(
    robot: &Standing,
    held: &HeldContactStep,
    feet: usize,
    com: Option<[f64; 3]>,
    swings: &[(&str, [f64; 3])],
) -> Result<Cost, Box<dyn Error>> {
    let (mut cost, h) = (Cost::new(), robot.step);
    if let Some(com) = com {
        cost.add(CenterOfMassResidual::new(robot.model.clone(), com)?, 1e6 * h)?;
    }
    for foot in 0..feet {
        let rows = [3 * foot, 3 * foot + 1, 3 * foot + 2];
        let pyramid = ContactForceResidual::friction_pyramid(held, rows, 0.7)?;
        let barrier = Activation::QuadraticBarrier { lower: vec![0.0; 5], upper: vec![f64::INFINITY; 5] };
        cost.add_term(LeastSquares::new(pyramid, 10.0 * h)?.with_activation(barrier)?);
    }
    for &(name, target) in swings {
        robot.track(&mut cost, name, target, 1e6 * h)?;
    }
    robot.state_cost(&mut cost, 10.0 * h, PHASE)?;
    cost.add(ControlResidual::new(&vec![0.0; held_controls(robot)])?, 0.1 * h)?;
    cost.add_term(state_bounds(robot)?);
    Ok(cost)
}

fn held_controls(robot: &Standing) -> usize {
    robot.model.nv() - 6
}

/// The limits of the joints' positions and velocities as barriers.
fn state_bounds(robot: &Standing) -> Result<LeastSquares, Box<dyn Error>> {
    let (model, inf) = (&robot.model, f64::INFINITY);
    let mut origin = neutral(model);
    origin.resize(robot.x0.len(), 0.0);
    let limits = &model.coordinate_limits()[6..];
    let base = vec![inf; 6];
    let upper = [base.clone(), limits.iter().map(|l| l.upper).collect()].concat();
    let upper = [upper, base.clone(), limits.iter().map(|l| l.velocity).collect()].concat();
    let low = vec![-inf; 6];
    let lower = [low.clone(), limits.iter().map(|l| l.lower).collect()].concat();
    let lower = [lower, low, limits.iter().map(|l| -l.velocity).collect()].concat();
    let residual = StateResidual::new(&StateSpace::robot(model.clone()), &origin)?;
    let term = LeastSquares::new(residual, 1e3 * robot.step)?;
    Ok(term.with_activation(Activation::QuadraticBarrier { lower, upper })?)
}

/// A trot of two steps: 40 nodes of 10 ms with held feet, and impacts where feet land.
pub(crate) fn trot() -> Result<Problem, Box<dyn Error>> {
    let (length, height) = (0.15, 0.1);
    let mut robot = Standing::new("quadruped.urdf", &[0.0, 0.7, -1.4], &TROT, 0.01)?;
    let all = [0, 1, 2, 3];
    let stand = robot.held(&all, false)?;
    let nodes = 2 * (STAND_NODES + SWING_NODES + 1);
    let mut problem = Problem::new(stand.clone(), &robot.x0, nodes)?;
    let w = &mut Workspace::new(&robot.model);
    let mut com = [0.0; 3];
    for (_, foot) in &robot.feet {
        (0..3).for_each(|i| com[i] += 0.25 * foot[i]);
    }
    com[2] = robot_dynamics::algorithms::center_of_mass(&robot.model, w, &robot.x0[..robot.model.nq()])[2];
    let mut node = 0;
    for (swing, support, length) in [([1, 2], [0, 3], 0.5 * length), ([0, 3], [1, 2], length)] {
        let standing = phase_cost(&robot, &stand, 4, None, &[])?;
        problem.set_running_cost(node..node + STAND_NODES, standing)?;
        node += STAND_NODES;
        let held = robot.held(&support, false)?;
        problem.set_dynamics(node..node + SWING_NODES, held.clone())?;
        let half = SWING_NODES as f64 / 2.0;
        let mut targets = Vec::new();
        for k in 0..SWING_NODES {
            let at = k as f64;
            let forward = length * (at + 1.0) / SWING_NODES as f64;
            let up = if at < half { height * at / half } else { height * (1.0 - (at - half) / half) };
            targets = swing
                .map(|foot| {
                    let (name, [x, y, z]) = robot.feet[foot];
                    (name, [x + forward, y, z + up])
                })
                .to_vec();
            let com = [com[0] + 0.5 * forward, com[1], com[2]];
            let cost = phase_cost(&robot, &held, 2, Some(com), &targets)?;
            problem.set_running_cost(node..node + 1, cost)?;
            node += 1;
        }
        problem.set_dynamics(
            node..node + 1,
            ImpactStep::new(robot.model.clone(), &robot.set(&swing, false)?, 0.0)?,
        )?;
        let mut landing = Cost::new();
        for &(name, target) in &targets {
            robot.track(&mut landing, name, target, 1e7)?;
        }
        robot.state_cost(&mut landing, 10.0, [1.0, 1.0, 10.0, 10.0, 10.0])?;
        problem.set_running_cost(node..node + 1, landing)?;
        node += 1;
        com[0] += 0.5 * length;
        for foot in swing {
            robot.feet[foot].1[0] += length;
        }
    }
    let mut terminal = Cost::new();
    robot.state_cost(&mut terminal, 10.0, PHASE)?;
    problem.set_terminal_cost(terminal)?;
    Ok(problem)
}

/// A reach of the humanoid's hand with both feet held flat: 40 nodes of 20 ms.
pub(crate) fn humanoid() -> Result<Problem, Box<dyn Error>> {
    let robot = Standing::new("humanoid.urdf", &[0.0], &["left_foot", "right_foot"], 0.02)?;
    let held = robot.held(&[0, 1], true)?;
    let mut problem = Problem::new(held, &robot.x0, 40)?;
    let w = &mut Workspace::new(&robot.model);
    let hand = "right_hand";
    let [x, y, z] =
        frame_pose(&robot.model, w, &robot.x0[..robot.model.nq()], robot.model.frame_named(hand)?)
            .translation;
    let (mut running, mut terminal) = (Cost::new(), Cost::new());
    let (target, h) = ([x + 0.3, y + 0.1, z + 0.4], robot.step);
    robot.track(&mut running, hand, target, 1e2 * h)?;
    robot.state_cost(&mut running, h, [0.0, 10.0, 0.3, 3.0, 0.3])?;
    running.add(ControlResidual::new(&vec![0.0; held_controls(&robot)])?, 1e-3 * h)?;
    robot.track(&mut terminal, hand, target, 1e4)?;
    robot.state_cost(&mut terminal, 1.0, [0.0, 10.0, 0.3, 3.0, 1.0])?;
    problem.set_running_cost(0..40, running)?;
    problem.set_terminal_cost(terminal)?;
    Ok(problem)
}
