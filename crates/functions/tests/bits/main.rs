//! Machine code made in memory has the same bits as its graph, and the graph has the library's values.
//!
//! Every function of every robot is traced as for generated code. The code must give each bit of the graph,
//! evaluated operation by operation. This holds for single states and for rows of tables, on every set of
//! instructions of this machine. In doubles the graph must also give the values of the library's recursions
//! for the robot as described. Its mass is not regrouped, and its right angles are rounded.

mod compare;
mod extent;
mod messages;
mod robots;

use robot_dynamics::model::Model;

use crate::compare::Comparison;
use crate::extent::Extent;

/// Compares every function of these robots, each in a few random states.
fn compare(robots: impl Iterator<Item = (String, Model)>) -> Comparison {
    let extent = Extent::asked();
    let mut comparison = Comparison::default();
    for (name, model) in robots {
        comparison.robot(&name, &model, extent);
    }
    println!("{comparison:?}");
    comparison
}

#[test]
fn robots_of_the_repository_have_the_bits_of_their_graphs() {
    let compared = compare(robots::of_repository());
    // Twenty-eight functions of fifteen robots in two precisions.
    assert!(compared.graphs + compared.left_out >= 15 * 28 * 2, "{compared:?}");
}

#[test]
fn published_robots_have_the_bits_of_their_graphs() {
    let compared = compare(robots::published());
    assert!(compared.graphs > 300, "{compared:?}");
}

/// The random robots with even numbers, or those with odd ones: two tests run in parallel.
fn compare_random(remainder: usize) {
    let count = Extent::asked().random_robots;
    let robots = robots::random(count).enumerate().filter(|(number, _)| number % 2 == remainder);
    let compared = compare(robots.map(|(_, robot)| robot));
    // A third of the functions of each robot, in one precision: most of the largest are left out.
    assert!(compared.graphs >= 8 * (count / 2), "{compared:?}");
}

#[test]
fn random_robots_have_the_bits_of_their_graphs() {
    compare_random(0);
}

#[test]
fn other_random_robots_have_the_bits_of_their_graphs() {
    compare_random(1);
}
