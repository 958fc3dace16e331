//! The same equation of motion with fewer inertial parameters.
//!
//! What mass sits on a revolute joint's axis moves as the body below the joint does, whatever the joint does; so does a pure second
//! moment ∫ r rᵀ dm (no mass, no first moment) on a prismatic joint. Counted with the body below, it costs the body above nothing:
//! a link on a revolute joint keeps seven of its ten numbers, which for a serial arm with skew axes are the base parameters. On a
//! joint in the world it keeps three, or m alone where it slides.
//! Source: Khalil, Dombre, *Modeling, Identification and Control of Robots* (2002), §9.4; the pseudo-inertia of Atcheson, An,
//! Hollerbach (1986) and Wensing, Kim, Slotine (2018) makes it two rules.

use crate::Model;
use crate::joint::Motion;
use crate::model::{Body, WORLD};
use crate::spatial::algebra::{PaddedColumns, padded_columns};

impl Model {
    /// This robot with mass moved down across its joints until most entries are zero, so that code written for it alone has less to
    /// do. M(q), C(q, v) and g(q) are the same to rounding. **Not** what is asked of single bodies or of all mass: the centre of mass
    /// and the potential energy's zero change, and its description is still the robot's.
    #[doc(hidden)]
    #[must_use]
    pub fn regrouped(&self) -> Self {
        let mut model = self.without_native_code();
        for i in (0..model.bodies.len()).rev() {
            let (below, from) = model.bodies.split_at_mut(i);
            let carried = match from[0].motion {
                Motion::Revolute => take_from_axis(&mut from[0]),
                Motion::Prismatic => take_second_moment(&mut from[0]),
                Motion::Helical(_) | Motion::Spherical | Motion::Floating => continue,
            };
            if from[0].parent == WORLD {
                keep_what_resists(&mut from[0]);
            } else {
                carried.add_to(&mut below[from[0].parent], &from[0]);
            }
        }
        model
    }

    /// How many links follow one upon the other that are alike, mass and placement. [`regrouped`](Self::regrouped) they are not: each
    /// would carry what hangs on it.
    #[doc(hidden)]
    pub fn longest_run_of_equal_links(&self) -> usize {
        let (mut longest, mut run) = (0, 0);
        for (i, body) in self.bodies.iter().enumerate() {
            let follows = i > 0 && body.parent == i - 1 && is_alike(&self.bodies[i - 1], body);
            run = if follows { run + 1 } else { 1 };
            longest = longest.max(run);
        }
        longest
    }
}

fn is_alike(one: &Body, other: &Body) -> bool {
    let placement = |body: &Body| (body.motion, body.rotation, body.translation);
    let moments = |body: &Body| (body.mass, body.first_moment, body.second_moment);
    placement(one) == placement(other) && moments(one) == moments(other)
}

/// Mass, first and second moments in a body's frame.
struct Moments {
    mass: f64,
    first: [f64; 3],
    second: [[f64; 3]; 3],
}

/// m, h_z and Σ_zz: the mass on the axis.
fn take_from_axis(body: &mut Body) -> Moments {
    let mut taken = Moments { mass: body.mass, first: [0.0; 3], second: [[0.0; 3]; 3] };
    taken.first[2] = body.first_moment[2];
    taken.second[2][2] = body.second_moment[2][2];
    body.mass = 0.0;
    body.first_moment[2] = 0.0;
    body.second_moment[2][2] = 0.0;
    body.inertia = inertia(&body.second_moment);
    taken
}

/// A joint in the world feels of what turns about it I_zz = Σ_xx + Σ_yy alone, which here lies on x, beside h's weight; of what slides m.
fn keep_what_resists(body: &mut Body) {
    if body.motion == Motion::Prismatic {
        body.first_moment = [0.0; 4];
        return;
    }
    let resists = body.second_moment[0][0] + body.second_moment[1][1];
    body.second_moment = padded_columns([[resists, 0.0, 0.0], [0.0; 3], [0.0; 3]]);
    body.inertia = inertia(&body.second_moment);
}

/// Σ, of which no force depends on where the joint is.
fn take_second_moment(body: &mut Body) -> Moments {
    let second = core::array::from_fn(|j| core::array::from_fn(|i| body.second_moment[j][i]));
    body.second_moment = [[0.0; 4]; 3];
    body.inertia = [[0.0; 4]; 3];
    Moments { mass: 0.0, first: [0.0; 3], second }
}

impl Moments {
    /// Adds them to the parent of the body they were taken from, whose placement at q = 0 serves as any other: with p the body's
    /// origin and R its rotation there, m, m p + R h and R Σ Rᵀ + p (R h)ᵀ + (R h) pᵀ + m p pᵀ.
    fn add_to(&self, parent: &mut Body, body: &Body) {
        let (columns, p) = (&body.rotation, &body.translation);
        let turned = |x: &[f64; 3], i: usize| (0..3).map(|k| columns[k][i] * x[k]).sum::<f64>();
        let first: [f64; 3] = core::array::from_fn(|i| turned(&self.first, i));
        // R Σ by columns, each turned.
        let half: [[f64; 3]; 3] =
            core::array::from_fn(|k| core::array::from_fn(|i| turned(&self.second[k], i)));
        for i in 0..3 {
            parent.first_moment[i] += self.mass * p[i] + first[i];
            for j in 0..3 {
                let second = (0..3).map(|k| half[k][i] * columns[k][j]).sum::<f64>();
                let shift = p[i] * first[j] + first[i] * p[j] + self.mass * p[i] * p[j];
                parent.second_moment[j][i] += second + shift;
            }
        }
        parent.mass += self.mass;
        parent.inertia = inertia(&parent.second_moment);
    }
}

