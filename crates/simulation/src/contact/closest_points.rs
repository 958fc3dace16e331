//! The nearest points of two balls or capsules, each a set of balls along a line.
//!
//! | point | what |
//! | --- | --- |
//! | 0 | where the lines cross, if that is between the ends of both |
//! | 1, 2 | an end of the first, and the nearest point of the second |
//! | 3, 4 | an end of the second, and the nearest point of the first, if that is between its ends |
//!
//! Each gap is the distance of two points less both radii, so no gap is deeper than the shapes are. Parallel
//! capsules rest on two of their ends. Each point has a number that stays the same while the shapes move.

use nalgebra::Vector3;

/// The most contact points of two shapes.
pub(super) const MOST_NEAREST: usize = 5;

/// Balls of one radius along a line segment, in the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    /// Both are equal for a ball.
    pub(super) ends: [Vector3<f64>; 2],
    pub(super) radius: f64,
}

/// The nearest points of two surfaces.
#[derive(Clone, Copy, Debug)]
pub(super) struct ClosestPoints {
    /// Negative where they overlap \[m\].
    pub(super) gap: f64,
    /// Half-way between the surfaces.
    pub(super) at: Vector3<f64>,
    /// Unit vector into the first shape.
    pub(super) normal: Vector3<f64>,
}

/// The sine below which lines are parallel: their ends are the contacts, as their crossing is rounding.
const PARALLEL: f64 = 1e-9;

impl Line {
    fn is_ball(&self) -> bool {
        self.ends[0] == self.ends[1]
    }

    /// The position of the nearest point to a given point along the segment: 0 to 1.
    fn share(&self, point: &Vector3<f64>) -> f64 {
        let along = self.ends[1] - self.ends[0];
        let square = along.norm_squared();
        if square > 0.0 { (along.dot(&(point - self.ends[0])) / square).clamp(0.0, 1.0) } else { 0.0 }
    }

    fn at(&self, share: f64) -> Vector3<f64> {
        self.ends[0] + (self.ends[1] - self.ends[0]) * share
    }
}

/// The positions at which two infinite lines are nearest; `None` if they are parallel.
fn crossing(one: &Line, two: &Line) -> Option<[f64; 2]> {
    let [d, e] = [one, two].map(|line| line.ends[1] - line.ends[0]);
    let r = one.ends[0] - two.ends[0];
    let (dd, de, ee) = (d.norm_squared(), d.dot(&e), e.norm_squared());
    let determinant = dd * ee - de * de;
    if determinant <= PARALLEL * PARALLEL * dd * ee {
        return None;
    }
    let (dr, er) = (d.dot(&r), e.dot(&r));
    Some([(de * er - ee * dr) / determinant, (dd * er - de * dr) / determinant])
}

/// Whether point k can be a contact.
pub(super) fn takes_part(one: &Line, two: &Line, k: usize) -> bool {
    let inside = |share: f64| share > 0.0 && share < 1.0;
    match k {
        0 => crossing(one, two).is_some_and(|shares| shares.into_iter().all(inside)),
        1 => true,
        2 => !one.is_ball(),
        k => !one.is_ball() && (k == 3 || !two.is_ball()) && inside(one.share(&two.ends[k - 3])),
    }
}

/// Point k, whether it can be a contact or not.
pub(super) fn nearest(one: &Line, two: &Line, k: usize) -> ClosestPoints {
    let (a, b) = match k {
        0 => {
            let [s, t] = crossing(one, two).unwrap_or([0.5; 2]);
            (one.at(s.clamp(0.0, 1.0)), two.at(t.clamp(0.0, 1.0)))
        }
        1 | 2 => (one.ends[k - 1], two.at(two.share(&one.ends[k - 1]))),
        k => (one.at(one.share(&two.ends[k - 3])), two.ends[k - 3]),
    };
    let apart = a - b;
    let distance = apart.norm();
    // If the lines meet: a direction out of both, or any direction.
    let normal = if distance > 0.0 { apart / distance } else { across(one, two) };
    let gap = distance - one.radius - two.radius;
    ClosestPoints { gap, at: b + normal * (two.radius + 0.5 * gap), normal }
}

fn across(one: &Line, two: &Line) -> Vector3<f64> {
    let [d, e] = [one, two].map(|line| line.ends[1] - line.ends[0]);
    let both = d.cross(&e);
    let along = if d == Vector3::zeros() { e } else { d };
    let from = if along.x.abs() < 0.9 * along.norm() { Vector3::x() } else { Vector3::y() };
    let any = along.cross(&from);
    both.try_normalize(0.0).or_else(|| any.try_normalize(0.0)).unwrap_or_else(Vector3::z)
}

#[cfg(test)]
mod tests {
    use robot_dynamics_number::SplitMix64;

    use super::*;

    /// The least of the points' gaps is the least distance of the lines, found on a grid, less the radii.
    #[test]
    fn no_points_of_the_lines_are_nearer() {
        let mut random = SplitMix64::new(5);
        for round in 0..300 {
            let mut point = || Vector3::from_fn(|_, _| random.uniform(-1.0, 1.0));
            let (a, b, c, d) = (point(), point(), point(), point());
            // Balls, parallel capsules and general ones.
            let b = if round % 5 == 0 { a } else { b };
            let d = match round % 7 {
                0 => c,
                1 => c + (b - a) * 0.7,
                _ => d,
            };
            let (one, two) = (Line { ends: [a, b], radius: 0.15 }, Line { ends: [c, d], radius: 0.15 });
            let points = (0..MOST_NEAREST).filter(|k| takes_part(&one, &two, *k));
            let least = points.map(|k| nearest(&one, &two, k).gap).fold(f64::INFINITY, f64::min);
            let (mut found, n) = (f64::INFINITY, 4000);
            for i in 0..=n {
                let at = one.at(f64::from(i) / f64::from(n));
                found = found.min((at - two.at(two.share(&at))).norm());
            }
            assert!((found - 0.3 - least).abs() < 1e-4, "round {round}: {} for {}", least, found - 0.3);
            for k in 0..MOST_NEAREST {
                let ClosestPoints { gap, at, normal } = nearest(&one, &two, k);
                let depth = |line: &Line| (at - line.at(line.share(&at))).norm() - line.radius;
                // Half of the gap from each surface, and not nearer.
                assert!((normal.norm() - 1.0).abs() < 1e-12);
                assert!(
                    depth(&one) <= 0.5 * gap + 1e-12 && depth(&two) <= 0.5 * gap + 1e-12,
                    "round {round}, {k}"
                );
            }
        }
    }

    /// Parallel capsules side by side touch in two points, crossed ones in one.
    #[test]
    fn points_that_carry() {
        let along = |at: f64, from: f64, to: f64| Line {
            ends: [Vector3::new(from, 0.0, at), Vector3::new(to, 0.0, at)],
            radius: 0.1,
        };
        let count = |one: &Line, two: &Line| {
            (0..MOST_NEAREST).filter(|k| takes_part(one, two, *k) && nearest(one, two, *k).gap < 1e-9).count()
        };
        assert_eq!(count(&along(0.2, 0.0, 1.0), &along(0.0, 0.3, 2.0)), 2);
        let crossed = Line { ends: [Vector3::new(0.5, -1.0, 0.2), Vector3::new(0.5, 1.0, 0.2)], radius: 0.1 };
        assert_eq!(count(&crossed, &along(0.0, 0.0, 1.0)), 1);
    }
}
