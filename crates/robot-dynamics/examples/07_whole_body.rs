//! A quadruped that is pushed, leans, and lifts a foot.
//!
//! Whole-body control computes the motors' torques and the expected forces at the feet from one quadratic
//! program every 2 ms. A push of 40 N acts on the trunk from 0.2 s to 0.3 s. From 0.5 s to 1 s the centre of
//! mass moves over the other three feet; then the front left foot is released and rises by 5 cm. The example
//! prints how far the trunk moved, the height of the foot, and the loads that the simulator finds.
//!
//! `cargo run --release -p robot-dynamics --example 07_whole_body`
#![allow(dead_code)] // the tests do not call `main`

#[path = "plot/mod.rs"]
mod plot;

use std::error::Error;

use plot::{Axis, Figure, Line, Panel};
use robot_dynamics::algorithms::{center_of_mass, frame_pose};
use robot_dynamics::contact::Ground;
use robot_dynamics::control::whole_body::{
    ALL_AXES, ContactGeometry, ContactId, HeldContact, Objective, PdGains, TaskId, WholeBodyControl,
};
use robot_dynamics::control::{PoseReference, Reference, TaskReference};
use robot_dynamics::description::Base;
use robot_dynamics::model::{Model, Workspace, neutral};
use robot_dynamics::simulation::{AppliedWrench, SimulationBuilder};

const ROBOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/quadruped.urdf");
const FEET: [&str; 4] = ["front_left_foot", "front_right_foot", "hind_left_foot", "hind_right_foot"];

/// The radius of the feet \[m\], and the time between torques \[s\].
const RADIUS: f64 = 0.02;
const PERIOD: f64 = 2e-3;

/// The results that the example prints and draws.
pub(crate) struct Numbers {
    /// The largest displacement of the centre of mass by the push, and at 0.5 s \[m\].
    pub(crate) pushed: [f64; 2],
    /// The height of the lifted foot at the end \[m\].
    pub(crate) height: f64,
    /// The sum of the vertical contact forces of the simulator at the end, over the weight.
    pub(crate) carried: f64,
    /// Time, and the vertical force that the controller expects at each foot \[N\].
    pub(crate) loads: Vec<(f64, [f64; 4])>,
    /// Time, and the displacement of the centre of mass along x and y \[m\].
    pub(crate) paths: Vec<(f64, [f64; 2])>,
}

/// The controller with its handles.
struct Stance<'m> {
    control: WholeBodyControl<&'m Model>,
    feet: Vec<ContactId>,
    center: TaskId,
    swing: TaskId,
}

fn center_at(position: [f64; 3]) -> Objective {
    let reference = TaskReference { position, velocity: [0.0; 3], acceleration: [0.0; 3] };
    Objective::CenterOfMass { reference, gains: PdGains::critical(150.0) }
}

/// Contacts at all feet; tasks for the centre of mass, the trunk's orientation, the posture and a foot.
fn stance<'m>(model: &'m Model, q: &[f64]) -> Result<Stance<'m>, Box<dyn Error>> {
    let mut control = WholeBodyControl::new(model).with_dissipation();
    let mut feet = Vec::new();
    for foot in FEET {
        let contact = HeldContact::new(model.frame_named(foot)?, ContactGeometry::Ball(RADIUS));
        feet.push(control.add_contact(contact.with_friction(0.6, 8)?)?);
    }
    let (w, rest) = (&mut Workspace::new(model), vec![0.0; model.nv()]);
    let gains = PdGains::critical(150.0);
    let center = control.add_task(center_at(center_of_mass(model, w, q)), 10.0)?;
    let pose = |w: &mut Workspace, frame, axes: &[_]| Objective::FramePose {
        frame,
        axes: axes.to_vec(),
        reference: PoseReference::at_rest(frame_pose(model, w, q, frame)),
        gains,
    };
    control.add_task(pose(w, model.frame_named("trunk")?, &ALL_AXES[3..]), 5.0)?;
    // The foot follows its task after its release.
    let swing = control.add_task(pose(w, model.frame_named(FEET[0])?, &ALL_AXES[..3]), 0.0)?;
    let reference = Reference { q: q.to_vec(), v: rest.clone(), a: rest };
    control.add_task(Objective::Posture { reference, gains: PdGains::critical(50.0) }, 1e-3)?;
    control.add_task(Objective::ContactForces, 1e-6)?;
    Ok(Stance { control, feet, center, swing })
}

