//! Closed loops given beside a robot file, which can describe trees only.

use robot_dynamics_core::Model;
use robot_dynamics_description::{Pose, unknown_name};
use robot_dynamics_number::InvalidInput;
#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::{Anchor, FrameConstraint, SpatialAxis};

/// A loop closed between two frames of a robot, by name.
///
/// In JSON: `{"name": "pin", "frame_a": "coupler_end", "frame_b": "rocker_end", "rows": ["x", "z"]}`.
/// [`FrameConstraint`] defines the rows; they are along the axes of frame a.
///
/// ```
/// use robot_dynamics::constraints::{SpatialAxis, LoopClosure};
/// let text = r#"[{"name": "pin", "frame_a": "coupler", "frame_b": "rocker", "rows": ["x", "z"]}]"#;
/// let loops: Vec<LoopClosure> = serde_json::from_str(text)?;
/// assert_eq!(loops[0].rows, [SpatialAxis::X, SpatialAxis::Z]);
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct LoopClosure {
    /// The loop's name.
    pub name: String,
    /// The link or frame along whose axes the rows are, or `world`.
    pub frame_a: String,
    /// The link or frame joined to it, or `world`.
    pub frame_b: String,
    /// The constrained directions.
    pub rows: Vec<SpatialAxis>,
}

impl LoopClosure {
    /// Finds the frames. A robot's own frame named `world` takes precedence over the world.
    ///
    /// # Errors
    /// [`InvalidInput`] if a frame is missing.
    pub fn resolve(&self, model: &Model) -> Result<FrameConstraint, InvalidInput> {
        let anchor = |name: &str| match model.frame(name) {
            Some(frame) => Ok(Anchor::Frame(frame)),
            None if name == "world" => Ok(Anchor::World(Pose::IDENTITY)),
            None => {
                let owner = format!("constraint `{}`: robot `{}`", self.name, model.name());
                let names = model.frames().iter().map(|frame| frame.name.as_str());
                Err(unknown_name("link or frame", name, owner, names))
            }
        };
        Ok(FrameConstraint { a: anchor(&self.frame_a)?, b: anchor(&self.frame_b)?, rows: self.rows.clone() })
    }
}
