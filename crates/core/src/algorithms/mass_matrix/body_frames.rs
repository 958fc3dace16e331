//! The composite-rigid-body algorithm in the bodies' own frames.
//!
//! A composite inertia is rotated by its joint, then into the parent's frame. A joint's momentum goes from
//! body to body, and each joint on the way takes its component.
//!
//! In body frames a joint's motion is a unit vector, and a quarter turn about an axis only permutes numbers.
//! With [`FOLDS_ZEROS`](robot_dynamics_number::Triple::FOLDS_ZEROS) this takes half the operations of the
//! form in one frame. **(RBDA §6.2)**

use robot_dynamics_number::Scalar;

use super::entries::{Entries, add_armature, add_reduced};
use crate::Model;
use crate::kinematics::parent_inertia::{in_parent, own_inertia, turn_of};
use crate::kinematics::placement::place_bodies;
use crate::kinematics::world_frame::{add_composite, momentum_of};
use crate::model::WORLD;
use crate::workspace::tree::TreeMemory;

/// Writes all entries of M, whichever are selected.
#[inline(always)]
pub(super) fn write_matrix<S: Scalar>(
    model: &Model,
    tree: &mut TreeMemory<S>,
    q: &[S],
    mass: &mut [S],
    _: Entries,
) {
    place_bodies(model, tree, q);
    let (composites, places) = (&mut tree.inertias.composite, &tree.bodies.place);
    for (composite, body) in composites.iter_mut().zip(&model.bodies) {
        *composite = own_inertia(body);
    }
    mass.fill(S::zero());
    for (i, body) in model.bodies.iter().enumerate().rev() {
        let composite = composites[i];
        for k in 0..body.motion.nv() {
            let unit: [S; 6] = core::array::from_fn(|at| if at == k { S::one() } else { S::zero() });
            let mut momentum = momentum_of(&composite, &body.motion.velocity(&unit));
            for along in 0..=k {
                let entry = body.motion.force_along(along, &momentum);
                add_reduced(model, mass, body.dof + along, body.dof + k, entry);
            }
            let mut at = i;
            while model.bodies[at].parent != WORLD {
                momentum = places[at].force_in_parent(&momentum);
                at = model.bodies[at].parent;
                let carrier = &model.bodies[at];
                for along in 0..carrier.motion.nv() {
                    let entry = carrier.motion.force_along(along, &momentum);
                    add_reduced(model, mass, carrier.dof + along, body.dof + k, entry);
                }
            }
        }
        if body.parent != WORLD {
            let turn = turn_of(model, &tree.angles, q, i);
            add_composite(&mut composites[body.parent], &in_parent(body, &turn, &places[i], &composite));
        }
    }
    add_armature(model, mass);
}

#[cfg(test)]
mod tests {
    use robot_dynamics_description::{Base, RandomRobotOptions, random_robot};
    use robot_dynamics_number::SplitMix64;

    use super::*;
    use crate::{Workspace, mass_matrix, random_state};

    /// Compares with the form in one frame, with mimic joints and tendons' armature. The tolerance covers the
    /// rounding of sums of about a hundred products.
    #[test]
    fn the_matrix_is_that_in_one_frame() {
        for seed in 0..40 {
            let base = if seed % 2 == 0 { Base::Floating } else { Base::Fixed };
            let options = RandomRobotOptions {
                joints: 9,
                base,
                mimic: 0.2,
                tendons: 1,
                passive: 0.5,
                ..Default::default()
            };
            let model = Model::new(random_robot(seed, &options)).unwrap();
            let q = random_state(&model, &mut SplitMix64::new(seed)).q;
            let w = &mut Workspace::<f64>::limited(&model, crate::InstructionSet::Portable);
            let (mut found, mut expected) =
                (vec![0.0; model.nv() * model.nv()], vec![0.0; model.nv() * model.nv()]);
            mass_matrix(&model, w, &q, &mut expected);
            write_matrix(&model, &mut w.tree, &q, &mut found, Entries::All);
            let size = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            for (found, expected) in found.iter().zip(&expected) {
                assert!((found - expected).abs() < 1e-13 * size, "{seed}: {found} {expected}");
            }
        }
    }
}
