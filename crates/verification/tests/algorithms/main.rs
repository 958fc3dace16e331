//! The recursions and their derivatives over scalar types that are compiled here, against the Lagrange recipe
//! and each other.

#[path = "../common/mod.rs"]
mod common;

mod derivatives;
mod dispatch_paths;
mod momentum;
mod reference_routes;
mod second_order;
