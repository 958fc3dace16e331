//! The contacts of the last step.

use crate::Status;
use crate::arrays::Arrays;
use crate::calls::call;
use crate::handle::shared;

use super::{RobotSimulation, SimulationHandle};

/// A contact of two surfaces.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactC {
    /// The frame of the link in contact.
    pub link: u32,
    /// The frame of the other link; `UINT32_MAX` for a ground.
    pub other_link: u32,
    /// The point in the world \[m\].
    pub point: [f64; 3],
    /// The unit vector that points into `link`, in the world.
    pub normal: [f64; 3],
    /// The distance of the surfaces along the normal, negative where they overlap \[m\].
    pub gap: f64,
    /// The force on `link`, in the world's axes \[N\].
    pub force: [f64; 3],
    /// The moment on `link` about the point, in the world's axes \[N m\].
    pub moment: [f64; 3],
}

/// The contacts of the last step. At most `capacity` are written; `count` is the number of all. Allocates.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_simulation_contacts(
    simulation: SimulationHandle,
    contacts: *mut ContactC,
    capacity: usize,
    count: *mut usize,
) -> Status {
    call(|| {
        let own = shared::<RobotSimulation>(simulation.id)?;
        let mut arrays = Arrays::default();
        let out = arrays.output("the contacts", contacts, capacity, capacity)?;
        let count = arrays.result("the result `count`", count)?;
        let found = own.simulation.contacts();
        *count = found.len();
        let model = own.simulation.model();
        let frame = |link: &str| {
            let named = model.frame(link);
            let index = named.and_then(|id| own.frames.iter().position(|own| *own == id));
            index.map_or(u32::MAX, |index| index as u32)
        };
        for (out, contact) in out.iter_mut().zip(&found) {
            *out = ContactC {
                link: frame(contact.link),
                other_link: contact.other_link.map_or(u32::MAX, frame),
                point: contact.point,
                normal: contact.normal,
                gap: contact.gap,
                force: contact.force,
                moment: contact.moment,
            };
        }
        Ok(())
    })
}
