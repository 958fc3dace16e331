//! The rows of the table.

use Input::{Acceleration, Force, Frame, Velocity};

use super::arguments::ResultShape::{Point, Poses, Rows, Scalar, Square, Vector};
use super::arguments::{Input, Inputs, QuantityResult};
use crate::{Model, ReferenceFrame, Workspace};
use robot_dynamics_description::Pose;

/// Generates the enum, its list and its calls from the rows.
macro_rules! table {
    ($(
        $(#[$doc:meta])*
        $variant:ident($name:literal, $title:literal) [$($input:ident),*] => [$($result:literal: $shape:expr),*] {
            one |$model:ident, $w:ident, $i:ident, $out:ident, $poses:ident| $single:expr;
        }
    )*) => {
        /// A quantity of a state: a row of the table of algorithms.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub enum Quantity {
            $($(#[$doc])* $variant,)*
        }

        impl Quantity {
            /// Every row of the table.
            pub const ALL: [Self; [$(Self::$variant),*].len()] = [$(Self::$variant),*];

            /// The name, equal to that of its function.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }

            /// The title, with its symbol.
            pub fn title(self) -> &'static str {
                match self {
                    $(Self::$variant => $title,)*
                }
            }

            /// Its inputs besides q.
            pub fn inputs(self) -> &'static [Input] {
                match self {
                    $(Self::$variant => &[$($input),*],)*
                }
            }

            /// Its results, in order.
            pub fn results(self) -> &'static [QuantityResult] {
                match self {
                    $(Self::$variant => &[$(QuantityResult { name: $result, shape: $shape }),*],)*
                }
            }

            #[track_caller]
            pub(super) fn call(
                self,
                model: &Model,
                workspace: &mut Workspace,
                inputs: &Inputs<'_>,
                results: [&mut [f64]; 3],
                poses: &mut [Pose],
            ) {
                match self {
                    $(Self::$variant => {
                        let ($model, $w, $i, $out, $poses) = (model, workspace, inputs, results, poses);
                        let _ = (&$out, &$poses);
                        $single;
                    })*
                }
            }
        }
    };
}

