//! `<mimic>`: a joint that follows another, q = multiplier · q_leader + offset.

use multibody::Mimic;

use crate::UrdfError;
use crate::element::Element;
use crate::error::excerpt;
use crate::reader::Reader;
use crate::unread::Unknown;

impl<'a> Reader<'a> {
    /// Whom the joint follows, and how.
    pub(crate) fn mimic(&mut self, joint: &Element<'a>) -> Result<Option<Mimic>, UrdfError> {
        let Some(element) = self.child(joint, "mimic")? else { return Ok(None) };
        self.list_unread(&element, &["joint", "multiplier", "offset"], &[], Unknown::IsPhysics)?;
        let leader = element.required_name("joint", "joint=\"NAME\", the joint to follow")?;
        let ratio = element.number("multiplier")?;
        let offset = element.number("offset")?;
        if ratio.is_none() {
            self.defaulted(&element, "no multiplier: taken as 1");
        }
        if offset.is_none() {
            self.defaulted(&element, "no offset: taken as 0");
        }
        let (ratio, offset) = (ratio.unwrap_or(1.0), offset.unwrap_or(0.0));
        self.read(&element, format!("follows {:?} with ratio {ratio} and offset {offset}", excerpt(leader)));
        Ok(Some(Mimic { joint: leader.to_owned(), ratio, offset }))
    }
}
