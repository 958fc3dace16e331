//! The functions that make objects.

use std::ptr::{null, null_mut};

use robot_dynamics_c::Status;
use robot_dynamics_c::batch::*;
use robot_dynamics_c::constraints::*;
use robot_dynamics_c::control::observer::*;
use robot_dynamics_c::control::task::*;
use robot_dynamics_c::control::*;
use robot_dynamics_c::identification::*;
use robot_dynamics_c::load::*;
use robot_dynamics_c::model::*;
use robot_dynamics_c::optimal::mpc::*;
use robot_dynamics_c::optimal::solution::SolverOptionsC;
use robot_dynamics_c::optimal::*;
use robot_dynamics_c::simulation::snapshots::*;
use robot_dynamics_c::simulation::*;
use robot_dynamics_c::workspace::*;

use crate::memory::*;

/// Makes an object with a function, and keeps it.
macro_rules! kept {
    ($f:ident, $kind:ident, $handle:ident, $function:ident($($argument:expr),* $(,)?)) => {{
        let mut made = $handle { id: 0 };
        let out: *mut $handle = if $f.chance(3) { null_mut() } else { &raw mut made };
        // SAFETY: the arguments are as the interface allows.
        let status = unsafe { $function($($argument,)* out) };
        (stringify!($function), $f.keep($kind, status, made.id))
    }};
}

/// Makes an object, or fails.
pub(crate) fn make(f: &mut Fuzz) -> (&'static str, Status) {
    match f.below(26) {
        0 | 1 => kept!(f, WORKSPACE, WorkspaceHandle, rd_workspace_new(f.model())),
        2 | 3 => kept!(f, BATCH, BatchHandle, rd_batch_new(f.model(), threads(f))),
        4 | 5 => kept!(f, CONSTRAINTS, ConstraintsHandle, rd_constraints_from_file(f.model())),
        6 => supports(f),
        7..10 => simulation(f),
        10 | 11 => kept!(f, SNAPSHOT, SnapshotHandle, rd_simulation_snapshot(f.simulation())),
        12 | 13 => {
            let (kp, n) = (f.input(f.nv), f.len);
            kept!(f, TORQUE, ComputedTorqueHandle, rd_computed_torque_new(f.model(), kp, n, kp, n, f.flag()))
        }
        14 | 15 => task(f),
        16 | 17 => {
            let (gains, n) = (f.input(f.nv), f.len);
            kept!(
                f,
                OBSERVER,
                MomentumObserverHandle,
                rd_momentum_observer_new(f.model(), gains, n, f.flag())
            )
        }
        18 => {
            let terms = f.index(16);
            kept!(f, RECORD, MotionRecordHandle, rd_motion_record_new(f.model(), f.flag(), terms))
        }
        19 | 20 => problem(f),
        21 => {
            let (x, n, nodes) = (f.x(), f.len, f.end(2));
            kept!(
                f,
                PROBLEM,
                ProblemHandle,
                rd_problem_from_simulation(f.simulation(), f.flag(), nodes, x, n)
            )
        }
        22..24 => {
            let solver = SolverOptionsC { max_iterations: 1, threads: f.count(2), ..Default::default() };
            let budget = if f.chance(80) { 0.0 } else { f.number() };
            let options = f.always_options(solver);
            kept!(f, MPC, MpcHandle, rd_mpc_new(f.problem(), options, 1 + f.below(2), budget))
        }
        24 => load(f),
        _ => files(f),
    }
}

/// A number of threads; starting two takes long.
fn threads(f: &mut Fuzz) -> usize {
    if f.chance(98) { f.below(2) } else { f.count(2) }
}

fn supports(f: &mut Fuzz) -> (&'static str, Status) {
    let frames = f.frames(2, f.frames);
    if f.flag() == 0 {
        let (points, n) = (f.input(6), f.len);
        kept!(f, CONSTRAINTS, ConstraintsHandle, rd_constraints_at_points(f.model(), frames, 2, points, n))
    } else {
        let (poses, n) = (f.input(24), f.len);
        kept!(f, CONSTRAINTS, ConstraintsHandle, rd_constraints_at_poses(f.model(), frames, 2, poses, n))
    }
}

