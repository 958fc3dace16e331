//! The length of a spatial tendon, and its derivatives by the coordinates.
//!
//! ℓ = Σ (lengths of the straight parts + lengths on surfaces)/divisor. A straight part from a to b along the
//! unit vector u changes by uᵀ(J_b − J_a) v. Where the path leaves a surface it is tangent to it, so that a
//! motion of the surface moves these points without a change of the part between them: the part contributes
//! nothing.

mod curvature;
mod derivatives;
mod path_number;
mod wrapping;

use std::collections::{BTreeSet, HashMap};

use nalgebra::{Matrix3, Vector3};
use robot_dynamics_description::{Pose, SpatialTendonDescription, TendonPathElement, TendonSurface};

use self::wrapping::{Wrap, wrap};
use crate::kinematics::body_placement::Placement;
use crate::model::WORLD;
use crate::{Frame, Model};

pub use derivatives::{LengthDerivatives, LengthEntry};

/// The path of a spatial tendon of a compiled robot.
#[derive(Clone, Debug, PartialEq)]
pub struct TendonPath {
    segments: Vec<Segment>,
}

/// A point of a body, or of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
struct BodyPoint {
    body: usize,
    position: Vector3<f64>,
}

/// A sphere or cylinder of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
struct BodySurface {
    body: usize,
    rotation: Matrix3<f64>,
    origin: Vector3<f64>,
    kind: TendonSurface,
    radius: f64,
    side: Option<BodyPoint>,
}

/// The path from one point to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Segment {
    ends: [BodyPoint; 2],
    surface: Option<BodySurface>,
    /// 1/divisor.
    share: f64,
}

impl TendonPath {
    /// The paths of all spatial tendons of a robot, in the order of its description.
    pub fn all(model: &Model) -> Vec<Self> {
        let frames = Frames::new(model);
        model.description().spatial_tendons.iter().map(|tendon| Self::new(&frames, tendon)).collect()
    }

    fn new(frames: &Frames<'_>, tendon: &SpatialTendonDescription) -> Self {
        let (mut segments, mut share) = (Vec::new(), 1.0);
        let mut last: Option<BodyPoint> = None;
        let mut passed: Option<BodySurface> = None;
        for element in &tendon.path {
            match element {
                TendonPathElement::Point { frame } => {
                    let point = frames.point(frame);
                    if let Some(last) = last {
                        segments.push(Segment { ends: [last, point], surface: passed.take(), share });
                    }
                    last = Some(point);
                }
                TendonPathElement::Surface { link, link_from_surface, surface, radius, side } => {
                    let (body, body_from_link) = frames.place(link);
                    let Pose { rotation, translation } = body_from_link.compose(link_from_surface);
                    passed = Some(BodySurface {
                        body,
                        rotation: Matrix3::from_fn(|i, j| rotation[i][j]),
                        origin: translation.into(),
                        kind: *surface,
                        radius: *radius,
                        side: side.as_ref().map(|frame| frames.point(frame)),
                    });
                }
                TendonPathElement::Pulley { divisor } => {
                    (last, passed, share) = (None, None, 1.0 / divisor);
                }
            }
        }
        Self { segments }
    }

    /// The coordinates that may change ℓ, in increasing order.
    pub fn coordinates(&self, model: &Model) -> Vec<usize> {
        let mut all = BTreeSet::new();
        for Segment { ends: [from, to], surface, .. } in &self.segments {
            let through = surface.as_ref().map_or(to.body, |surface| surface.body);
            for [one, other] in [[from.body, to.body], [from.body, through], [through, to.body]] {
                let carrier = model.common_ancestor([one, other]);
                for body in [one, other] {
                    all.extend(model.coordinates_between(carrier, body));
                }
            }
        }
        all.into_iter().collect()
    }

    /// ℓ at a placement \[m\].
    pub fn length(&self, placement: &Placement) -> f64 {
        let mut sum = 0.0;
        for segment in &self.segments {
            segment.visit(placement, |share, length, _| sum += share * length);
        }
        sum
    }

