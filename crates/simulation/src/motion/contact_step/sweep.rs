//! One projected Gauss-Seidel sweep.

use robot_dynamics_core::factorization::sparse::dof_ancestors;
use robot_dynamics_description::check_length;
use robot_dynamics_number::Scalar;

use super::problem::{Reader, TINY};
use super::{ContactStep, JointRowKind, positive_part};

/// A row of a problem: the last coordinate of its path, and its entries.
struct Row<'a, S> {
    dof_parent: &'a [usize],
    coordinate: usize,
    entries: &'a [S],
}

impl<S: Scalar> Row<'_, S> {
    fn path(&self) -> impl Iterator<Item = usize> + '_ {
        core::iter::once(self.coordinate).chain(dof_ancestors(self.dof_parent, self.coordinate))
    }

    /// The velocity of the row.
    fn speed(&self, velocity: &[S]) -> S {
        let mut terms = self.path().zip(self.entries);
        let (first, &x) = terms.next().expect("a path has a coordinate");
        terms.fold(x * velocity[first], |sum, (i, &x)| x.mul_add(velocity[i], sum))
    }

    /// Adds a change of the row's multiplier.
    fn push(&self, velocity: &mut [S], impulse: S) {
        for (i, &x) in self.path().zip(self.entries) {
            velocity[i] = x.mul_add(impulse, velocity[i]);
        }
    }
}

impl ContactStep {
    /// Adds the effect of the given multipliers to the velocity √D L v.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    #[track_caller]
    pub fn start<S: Scalar>(&self, problem: &[S], impulses: &[S], velocity: &mut [S]) {
        self.check(problem, velocity, impulses);
        let mut reader = self.rows_of(problem);
        let (contacts, joints) = impulses.split_at(3 * self.point_coordinates.len());
        for (joint, &impulse) in self.joints.iter().zip(joints) {
            self.row(&mut reader, joint.coordinate).push(velocity, impulse);
            reader.many(joint.kind.numbers());
        }
        for (&k, impulses) in self.point_coordinates.iter().zip(contacts.chunks(3)) {
            for &impulse in impulses {
                self.row(&mut reader, k).push(velocity, impulse);
            }
            reader.many(3);
        }
    }

    /// One sweep over the rows of joints, then over the contacts. It updates the velocity √D L v and the
    /// multipliers.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    #[track_caller]
    pub fn sweep<S: Scalar>(&self, problem: &[S], velocity: &mut [S], impulses: &mut [S]) {
        self.check(problem, velocity, impulses);
        let mut reader = self.rows_of(problem);
        let friction = problem[problem.len() - 1];
        let (contacts, joints) = impulses.split_at_mut(3 * self.point_coordinates.len());
        for (joint, impulse) in self.joints.iter().zip(joints) {
            let row = self.row(&mut reader, joint.coordinate);
            let mobility = reader.one();
            let speed = row.speed(velocity);
            let next = match joint.kind {
                JointRowKind::Friction(_) => clamp_to(*impulse - speed / mobility, reader.one()),
                JointRowKind::Stop { .. } => {
                    let free = speed - mobility * *impulse;
                    let (lower, upper) = (reader.one(), reader.one());
                    let bounded = free + positive_part(lower - free) - positive_part(free - upper);
                    (bounded - free) / mobility
                }
            };
            row.push(velocity, next - *impulse);
            *impulse = next;
        }
        for (&k, impulse) in self.point_coordinates.iter().zip(contacts.chunks_mut(3)) {
            let mut row = || self.row(&mut reader, k);
            let rows = [row(), row(), row()];
            let [by_normal, by_tangent, bound] = [reader.one(), reader.one(), reader.one()];
            let next = positive_part(impulse[0] - (rows[0].speed(velocity) - bound) * by_normal);
            rows[0].push(velocity, next - impulse[0]);
            impulse[0] = next;
            let slid = [1, 2].map(|i| impulse[i] - rows[i].speed(velocity) * by_tangent);
            let size = (slid[0] * slid[0] + slid[1] * slid[1] + S::from_f64(TINY)).sqrt();
            let radius = friction * next;
            // radius / max(radius, size)
            let shrink = radius / (radius + positive_part(size - radius));
            for i in [1, 2] {
                let next = slid[i - 1] * shrink;
                rows[i].push(velocity, next - impulse[i]);
                impulse[i] = next;
            }
        }
    }
}

impl ContactStep {
    #[track_caller]
    fn check<S>(&self, problem: &[S], velocity: &[S], impulses: &[S]) {
        check_length("the problem", problem.len(), self.problem_count());
        check_length("the velocity", velocity.len(), self.dof_parent.len());
        check_length("the multipliers", impulses.len(), self.impulse_count());
    }

    /// The rows of a problem, which follow the factor.
    fn rows_of<'a, S: Scalar>(&self, problem: &'a [S]) -> Reader<'a, S> {
        let mut reader = Reader::new(problem);
        reader.many((0..self.dof_parent.len()).map(|k| self.path_length(k)).sum());
        reader
    }

    /// The next row, whose last coordinate is k.
    fn row<'a, S: Scalar>(&'a self, reader: &mut Reader<'a, S>, k: usize) -> Row<'a, S> {
        Row { dof_parent: &self.dof_parent, coordinate: k, entries: reader.many(self.path_length(k)) }
    }
}

/// x within ±bound.
fn clamp_to<S: Scalar>(x: S, bound: S) -> S {
    x - positive_part(x - bound) + positive_part(-bound - x)
}