/// A smooth transition from 0 at `start` to 1 at `end`.
fn transition(t: f64, start: f64, end: f64) -> f64 {
    let s = ((t - start) / (end - start)).clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}

pub(crate) fn numbers() -> Result<Numbers, Box<dyn Error>> {
    let mut robot =
        robot_dynamics::load_description(ROBOT, &robot_dynamics::LoadOptions::default())?.description;
    robot.base = Base::Floating;
    let model = Model::new(robot)?;
    let (mut q, w) = (neutral(&model), &mut Workspace::new(&model));
    for leg in 0..4 {
        q[7 + 3 * leg..10 + 3 * leg].copy_from_slice(&[0.0, 0.7, -1.4]);
    }
    let foot = model.frame_named(FEET[0])?;
    q[2] += RADIUS - frame_pose(&model, w, &q, foot).translation[2];
    let home = center_of_mass(&model, w, &q);
    let Stance { mut control, feet, center, swing } = stance(&model, &q)?;
    let trunk = model.frame_named("trunk")?;
    let ground = Ground::through([0.0; 3], [0.0, 0.0, 1.0])?;
    let mut simulation = SimulationBuilder::new(&model).ground(ground).dt(PERIOD).build()?;
    simulation.set_state(&q, &vec![0.0; model.nv()])?;

    let (mut pushed, mut loads, mut paths) = ([0.0_f64; 2], Vec::new(), Vec::new());
    for step in 0..1000 {
        let t = f64::from(step) * PERIOD;
        let lean = 0.06 * transition(t, 0.5, 1.0);
        *control.objective_mut(center) = center_at([home[0] - lean, home[1] - lean, home[2]]);
        if t >= 1.1 {
            control.hold_contact(feet[0], false);
            control.set_weight(swing, 10.0)?;
            if let Objective::FramePose { reference, .. } = control.objective_mut(swing) {
                reference.pose.translation[2] = RADIUS + 0.05 * transition(t, 1.1, 1.5);
            }
        }
        let is_pushed = (0.2..0.3).contains(&t);
        let push = AppliedWrench::force(trunk, [0.0, 40.0, 0.0]);
        simulation.set_wrenches(if is_pushed { std::slice::from_ref(&push) } else { &[] });
        let solution = control.solve(simulation.q(), simulation.v())?;
        simulation.set_torques(&solution.torque);
        let mut load = [0.0; 4];
        solution.forces.iter().for_each(|point| load[point.contact.index()] += point.force[2]);
        loads.push((t, load));
        simulation.step()?;
        let now = center_of_mass(&model, w, simulation.q());
        let moved = [now[0] - home[0], now[1] - home[1]];
        if t < 0.5 {
            let distance = moved[0].hypot(moved[1]);
            pushed = [pushed[0].max(distance), distance];
        }
        paths.push((t, moved));
    }
    let height = frame_pose(&model, w, simulation.q(), foot).translation[2] - RADIUS;
    let force: f64 = simulation.contacts().iter().map(|contact| contact.force[2]).sum();
    Ok(Numbers { pushed, height, carried: force / (9.81 * model.mass()), loads, paths })
}

impl Numbers {
    pub(crate) fn figure(&self) -> Figure {
        let panel =
            |name: &str, lines| Panel { name: name.into(), axis: Axis::Linear, lines, limits: Vec::new() };
        let load = |k: usize| self.loads.iter().map(|(t, load)| (*t, load[k])).collect();
        let path = |k: usize| self.paths.iter().map(|(t, moved)| (*t, 1e3 * moved[k])).collect();
        let feet =
            FEET.iter().enumerate().map(|(k, foot)| Line::new(foot.replace('_', " "), load(k))).collect();
        let center = ["x", "y"].into_iter().enumerate().map(|(k, name)| Line::new(name, path(k))).collect();
        Figure {
            title: "A quadruped is pushed, leans, and lifts a foot".into(),
            across: "t [s]".into(),
            panels: vec![
                panel("Vertical force at each foot [N]", feet),
                panel("Centre of mass [mm]", center),
            ],
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let numbers = numbers()?;
    let Numbers { pushed: [most, left], height, carried, .. } = numbers;
    println!("centre of mass by the push          {:.2} mm; {:.2} mm at 0.5 s", 1e3 * most, 1e3 * left);
    println!("height of the lifted foot           {:.2} mm", 1e3 * height);
    println!("load that the simulator finds       {carried:.4} of the weight");
    numbers.figure().save("07_whole_body")
}