/// I = tr(Σ) 1 − Σ.
fn inertia(second: &PaddedColumns) -> PaddedColumns {
    let trace: f64 = (0..3).map(|i| second[i][i]).sum();
    let entry = |i: usize, j: usize| if i == j { trace } else { 0.0 } - second[j][i];
    padded_columns(core::array::from_fn(|i| core::array::from_fn(|j| entry(i, j))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Base, RandomRobotOptions, RandomState, Workspace, coriolis_matrix, forward_dynamics,
        inverse_dynamics, mass_matrix, random_robot, random_state,
    };
    use dynamics::SplitMix64;

    /// Largest difference, as a multiple of the largest value.
    fn difference(one: &[f64], other: &[f64]) -> f64 {
        let largest = one.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        one.iter().zip(other).fold(0.0_f64, |most, (x, y)| most.max((x - y).abs())) / largest
    }

    /// Trees with every kind of joint, followers, tendons, springs: what is left gives the same terms.
    #[test]
    fn the_equation_of_motion_stays() {
        for seed in 0..40 {
            let base = if seed % 2 == 0 { Base::Fixed } else { Base::Floating };
            let options = RandomRobotOptions {
                joints: 8,
                base,
                mimic: 0.2,
                tendons: 1,
                passive: 1.0,
                ..Default::default()
            };
            let model = Model::new(random_robot(seed, &options)).unwrap();
            let regrouped = model.regrouped();
            let RandomState { q, v, a, tau } = random_state(&model, &mut SplitMix64::new(seed));
            let terms = |model: &Model| {
                let w = &mut Workspace::new(model);
                let nv = model.nv();
                let (mut force, mut acceleration) = (vec![0.0; nv], vec![0.0; nv]);
                let (mut mass, mut coriolis) = (vec![0.0; nv * nv], vec![0.0; nv * nv]);
                inverse_dynamics(model, w, &q, &v, &a, &mut force);
                forward_dynamics(model, w, &q, &v, &tau, &mut acceleration);
                mass_matrix(model, w, &q, &mut mass);
                coriolis_matrix(model, w, &q, &v, &mut coriolis);
                [force, mass, coriolis, acceleration]
            };
            // Sums of some twenty terms, all of the size of the largest; a is divided by M, of condition below 1e5.
            let allowed = [1e-13, 1e-13, 1e-13, 1e-10];
            for ((one, other), allowed) in terms(&model).iter().zip(&terms(&regrouped)).zip(allowed) {
                let off = difference(one, other);
                assert!(off < allowed, "seed {seed}: {off:e}");
            }
        }
    }

    /// Four links that are alike but for the first one's axis, which is y of the world and z of what the others hang on, and a fifth that
    /// is heavier.
    #[test]
    fn equal_links_are_counted() {
        let mut robot = crate::pendulum(2.0, 0.5);
        let (link, joint) = (robot.links.last().unwrap().clone(), robot.joints[0].clone());
        let tip = link.name.clone();
        for (k, mass) in [2.0, 2.0, 2.0, 3.0].into_iter().enumerate() {
            let mut heavier = link.clone();
            heavier.name = format!("link{k}");
            heavier.mass_properties = crate::pendulum(mass, 0.5).links.last().unwrap().mass_properties;
            let mut hinge = joint.clone();
            hinge.name = format!("hinge{k}");
            hinge.parent = if k == 0 { tip.clone() } else { format!("link{}", k - 1) };
            hinge.child = heavier.name.clone();
            robot.links.push(heavier);
            robot.joints.push(hinge);
        }
        assert_eq!(Model::new(robot).unwrap().longest_run_of_equal_links(), 3);
    }

    /// Of a link on a revolute joint seven numbers are left, of one that slides m and h; what is not taken stays to the bit.
    #[test]
    fn what_is_taken_is_zero() {
        let options = RandomRobotOptions { joints: 12, ..Default::default() };
        let mut counts = [0; 2];
        for seed in 0..10 {
            let model = Model::new(random_robot(seed, &options)).unwrap();
            let regrouped = model.regrouped();
            for (i, (body, before)) in regrouped.bodies.iter().zip(&model.bodies).enumerate() {
                let is_tip = model.bodies.iter().all(|other| other.parent != i);
                match body.motion {
                    Motion::Revolute => {
                        assert_eq!(
                            (body.mass, body.first_moment[2], body.second_moment[2][2]),
                            (0.0, 0.0, 0.0)
                        );
                        counts[0] += 1;
                        if is_tip {
                            assert_eq!(body.first_moment[..2], before.first_moment[..2]);
                        }
                        if body.parent == WORLD {
                            let numbers = body.second_moment.as_flattened();
                            assert!(
                                numbers[0] > 0.0 && numbers[1..].iter().all(|&x| x == 0.0),
                                "{numbers:?}"
                            );
                        } else if is_tip {
                            assert_eq!(body.second_moment[..2], before.second_moment[..2]);
                        }
                    }
                    Motion::Prismatic => {
                        assert!(body.second_moment.as_flattened().iter().all(|&x| x == 0.0));
                        counts[1] += 1;
                        if body.parent == WORLD {
                            assert_eq!(body.first_moment, [0.0; 4]);
                        } else if is_tip {
                            assert_eq!((body.mass, body.first_moment), (before.mass, before.first_moment));
                        }
                    }
                    _ => {}
                }
            }
        }
        assert!(counts.iter().all(|&count| count > 10), "{counts:?}");
    }
}
