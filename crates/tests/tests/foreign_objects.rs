//! Workspaces, frames and constraint sets are tied to one robot. Using one with another robot panics, because
//! the results would be wrong but plausible.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

use robot_dynamics::algorithms::{
    ReferenceFrame, frame_jacobian, frame_pose, gravity, kinetic_energy, mass_matrix, mass_rank,
};
use robot_dynamics::batch;
use robot_dynamics::batch::BatchWorkspace;
use robot_dynamics::constraints::{ConstraintError, ConstraintSet, FrameConstraint};
use robot_dynamics::description::{RandomRobotOptions, RobotDescription, random_robot};
use robot_dynamics::model::{FrameId, InstructionSet, Model, Workspace, neutral};
use robot_dynamics::quantity::{Input, Inputs, Quantity, QuantityMemory};

fn model(description: RobotDescription) -> Model {
    Model::new(description).unwrap_or_else(|error| panic!("{error}"))
}

/// Two robots with the same joints and links; one of them is heavier.
fn twins() -> (Model, Model) {
    let mut light = random_robot(3, &RandomRobotOptions::default());
    light.name = "light".into();
    let mut heavy = light.clone();
    heavy.name = "heavy".into();
    for link in &mut heavy.links {
        if let Some(properties) = &mut link.mass_properties {
            let twice = properties.combine(properties);
            *properties = twice;
        }
    }
    (model(light), model(heavy))
}

fn message<T>(call: impl FnOnce() -> T) -> String {
    match catch_unwind(AssertUnwindSafe(call)) {
        Ok(_) => panic!("the call returns"),
        Err(panic) => *panic.downcast::<String>().expect("a message"),
    }
}

const BOTH: &[&str] = &["heavy", "light"];

/// Asserts that a panic names these robots.
#[track_caller]
fn assert_names(message: &str, robots: &[&str]) {
    for robot in robots {
        assert!(message.contains(&format!("`{robot}`")), "{message}");
    }
}

fn last_frame(model: &Model) -> FrameId {
    let frames = model.frames();
    model.frame(&frames[frames.len() - 1].name).expect("a frame of the model")
}

#[test]
fn workspace_of_another_robot_panics() {
    let (light, heavy) = twins();
    let (q, nv) = (neutral(&light), light.nv());
    let v = vec![0.1; nv];
    let mut foreign = Workspace::new(&heavy);
    let mut portable = Workspace::limited(&heavy, InstructionSet::Portable);
    let mut out = vec![0.0; nv * nv];
    for foreign in [&mut foreign, &mut portable] {
        assert_names(&message(|| gravity(&light, foreign, &q, &mut out[..nv])), BOTH);
        assert_names(&message(|| mass_matrix(&light, foreign, &q, &mut out)), BOTH);
        assert_names(&message(|| kinetic_energy(&light, foreign, &q, &v)), BOTH);
        assert_names(&message(|| mass_rank(&light, foreign, &q)), BOTH);
    }
    let mut foreign = BatchWorkspace::<f64>::new(&heavy);
    assert_names(&message(|| batch::gravity(&light, &mut foreign, &q, &mut out[..nv])), BOTH);
}

#[test]
fn frame_of_another_robot_panics() {
    let (light, heavy) = twins();
    let (q, frame) = (neutral(&light), last_frame(&heavy));
    let mut workspace = Workspace::new(&light);
    assert_names(&message(|| frame_pose(&light, &mut workspace, &q, frame)), &["light"]);
    let mut jacobian = vec![0.0; 6 * light.nv()];
    let call = || {
        frame_jacobian(&light, &mut workspace, &q, frame, ReferenceFrame::LocalWorldAligned, &mut jacobian);
    };
    assert_names(&message(call), &["light"]);
    let set = ConstraintSet::new(&light, [("pin", FrameConstraint::point_contact(frame, [0.0; 3]).into())]);
    let foreign = ConstraintError::ForeignFrame { constraint: "pin".into(), robot: "light".into() };
    assert_eq!(set, Err(foreign));
}

#[test]
fn constraint_set_of_another_robot_panics() {
    let (light, heavy) = twins();
    let pin = FrameConstraint::point_contact(last_frame(&heavy), [0.0; 3]);
    let set = ConstraintSet::new(&heavy, [("pin", pin.into())]).expect("a set of the heavy robot");
    let (q, v) = (neutral(&light), vec![0.0; light.nv()]);
    assert_names(&message(|| set.rows(&light, &mut Workspace::new(&light), &q, &v)), BOTH);
}

#[test]
fn clones_and_equal_descriptions_share_workspaces() {
    let (light, _) = twins();
    let again = model(light.description().clone());
    let (q, mut g) = (neutral(&light), vec![0.0; light.nv()]);
    let mut workspace = Workspace::new(&light);
    gravity(&light, &mut workspace, &q, &mut g);
    let mut same = vec![0.0; light.nv()];
    for other in [&light.clone(), &again] {
        gravity(other, &mut workspace, &q, &mut same);
        assert_eq!(g, same);
        frame_pose(other, &mut workspace, &q, last_frame(&light));
    }
}

/// The location of the panic of this thread.
fn location_of(call: impl FnOnce()) -> (String, String) {
    thread_local! {
        static PLACE: Cell<Option<String>> = const { Cell::new(None) };
    }
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = take_hook();
        set_hook(Box::new(move |info| {
            PLACE.set(info.location().map(|place| place.file().to_owned()));
            before(info);
        }));
    });
    let text = message(call);
    (text, PLACE.take().unwrap_or_default())
}

/// A wrong argument of any quantity panics with the location of the caller.
#[test]
fn panics_of_wrong_arguments_point_at_the_caller() {
    let (light, heavy) = twins();
    let (q, x) = (neutral(&light), vec![0.1; light.nv()]);
    let (own, foreign) = ([last_frame(&light)], [last_frame(&heavy)]);
    let right = Inputs { q: &q, v: &x, a: &x, tau: &x, frames: &own };
    let mut memory = QuantityMemory::new(&light);
    let mut checked = 0;
    for quantity in Quantity::ALL {
        let mut wrong = vec![("q", Inputs { q: &q[1..], ..right })];
        if quantity.reads(Input::Velocity) {
            wrong.push(("v", Inputs { v: &x[1..], ..right }));
        }
        if quantity.reads(Input::Acceleration) {
            wrong.push(("a", Inputs { a: &x[1..], ..right }));
        }
        if quantity.reads(Input::Force) {
            wrong.push(("tau", Inputs { tau: &x[1..], ..right }));
        }
        if quantity.reads(Input::Frame) {
            wrong.push(("`light`", Inputs { frames: &foreign, ..right }));
        }
        // The name of the argument or of the robot.
        let mut cases: Vec<_> =
            wrong.into_iter().map(|(name, inputs)| (name, inputs, Workspace::new(&light))).collect();
        cases.push(("`heavy`", right, Workspace::new(&heavy)));
        for (name, inputs, mut workspace) in cases {
            let (text, place) =
                location_of(|| quantity.compute(&light, &mut workspace, &inputs, &mut memory));
            assert!(
                text.split(' ').any(|word| word.trim_matches([',', ':']) == name),
                "{}: {text}",
                quantity.name()
            );
            assert!(place.ends_with("foreign_objects.rs"), "{}: {text}: {place}", quantity.name());
            checked += 1;
        }
    }
    assert!(checked > 50, "only {checked} cases");
}
