//! The command, as a user calls it.

#[path = "../command/mod.rs"]
mod command;

mod audit;
mod bench;
mod certify;
mod convert;
mod endings;
mod files_read;
mod generate;
mod ground;
mod guide;
mod inspect_and_compute;
mod labels;
mod malformed;
mod manuals;
mod messages;
mod names;
mod outputs;
mod same_motion;
mod signals;
mod simulate;
mod singular;
