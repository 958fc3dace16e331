//! Contact points of shapes with height fields.

use nalgebra::Vector3;

use super::PlacedField;
use super::ellipsoid::{PlacedEllipsoid, TrianglePoint};
use crate::contact::ContactSet;
use crate::contact::contact_detection::{ExtremePoints, MOST_POINTS};
use crate::contact::contact_geometry::ContactGeometry;
use crate::contact::contact_shape::ContactShape;
use crate::contact::ground::axes;
use crate::contact::placed_shape::PlacedShape;
use crate::contact::shape_point::{ContactPartner, ShapePoint};

/// A shape that may touch a field, both by their indices.
#[derive(Clone, Copy)]
struct FieldPair<'a> {
    set: &'a ContactSet,
    shape: usize,
    field: usize,
    placed: &'a PlacedShape,
    /// The number of the first point of the first shape at the field's first face.
    first: usize,
}

impl ContactSet {
    /// The number of possible contacts with height fields.
    pub(in crate::contact) fn field_count(&self) -> usize {
        self.points * self.fields.iter().map(PlacedField::count).sum::<usize>()
    }

    /// Calls `visit` for each point of that shape whose gap to a height field is at most `within` \[m\].
    pub(in crate::contact) fn for_each_field_contact(
        &self,
        (shape, placed): (usize, &PlacedShape),
        within: f64,
        mut visit: impl FnMut(ShapePoint),
    ) {
        let (reach, count) = (self.shapes[shape].reach, self.shapes[shape].form.count());
        let mut first = self.points * self.grounds.len();
        for (index, field) in self.fields.iter().enumerate() {
            let meeting = FieldPair { set: self, shape, field: index, placed, first };
            first += self.points * field.count();
            if !self.meets_field(shape, index) {
                continue;
            }
            if field.inward(&placed.center).z > field.facets.highest + reach + within {
                continue;
            }
            if count <= MOST_POINTS {
                meeting.for_each_contact(within, &mut visit);
            } else {
                let [x, y] = [0, 1].map(|k| field.rotation.column(k).into_owned());
                let mut outermost = ExtremePoints::new([x, y]);
                meeting.for_each_contact(within, |point| outermost.add(point));
                outermost.each(&mut visit);
            }
        }
    }

    /// The point of this number among those of all fields, at any distance; without a gap if it is not above
    /// that face.
    pub(in crate::contact) fn point_at_field(
        &self,
        placed: impl FnOnce(&ContactShape) -> PlacedShape,
        number: usize,
    ) -> ShapePoint {
        let (mut field, mut first) = (0, self.points * self.grounds.len());
        let mut rest = number - first;
        while rest >= self.points * self.fields[field].count() {
            rest -= self.points * self.fields[field].count();
            first += self.points * self.fields[field].count();
            field += 1;
        }
        let (face, point) = (rest / self.points, rest % self.points);
        let shape = self.shapes.partition_point(|shape| shape.first <= point) - 1;
        let placed = placed(&self.shapes[shape]);
        let k = point - self.shapes[shape].first;
        FieldPair { set: self, shape, field, placed: &placed, first }.point(k, face)
    }
}

