//! The same equation of motion with fewer inertial parameters.
//!
//! The mass on a revolute joint's axis moves like the parent body, whatever the joint does. On a prismatic
//! joint, so does a pure second moment ∫ r rᵀ dm (without mass and first moment). Moving these parameters to
//! the parent leaves the equation of motion unchanged.
//!
//! A link on a revolute joint keeps seven of its ten numbers. For a serial arm with skew axes these are the
//! base parameters. On a joint in the world it keeps three, or m alone if the joint is prismatic.
//!
//! Source: Khalil, Dombre, *Modeling, Identification and Control of Robots* (2002), §9.4. The pseudo-inertia
//! of Atkeson, An, Hollerbach (1986) and Wensing, Kim, Slotine (2018) reduces it to two rules.

use robot_dynamics_number::algebra::{PaddedColumns, padded_columns};

use crate::Model;
use crate::joint::PrimitiveJoint;
use crate::model::{Body, WORLD};

impl Model {
    /// This robot with mass moved towards the root across its joints, so that most entries are zero and
    /// generated code takes fewer operations. M(q), C(q, v) and g(q) agree up to rounding.
    ///
    /// Quantities of single bodies and of the total mass do **not** agree: the centre of mass and the zero of
    /// the potential energy change. The description remains the original one.
    #[doc(hidden)]
    #[must_use]
    pub fn regrouped(&self) -> Self {
        let mut model = self.without_native_code();
        for i in (0..model.bodies.len()).rev() {
            let (below, from) = model.bodies.split_at_mut(i);
            let carried = match from[0].motion {
                PrimitiveJoint::Revolute => take_from_axis(&mut from[0]),
                PrimitiveJoint::Prismatic => take_second_moment(&mut from[0]),
                PrimitiveJoint::Helical(_) | PrimitiveJoint::Spherical | PrimitiveJoint::Floating => continue,
            };
            if from[0].parent == WORLD {
                keep_what_resists(&mut from[0]);
            } else {
                carried.add_to(&mut below[from[0].parent], &from[0]);
            }
        }
        model
    }

    /// The length of the longest run of consecutive links with equal mass properties and placement. After
    /// [`regrouped`](Self::regrouped) such links differ, because each includes mass from its subtree.
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

/// Removes m, h_z and Σ_zz, the mass on the axis, and returns them.
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

/// Keeps only the parameters that matter on a joint in the world. A revolute joint needs I_zz = Σ_xx + Σ_yy,
/// stored in Σ_xx, and h perpendicular to the axis for its weight. A prismatic joint needs m.
fn keep_what_resists(body: &mut Body) {
    if body.motion == PrimitiveJoint::Prismatic {
        body.first_moment = [0.0; 4];
        return;
    }
    let resists = body.second_moment[0][0] + body.second_moment[1][1];
    body.second_moment = padded_columns([[resists, 0.0, 0.0], [0.0; 3], [0.0; 3]]);
    body.inertia = inertia(&body.second_moment);
}

/// Removes Σ, which affects no force of a prismatic joint, and returns it.
fn take_second_moment(body: &mut Body) -> Moments {
    let second = core::array::from_fn(|j| core::array::from_fn(|i| body.second_moment[j][i]));
    body.second_moment = [[0.0; 4]; 3];
    body.inertia = [[0.0; 4]; 3];
    Moments { mass: 0.0, first: [0.0; 3], second }
}

impl Moments {
    /// Adds the moments to the parent of their body. The body's placement at q = 0 stands for any other. With
    /// the body's origin p and rotation R it adds m, m p + R h and R Σ Rᵀ + p (R h)ᵀ + (R h) pᵀ + m p pᵀ.
    fn add_to(&self, parent: &mut Body, body: &Body) {
        let (columns, p) = (&body.rotation, &body.translation);
        let turned = |x: &[f64; 3], i: usize| (0..3).map(|k| columns[k][i] * x[k]).sum::<f64>();
        let first: [f64; 3] = core::array::from_fn(|i| turned(&self.first, i));
        // R Σ by columns.
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
    use robot_dynamics_description::{Base, RandomRobotOptions, random_robot};
    use robot_dynamics_number::SplitMix64;

    use super::*;
    use crate::{
        RandomState, Workspace, coriolis_matrix, forward_dynamics, inverse_dynamics, mass_matrix,
        random_state,
    };

    /// Largest difference, as a multiple of the largest value.
    fn difference(one: &[f64], other: &[f64]) -> f64 {
        let largest = one.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        one.iter().zip(other).fold(0.0_f64, |most, (x, y)| most.max((x - y).abs())) / largest
    }

    /// Regrouping preserves all terms for trees with every kind of joint, mimic joints, tendons and springs.
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
            // Sums of about twenty terms of the size of the largest. a is divided by M, with a condition
            // number below 1e5.
            let allowed = [1e-13, 1e-13, 1e-13, 1e-10];
            for ((one, other), allowed) in terms(&model).iter().zip(&terms(&regrouped)).zip(allowed) {
                let off = difference(one, other);
                assert!(off < allowed, "seed {seed}: {off:e}");
            }
        }
    }

    /// Four links that are equal except for the first one's axis, and a fifth heavier one. The first axis is
    /// y of the world and z of the next links.
    #[test]
    fn equal_links_are_counted() {
        let mut robot = robot_dynamics_description::pendulum(2.0, 0.5);
        let (link, joint) = (robot.links.last().unwrap().clone(), robot.joints[0].clone());
        let tip = link.name.clone();
        for (k, mass) in [2.0, 2.0, 2.0, 3.0].into_iter().enumerate() {
            let mut heavier = link.clone();
            heavier.name = format!("link{k}");
            heavier.mass_properties =
                robot_dynamics_description::pendulum(mass, 0.5).links.last().unwrap().mass_properties;
            let mut hinge = joint.clone();
            hinge.name = format!("hinge{k}");
            hinge.parent = if k == 0 { tip.clone() } else { format!("link{}", k - 1) };
            hinge.child = heavier.name.clone();
            robot.links.push(heavier);
            robot.joints.push(hinge);
        }
        assert_eq!(Model::new(robot).unwrap().longest_run_of_equal_links(), 3);
    }

    /// A link on a revolute joint keeps seven numbers, and one that slides keeps m and h. The remaining
    /// numbers are unchanged to the last bit.
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
                    PrimitiveJoint::Revolute => {
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
                    PrimitiveJoint::Prismatic => {
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
