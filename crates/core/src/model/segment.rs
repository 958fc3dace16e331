//! The tree of links, including fixed ones, for the forces between links of one body.

use std::collections::HashMap;

use robot_dynamics_description::{Base, RobotDescription};
use robot_dynamics_number::algebra::{Padded, PaddedColumns, padded, padded_columns};

use crate::model::joint::Joint;
use crate::model::placed_link::PlacedLink;

/// All links, each after its parent. The links of a subtree are contiguous.
#[derive(Clone, Debug)]
pub struct Segments {
    pub list: Vec<Segment>,
    /// For each link of the description its index in `list`.
    pub of_link: Vec<usize>,
    /// The index of the first joint's child: 1 for a fixed base, whose root link has no joint, else 0.
    pub first: usize,
}

/// One link: its own mass properties, in its own axes and about its own origin.
#[derive(Clone, Debug)]
pub struct Segment {
    /// The index of its parent link, smaller than its own; `None` for the root.
    pub parent: Option<usize>,
    /// One past the last link of its subtree.
    pub end: usize,
    /// Its body; `None` if it is fixed to the world.
    pub body: Option<usize>,
    /// `body_from_link`, or `world_from_link`.
    pub rotation: PaddedColumns,
    pub translation: Padded,
    pub mass: f64,
    /// h = m c \[kg·m\].
    pub first_moment: Padded,
    /// Rotational inertia about the link's origin \[kg·m²\].
    pub inertia: PaddedColumns,
}

impl Segments {
    /// `joints` are in depth-first order, fixed ones included.
    pub fn new(
        description: &RobotDescription,
        link_index: &HashMap<&str, usize>,
        root: usize,
        joints: &[Joint],
        placed: &[PlacedLink],
    ) -> Self {
        let first = usize::from(description.base == Base::Fixed);
        let children = joints.iter().skip(1 - first).map(|joint| link_index[joint.child_link.as_str()]);
        let order: Vec<usize> = core::iter::once(root).chain(children).collect();
        let mut of_link = vec![0; order.len()];
        for (index, &link) in order.iter().enumerate() {
            of_link[link] = index;
        }
        let parents =
            joints.iter().skip(1 - first).map(|joint| of_link[link_index[joint.parent_link.as_str()]]);
        let parents = core::iter::once(None).chain(parents.map(Some));
        let mut list: Vec<Segment> = (order.iter().zip(parents))
            .map(|(&link, parent)| Segment::new(description, link, parent, &placed[link]))
            .collect();
        for index in (0..list.len()).rev() {
            list[index].end = list[index].end.max(index + 1);
            if let Some(parent) = list[index].parent {
                list[parent].end = list[parent].end.max(list[index].end);
            }
        }
        Self { list, of_link, first }
    }
}

impl Segment {
    fn new(description: &RobotDescription, link: usize, parent: Option<usize>, placed: &PlacedLink) -> Self {
        let PlacedLink { body, body_from_link } = placed;
        let (mut mass, mut first_moment, mut inertia) = (0.0, [0.0; 4], [[0.0; 4]; 3]);
        if let Some(own) = &description.links[link].mass_properties {
            mass = own.mass();
            first_moment = padded((own.center_of_mass() * own.mass()).into());
            inertia = padded_columns(own.inertia_about_origin().transpose().data.0);
        }
        Self {
            parent,
            end: 0, // set after all links are added
            body: *body,
            rotation: padded_columns(body_from_link.rotation),
            translation: padded(body_from_link.translation),
            mass,
            first_moment,
            inertia,
        }
    }
}
