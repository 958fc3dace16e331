//! A workspace, a frame or a set of constraints of another robot is refused with its name: numbers computed with it would
//! look right.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

use multibody::batch::{self, BatchWorkspace};
use multibody::{
    Closure, ConstraintSet, ConstraintSetError, FrameId, Input, Inputs, InstructionSet, Model, Quantity,
    QuantityMemory, RandomRobotOptions, RobotDescription, Workspace, frame_jacobian_world_aligned,
    frame_pose, gravity, kinetic_energy, mass_matrix, mass_rank, neutral, random_robot,
};

fn model(description: RobotDescription) -> Model {
    Model::new(description).unwrap_or_else(|error| panic!("{error}"))
}

/// Two robots of the same joints and links, one of them heavier.
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
        Ok(_) => panic!("it was taken"),
        Err(panic) => *panic.downcast::<String>().expect("a message"),
    }
}

fn last_frame(model: &Model) -> FrameId {
    let frames = model.frames();
    model.frame(&frames[frames.len() - 1].name).expect("a frame of the model")
}

#[test]
fn a_workspace_of_another_robot_is_refused_with_both_names() {
    let (light, heavy) = twins();
    let (q, nv) = (neutral(&light), light.nv());
    let v = vec![0.1; nv];
    let mut foreign = Workspace::new(&heavy);
    let mut portable = Workspace::limited(&heavy, InstructionSet::Portable);
    let expected = "the workspace is for robot `heavy`, not for `light`: make one for this model";
    let mut out = vec![0.0; nv * nv];
    for foreign in [&mut foreign, &mut portable] {
        assert_eq!(message(|| gravity(&light, foreign, &q, &mut out[..nv])), expected);
        assert_eq!(message(|| mass_matrix(&light, foreign, &q, &mut out)), expected);
        assert_eq!(message(|| kinetic_energy(&light, foreign, &q, &v)), expected);
        assert_eq!(message(|| mass_rank(&light, foreign, &q)), expected);
    }
    let mut foreign = BatchWorkspace::<f64>::new(&heavy);
    let found = message(|| batch::gravity(&light, &mut foreign, &q, &mut out[..nv]));
    assert_eq!(found, expected.replace("the workspace", "the batch's workspace"));
}

#[test]
fn a_frame_of_another_robot_is_refused() {
    let (light, heavy) = twins();
    let (q, frame) = (neutral(&light), last_frame(&heavy));
    let mut workspace = Workspace::new(&light);
    let expected = "the frame is another robot's, not one of `light`: look it up by name in this model";
    assert_eq!(message(|| frame_pose(&light, &mut workspace, &q, frame)), expected);
    let mut jacobian = vec![0.0; 6 * light.nv()];
    let call = || frame_jacobian_world_aligned(&light, &mut workspace, &q, frame, &mut jacobian);
    assert_eq!(message(call), expected);
    let set = ConstraintSet::new(&light, [("pin", Closure::point_contact(frame, [0.0; 3]).into())]);
    let foreign = ConstraintSetError::ForeignFrame { constraint: "pin".into(), robot: "light".into() };
    assert_eq!(set, Err(foreign));
}

#[test]
fn a_constraint_set_of_another_robot_is_refused_with_both_names() {
    let (light, heavy) = twins();
    let pin = Closure::point_contact(last_frame(&heavy), [0.0; 3]);
    let set = ConstraintSet::new(&heavy, [("pin", pin.into())]).expect("a set of the heavy robot");
    let (q, v) = (neutral(&light), vec![0.0; light.nv()]);
    let found = message(|| set.rows(&light, &mut Workspace::new(&light), &q, &v));
    assert_eq!(found, "the constraint set is for robot `heavy`, not for `light`: make one for this model");
}

#[test]
fn clones_and_equal_descriptions_are_the_same_robot() {
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

/// Where the panics of this thread were raised.
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

/// A wrong argument of any row of the table of algorithms is blamed on the line that gave it.
#[test]
fn wrong_arguments_are_blamed_on_the_caller() {
    let (light, heavy) = twins();
    let (q, x) = (neutral(&light), vec![0.1; light.nv()]);
    let (own, foreign) = ([last_frame(&light)], [last_frame(&heavy)]);
    let right = Inputs { q: &q, v: &x, a: &x, tau: &x, frames: &own };
    let mut memory = QuantityMemory::new(&light);
    let mut blamed = 0;
    for quantity in Quantity::ALL {
        let mut wrong = vec![("q has", Inputs { q: &q[1..], ..right })];
        if quantity.reads(Input::Velocity) {
            wrong.push(("v has", Inputs { v: &x[1..], ..right }));
        }
        if quantity.reads(Input::Acceleration) {
            wrong.push(("a has", Inputs { a: &x[1..], ..right }));
        }
        if quantity.reads(Input::Force) {
            wrong.push(("tau has", Inputs { tau: &x[1..], ..right }));
        }
        if quantity.reads(Input::Frame) {
            wrong.push(("the frame is another robot's", Inputs { frames: &foreign, ..right }));
        }
        let mut cases: Vec<_> =
            wrong.into_iter().map(|(says, inputs)| (says, inputs, Workspace::new(&light))).collect();
        cases.push(("`heavy`", right, Workspace::new(&heavy)));
        for (says, inputs, mut workspace) in cases {
            let (text, place) =
                location_of(|| quantity.compute(&light, &mut workspace, &inputs, &mut memory));
            assert!(text.contains(says), "{}: {text}", quantity.name());
            assert!(place.ends_with("foreign_objects.rs"), "{}: {text}: {place}", quantity.name());
            blamed += 1;
        }
    }
    assert!(blamed > 50, "only {blamed} cases");
}
