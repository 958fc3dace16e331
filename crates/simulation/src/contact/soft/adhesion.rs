//! Forces of actuators that pull the contacts of a link together.

use nalgebra::Vector3;
use robot_dynamics_core::clone_in_place::clone_in_place;
use robot_dynamics_core::{FrameId, Model};

use super::point::SoftContact;
use super::point_rows::Bodies;

clone_in_place! {
    /// The adhesion of links, and its forces at the last state.
    #[derive(Debug)]
    pub(super) struct Adhesion {
        /// Each link with the force that its contacts share \[N\].
        links: Vec<(FrameId, f64)>,
        /// The contacts in the gap beyond their margin, which have no force of their own.
        pub(super) near: Vec<SoftContact>,
        /// The generalized forces at the last state.
        forces: Vec<f64>,
    }
}

impl Adhesion {
    pub(super) fn new(nv: usize) -> Self {
        Self { links: Vec::new(), near: Vec::new(), forces: vec![0.0; nv] }
    }

    /// Sets the links, each with the force that its contacts share.
    pub(super) fn set(&mut self, links: impl Iterator<Item = (FrameId, f64)>) {
        self.links.clear();
        self.links.extend(links);
    }

    /// Whether a link adheres.
    pub(super) fn acts(&self) -> bool {
        !self.links.is_empty()
    }

    /// The generalized forces at the last state, nv entries \[N·m or N\].
    pub(super) fn forces(&self) -> &[f64] {
        &self.forces
    }

    /// Computes the forces. A contact repels along its normal with the row J, and a force f of a link with n
    /// contacts gives −f/n Σ Jᵀ.
    pub(super) fn compute(&mut self, model: &Model, bodies: &Bodies, contacts: &[SoftContact]) {
        let Self { links, near, forces } = self;
        forces.fill(0.0);
        for (link, force) in &*links {
            let of_link = |contact: &&SoftContact| contact.link == *link || contact.other == Some(*link);
            let touching = || contacts.iter().chain(&*near).filter(of_link);
            let count = touching().count() as f64;
            for contact in touching() {
                let normal = Vector3::from(contact.normal) * (-force / count);
                let mut add = |side: FrameId, force: Vector3<f64>| {
                    let Some(body) = model.frame_of(side).body else { return };
                    let point = contact.point.into();
                    bodies.placement.each_motion(model, body, point, |dof, velocity, _| {
                        forces[dof.coordinate] += dof.ratio * force.dot(&velocity);
                    });
                };
                add(contact.link, normal);
                if let Some(other) = contact.other {
                    add(other, -normal);
                }
            }
        }
    }
}
