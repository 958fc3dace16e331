//! The points of a robot's shapes that can touch the ground z = 0, over any number type.

use robot_dynamics_core::{FrameId, Model, ReferenceFrame, Workspace, frame_jacobian, frame_pose};
use robot_dynamics_description::{LinkShape, Pose, Shape, ShapeRole};
use robot_dynamics_number::{InvalidInput, Scalar};

/// A shape that can touch the ground.
#[derive(Clone, Debug)]
pub(super) struct ContactShapePoints {
    pub(super) link: String,
    /// The last coordinate that moves it; all others are its ancestors.
    pub(super) coordinate: usize,
    frame: FrameId,
    link_from_shape: Pose,
    form: Form,
}

/// The points of a shape in its own frame.
#[derive(Clone, Debug)]
enum Form {
    /// Balls of one radius about these points.
    Balls { centers: Vec<[f64; 3]>, radius: f64 },
    /// About z, from −half to half: of each end the lowest point of the rim, and two at 120° from it.
    Cylinder { radius: f64, half: f64 },
    /// Its half axes: the lowest point.
    Ellipsoid([f64; 3]),
}

/// A contact point: its height above the ground \[m\], and its Jacobian, rows z, x, y, each \[nv\].
pub(super) struct ContactPointRows<S> {
    pub(super) gap: S,
    pub(super) rows: [Vec<S>; 3],
}

/// The part of a cylinder's reference direction that fixes the point where the cylinder stands upright. The
/// point is then that far from the lowest one, as a fraction of the radius.
const UPRIGHT: f64 = 1e-3;

/// The shapes of this robot that can touch the ground.
pub(super) fn shapes_on_ground(model: &Model) -> Result<Vec<ContactShapePoints>, InvalidInput> {
    let touches = |shape: &&LinkShape| {
        shape.role == ShapeRole::Collision && (shape.surface.contype | shape.surface.conaffinity) & 1 != 0
    };
    let mut shapes = Vec::new();
    for shape in model.description().shapes.iter().filter(touches) {
        let Some(frame) = model.frame(&shape.link) else { continue };
        let Some(body) = model.frame_of(frame).body else { continue };
        let moving = model.coordinates_between(robot_dynamics_core::model::WORLD, body);
        let Some(&coordinate) = moving.last() else { continue };
        let form = Form::of(&shape.shape).ok_or_else(|| {
            let name = if shape.name.is_empty() { String::new() } else { format!(" `{}`", shape.name) };
            let quantity = format!("the collision shape{name} of link `{}`", shape.link);
            let wanted = "must be a sphere, capsule, box, cylinder or ellipsoid: remove or replace it";
            InvalidInput::unmet(quantity, wanted)
        })?;
        shapes.push(ContactShapePoints {
            link: shape.link.clone(),
            coordinate,
            frame,
            link_from_shape: shape.link_from_shape,
            form,
        });
    }
    Ok(shapes)
}

impl Form {
    fn of(shape: &Shape) -> Option<Self> {
        Some(match *shape {
            Shape::Sphere { radius } => Self::Balls { centers: vec![[0.0; 3]], radius },
            Shape::Capsule { radius, length } => {
                let half = 0.5 * length;
                Self::Balls { centers: vec![[0.0, 0.0, half], [0.0, 0.0, -half]], radius }
            }
            Shape::Box { size } => {
                let corner = |k: usize| {
                    core::array::from_fn(|i| if k >> i & 1 == 0 { 0.5 * size[i] } else { -0.5 * size[i] })
                };
                Self::Balls { centers: (0..8).map(corner).collect(), radius: 0.0 }
            }
            Shape::Cylinder { radius, length } => Self::Cylinder { radius, half: 0.5 * length },
            Shape::Ellipsoid { half_axes } => Self::Ellipsoid(half_axes),
            Shape::Plane { .. } | Shape::HeightField { .. } | Shape::Mesh { .. } => return None,
        })
    }
}

impl ContactShapePoints {
    /// The number of its points.
    pub(super) fn count(&self) -> usize {
        match &self.form {
            Form::Balls { centers, .. } => centers.len(),
            Form::Cylinder { .. } => 6,
            Form::Ellipsoid(_) => 1,
        }
    }

    /// Its points in the shape's frame; `down` is a unit vector.
    fn points<S: Scalar>(&self, down: [S; 3]) -> Vec<[S; 3]> {
        match &self.form {
            Form::Balls { centers, radius } => {
                let lowest = |center: &[f64; 3]| {
                    core::array::from_fn(|i| S::from_f64(center[i]) + down[i].scale(*radius))
                };
                centers.iter().map(lowest).collect()
            }
            Form::Cylinder { radius, half } => cylinder_points(*radius, *half, down),
            Form::Ellipsoid(axes) => {
                // The normal at x is A⁻²x: x = A²n/|A n|.
                let scaled: [S; 3] = core::array::from_fn(|i| down[i].scale(axes[i]));
                let length = scaled.iter().map(|&x| x * x).fold(S::zero(), |sum, x| sum + x).sqrt();
                vec![core::array::from_fn(|i| scaled[i].scale(axes[i]) / length)]
            }
        }
    }

