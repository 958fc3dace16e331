//! Robots of the repository, published robots, and random ones with every kind of joint.

use std::path::{Path, PathBuf};

use robot_dynamics::description::{
    Base, Equality, EqualityDescription, JointKinds, RandomRobotOptions, RobotDescription, random_robot,
};
use robot_dynamics::model::Model;

/// Published robots whose descriptions are stored with the numbers of other programs for them.
const PUBLISHED: [&str; 13] = [
    "allegro_hand",
    "anymal_c",
    "baxter",
    "bolt",
    "g1",
    "kinova",
    "panda_example",
    "pr2",
    "solo12",
    "talos",
    "tiago",
    "ur5_example",
    "xarm7",
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The robots of the folder `robots`; those with legs have a floating base.
pub(crate) fn of_repository() -> impl Iterator<Item = (String, Model)> {
    let mut paths: Vec<PathBuf> =
        std::fs::read_dir(root().join("robots")).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths.into_iter().map(|path| {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let mut options = robot_dynamics::LoadOptions::default();
        if name == "humanoid.urdf" || name == "quadruped.urdf" {
            options = options.with_floating_base();
        }
        (name, robot_dynamics::load_with(&path, &options).unwrap().model)
    })
}

/// The published robots.
pub(crate) fn published() -> impl Iterator<Item = (String, Model)> {
    PUBLISHED.into_iter().map(|name| {
        let path = root().join("testdata/golden").join(name).with_extension("json");
        let mut record: serde_json::Value =
            serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        let description: RobotDescription = serde_json::from_value(record["description"].take()).unwrap();
        (name.to_owned(), Model::new(description).unwrap())
    })
}

/// Random robots of 1 to 60 moving joints, small ones more often: chains, trees and bushes, with fixed or
/// floating base. They have mimic joints, armature on tendons, springs, damping and friction. Every third one
/// is closed by a connection of two links.
pub(crate) fn random(count: usize) -> impl Iterator<Item = (String, Model)> {
    (0..count).map(move |number| {
        let seed = u64::try_from(number).unwrap();
        let kinds = match number % 4 {
            0 | 1 => JointKinds::All,
            2 => JointKinds::VectorSpace,
            _ => JointKinds::SingleDof,
        };
        let last = count.saturating_sub(1).max(1);
        let options = RandomRobotOptions {
            joints: 1 + 59 * number * number / (last * last),
            base: if number % 3 == 0 { Base::Floating } else { Base::Fixed },
            kinds,
            chain: [0.6, 1.0, 0.0][number % 3],
            mimic: if number % 2 == 0 { 0.0 } else { 0.2 },
            tendons: usize::from(number % 5 == 4),
            passive: if number % 7 == 0 { 0.0 } else { 0.8 },
            ..Default::default()
        };
        let mut robot = random_robot(seed, &options);
        if number % 3 == 2 && robot.links.len() > 2 {
            let (first, last) = (&robot.links[1], &robot.links[robot.links.len() - 1]);
            let kind = Equality::Connect {
                a: (first.name.clone(), [0.1, 0.2, -0.1]),
                b: (last.name.clone(), [0.3, 0.0, 0.1]),
            };
            robot.equalities.push(EqualityDescription::new("closure", kind));
        }
        (format!("random {number}"), Model::new(robot).unwrap())
    })
}
