//! A gripper with two fingers lifts a box from a table and holds it.
#![cfg(feature = "convex")]

use std::path::PathBuf;

use robot_dynamics::simulation::{Method, Simulation};
use robot_dynamics::{Robot, load};

/// The times at which the controls reach each named pose, by linear interpolation \[s\].
const PHASES: [(f64, &str); 2] = [(0.5, "closed"), (1.5, "lifted")];

/// The duration of each interpolation, and the end of the lift including settling \[s\].
const RAMP: f64 = 0.5;
const LIFTED: f64 = 4.0;

/// The number of steps between two checks of the corners.
const LOOKED: usize = 10;

/// Half an edge of the box \[m\].
const HALF: f64 = 0.025;

/// A box in the middle between the fingers, as in the file, keeps its position relative to both fingers.
#[test]
fn a_centred_box_is_held() {
    let robot = scene();
    let simulation = robot.simulation().build().unwrap();
    assert_eq!(simulation.method(), Method::Implicit);
    assert!(simulation.left_out().is_empty(), "{:?}", simulation.left_out());
    let (moved, end) = held(&robot, [0.0; 3], 10.0);
    assert!(moved < 1e-6, "{moved:e} m");
    // Each finger presses with kp (control − joint), and its friction carries half of the weight.
    let pressed = 1000.0 * (0.03 - 0.019);
    let sum = |finger: &str| {
        end.contacts()
            .iter()
            .filter(|touch| touch.link == finger)
            .fold([0.0; 3], |sum, touch| [0, 1, 2].map(|i| sum[i] + touch.force[i]))
    };
    for (finger, side) in [("left_finger", 1.0), ("right_finger", -1.0)] {
        let force = sum(finger);
        assert!((side * force[1] - pressed).abs() < 1e-3, "{finger}: {force:?}");
        assert!((force[2] + 0.5 * 0.2 * 9.81).abs() < 1e-6, "{finger}: {force:?}");
    }
}

/// A box that is displaced and rotated is first pushed, and then held at faces or edges. It does not creep
/// either.
#[test]
fn a_displaced_box_is_held() {
    let robot = scene();
    for start in [[0.003, 0.0, 0.0], [0.003, 0.004, 0.0], [0.003, 0.004, 0.15]] {
        let (moved, end) = held(&robot, start, 1.0);
        assert!(moved < 1e-6, "from {start:?}: {moved:e} m");
        assert!(end.q()[5] > 0.56, "it is held: {:?}", end.q());
    }
}

fn scene() -> Robot {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../robots/gripper_and_box.xml");
    load(path).unwrap()
}

/// Grips a box at x, y \[m\] with a rotation \[rad\], lifts it and holds it for a time \[s\]. Returns the
/// largest displacement of a corner relative to a finger while it was held \[m\], and the simulation at the
/// end.
fn held(robot: &Robot, [x, y, angle]: [f64; 3], duration: f64) -> (f64, Simulation) {
    let mut simulation = robot.simulation().build().unwrap();
    let (mut q, v) = robot.model.named_pose("open").unwrap();
    (q[3], q[4]) = (x, y);
    (q[8], q[9]) = (0.5 * angle).sin_cos();
    simulation.reset(&q, &v).unwrap();
    let (lifted, end) =
        (simulation.steps_in(LIFTED).unwrap(), simulation.steps_in(LIFTED + duration).unwrap());
    let mut start = Vec::new();
    let mut moved = 0.0_f64;
    for step in 0..end {
        let controls = controls(robot, simulation.time());
        simulation.set_controls(&controls);
        simulation.step().unwrap();
        if step + 1 == lifted {
            start = corners(&simulation);
        }
        if step % LOOKED != 0 {
            continue;
        }
        for (now, before) in corners(&simulation).iter().zip(&start) {
            let square: f64 = now.iter().zip(before).map(|(a, b)| (a - b) * (a - b)).sum();
            moved = moved.max(square.sqrt());
        }
    }
    println!("from {x}, {y}, {angle}: {moved:e} m");
    (moved, simulation)
}

fn controls(robot: &Robot, time: f64) -> Vec<f64> {
    let poses = &robot.model.description().poses;
    let of = |name: &str| &poses.iter().find(|pose| pose.name == name).unwrap().controls;
    let mut controls = of("open").clone();
    for (start, name) in PHASES {
        let share = ((time - start) / RAMP).clamp(0.0, 1.0);
        for (control, goal) in controls.iter_mut().zip(of(name)) {
            *control += share * (goal - *control);
        }
    }
    controls
}

/// The corners of the box in the frame of each finger \[m\].
fn corners(simulation: &Simulation) -> Vec<[f64; 3]> {
    let model = simulation.model();
    let pose = |name: &str| model.frame_pose(simulation.q(), model.frame_named(name).unwrap()).unwrap();
    let side = |bit: usize| if bit == 0 { -HALF } else { HALF };
    let all = (0..8).map(|k| [side(k & 1), side(k & 2), side(k & 4)]);
    let world_from_box = pose("box");
    let in_world: Vec<[f64; 3]> = all.map(|corner| world_from_box.apply(corner)).collect();
    let fingers = ["left_finger", "right_finger"].map(|finger| pose(finger).inverse());
    fingers.iter().flat_map(|finger| in_world.iter().map(|corner| finger.apply(*corner))).collect()
}