    /// ℓ at a placement \[m\], and ∂ℓ̇/∂v, nv entries.
    pub fn length_and_row(&self, model: &Model, placement: &Placement, row: &mut [f64]) -> f64 {
        row.fill(0.0);
        let mut sum = 0.0;
        for segment in &self.segments {
            segment.visit(placement, |share, length, straight| {
                sum += share * length;
                if let Some([from, to]) = straight
                    && from.0 != to.0
                    && let Some(along) = (to.1 - from.1).try_normalize(0.0)
                {
                    add_motion(model, placement, [to, from], along * share, row);
                    add_motion(model, placement, [from, to], along * -share, row);
                }
            });
        }
        sum
    }
}

/// A body, and a point in the world.
type PlacedPoint = (usize, Vector3<f64>);

/// row += uᵀ ∂ṗ/∂v of a point, without the degrees of freedom that carry the other point, too.
fn add_motion(
    model: &Model,
    placement: &Placement,
    [(body, point), (other, _)]: [PlacedPoint; 2],
    along: Vector3<f64>,
    row: &mut [f64],
) {
    if body == WORLD {
        return;
    }
    let carrier = if other == WORLD { WORLD } else { model.common_ancestor([body, other]) };
    placement.each_motion_on(model, [body, carrier], point, |dof, velocity, _| {
        row[dof.coordinate] += dof.ratio * along.dot(&velocity);
    });
}

impl Segment {
    /// Calls `visit` with the share, the length and, for straight parts, the ends of each part.
    fn visit(&self, placement: &Placement, mut visit: impl FnMut(f64, f64, Option<[PlacedPoint; 2]>)) {
        let [from, to] = self.ends.map(|end| (end.body, end.in_world(placement)));
        let mut straight =
            |from: PlacedPoint, to: PlacedPoint| visit(self.share, (to.1 - from.1).norm(), Some([from, to]));
        let Some((surface, found)) = self.surface.and_then(|surface| {
            let found = surface.wrap(placement, [from.1, to.1])?;
            Some((surface, found))
        }) else {
            return straight(from, to);
        };
        straight(from, (surface.body, found.ends[0]));
        straight((surface.body, found.ends[1]), to);
        visit(self.share, found.length, None);
    }
}

impl BodySurface {
    /// Its axes, as columns, and its origin in the world.
    fn place(&self, placement: &Placement) -> (Matrix3<f64>, Vector3<f64>) {
        let (rotation, translation) = placement.body(self.body);
        (rotation * self.rotation, rotation * self.origin + translation)
    }

    /// The part of the path between two points of the world that is on the surface, in the world.
    fn wrap(&self, placement: &Placement, points: [Vector3<f64>; 2]) -> Option<Wrap> {
        let (axes, origin) = self.place(placement);
        let into_surface = |point: Vector3<f64>| axes.tr_mul(&(point - origin));
        let side = self.side.map(|side| into_surface(side.in_world(placement)));
        let Wrap { ends, length } = wrap(self.kind, self.radius, points.map(into_surface), side)?;
        Some(Wrap { ends: ends.map(|end| axes * end + origin), length })
    }
}

impl BodyPoint {
    fn in_world(&self, placement: &Placement) -> Vector3<f64> {
        let (rotation, translation) = placement.body(self.body);
        rotation * self.position + translation
    }
}

/// The frames of a robot by name.
struct Frames<'a>(HashMap<&'a str, &'a Frame>);

impl<'a> Frames<'a> {
    fn new(model: &'a Model) -> Self {
        Self(model.frames().iter().map(|frame| (frame.name.as_str(), frame)).collect())
    }

    /// The body of a link or frame, and the frame's pose in it.
    fn place(&self, name: &str) -> (usize, Pose) {
        // `Model::new` has found all names.
        let Some(Frame { body, body_from_frame, .. }) = self.0.get(name) else {
            return (WORLD, Pose::IDENTITY);
        };
        (body.unwrap_or(WORLD), *body_from_frame)
    }

    /// The origin of a link or frame.
    fn point(&self, name: &str) -> BodyPoint {
        let (body, body_from_frame) = self.place(name);
        BodyPoint { body, position: body_from_frame.translation.into() }
    }
}
