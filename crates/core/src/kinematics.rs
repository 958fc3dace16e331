//! Stages that several algorithms share: placements, motions in one frame, shifts between points, wrenches.
//!
//! `parent_from_child` of every joint, then motions S of the DoFs in one inertial frame, V = Σ S v and A = Σ
//! (S a + Ṡ v). Each stage is one pass, O(n). The frame's origin moves with the robot
//! (`model::reference_point`): about a distant origin the terms m d² would cancel significant digits.

pub mod body_placement;
pub mod frame_transmission;
pub mod motion_columns;
pub mod parent_inertia;
pub mod placement;
pub mod shifts;
pub mod tendon_path;
pub mod world_frame;
pub mod wrench;
