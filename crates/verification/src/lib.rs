//! Independent computations of the same quantities: the Lagrange recipe on trees, contact by ADMM, and the
//! audit of a robot.
//!
//! They share no code with the recursions and the contact solver beyond the description of the robot. They
//! are slow, O(nv³) and more, and serve tests, the audit and teaching.

// Each module uses only earlier modules (`cargo xtask tidy` checks this).

// Rigid contact by the alternating direction method of multipliers.
pub mod admm;

// The equation of motion from K, V and their derivatives.
pub mod lagrange;

// Checks of the laws of mechanics on one robot.
pub mod audit;
