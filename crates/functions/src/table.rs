//! The tables that generated code reads and writes.

use robot_dynamics_core::Model;

use crate::{Argument, Function, FunctionResult, identifier};

/// A table that a function reads or writes for each state, by rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Table {
    /// Its name in the generated code.
    pub name: &'static str,
    /// Its rows.
    pub rows: usize,
    /// Its columns, 1 for a vector.
    pub columns: usize,
}

impl Table {
    /// The count of numbers for each state.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics_functions::Function;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// assert_eq!(Function::FramePose("bob".into()).writes(&model)[0].width(), 9); // R
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn width(&self) -> usize {
        self.rows * self.columns
    }
}

impl Function {
    /// The tables that it reads, in the order of its parameters and of the bindings of a shader.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics_functions::Function;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let names: Vec<_> = Function::Rk4Step.reads(&model).iter().map(|table| table.name).collect();
    /// assert_eq!(names, ["q", "v", "tau", "h"]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn reads(&self, model: &Model) -> Vec<Table> {
        let table = |Argument { name, length, .. }| Table { name, rows: length, columns: 1 };
        self.arguments(model).into_iter().map(table).collect()
    }

    /// The tables that it writes, in the order of the parameters and bindings that follow those of the tables
    /// that it reads.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics_functions::Function;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let names: Vec<_> = Function::Rk4Step.writes(&model).iter().map(|table| table.name).collect();
    /// assert_eq!(names, ["q_next", "v_next"]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn writes(&self, model: &Model) -> Vec<Table> {
        let table = |FunctionResult { name, rows, columns, .. }| Table { name, rows, columns };
        self.results(model).into_iter().map(table).collect()
    }

    /// Its name in generated code, which follows the robot's name.
    ///
    /// ```
    /// use robot_dynamics_functions::Function;
    /// assert_eq!(Function::FramePose("left foot".into()).symbol(), "frame_pose_left_foot");
    /// ```
    pub fn symbol(&self) -> String {
        match self.frame() {
            Some(frame) => format!("{}_{}", self.stem(), identifier(frame)),
            None => self.stem(),
        }
    }
}
