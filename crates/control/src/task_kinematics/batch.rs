//! Many solutions in several threads.

use std::borrow::Borrow;

use robot_dynamics_core::Model;

use super::controller::TaskKinematics;
use super::error::TaskKinematicsError;
use super::solution::TaskSolution;
use crate::inverse_kinematics::InverseKinematicsOptions;

impl<M: Borrow<Model> + Clone + Send> TaskKinematics<M> {
    /// [`solve`](Self::solve) for `count` problems in `threads` threads. `prepare` receives the index of a
    /// problem and a copy of this object; it sets the targets and returns the start. It has to set the same
    /// targets in every problem. Then the results do not depend on the number of threads.
    ///
    /// ```
    /// use robot_dynamics::control::InverseKinematicsOptions;
    /// use robot_dynamics::control::task_kinematics::{KinematicObjective, TaskKinematics};
    /// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf");
    /// let model = robot_dynamics::load(file)?.model;
    /// let hand = model.frame_named("panda_link8")?;
    /// let mut kinematics = TaskKinematics::new(&model);
    /// let reach = kinematics.add_task(KinematicObjective::pose(hand, [0.4, 0.0, 0.5]))?;
    /// let heights = [0.3, 0.4, 0.5, 0.6];
    /// let found = kinematics.solve_many(4, 2, &InverseKinematicsOptions::default(), |i, tasks| {
    ///     *tasks.objective_mut(reach) = KinematicObjective::pose(hand, [0.4, 0.0, heights[i]]);
    ///     vec![0.0, -0.4, 0.0, -2.2, 0.0, 1.9, 0.8]
    /// });
    /// for (solution, z) in found.iter().zip(heights) {
    ///     let q = &solution.as_ref().expect("a solution").q;
    ///     assert!((model.frame_pose(q, hand)?.translation[2] - z).abs() < 1e-9);
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn solve_many(
        &self,
        count: usize,
        threads: usize,
        options: &InverseKinematicsOptions,
        prepare: impl Fn(usize, &mut Self) -> Vec<f64> + Sync,
    ) -> Vec<Result<TaskSolution, TaskKinematicsError>> {
        let threads = threads.clamp(1, count.max(1));
        let solve = |own: &mut Self, index: usize| {
            let start = prepare(index, own);
            own.solve(&start, options)
        };
        if threads == 1 {
            let mut own = self.clone();
            return (0..count).map(|index| solve(&mut own, index)).collect();
        }
        let first = |thread: usize| thread * count / threads;
        std::thread::scope(|scope| {
            let start = |thread: usize| {
                let (mut own, range) = (self.clone(), first(thread)..first(thread + 1));
                scope.spawn(move || range.map(|index| solve(&mut own, index)).collect::<Vec<_>>())
            };
            let running: Vec<_> = (0..threads).map(start).collect();
            let joined = running
                .into_iter()
                .flat_map(|thread| thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
            joined.collect()
        })
    }
}