    /// Appends its points with their Jacobians.
    pub(super) fn add_rows<S: Scalar>(
        &self,
        model: &Model,
        workspace: &mut Workspace<S>,
        q: &[S],
        rows: &mut Vec<ContactPointRows<S>>,
    ) {
        let nv = model.nv();
        let link = frame_pose(model, workspace, q, self.frame);
        let mut jacobian = vec![S::zero(); 6 * nv];
        frame_jacobian(model, workspace, q, self.frame, ReferenceFrame::LocalWorldAligned, &mut jacobian);
        let (turned, shift) = (self.link_from_shape.rotation, self.link_from_shape.translation);
        let rotation: [[S; 3]; 3] = core::array::from_fn(|i| {
            core::array::from_fn(|j| {
                let entry = |k: usize| link.rotation[i][k].scale(turned[k][j]);
                entry(0) + entry(1) + entry(2)
            })
        });
        let times = |r: &[[S; 3]; 3], x: [S; 3]| -> [S; 3] {
            core::array::from_fn(|i| r[i][0] * x[0] + r[i][1] * x[1] + r[i][2] * x[2])
        };
        let shift = times(&link.rotation, shift.map(S::from_f64));
        for point in self.points(core::array::from_fn(|j| -rotation[2][j])) {
            let own = times(&rotation, point);
            // From the link's origin, where the Jacobian is known.
            let [x, y, z]: [S; 3] = core::array::from_fn(|i| shift[i] + own[i]);
            let row = |i: usize, (a, b): (usize, S), (c, d): (usize, S)| -> Vec<S> {
                let entry = |k: usize| {
                    jacobian[i * nv + k] + jacobian[(3 + a) * nv + k] * b - jacobian[(3 + c) * nv + k] * d
                };
                (0..nv).map(entry).collect()
            };
            rows.push(ContactPointRows {
                gap: link.translation[2] + z,
                rows: [row(2, (0, y), (1, x)), row(0, (1, z), (2, y)), row(1, (2, x), (0, z))],
            });
        }
    }
}

/// The lowest point of the rim of each end of a cylinder, and two points at 120° from it.
fn cylinder_points<S: Scalar>(radius: f64, half: f64, down: [S; 3]) -> Vec<[S; 3]> {
    // The direction across the axis, with a small constant part that keeps it defined.
    let (x, y) = (down[0] + S::from_f64(UPRIGHT), down[1]);
    let length = (x * x + y * y + S::from_f64(UPRIGHT * UPRIGHT * 1e-6)).sqrt();
    let (x, y) = (x / length, y / length);
    let turn = |cosine: f64, sine: f64| (x.scale(cosine) - y.scale(sine), y.scale(cosine) + x.scale(sine));
    let third = 0.75_f64.sqrt();
    let around = [(x, y), turn(-0.5, third), turn(-0.5, -third)];
    let end = |z: f64| around.map(|(x, y)| [x.scale(radius), y.scale(radius), S::from_f64(z)]);
    end(half).into_iter().chain(end(-half)).collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Vector3};
    use robot_dynamics_description::{Base, LinkDescription, MassProperties, RobotDescription};
    use robot_dynamics_number::SplitMix64;

    use super::*;
    use crate::contact::{ContactSet, Ground};

    /// The lowest point of each shape has the height that the search for contacts finds, in random poses. A
    /// cylinder's reference direction moves its point by [`UPRIGHT`], at second order in the height.
    #[test]
    fn the_lowest_point_is_that_of_the_contact_search() {
        let mut random = SplitMix64::new(3);
        let shapes = [
            (Shape::Sphere { radius: 0.3 }, 1e-14),
            (Shape::Capsule { radius: 0.1, length: 0.4 }, 1e-14),
            (Shape::Box { size: [0.2, 0.3, 0.5] }, 1e-14),
            (Shape::Cylinder { radius: 0.2, length: 0.3 }, 0.2 * UPRIGHT),
            (Shape::Ellipsoid { half_axes: [0.1, 0.2, 0.4] }, 1e-14),
        ];
        for (shape, tolerance) in shapes {
            let mut robot = RobotDescription::new("body");
            robot.base = Base::Floating;
            let mass = MassProperties::new(1.0, Vector3::zeros(), Matrix3::identity()).unwrap();
            robot.links.push(LinkDescription::new("body", mass));
            let (sin, cos) = 0.3_f64.sin_cos();
            let turned = Pose {
                rotation: [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]],
                translation: [0.05, -0.02, 0.1],
            };
            robot.shapes = vec![LinkShape::new("body", ShapeRole::Collision, turned, shape.clone())];
            let model = Model::new(robot).unwrap();
            let contacts = ContactSet::new(&model, &[Ground::level(0.0)]).unwrap();
            let shapes = shapes_on_ground(&model).unwrap();
            for _ in 0..50 {
                let mut q: Vec<f64> = (0..7).map(|_| random.uniform(-1.0, 1.0)).collect();
                let length = q[3..].iter().map(|x| x * x).sum::<f64>().sqrt();
                q[3..].iter_mut().for_each(|x| *x /= length);
                let expected = contacts.clearance(&model, &mut Workspace::new(&model), &q).unwrap();
                let mut points = Vec::new();
                shapes[0].add_rows(&model, &mut Workspace::new(&model), &q, &mut points);
                let found = points.iter().map(|point| point.gap).fold(f64::INFINITY, f64::min);
                assert!((found - expected).abs() < tolerance, "{shape:?}: {found} for {expected}");
            }
        }
    }
}
