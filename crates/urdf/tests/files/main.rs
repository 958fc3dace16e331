//! What is read from files, and what is refused.

mod audit;
mod collected;
mod faults;
mod hostile;
mod malformed;
mod mutations;
mod plausibility;
mod reading;
mod robots;
mod shapes;
mod warnings;
