//! `<mimic>`: a joint that follows another, q = multiplier · q_leader + offset.

use multibody::Mimic;

use crate::element::Element;
use crate::reader::Reader;
use crate::unread::Unknown;
use robot_xml::excerpt;

impl<'a> Reader<'a> {
    /// Whom the joint follows, and how.
    pub(crate) fn mimic(&mut self, joint: &Element<'a>) -> Option<Mimic> {
        let element = self.child(joint, "mimic")?;
        self.list_unread(&element, &["joint", "multiplier", "offset"], &[], Unknown::IsPhysics);
        let leader = self.required_name(&element, "joint", "joint=\"NAME\", the joint to follow");
        let ratio = self.number(&element, "multiplier");
        let offset = self.number(&element, "offset");
        if ratio.is_none() {
            self.defaulted(&element, "no multiplier: taken as 1");
        }
        if offset.is_none() {
            self.defaulted(&element, "no offset: taken as 0");
        }
        let (ratio, offset) = (ratio.unwrap_or(1.0), offset.unwrap_or(0.0));
        self.read(&element, format!("follows {:?} with ratio {ratio} and offset {offset}", excerpt(leader)));
        Some(Mimic::new(leader, ratio, offset))
    }
}
