//! Rows of equalities: closed loops, coupled joints, rolling wheels.
//!
//! A row is A v = 0 with φ̇ = A v, if it comes from a position. A is sparse: it has entries for the
//! coordinates that move the sides of the row relative to each other. Rows need only the placement of the
//! bodies in the world, O(n) for all bodies and O(depth) for each row. Steps, runs and projections use the
//! same rows.
//!
//! | file | content |
//! | --- | --- |
//! | `site` | a frame on a body, its place and its motion |
//! | `direction` | the motions that a row between two sites prevents: A, φ and Ȧv of each |
//! | `polynomial` | the relation y = p(x) of two positions |
//! | `position` | a position that a polynomial couples: of joints, or the length of a tendon |
//! | `relation` | an equality with its rows, of sites or of positions |
//! | `rows` | all rows of a robot |
//! | `row_derivatives` | the derivatives of all rows by q and v |
//! | `site_derivatives` | those of rows between sites |
//! | `error` | the errors of constraints and of motions with them |

pub(crate) mod direction;
pub(crate) mod error;
pub(crate) mod polynomial;
pub(crate) mod position;
pub(crate) mod relation;
pub(crate) mod row_derivatives;
pub(crate) mod rows;
pub(crate) mod site;
mod site_derivatives;
