//! The robots of the folder `robots`, and all functions of each.

use std::fs;
use std::path::{Path, PathBuf};

use robot_dynamics::description::{
    Base, JointKind, Limits, LinkShape, Pose, RandomRobotOptions, Shape, ShapeRole, random_robot,
};
use robot_dynamics::model::Model;
use robot_dynamics_generate::Function;

/// Every robot of the folder, with its file's name.
pub(crate) fn all() -> Vec<(String, Model)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots");
    let mut paths: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let name = |path: &Path| path.file_name().unwrap().to_string_lossy().replace('.', "_");
    let robots: Vec<_> = paths.iter().map(|path| (name(path), load(path))).collect();
    assert!(robots.len() > 10, "{}", robots.len());
    robots
}

/// A robot of the folder.
pub(crate) fn named(file: &str) -> Model {
    load(&path(file))
}

/// A tree with a floating base, two joints, one of them spherical, springs and friction.
pub(crate) fn random() -> Model {
    let options = RandomRobotOptions { joints: 2, base: Base::Floating, passive: 1.0, ..Default::default() };
    let has_ball = |model: &Model| model.joints().iter().any(|joint| joint.kind == JointKind::Spherical);
    let mut models = (0..1000).map(|seed| Model::new(random_robot(seed, &options)).unwrap());
    models.find(has_ball).unwrap()
}

/// A floating body with an arm of two joints, with damping, friction and stops; its shapes touch the ground.
pub(crate) fn on_ground() -> Model {
    let options = RandomRobotOptions { joints: 2, base: Base::Floating, passive: 1.0, ..Default::default() };
    let mut robot = random_robot(3, &options);
    let shapes = [
        Shape::Sphere { radius: 0.3 },
        Shape::Cylinder { radius: 0.2, length: 0.3 },
        Shape::Ellipsoid { half_axes: [0.1, 0.2, 0.4] },
    ];
    let links = robot.links.iter().map(|link| link.name.clone());
    robot.shapes = links
        .zip(shapes)
        .map(|(link, shape)| LinkShape::new(link, ShapeRole::Collision, Pose::IDENTITY, shape))
        .collect();
    for joint in &mut robot.joints {
        joint.kind = JointKind::Revolute { axis: [0.0, 1.0, 0.0] };
        joint.limits = Limits::new(-0.5, 0.8);
    }
    Model::new(robot).unwrap()
}

fn path(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots").join(file)
}

fn load(path: &Path) -> Model {
    robot_dynamics::load(path).unwrap().model
}

/// All functions, those of frames for the last frame.
pub(crate) fn functions(model: &Model) -> Vec<Function> {
    let of_frames = Function::of_frame(&model.frames().last().unwrap().name);
    Function::PLAIN.into_iter().chain(of_frames).collect()
}

/// These functions, and all derivatives and pullbacks that are not among them.
pub(crate) fn with_derivatives(model: &Model) -> Vec<Function> {
    let functions = functions(model);
    let is_derivative = |name: &str| name.contains("derivatives") || name.contains("pullback");
    let plain = functions.iter().filter(|function| !is_derivative(&function.to_string()));
    let derivatives =
        plain.flat_map(|function| [function.clone().derivatives(), function.clone().pullback()]);
    let new: Vec<Function> = derivatives.filter(|slope| !functions.contains(slope)).collect();
    assert_eq!((functions.len(), new.len()), (28, 44));
    functions.into_iter().chain(new).collect()
}
