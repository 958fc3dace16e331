//! The tables that generated code reads and writes, for who calls it.

use multibody::Model;

use crate::Function;
use crate::program::symbol;

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
    /// Numbers of each state.
    ///
    /// ```
    /// use generate::Function;
    /// use multibody::{Model, pendulum};
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// assert_eq!(Function::FramePose("bob".into()).writes(&model)[0].width(), 9); // R
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn width(&self) -> usize {
        self.rows * self.columns
    }
}

impl Function {
    /// What it reads, in the order of its parameters, and of the bindings of a shader.
    ///
    /// ```
    /// use generate::Function;
    /// use multibody::{Model, pendulum};
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let names: Vec<_> = Function::Rk4Step.reads(&model).iter().map(|table| table.name).collect();
    /// assert_eq!(names, ["q", "v", "tau", "h"]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn reads(&self, model: &Model) -> Vec<Table> {
        let argument =
            |&(name, size, _): &crate::function::Argument| Table { name, rows: size.of(model), columns: 1 };
        self.arguments().iter().map(argument).collect()
    }

    /// What it writes, in the order of the parameters and bindings after those that it reads.
    ///
    /// ```
    /// use generate::Function;
    /// use multibody::{Model, pendulum};
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let names: Vec<_> = Function::Rk4Step.writes(&model).iter().map(|table| table.name).collect();
    /// assert_eq!(names, ["q_next", "v_next"]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn writes(&self, model: &Model) -> Vec<Table> {
        let outcome = |&(name, rows, columns, _): &crate::function::Outcome| Table {
            name,
            rows: rows.of(model),
            columns: columns.of(model),
        };
        self.results().iter().map(outcome).collect()
    }

    /// Its name in generated code, after the robot's.
    ///
    /// ```
    /// use generate::Function;
    /// assert_eq!(Function::FramePose("left foot".into()).symbol(), "frame_pose_left_foot");
    /// ```
    pub fn symbol(&self) -> String {
        symbol(self)
    }
}
