//! Closed loops as they stand beside a robot file, which can describe trees only.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::{Anchor, Closure, ClosureRow, ConstraintSetError};
use crate::{Model, Pose};

/// A loop closed between two frames of a robot, by name.
///
/// Written in JSON: `{"name": "pin", "frame_a": "coupler_end", "frame_b": "rocker_end", "rows": ["x", "z"]}`.
/// What the rows mean, [`Closure`] says; they are along the axes of frame a.
///
/// ```
/// use multibody::{ClosureRow, LoopClosure};
/// let text = r#"[{"name": "pin", "frame_a": "coupler", "frame_b": "rocker", "rows": ["x", "z"]}]"#;
/// let loops: Vec<LoopClosure> = serde_json::from_str(text)?;
/// assert_eq!(loops[0].rows, [ClosureRow::X, ClosureRow::Z]);
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct LoopClosure {
    /// The loop's name.
    pub name: String,
    /// The link or frame whose axes the rows are given in, or `world`.
    pub frame_a: String,
    /// The link or frame joined to it, or `world`.
    pub frame_b: String,
    /// What is forbidden.
    pub rows: Vec<ClosureRow>,
}

impl LoopClosure {
    /// Looks the frames up. A robot's own frame named `world` goes before the world.
    ///
    /// # Errors
    /// [`ConstraintSetError::UnknownFrame`].
    pub fn resolve(&self, model: &Model) -> Result<Closure, ConstraintSetError> {
        let anchor = |name: &str| match model.frame(name) {
            Some(frame) => Ok(Anchor::Frame(frame)),
            None if name == "world" => Ok(Anchor::World(Pose::IDENTITY)),
            None => Err(ConstraintSetError::UnknownFrame {
                constraint: self.name.clone(),
                frame: name.to_owned(),
                robot: model.name().to_owned(),
            }),
        };
        Ok(Closure { a: anchor(&self.frame_a)?, b: anchor(&self.frame_b)?, rows: self.rows.clone() })
    }
}
