//! The pairs of shapes of two links that may touch, and their contact points.

use nalgebra::Vector3;
use robot_dynamics_core::model::WORLD;
use robot_dynamics_core::{Model, Workspace, neutral};
use robot_dynamics_number::InvalidInput;

use super::ContactSet;
use super::candidates::Candidates;
use super::closest_points::ClosestPoints;
use super::components::floating_part;
use super::ground::{axes, bad_friction, bad_restitution};
use super::pair::{PairContacts, ShapePair};
use super::placed_pair::MOST_PAIR_POINTS;
use super::placed_shape::PlacedShape;
use super::shape_point::{ContactPartner, ShapePoint};
use super::soft::mixed;
use crate::placement::Placement;

/// The overlap of two shapes in the neutral configuration that exceeds rounding \[m\].
const OVERLAP: f64 = 1e-9;

impl ContactSet {
    /// Adds contacts between links: all pairs of shapes whose file lets them touch (`contype` and
    /// `conaffinity`, `<exclude>`), with these exceptions:
    /// - shapes of one link, or of a link and the one that carries it by a joint (not a floating one);
    /// - links of one floating body or tree, or of the fixed tree, whose shapes overlap in the neutral
    ///   configuration.
    ///
    /// The contact's surface is MuJoCo's: that of the higher priority, otherwise the larger friction and
    /// `condim`. Pairs that the description names
    /// ([`contact_pairs`](robot_dynamics_description::RobotDescription::contact_pairs)) touch regardless,
    /// with a surface of their own.
    ///
    /// Balls and capsules touch each other in closed form; boxes, cylinders and convex meshes with the
    /// feature `convex`. Other pairs are left out ([`left_out_pairs`](Self::left_out_pairs)).
    ///
    /// ```
    /// use robot_dynamics::contact::ContactSet;
    /// use robot_dynamics::description::{Base, JointDescription, JointKind, LinkDescription};
    /// use robot_dynamics::description::{LinkShape, MassProperties, Pose, RobotDescription, Shape};
    /// use robot_dynamics::description::ShapeRole;
    /// use robot_dynamics::model::Model;
    /// let mut robot = RobotDescription::new("two balls");
    /// robot.links.push(LinkDescription::new("world", None));
    /// for (name, x) in [("left", -0.5), ("right", 0.5)] {
    ///     let ball = MassProperties::new(1.0, nalgebra::Vector3::zeros(), nalgebra::Matrix3::identity() * 4e-3)?;
    ///     robot.links.push(LinkDescription::new(name, ball));
    ///     let at = Pose::from_translation([x, 0.0, 0.0]);
    ///     robot.joints.push(JointDescription::new(format!("to {name}"), JointKind::Floating, "world", name, at));
    ///     robot.shapes.push(LinkShape::new(name, ShapeRole::Collision, Pose::IDENTITY, Shape::Sphere { radius: 0.1 }));
    /// }
    /// let model = Model::new(robot)?;
    /// let contacts = ContactSet::new(&model, &[])?.with_links(&model);
    /// assert_eq!(contacts.pairs().collect::<Vec<_>>(), [("left", "right")]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// If the set belongs to another robot.
    #[track_caller]
    pub fn with_links(mut self, model: &Model) -> Self {
        model.check_identity(&self.robot, "the contact set");
        let mut placement = Placement::new(model);
        placement.set(model, &mut Workspace::new(model), &neutral(model));
        let carriers: Vec<usize> = self.shapes.iter().map(|shape| self.carrier(model, shape.body)).collect();
        let mut candidates = Candidates::new(model, &self.shapes, carriers);
        self.add_stated(model).into_iter().for_each(|shapes| candidates.leave_out(shapes));
        self.candidates = Some(candidates);
        self.find_convex();
        self.note_unknown();
        // The neutral configuration does not determine the relative position of floating bodies.
        let parts: Vec<usize> = self.shapes.iter().map(|shape| floating_part(model, shape.body)).collect();
        let overlapping = self.overlapping_balls(&placement, |set, shapes| {
            parts[shapes[0]] == parts[shapes[1]] && set.can_meet(shapes) && set.may_touch(shapes)
        });
        for shapes in overlapping {
            let Some(gap) = self.overlap(&placement, shapes) else { continue };
            let [a, b] = shapes.map(|shape| &self.shapes[shape].link);
            self.overlapping_pairs.push(format!(
                "links `{a}` and `{b}`: they overlap by {:.1e} m in the neutral configuration",
                -gap
            ));
            self.candidates.iter_mut().for_each(|candidates| candidates.leave_out(shapes));
        }
        self.make_few_pairs(model);
        for pairs in [&mut self.left_out_pairs, &mut self.overlapping_pairs] {
            pairs.sort();
            pairs.dedup();
        }
        self
    }

