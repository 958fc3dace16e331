//! Reads `<mimic>`: q = multiplier · q_leader + offset.

use robot_dynamics_description::Mimic;
use robot_dynamics_xml::excerpt;

use crate::element::Element;
use crate::reader::Reader;
use crate::unread_parts::UnknownPart;

impl<'a> Reader<'a> {
    /// The leader, multiplier and offset of a mimic joint.
    pub(crate) fn mimic(&mut self, joint: &Element<'a>) -> Option<Mimic> {
        let element = self.child(joint, "mimic")?;
        self.list_unread(&element, &["joint", "multiplier", "offset"], &[], UnknownPart::Physics);
        let leader = self.required_name(&element, "joint", "joint=\"NAME\", the joint to follow");
        let ratio = self.number(&element, "multiplier");
        let offset = self.number(&element, "offset");
        if ratio.is_none() {
            self.report_default(&element, "no multiplier: taken as 1");
        }
        if offset.is_none() {
            self.report_default(&element, "no offset: taken as 0");
        }
        let (ratio, offset) = (ratio.unwrap_or(1.0), offset.unwrap_or(0.0));
        self.report_read(
            &element,
            format!("follows {:?} with ratio {ratio} and offset {offset}", excerpt(leader)),
        );
        Some(Mimic::new(leader, ratio, offset))
    }
}
