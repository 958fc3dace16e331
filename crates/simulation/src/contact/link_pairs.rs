//! Lists of link pairs that must not touch, or that alone may touch.

use std::collections::BTreeSet;

use robot_dynamics_core::Model;
use robot_dynamics_description::unknown_name;
use robot_dynamics_number::InvalidInput;

use super::ContactSet;

impl ContactSet {
    /// Removes contacts between the links of these pairs, whatever their file states, including
    /// `contact_pairs`. If a plane or height field is on one link, the other link does not touch it. Call it
    /// after the links and the planes are added: [`with_links`](Self::with_links).
    ///
    /// ```
    /// use robot_dynamics::contact::ContactSet;
    /// use robot_dynamics::description::{LinkShape, Pose, Shape, ShapeRole, pendulum};
    /// use robot_dynamics::model::Model;
    /// let mut robot = pendulum(2.0, 0.5);
    /// let links = [robot.links[0].name.clone(), robot.links[1].name.clone()];
    /// for link in &links {
    ///     let ball = Shape::Sphere { radius: 0.1 };
    ///     robot.shapes.push(LinkShape::new(link, ShapeRole::Collision, Pose::IDENTITY, ball));
    /// }
    /// let model = Model::new(robot)?;
    /// let contacts = ContactSet::new(&model, &[])?.with_pair(&model, [&links[0], &links[1]], 0.5)?;
    /// let without = contacts.without_link_pairs(&model, &[links.into()])?;
    /// assert_eq!(without.pairs().count(), 0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`InvalidInput`]: a link does not exist.
    ///
    /// # Panics
    /// If the set belongs to another robot.
    #[track_caller]
    pub fn without_link_pairs(
        mut self,
        model: &Model,
        pairs: &[(String, String)],
    ) -> Result<Self, InvalidInput> {
        model.check_identity(&self.robot, "the contact set");
        let listed = both_ways(model, pairs)?;
        self.retain_pairs(|set, pair| !listed.contains(&set.links_of(pair.shapes)));
        let numbers = self.numbers_of(&listed);
        if let Some(candidates) = &mut self.candidates {
            candidates.exclude(numbers);
        }
        let Self { ground_links, ground_surfaces, fields, shapes, .. } = &mut self;
        let grounds = ground_links.iter().zip(ground_surfaces);
        let fields = fields.iter_mut().map(|field| (&field.link, &mut field.surfaces));
        for (ground, surfaces) in grounds.chain(fields) {
            for (shape, surface) in shapes.iter().zip(surfaces.iter_mut().flatten()) {
                if listed.contains(&[ground.clone(), shape.link.clone()]) {
                    *surface = None;
                }
            }
        }
        Ok(self)
    }

    /// Keeps contacts between links for these pairs only, if their file lets them touch. Grounds are not
    /// affected.
    ///
    /// ```
    /// use robot_dynamics::contact::ContactSet;
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let contacts = ContactSet::new(&model, &[])?.with_links(&model);
    /// let error = contacts.with_only_link_pairs(&model, &[("rod".into(), "celing".into())]).unwrap_err();
    /// assert!(error.to_string().contains("did you mean `ceiling`?"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`InvalidInput`]: a link does not exist.
    ///
    /// # Panics
    /// If the set belongs to another robot.
    #[track_caller]
    pub fn with_only_link_pairs(
        mut self,
        model: &Model,
        pairs: &[(String, String)],
    ) -> Result<Self, InvalidInput> {
        model.check_identity(&self.robot, "the contact set");
        let listed = both_ways(model, pairs)?;
        self.retain_pairs(|set, pair| listed.contains(&set.links_of(pair.shapes)));
        let numbers = self.numbers_of(&listed);
        if let Some(candidates) = &mut self.candidates {
            candidates.keep_only(numbers);
        }
        Ok(self)
    }

    fn links_of(&self, shapes: [usize; 2]) -> [String; 2] {
        shapes.map(|shape| self.shapes[shape].link.clone())
    }

    /// The numbers of the links of pairs among the candidates; a link without shapes has no number.
    fn numbers_of(&self, pairs: &BTreeSet<[String; 2]>) -> Vec<[usize; 2]> {
        let Some(candidates) = &self.candidates else { return Vec::new() };
        let shape_of = |link: &String| self.shapes.iter().position(|shape| shape.link == *link);
        let number = |link: &String| shape_of(link).map(|shape| candidates.link(shape));
        pairs.iter().filter_map(|[a, b]| Some([number(a)?, number(b)?])).collect()
    }
}

/// The pairs in both orders.
fn both_ways(model: &Model, pairs: &[(String, String)]) -> Result<BTreeSet<[String; 2]>, InvalidInput> {
    let links: BTreeSet<&str> = model.description().links.iter().map(|link| link.name.as_str()).collect();
    for name in pairs.iter().flat_map(|(a, b)| [a, b]) {
        if !links.contains(name.as_str()) {
            let owner = format!("a pair of links is invalid: robot `{}`", model.name());
            return Err(unknown_name("link", name, owner, links.into_iter()));
        }
    }
    Ok(pairs.iter().flat_map(|(a, b)| [[a.clone(), b.clone()], [b.clone(), a.clone()]]).collect())
}