    /// Adds contacts between the shapes of these two links, whatever their file states, with this friction.
    /// The surface's other numbers are those of the two shapes' mix.
    ///
    /// # Errors
    /// [`InvalidInput`] if the friction is invalid, no two of their shapes have a known contact search, or
    /// neither link moves relative to the other.
    ///
    /// # Panics
    /// If the set belongs to another robot.
    ///
    /// ```
    /// use robot_dynamics::contact::ContactSet;
    /// use robot_dynamics::description::{LinkShape, Pose, Shape, ShapeRole, pendulum};
    /// use robot_dynamics::model::Model;
    /// let mut robot = pendulum(2.0, 0.5);
    /// let links: Vec<String> = robot.links.iter().map(|link| link.name.clone()).collect();
    /// for link in &links {
    ///     let ball = Shape::Sphere { radius: 0.1 };
    ///     robot.shapes.push(LinkShape::new(link, ShapeRole::Collision, Pose::IDENTITY, ball));
    /// }
    /// let model = Model::new(robot)?;
    /// let contacts = ContactSet::new(&model, &[])?;
    /// assert_eq!(contacts.clone().with_links(&model).pairs().count(), 0); // one carries the other
    /// assert_eq!(contacts.with_pair(&model, [&links[0], &links[1]], 0.5)?.pairs().count(), 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[track_caller]
    pub fn with_pair(mut self, model: &Model, links: [&str; 2], friction: f64) -> Result<Self, InvalidInput> {
        model.check_identity(&self.robot, "the contact set");
        if !(friction >= 0.0 && friction.is_finite()) {
            return Err(bad_friction(friction));
        }
        let links_of = |set: &Self, shapes: [usize; 2]| {
            let [a, b] = shapes.map(|shape| set.shapes[shape].link.as_str());
            [a, b] == links || [b, a] == links
        };
        self.retain_pairs(|set, pair| !links_of(set, pair.shapes));
        let kept = self.pairs.len();
        let [ones, twos] = links.map(|link| {
            let of = |index: &usize| self.shapes[*index].link == link;
            (0..self.shapes.len()).filter(of).collect::<Vec<_>>()
        });
        for &one in &ones {
            for &two in &twos {
                let [a, b] = [one, two].map(|index| self.shapes[index].body);
                if a != b && self.is_known([one, two]) {
                    let mut surface = mixed(&self.shapes[one].surface, &self.shapes[two].surface);
                    surface.friction[0] = friction;
                    self.add_named(ShapePair::new(model, [(one, a), (two, b)], surface));
                    self.candidates.iter_mut().for_each(|candidates| candidates.exclude_links([one, two]));
                }
            }
        }
        if self.pairs.len() == kept {
            let pair = format!("links `{}` and `{}`", links[0], links[1]);
            let requirement = "cannot touch: each needs a collision shape of a known kind, and one must move relative \
                               to the other";
            return Err(InvalidInput::unmet(pair, requirement));
        }
        Ok(self)
    }

    /// Sets the restitution between links: the fraction, 0 to 1, of their normal speed with which they
    /// separate; 0 by default.
    ///
    /// ```
    /// use robot_dynamics::contact::ContactSet;
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let contacts = ContactSet::new(&Model::new(pendulum(2.0, 0.5))?, &[])?;
    /// assert!(contacts.clone().with_link_restitution(0.9).is_ok());
    /// assert!(contacts.with_link_restitution(1.1).is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`InvalidInput`].
    pub fn with_link_restitution(self, restitution: f64) -> Result<Self, InvalidInput> {
        if !(0.0..=1.0).contains(&restitution) {
            return Err(bad_restitution(restitution));
        }
        Ok(Self { link_restitution: restitution, ..self })
    }

    /// The links of each pair of shapes that may touch.
    pub fn pairs(&self) -> impl Iterator<Item = (&str, &str)> {
        let named = self.named_pairs().map(|pair| pair.shapes);
        named.chain(self.pairs_by_rule()).map(|shapes| {
            let [a, b] = shapes.map(|shape| self.shapes[shape].link.as_str());
            (a, b)
        })
    }

    /// Pairs of links that could touch but are left out, each with the reason.
    pub fn left_out_pairs(&self) -> &[String] {
        &self.left_out_pairs
    }

