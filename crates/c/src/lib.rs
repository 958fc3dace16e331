//! The C interface of robot-dynamics. `cpp/include/robot_dynamics.h` is written from this crate by cbindgen.
//!
//! - Objects are handles: a kind, a generation and an index in a table. Every call checks its handles, so a
//!   null handle, a handle of another kind and a handle of a freed object are errors, not undefined
//!   behaviour.
//! - Functions return a [`Status`]. [`rd_error_message`](calls::rd_error_message) has the text of the last
//!   error of the calling thread.
//! - Arrays are a pointer and a length. Pointers that are null or not aligned, wrong lengths, and outputs
//!   that overlap other arrays are errors.
//! - No panic crosses the interface; a panic is the status `RD_STATUS_PANIC`.
//! - A model is immutable and may be used by many threads at once. Every other object serves one call at a
//!   time; a second call at the same time returns `RD_STATUS_IN_USE`.
//!
//! # Safety
//! Each pointer argument is null, or points to as many numbers as its length says, or, without a length, to
//! one value or to a text that ends with a zero byte. The header repeats this once for all functions.

#![allow(unsafe_code, unsafe_op_in_unsafe_fn)]
// The section above is the contract of all functions.
#![allow(clippy::missing_safety_doc)]
// Frames and parameters are fewer than 2³², and a handle is taken apart into its fields.
#![allow(clippy::cast_possible_truncation)]

mod arrays;
mod failure;
mod handle;

pub mod calls;
pub mod status;

pub mod configuration;
pub mod load;
pub mod model;

pub mod batch;
pub mod constraints;
pub mod control;
pub mod frames;
pub mod identification;
pub mod inverse_kinematics;
pub mod linearization;
pub mod optimal;
pub mod quantities;
pub mod simulation;
pub mod workspace;

pub use status::Status;
