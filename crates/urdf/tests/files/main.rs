//! Tests of reading files, and of refused files.

mod audit;
mod collected;
mod faults;
mod hostile;
mod malformed;
mod messages;
mod mutations;
mod plausibility;
mod reading;
mod robots;
mod shapes;
mod warnings;
