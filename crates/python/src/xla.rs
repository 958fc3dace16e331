//! The functions that programs compiled by XLA call: the rows of the table, and rollouts. Their robots stay
//! in memory.
//!
//! A call comes from a thread of XLA's, without Python: no code here needs the interpreter. The rows of bad
//! states are NaN, as an error would end the whole program.

mod calls;
mod groups;
mod registration;
mod rollout;
mod row;

pub(crate) use self::registration::_xla_handlers;
pub(crate) use self::rollout::{rollout, rollout_pullback, rollout_tangent};
pub(crate) use self::row::row;