fn simulation(f: &mut Fuzz) -> (&'static str, Status) {
    let methods = [c"rk4", c"implicit", c"mujoco", c"semi-implicit-euler", c"dopri5", c"rk5", c"\xff"];
    let method = if f.chance(40) { null() } else { f.text(&methods) };
    let options = SimulationOptionsC {
        dt: if f.chance(50) { 0.0 } else { f.positive() },
        method,
        conservative: f.flag(),
        without: if f.chance(70) {
            null()
        } else {
            f.text(&[c"dissipation", c"limits, contacts", c"wind,,"])
        },
        has_ground: f.flag(),
        ground_height: f.number(),
        ground_friction: f.number(),
        ground_restitution: if f.chance(70) { 0.0 } else { f.number() },
    };
    let options = f.options(options);
    kept!(f, SIMULATION, SimulationHandle, rd_simulation_new(f.model(), options))
}

fn task(f: &mut Fuzz) -> (&'static str, Status) {
    let (posture, n) = if f.chance(50) { (null(), 0) } else { (f.q(), f.len) };
    let (frame, kind) = (f.index(f.frames), f.flag());
    let [stiffness, damping, null_damping, posture_stiffness] = [(); 4].map(|()| f.number().abs());
    kept!(
        f,
        TASK,
        TaskControlHandle,
        rd_task_control_new(
            f.model(),
            frame,
            kind,
            stiffness,
            damping,
            null_damping,
            posture,
            n,
            posture_stiffness
        )
    )
}

fn problem(f: &mut Fuzz) -> (&'static str, Status) {
    let integrator = f.text(&[c"rk4", c"semi-implicit-euler", c"implicit-midpoint", c"euler"]);
    let (dt, lossy, nodes) = (f.positive(), f.flag(), f.end(2));
    let (x, n) = (f.x(), f.len);
    kept!(f, PROBLEM, ProblemHandle, rd_problem_new(f.model(), integrator, dt, lossy, nodes, x, n))
}

/// A text of a robot's file.
const TEXTS: &[&std::ffi::CStr] = &[
    c"<robot name='rigid'><link name='base'/></robot>",
    c"<robot name='open'><link name='base'/>",
    c"<mujoco><worldbody><body><joint/><geom size='1'/></body></worldbody></mujoco>",
    c"<mujoco><worldbody><body><joint axis='0 0 0'/><geom size='-1'/></body></worldbody></mujoco>",
    c"",
    c"\xff\xfe",
    c"<sdf version='1.9'/>",
    c"#usda 1.0",
];

fn load_options(f: &mut Fuzz) -> *const LoadOptionsC {
    let options = LoadOptionsC {
        floating_base: f.flag(),
        strict: f.flag(),
        repair_inertia: f.flag(),
        confined: f.flag(),
        package_path: if f.chance(80) { null() } else { c"no/such/folder".as_ptr() },
        srdf: if f.chance(90) { null() } else { c"no/such/file".as_ptr() },
    };
    f.options(options)
}

fn load(f: &mut Fuzz) -> (&'static str, Status) {
    let options = load_options(f);
    if f.chance(20) {
        let path = f.text(&[c"no/such/robot.urdf", c"", c"/", c"\xff"]);
        return kept!(f, MODEL, ModelHandle, rd_load(path, options));
    }
    let text = f.text(TEXTS);
    kept!(f, MODEL, ModelHandle, rd_load_text(text, options))
}

fn files(f: &mut Fuzz) -> (&'static str, Status) {
    let text = TEXTS[f.below(TEXTS.len())].to_bytes();
    let paths = [c"a.urdf", c"b/c.xml", c""];
    let content = if f.chance(5) { null() } else { text.as_ptr() };
    let length = if f.chance(3) { usize::MAX } else { text.len() };
    let file = FileC { path: f.text(&paths), content, length };
    let (count, path, options) = (f.below(2), f.text(&paths), load_options(f));
    let files = f.always_options(file);
    kept!(f, MODEL, ModelHandle, rd_load_files(files, count, path, options))
}
