//! The robots of the folder `robots` and random ones, with random states in singles.

use std::fs;
use std::path::Path;

use robot_dynamics::batch;
use robot_dynamics::batch::{BatchFloat, BatchWorkspace};
use robot_dynamics::description::{Base, JointKind, RandomRobotOptions, random_robot};
use robot_dynamics::model::{Model, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics_gpu::{Rollout, RolloutError, Torques};

/// A robot of the folder; those with legs have a floating base.
pub(crate) fn named(file: &str) -> Model {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots").join(file);
    let mut options = robot_dynamics::LoadOptions::default();
    if file == "humanoid.urdf" || file == "quadruped.urdf" {
        options = options.with_floating_base();
    }
    robot_dynamics::load_with(&path, &options).unwrap().model
}

/// Every robot of the folder whose M has an inverse.
pub(crate) fn all() -> Vec<Model> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots");
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
    let mut files: Vec<String> = files.map(|name| name.to_string_lossy().into_owned()).collect();
    files.sort();
    let models: Vec<Model> = files.iter().map(|file| named(file)).collect();
    assert!(models.len() > 10, "{}", models.len());
    models
}

/// A tree with a floating base, a spherical joint, springs, damping and friction.
pub(crate) fn with_ball() -> Model {
    let options = RandomRobotOptions { joints: 2, base: Base::Floating, passive: 1.0, ..Default::default() };
    let has_ball = |model: &Model| model.joints().iter().any(|joint| joint.kind == JointKind::Spherical);
    let mut models = (0..1000).map(|seed| Model::new(random_robot(seed, &options)).unwrap());
    models.find(has_ball).unwrap()
}

/// Random states as tables of singles.
pub(crate) struct States {
    pub(crate) count: usize,
    pub(crate) q: Vec<f32>,
    pub(crate) v: Vec<f32>,
    pub(crate) a: Vec<f32>,
    pub(crate) tau: Vec<f32>,
}

#[allow(clippy::cast_possible_truncation)] // rounded is what they are to be
impl States {
    pub(crate) fn random(model: &Model, count: usize, seed: u64) -> Self {
        let mut random = SplitMix64::new(seed);
        let (mut q, mut v, mut a, mut tau) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for _ in 0..count {
            let state = random_state(model, &mut random);
            q.extend(state.q.iter().map(|&x| x as f32));
            v.extend(state.v.iter().map(|&x| x as f32));
            a.extend(state.a.iter().map(|&x| x as f32));
            tau.extend(state.tau.iter().map(|&x| x as f32));
        }
        Self { count, q, v, a, tau }
    }
}

/// Simulates states on the CPU, with the same torques at each step.
pub(crate) fn roll_out_on_cpu<T: BatchFloat>(
    model: &Model,
    how: &Rollout,
    tau: &[T],
    q: &mut [T],
    v: &mut [T],
) -> Result<(), RolloutError> {
    let mut workspace = BatchWorkspace::<T>::new(model);
    batch::rollout(model, &mut workspace, how, Torques::Held(tau), batch::RolloutStates::ends(q, v), None)
}

/// The row of one state, in doubles.
pub(crate) fn row(rows: &[f32], count: usize, state: usize) -> Vec<f64> {
    let width = rows.len() / count;
    rows[state * width..][..width].iter().map(|&x| f64::from(x)).collect()
}