    /// Links whose shapes overlap in the neutral configuration, as those of neighbours often do; they do not
    /// touch each other.
    pub fn overlapping_pairs(&self) -> &[String] {
        &self.overlapping_pairs
    }

    /// The body that carries this one, skipping bodies without mass and shape.
    fn carrier(&self, model: &Model, body: usize) -> usize {
        let parent = |body: usize| if body == WORLD { WORLD } else { model.bodies[body].parent };
        let mut at = parent(body);
        while at != WORLD && model.bodies[at].mass == 0.0 && self.shapes.iter().all(|shape| shape.body != at)
        {
            at = parent(at);
        }
        at
    }

    /// Calls `visit` for each point of each pair [found near](Self::find_near) with a gap of at most `within`
    /// \[m\].
    pub(super) fn for_each_pair_contact(
        &self,
        placement: &Placement,
        within: f64,
        mut visit: impl FnMut(ShapePoint),
    ) {
        let center = |shape: usize| {
            let (rotation, p) = placement.body(self.shapes[shape].body);
            p + rotation * self.shapes[shape].translation
        };
        // Pairs with the same second shape are adjacent. The distance of centres rejects most of them.
        let mut second = (usize::MAX, Vector3::zeros());
        let is_active = |pair: &&usize| self.pairs[**pair].shapes.iter().all(|shape| self.is_active(*shape));
        for &index in self.sweep.near().iter().filter(is_active) {
            let pair = &self.pairs[index];
            let [one, two] = pair.shapes;
            if second.0 != two {
                second = (two, center(two));
            }
            let [a, b] = pair.shapes.map(|shape| &self.shapes[shape]);
            let reach = a.reach + b.reach + within;
            if (center(one) - second.1).norm_squared() > reach * reach {
                continue;
            }
            let placed = [a, b].map(|shape| shape.placed(placement));
            self.meeting(pair.shapes, &placed, within).each(|k, found| {
                if found.gap <= within {
                    visit(self.at_pair(index, &placed[0], found, k));
                }
            });
        }
    }

    /// Point k of that pair, at any distance. The contact points of the last pair are cached.
    pub(super) fn point_of_pair_after(
        &self,
        placement: &Placement,
        number: usize,
        last: &mut Option<PairContacts>,
    ) -> ShapePoint {
        let (number, k) = (number / MOST_PAIR_POINTS, number % MOST_PAIR_POINTS);
        // The pairs of the last step exist.
        let index = self.sweep.slot_of(number).unwrap_or_default();
        let pair = &self.pairs[index];
        let shapes = pair.shapes.map(|shape| &self.shapes[shape]);
        let kept = last.take_if(|met| met.number == number);
        let met = kept.unwrap_or_else(|| {
            let placed = shapes.map(|shape| shape.placed(placement));
            let meeting = self.meeting(pair.shapes, &placed, shapes[0].reach + shapes[1].reach);
            PairContacts { number, placed, meeting }
        });
        let placed = &met.placed;
        // Without such a point, the shapes are far from each other.
        let apart = placed[0].center - placed[1].center;
        let far = || ClosestPoints {
            gap: f64::INFINITY,
            at: (placed[0].center + placed[1].center) * 0.5,
            normal: apart.try_normalize(0.0).unwrap_or_else(Vector3::z),
        };
        let found = met.meeting.point(k).unwrap_or_else(far);
        let point = self.at_pair(index, &placed[0], found, k);
        *last = Some(met);
        point
    }

    /// The least gap of two shapes, if it is below 0.
    fn overlap(&self, placement: &Placement, shapes: [usize; 2]) -> Option<f64> {
        let placed = shapes.map(|shape| self.shapes[shape].placed(placement));
        let mut least = None;
        self.meeting(shapes, &placed, 0.0).each(|_, found| {
            least = least.filter(|least| *least < found.gap).or(Some(found.gap));
        });
        least.filter(|gap| *gap < -OVERLAP)
    }

    fn at_pair(&self, index: usize, first: &PlacedShape, found: ClosestPoints, k: usize) -> ShapePoint {
        let pair = &self.pairs[index];
        // The tangential directions turn with the first shape.
        let axes = axes(first.rotation.tr_mul(&found.normal)).map(|axis| first.rotation * axis);
        ShapePoint {
            number: self.ground_point_count() + pair.number * MOST_PAIR_POINTS + k,
            shape: pair.shapes[0],
            against: ContactPartner::Pair(index),
            gap: found.gap,
            at: found.at,
            axes,
        }
    }
}
