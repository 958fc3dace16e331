//! Rotors that turn with a sum of joint positions: the armature of a tendon over several joints.

use robot_dynamics_description::RobotDescription;
use robot_dynamics_number::Scalar;

use crate::model::body::Dof;
use crate::model::joint::Joint;

/// A rotor that turns with ℓ = Σ cᵢ qᵢ. Its kinetic energy is ½ armature ℓ̇², and it adds armature·c cᵀ to M.
/// c is constant, so the rotor adds nothing to C and g.
#[derive(Clone, Debug)]
pub struct Rotor {
    armature: f64,
    /// The coordinates with their cᵢ; each is given by the tree's DoF of that coordinate.
    terms: Vec<(usize, f64)>,
}

impl Rotor {
    /// The rotors of the description's tendons. A tendon over one coordinate adds to that coordinate's
    /// armature.
    pub(crate) fn of_tendons(
        description: &RobotDescription,
        joints: &[Joint],
        dofs: &mut [Dof],
    ) -> Vec<Self> {
        let mut rotors = Vec::new();
        for tendon in description.tendons.iter().filter(|tendon| tendon.passive.armature != 0.0) {
            let mut terms: Vec<(usize, f64)> = Vec::new();
            for (name, c) in &tendon.terms {
                // A locked joint has no DoF; a mimic joint's is its leader's.
                let Some(own) = dofs.iter().find(|dof| joints[dof.joint].name == *name) else { continue };
                let is_leader =
                    |dof: &Dof| dof.coordinate == own.coordinate && joints[dof.joint].mimic.is_none();
                let leader = dofs.iter().position(is_leader).expect("chains of mimic joints end");
                let c = c * own.ratio;
                match terms.iter_mut().find(|(dof, _)| *dof == leader) {
                    Some((_, sum)) => *sum += c,
                    None => terms.push((leader, c)),
                }
            }
            match terms[..] {
                [] => {}
                [(dof, c)] => dofs[dof].passive.armature += tendon.passive.armature * c * c,
                _ => rotors.push(Self { armature: tendon.passive.armature, terms }),
            }
        }
        rotors
    }

    /// τ += armature·c (cᵀa), over the tree's DoFs. With v in place of a it adds the rotor's momentum.
    #[inline(always)]
    pub fn add_force<N: Scalar>(&self, a: &[N], tau: &mut [N]) {
        let force = self.rate(a).scale(self.armature);
        for &(dof, c) in &self.terms {
            tau[dof] += force.scale(c);
        }
    }

    /// The same, with τ over the coordinates.
    #[inline(always)]
    pub(crate) fn add_force_to_coordinates<N: Scalar>(&self, dofs: &[Dof], a: &[N], tau: &mut [N]) {
        let force = self.rate(a).scale(self.armature);
        for &(dof, c) in &self.terms {
            tau[dofs[dof].coordinate] += force.scale(c);
        }
    }

    /// armature (cᵀv)², twice the kinetic energy.
    #[inline(always)]
    pub(crate) fn twice_energy<N: Scalar>(&self, v: &[N]) -> N {
        let rate = self.rate(v);
        (rate * rate).scale(self.armature)
    }

    #[inline(always)]
    fn rate<N: Scalar>(&self, v: &[N]) -> N {
        self.terms.iter().fold(N::zero(), |sum, &(dof, c)| sum + v[dof].scale(c))
    }

    /// Its entries of M by row and column, in both triangles, which agree to the last bit.
    pub fn entries(&self, dofs: &[Dof]) -> impl Iterator<Item = (usize, usize, f64)> {
        let terms = || self.terms.iter().map(|&(dof, c)| (dofs[dof].coordinate, c));
        terms().flat_map(move |(i, x)| terms().map(move |(j, y)| (i, j, self.armature * (x * y))))
    }

    /// Its coordinates, each with √(armature c²).
    pub fn roots(&self, dofs: &[Dof]) -> impl Iterator<Item = (usize, f64)> {
        let root = self.armature.abs().sqrt();
        self.terms.iter().map(move |&(dof, c)| (dofs[dof].coordinate, root * c.abs()))
    }
}