impl FieldPair<'_> {
    fn form(&self) -> &ContactGeometry {
        &self.set.shapes[self.shape].form
    }

    fn field(&self) -> &PlacedField {
        &self.set.fields[self.field]
    }

    fn for_each_contact(&self, within: f64, mut visit: impl FnMut(ShapePoint)) {
        let field = self.field();
        let facets = &field.facets;
        let reach = self.set.shapes[self.shape].reach;
        let center = field.inward(&self.placed.center);
        let mut push = |point: ShapePoint| {
            if point.gap <= within {
                visit(point);
            }
        };
        for k in 0..self.form().count() {
            if let Some(smooth) = self.smooth(k) {
                if let Some(face) = self.face_over(&smooth) {
                    push(self.at_face(k, face));
                    continue;
                }
                for near in smooth.near_faces(facets, within).iter().flatten() {
                    if near.edge.is_none() || smooth.is_least(facets, near) {
                        push(self.at_near(k, near));
                    }
                }
            } else if self.form().is_lowest(k) {
                for triangle in facets.within(&center, reach) {
                    let face = facets.of[triangle];
                    let point = self.at_face(k, face);
                    let is_over = || facets.around(&field.inward(&point.at)).contains(&Some(triangle));
                    if self.form().takes_part(k, &self.down(face)) && is_over() {
                        push(point);
                    }
                }
            } else {
                let at = field.inward(&self.placed.at(&self.form().point(k, &Vector3::zeros())));
                for triangle in facets.around(&at).into_iter().flatten() {
                    let face = facets.of[triangle];
                    if self.form().takes_part(k, &self.down(face)) || !self.has_lowest(k, face) {
                        push(self.at_face(k, face));
                    }
                }
            }
        }
    }

    fn point(&self, k: usize, face: usize) -> ShapePoint {
        let field = self.field();
        let facets = &field.facets;
        let mut point = self.at_face(k, face);
        let Some(smooth) = self.smooth(k) else {
            if !self.is_over(&point.at, face) {
                point.gap = f64::INFINITY;
            }
            return point;
        };
        match self.face_over(&smooth) {
            Some(under) if under == face => return point,
            None => {
                let own = facets.within(&smooth.center, 2.0 * smooth.half_axes.max());
                let own = own.filter(|triangle| facets.of[*triangle] == face);
                let near = own.filter_map(|triangle| smooth.near(facets, triangle));
                if let Some(near) = near.min_by(|a, b| a.gap.total_cmp(&b.gap)) {
                    return self.at_near(k, &near);
                }
            }
            Some(_) => {}
        }
        point.gap = f64::INFINITY;
        point
    }

    /// Point k as a ball or an ellipsoid, if it is one.
    fn smooth(&self, k: usize) -> Option<PlacedEllipsoid> {
        let field = self.field();
        let (at, half_axes) = match self.form() {
            ContactGeometry::Rounded { centers, radius } if *radius > 0.0 => {
                (centers[k], Vector3::repeat(*radius))
            }
            ContactGeometry::Ellipsoid(half_axes) => (Vector3::zeros(), *half_axes),
            _ => return None,
        };
        let center = field.inward(&self.placed.at(&at));
        Some(PlacedEllipsoid { center, rotation: field.rotation.tr_mul(&self.placed.rotation), half_axes })
    }

    /// The face that a centre is below, through which the shape leaves the ground.
    fn face_over(&self, smooth: &PlacedEllipsoid) -> Option<usize> {
        let facets = &self.field().facets;
        let triangle = facets.under(&smooth.center)?;
        (facets.plane(triangle).gap(&smooth.center) < 0.0).then(|| facets.of[triangle])
    }

    /// Whether that point of the world is above or below the face, or next to it in a valley.
    fn is_over(&self, at: &Vector3<f64>, face: usize) -> bool {
        let field = self.field();
        let around = field.facets.around(&field.inward(at));
        around.into_iter().flatten().any(|triangle| field.facets.of[triangle] == face)
    }

    /// Whether the lowest point of the rim that has point k is above the face.
    fn has_lowest(&self, k: usize, face: usize) -> bool {
        let form = self.form();
        let lowest = (0..=k).rev().find(|k| form.is_lowest(*k));
        lowest.is_some_and(|lowest| self.is_over(&self.at_face(lowest, face).at, face))
    }

    /// The direction into the face, in the shape's frame.
    fn down(&self, face: usize) -> Vector3<f64> {
        let field = self.field();
        -self.placed.rotation.tr_mul(&(field.rotation * field.facets.planes[face].normal))
    }

    /// Point k relative to the plane of the face.
    fn at_face(&self, k: usize, face: usize) -> ShapePoint {
        let field = self.field();
        let plane = &field.facets.planes[face];
        let at = self.placed.at(&self.form().point(k, &self.down(face)));
        self.touching((k, face), at, plane.gap(&field.inward(&at)), field.rotation * plane.normal)
    }

    fn at_near(&self, k: usize, near: &TrianglePoint) -> ShapePoint {
        let field = self.field();
        let face = field.facets.of[near.triangle];
        match near.edge {
            None => self.at_face(k, face),
            Some([at, normal]) => {
                let at = field.origin + field.rotation * at;
                self.touching((k, face), at, near.gap, field.rotation * normal)
            }
        }
    }

    fn touching(
        &self,
        (k, face): (usize, usize),
        at: Vector3<f64>,
        gap: f64,
        normal: Vector3<f64>,
    ) -> ShapePoint {
        let own = self.set.shapes[self.shape].first + k;
        ShapePoint {
            number: self.first + face * self.set.points + own,
            shape: self.shape,
            against: ContactPartner::Field(self.field),
            gap,
            at,
            axes: axes(normal),
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;
    use robot_dynamics_core::{Model, Workspace, neutral};
    use robot_dynamics_description::{
        Base, LinkDescription, LinkShape, Pose, RobotDescription, Shape, ShapeRole,
    };
    use robot_dynamics_number::SplitMix64;

    use super::*;
    use crate::HeightField;
    use crate::placement::Placement;

    /// One shape of a free body, a field, and the body's placement at a random height above or in its
    /// surface.
    fn placed(shape: Shape, random: &mut SplitMix64) -> (ContactSet, Placement, HeightField, [f64; 7]) {
        let mut robot = RobotDescription::new("body");
        robot.base = Base::Floating;
        let mass =
            robot_dynamics_description::MassProperties::new(1.0, Vector3::zeros(), Matrix3::identity())
                .unwrap();
        robot.links.push(LinkDescription::new("body", mass));
        robot.shapes.push(LinkShape::new("body", ShapeRole::Collision, Pose::IDENTITY, shape));
        let model = Model::new(robot).unwrap();
        let heights = (0..35).map(|_| random.uniform(0.0, 0.4)).collect();
        let field = HeightField::new(5, 7, [1.2, 0.8], heights).unwrap();
        let set = ContactSet::new(&model, &[]).unwrap().with_height_field(&field).unwrap();
        let mut q: [f64; 7] = neutral(&model).try_into().unwrap();
        let [x, y] = [random.uniform(-0.8, 0.8), random.uniform(-0.5, 0.5)];
        q[..3].copy_from_slice(&[x, y, field.height(x, y).unwrap() + random.uniform(0.02, 0.3)]);
        (3..7).for_each(|k| q[k] = random.uniform(-1.0, 1.0));
        let norm = q[3..].iter().map(|q| q * q).sum::<f64>().sqrt();
        q[3..].iter_mut().for_each(|q| *q /= norm);
        let mut placement = Placement::new(&model);
        placement.set(&model, &mut Workspace::new(&model), &q);
        (set, placement, field, q)
    }

    /// The triangles by the definition of the grid.
    fn triangles(field: &HeightField) -> Vec<[Vector3<f64>; 3]> {
        let node = |row: usize, column: usize| {
            let (x, y) = (0.4 * column as f64 - 1.2, 0.4 * row as f64 - 0.8);
            // Next to the node, inside of the rectangle.
            Vector3::new(x, y, field.height(x * (1.0 - 1e-14), y * (1.0 - 1e-14)).unwrap())
        };
        let cells = (0..4).flat_map(|row| (0..6).map(move |column| (row, column)));
        cells
            .flat_map(|(r, c)| {
                let [a, b, c, d] = [node(r, c), node(r, c + 1), node(r + 1, c + 1), node(r + 1, c)];
                [[a, b, c], [a, c, d]]
            })
            .collect()
    }

    /// The nearest point of a segment.
    fn on_segment(p: &Vector3<f64>, a: &Vector3<f64>, b: &Vector3<f64>) -> Vector3<f64> {
        a + (b - a) * ((p - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0)
    }

    /// The nearest point of a triangle: in its plane if it is inside the three edges, and otherwise on one of
    /// them.
    fn on_triangle(p: &Vector3<f64>, corners: &[Vector3<f64>; 3]) -> Vector3<f64> {
        let [a, b, c] = corners;
        let n = (b - a).cross(&(c - a)).normalize();
        let foot = p - n * n.dot(&(p - a));
        let edges = [(a, b), (b, c), (c, a)];
        if edges.iter().all(|(from, to)| (*to - *from).cross(&(foot - *from)).dot(&n) >= 0.0) {
            return foot;
        }
        let ends = edges.map(|(from, to)| on_segment(p, from, to));
        ends.into_iter().min_by(|x, y| (x - p).norm().total_cmp(&(y - p).norm())).unwrap()
    }

    /// Gap, normal and point of balls are those of the nearest of all triangles. Each further contact is at a
    /// local minimum of the distance.
    #[test]
    fn balls_touch_where_they_are_nearest() {
        let mut random = SplitMix64::new(11);
        let (mut on_edges, mut several) = (0, 0);
        for case in 0..2000 {
            let radius = random.uniform(0.02, 0.4);
            let (set, placement, field, q) = placed(Shape::Sphere { radius }, &mut random);
            let center = Vector3::from_row_slice(&q[..3]);
            let all = triangles(&field);
            let points: Vec<_> = all.iter().map(|corners| on_triangle(&center, corners)).collect();
            let nearest =
                points.iter().min_by(|x, y| (*x - center).norm().total_cmp(&(*y - center).norm())).unwrap();
            let distance = (nearest - center).norm();
            let mut found = Vec::new();
            set.for_each_ground_contact(&placement, 0.5, |point| found.push(point));
            assert!(!found.is_empty(), "case {case}");
            let least = found.iter().min_by(|a, b| a.gap.total_cmp(&b.gap)).unwrap();
            // Distances agree to rounding; within 1e-6 R of a face's edge the normal is still the face's.
            assert!((least.gap - (distance - radius)).abs() < 1e-12, "case {case}: {least:?} for {distance}");
            let normal = (center - nearest) / distance;
            assert!(
                (least.axes[0] - normal).norm() < 1e-12 / distance + 1e-6,
                "case {case}: {least:?}, {normal}"
            );
            assert!((center - least.axes[0] * radius - least.at).norm() < 1e-12, "case {case}: {least:?}");
            for point in &found {
                let on_field = point.at - point.axes[0] * point.gap;
                let own = (on_field - center).norm();
                // No neighbouring point is nearer.
                for corners in &all {
                    if (on_triangle(&on_field, corners) - on_field).norm() < 1e-9 {
                        let other = (on_triangle(&center, corners) - center).norm();
                        assert!(other > own - 1e-9, "case {case}: {other} is nearer than {point:?}");
                    }
                }
            }
            for (k, point) in found.iter().enumerate() {
                let is_new =
                    |other: &ShapePoint| other.number != point.number && (other.at - point.at).norm() > 1e-9;
                assert!(found[..k].iter().all(is_new), "case {case}: {found:?}");
            }
            let is_plane =
                set.fields[0].facets.planes.iter().any(|plane| (plane.normal - least.axes[0]).norm() < 1e-9);
            on_edges += usize::from(!is_plane);
            several += usize::from(found.len() > 1);
        }
        assert!(on_edges > 200 && several > 200, "{on_edges} on edges, {several} with several contacts");
    }

    /// An ellipsoid touches if it contains points of the triangles, by sampling: it contains x if |D⁻¹Rᵀ(x −
    /// c)| < 1.
    #[test]
    fn ellipsoids_touch_where_points_are_in_them() {
        let mut random = SplitMix64::new(5);
        let (mut touching, mut apart) = (0, 0);
        for case in 0..300 {
            let half_axes = Vector3::from_fn(|_, _| random.uniform(0.05, 0.3));
            let (set, placement, field, _) =
                placed(Shape::Ellipsoid { half_axes: half_axes.into() }, &mut random);
            let shape = set.shapes[0].placed(&placement);
            let into =
                |x: Vector3<f64>| shape.rotation.tr_mul(&(x - shape.center)).component_div(&half_axes).norm();
            let mut least = f64::INFINITY;
            let steps = 40;
            for [a, b, c] in triangles(&field) {
                for i in 0..=steps {
                    for j in 0..=steps - i {
                        let [s, t] = [i, j].map(|k| f64::from(k) / f64::from(steps));
                        least = least.min(into(a + (b - a) * s + (c - a) * t));
                    }
                }
            }
            let mut gap = f64::INFINITY;
            set.for_each_ground_contact(&placement, f64::INFINITY, |point| gap = gap.min(point.gap));
            // The samples are at most 0.7 cm from any point, so a penetration of that depth contains a
            // sample.
            let slack = 0.007 / half_axes.min();
            if least < 1.0 {
                assert!(gap < 0.0, "case {case}: {gap} for {least}");
                touching += 1;
            } else if least > 1.0 + slack {
                assert!(gap > 0.0, "case {case}: {gap} for {least}");
                // It is at most the distance along the longest axis.
                assert!(gap <= (least - 1.0) * half_axes.max() + 1e-12, "case {case}: {gap} for {least}");
                apart += 1;
            }
        }
        assert!(touching > 50 && apart > 50, "{touching} {apart}");
    }
}