table! {
    /// M(q).
    MassMatrix("mass_matrix", "mass matrix M(q)") [] => ["": Square] {
        one |m, w, i, out, _p| crate::mass_matrix(m, w, i.q, out[0]);
    }

    /// C(q, v) v + g(q).
    Bias("bias", "bias C v + g") [Velocity] => ["": Vector] {
        one |m, w, i, out, _p| crate::bias(m, w, i.q, i.v, out[0]);
    }

    /// g(q), springs included.
    Gravity("gravity", "gravity g(q)") [] => ["": Vector] {
        one |m, w, i, out, _p| crate::gravity(m, w, i.q, out[0]);
    }

    /// C(q, v) of the Christoffel symbols.
    CoriolisMatrix("coriolis_matrix", "Coriolis matrix C(q,v)") [Velocity] => ["": Square] {
        one |m, w, i, out, _p| crate::coriolis_matrix(m, w, i.q, i.v, out[0]);
    }

    /// C(q, v) v.
    VelocityProduct("velocity_product", "velocity product C v") [Velocity] => ["": Vector] {
        one |m, w, i, out, _p| crate::velocity_product(m, w, i.q, i.v, out[0]);
    }

    /// τ = M a + C v + g.
    InverseDynamics("inverse_dynamics", "inverse dynamics τ(q,v,a)") [Velocity, Acceleration] => ["": Vector] {
        one |m, w, i, out, _p| crate::inverse_dynamics(m, w, i.q, i.v, i.a, out[0]);
    }

    /// a = M⁻¹(τ − C v − g).
    ForwardDynamics("forward_dynamics", "forward dynamics a(q,v,τ)") [Velocity, Force] => ["": Vector] {
        one |m, w, i, out, _p| crate::forward_dynamics(m, w, i.q, i.v, i.tau, out[0]);
    }

    /// M(q)⁻¹.
    InverseMassMatrix("inverse_mass_matrix", "inverse mass matrix M⁻¹(q)") [] => ["": Square] {
        one |m, w, i, out, _p| crate::inverse_mass_matrix(m, w, i.q, out[0]);
    }

    /// L and D of M(q) = LᵀDL.
    MassMatrixFactor("mass_matrix_factor", "factor LᵀDL of M(q)") [] => ["": Square] {
        one |m, w, i, out, _p| crate::mass_matrix_factor(m, w, i.q, out[0]);
    }

    /// K(q, v).
    KineticEnergy("kinetic_energy", "kinetic energy K(q,v)") [Velocity] => ["": Scalar] {
        one |m, w, i, out, _p| out[0][0] = crate::kinetic_energy(m, w, i.q, i.v);
    }

    /// V(q).
    PotentialEnergy("potential_energy", "potential energy V(q)") [] => ["": Scalar] {
        one |m, w, i, out, _p| out[0][0] = crate::potential_energy(m, w, i.q);
    }

    /// p = M(q) v.
    Momentum("momentum", "momentum M v") [Velocity] => ["": Vector] {
        one |m, w, i, out, _p| crate::momentum(m, w, i.q, i.v, out[0]);
    }

    /// The centre of mass, in the world.
    CenterOfMass("center_of_mass", "centre of mass") [] => ["": Point] {
        one |m, w, i, out, _p| out[0].copy_from_slice(&crate::center_of_mass(m, w, i.q));
    }

    /// The Jacobian of the centre of mass, along the world's axes.
    CenterOfMassJacobian("center_of_mass_jacobian", "Jacobian of the centre of mass") [] => ["": Rows(3)] {
        one |m, w, i, out, _p| crate::center_of_mass_jacobian(m, w, i.q, out[0]);
    }

    /// The centroidal momentum matrix, \[linear, angular\].
    CentroidalMomentumMatrix("centroidal_momentum_matrix", "centroidal momentum matrix") [] => ["": Rows(6)] {
        one |m, w, i, out, _p| crate::centroidal_momentum_matrix(m, w, i.q, out[0]);
    }

    /// `world_from_frame`: for one state of all frames of the model, for a batch of the given frames.
    FramePoses("frame_poses", "poses of all frames") [] => ["": Poses] {
        one |m, w, i, out, poses| crate::frame_poses(m, w, i.q, poses);
    }

    /// A frame's Jacobian in `ReferenceFrame::LocalWorldAligned`, \[linear, angular\].
    FrameJacobianLocalWorldAligned("frame_jacobian_local_world_aligned", "Jacobian of a frame, its origin, world axes") [Frame] => ["": Rows(6)] {
        one |m, w, i, out, _p| {
            crate::frame_jacobian(m, w, i.q, i.frames[0], ReferenceFrame::LocalWorldAligned, out[0]);
        };
    }

    /// A frame's Jacobian in `ReferenceFrame::Local`, \[linear, angular\].
    FrameJacobianLocal("frame_jacobian_local", "Jacobian of a frame, its origin, own axes") [Frame] => ["": Rows(6)] {
        one |m, w, i, out, _p| crate::frame_jacobian(m, w, i.q, i.frames[0], ReferenceFrame::Local, out[0]);
    }

    /// A frame's Jacobian in `ReferenceFrame::World`, \[linear, angular\].
    FrameJacobianWorld("frame_jacobian_world", "Jacobian of a frame, world origin, world axes") [Frame] => ["": Rows(6)] {
        one |m, w, i, out, _p| crate::frame_jacobian(m, w, i.q, i.frames[0], ReferenceFrame::World, out[0]);
    }

    /// ∂τ/∂q and ∂τ/∂v.
    InverseDynamicsDerivatives("inverse_dynamics_derivatives", "∂τ/∂q, ∂τ/∂v") [Velocity, Acceleration] => ["by_position": Square, "by_velocity": Square] {
        one |m, w, i, out, _p| {
            let [x, y, _] = out;
            crate::inverse_dynamics_derivatives(m, w, i.q, i.v, i.a, crate::InverseDynamicsDerivativesMut { by_position: x, by_velocity: y });
        };
    }

    /// ∂a/∂q, ∂a/∂v and ∂a/∂τ.
    ForwardDynamicsDerivatives("forward_dynamics_derivatives", "∂a/∂q, ∂a/∂v, ∂a/∂τ") [Velocity, Force] => ["by_position": Square, "by_velocity": Square, "by_force": Square] {
        one |m, w, i, out, _p| {
            let [x, y, z] = out;
            crate::forward_dynamics_derivatives(m, w, i.q, i.v, i.tau, crate::ForwardDynamicsDerivativesMut { by_position: x, by_velocity: y, by_force: z });
        };
    }

    /// ∂g/∂q.
    GravityDerivative("gravity_derivative", "∂g/∂q") [] => ["": Square] {
        one |m, w, i, out, _p| crate::gravity_derivative(m, w, i.q, out[0]);
    }
}

impl Quantity {
    /// Whether it is undefined if M is singular.
    pub fn inverts_mass(self) -> bool {
        matches!(
            self,
            Self::ForwardDynamics
                | Self::InverseMassMatrix
                | Self::MassMatrixFactor
                | Self::ForwardDynamicsDerivatives
        )
    }
}
