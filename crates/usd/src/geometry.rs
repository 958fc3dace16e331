//! Units, bodies, and the poses of prims in them.

use nalgebra::{Matrix3, Vector3};
use robot_dynamics_description::Pose;

use crate::findings::Findings;
use crate::prim::{Prim, Scene};
use crate::transform::{Affine, local_transform, matrix};

/// USD's default unit of length \[m\].
const CENTIMETER: f64 = 0.01;

/// The number of the world among the nodes that joints connect. Body i is node i + 1.
pub(crate) const WORLD_NODE: usize = 0;

/// Poses of all prims, in m.
#[derive(Debug)]
pub(crate) struct Geometry<'s> {
    pub(crate) scene: &'s Scene,
    /// \[m\] per unit of length.
    pub(crate) meters: f64,
    /// \[kg\] per unit of mass.
    pub(crate) kilograms: f64,
    /// The rotation from the axes of the stage to those of the world, whose z axis points up.
    pub(crate) world_from_stage: Matrix3<f64>,
    local: Vec<Affine>,
    world_from_prim: Vec<Affine>,
    /// The prims of the bodies.
    pub(crate) bodies: Vec<usize>,
    /// The node of each prim.
    pub(crate) node_of: Vec<usize>,
    /// \[rad\] per unit of the angles in MuJoCo's attributes.
    pub(crate) mujoco_angle: f64,
}

impl<'s> Geometry<'s> {
    pub(crate) fn new(scene: &'s Scene, findings: &mut Findings) -> Self {
        let meters = unit(scene.meters, CENTIMETER, "metersPerUnit", findings);
        let kilograms = unit(scene.kilograms, 1.0, "kilogramsPerUnit", findings);
        let world_from_stage = match scene.up.as_deref() {
            Some("Z") => Matrix3::identity(),
            Some("X") => Matrix3::new(0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0),
            up => {
                if up.is_none() {
                    findings.default_value("/", "upAxis is not given: Y, the default of USD");
                }
                Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0)
            }
        };
        let count = scene.prims.len();
        let mut geometry = Self {
            scene,
            meters,
            kilograms,
            world_from_stage,
            local: Vec::with_capacity(count),
            world_from_prim: Vec::with_capacity(count),
            bodies: Vec::new(),
            node_of: Vec::with_capacity(count),
            mujoco_angle: mujoco_angle(scene),
        };
        for at in 0..count {
            geometry.place(at, findings);
        }
        geometry
    }

    /// Adds the next prim, whose parent is placed.
    fn place(&mut self, at: usize, findings: &mut Findings) {
        let prim = &self.scene.prims[at];
        let Some(parent) = prim.parent else {
            self.local.push(Affine::IDENTITY);
            self.world_from_prim.push(Affine::linear(self.world_from_stage * self.meters));
            self.node_of.push(WORLD_NODE);
            return;
        };
        let (local, resets) = local_transform(prim).unwrap_or_else(|reason| {
            findings.refuse(&prim.path, reason);
            (Affine::IDENTITY, false)
        });
        let parent = if resets { 0 } else { parent };
        let world = self.world_from_prim[parent].compose(&local);
        let is_body = prim.has("PhysicsRigidBodyAPI") && prim.flag("physics:rigidBodyEnabled") != Some(false);
        let node = if is_body {
            if local.linear.determinant() < 0.0 {
                findings.warn(
                    &prim.path,
                    "its scale mirrors the body: all three axes are mirrored; remove the negative scale",
                );
            }
            self.bodies.push(at);
            self.bodies.len()
        } else {
            self.node_of[parent]
        };
        self.local.push(local);
        self.world_from_prim.push(world);
        self.node_of.push(node);
    }

    /// The prim of a body.
    pub(crate) fn body(&self, node: usize) -> &'s Prim {
        &self.scene.prims[self.bodies[node - 1]]
    }

    pub(crate) fn world_from_node(&self, node: usize) -> Pose {
        match node {
            WORLD_NODE => Pose::IDENTITY,
            _ => self.world_from_prim[self.bodies[node - 1]].rigid(),
        }
    }

    /// The transform of a prim in the rigid frame of its node, in m.
    pub(crate) fn node_from_prim(&self, prim: usize) -> Affine {
        let node = self.node_of[prim];
        if node == WORLD_NODE {
            return self.world_from_prim[prim];
        }
        // Without a detour over the world, which would round.
        let body = self.bodies[node - 1];
        let chain: Vec<usize> = self.scene.upward(prim).take_while(|&at| at != body).collect();
        let stretch = Affine::linear(self.world_from_prim[body].stretch());
        chain.iter().rev().fold(stretch, |total, &at| total.compose(&self.local[at]))
    }

    /// A frame at a point and a rotation in the frame of a prim, in the frame of the prim's node.
    pub(crate) fn frame(&self, prim: usize, point: Vector3<f64>, rotation: Matrix3<f64>) -> Pose {
        let node_from_prim = self.node_from_prim(prim);
        let turned = matrix(&node_from_prim.rigid()) * rotation;
        Pose {
            rotation: core::array::from_fn(|i| core::array::from_fn(|j| turned[(i, j)])),
            translation: node_from_prim.apply(point).into(),
        }
    }
}

/// A unit of the stage in SI.
fn unit(written: Option<f64>, default: f64, name: &str, findings: &mut Findings) -> f64 {
    match written {
        Some(unit) if unit > 0.0 && unit.is_finite() => unit,
        Some(unit) => {
            findings.refuse("/", format!("{name} = {unit} is not a unit; write 1 for SI units"));
            default
        }
        None if default == 1.0 => default,
        None => {
            findings.default_value("/", format!("{name} is not given: {default}, the default of USD"));
            default
        }
    }
}

/// MuJoCo's angles are in degrees, unless the settings of the compiler state radians.
fn mujoco_angle(scene: &Scene) -> f64 {
    let is_radian = |prim: &Prim| prim.word("mjc:compiler:angle") == Some("radian");
    if scene.prims.iter().any(is_radian) { 1.0 } else { 1_f64.to_radians() }
}
