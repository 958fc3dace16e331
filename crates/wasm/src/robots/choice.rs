//! The options that a person chose for a robot's motion, and the simulation that the library makes of them.
//!
//! The library decides what acts and by which method: here are the options of its builder, no more.

use core::fmt::Write;
use std::sync::Arc;

use multibody::simulator::{Effect, Method, Simulation, SimulationError};
use multibody::{Ground, LinkShape, Shape, ShapeRole};
use wasm_bindgen::prelude::wasm_bindgen;

use super::robot::{Robot, shown};
use crate::LabError;
use crate::input::positive;

/// How many things of one reason are named.
const NAMED: usize = 4;

/// Options of the builder.
#[derive(Clone, Debug)]
pub(crate) struct Choice {
    /// `None`: the library's.
    pub(crate) method: Option<Method>,
    /// \[s\].
    pub(crate) step: f64,
    /// The effects that are switched off.
    pub(crate) off: Vec<Effect>,
    /// Whether level ground lies under a robot that floats and whose file has no ground.
    pub(crate) ground: bool,
}

impl Default for Choice {
    fn default() -> Self {
        Self { method: None, step: 1e-3, off: Vec::new(), ground: false }
    }
}

#[wasm_bindgen]
impl Robot {
    /// Chooses the method by its name (empty: as the library chooses), the step \[s\], and which effects are switched off, by their names. The robot goes on from
    /// where it is; its energy account begins anew.
    ///
    /// # Errors
    /// If a name is unknown, the step is not positive, or the method does not know what acts; the choice before is kept.
    #[allow(clippy::needless_pass_by_value)] // wasm-bindgen passes lists by value
    pub fn choose(&mut self, method: &str, step: f64, off: Vec<String>) -> Result<(), LabError> {
        let method = if method.is_empty() { None } else { Some(method.parse::<Method>()?) };
        let off = off.iter().map(|name| Ok(name.parse::<Effect>()?)).collect::<Result<_, LabError>>()?;
        let choice = Choice { method, step: positive("the step", step)?, off, ground: self.choice.ground };
        self.set_up(choice)
    }

    /// Lays level ground, or takes it away; a robot that does not float, or whose file has ground, gets none. The energy account begins anew.
    ///
    /// # Errors
    /// If a size or a surface of a shape that touches it is invalid.
    #[wasm_bindgen(js_name = setGround)]
    pub fn set_ground(&mut self, on: bool) -> Result<(), LabError> {
        let choice = Choice { ground: on, ..self.choice.clone() };
        self.set_up(choice)
    }

    /// The names of all methods.
    #[wasm_bindgen(js_name = methodNames)]
    pub fn method_names() -> Vec<String> {
        Method::names().map(str::to_owned).collect()
    }

    /// The method that takes the steps.
    #[wasm_bindgen(getter)]
    pub fn method(&self) -> String {
        self.simulation.method().name().to_owned()
    }

    /// Why that method, in words.
    #[wasm_bindgen(getter)]
    pub fn reason(&self) -> String {
        shown(self.simulation.reason())
    }

    /// The step \[s\].
    #[wasm_bindgen(getter)]
    pub fn step(&self) -> f64 {
        self.choice.step
    }

    /// The effects that there are with everything on, by the implicit method: what a switch is worth having for.
    pub fn effects(&self) -> Vec<String> {
        self.stated.iter().map(|effect| effect.name().to_owned()).collect()
    }

    /// The effects that act.
    pub fn acting(&self) -> Vec<String> {
        self.simulation.acting().iter().map(|effect| effect.name().to_owned()).collect()
    }

    /// The features that the file states, or the page lays, and the simulation leaves out: each kind once, with the reason and a count.
    #[wasm_bindgen(getter, js_name = leftOut)]
    pub fn left_out(&self) -> Vec<String> {
        let all = self.simulation.left_out().iter().chain(&self.notes).map(String::as_str);
        grouped(all).iter().map(|line| shown(line)).collect()
    }

    /// Whether the file has ground of its own.
    #[wasm_bindgen(getter, js_name = ownGround)]
    pub fn own_ground(&self) -> bool {
        self.own_plane().is_some()
    }

    /// Where the ground is, or would be \[m\].
    #[wasm_bindgen(getter, js_name = groundHeight)]
    pub fn ground_height(&self) -> f64 {
        self.own_plane().map_or(0.0, |plane| plane.link_from_shape.translation[2])
    }

    /// Whether the robot meets the ground as it moves.
    #[wasm_bindgen(getter)]
    pub fn grounded(&self) -> bool {
        let grounds =
            self.simulation.contact_set().map_or(0, |set| set.ground_count() + set.height_field_count());
        grounds > 0 && self.simulation.acting().contains(&Effect::Contacts)
    }
}

impl Robot {
    /// A simulation by another choice, which goes on from where the robot is.
    pub(crate) fn set_up(&mut self, choice: Choice) -> Result<(), LabError> {
        let (mut simulation, notes) = self.build(&choice)?;
        simulation.reset(self.simulation.q(), self.simulation.v())?;
        self.since = self.time();
        (self.simulation, self.notes, self.choice, self.last) = (simulation, notes, choice, None);
        self.stated = self.everything()?;
        self.begin_samples();
        Ok(())
    }

    /// The effects that act with nothing switched off, by the method that supports all of them.
    pub(crate) fn everything(&self) -> Result<Vec<Effect>, LabError> {
        let all = Choice { method: Some(Method::Implicit), off: Vec::new(), ..self.choice.clone() };
        Ok(self.build(&all)?.0.acting().to_vec())
    }

    /// The simulation of a choice, and why it leaves out what the page lays. Motors that hold a pose take the place of the file's actuators.
    pub(crate) fn build(&self, choice: &Choice) -> Result<(Simulation, Vec<String>), LabError> {
        let (shapes, meshes) = (Arc::clone(&self.model), self.meshes.clone());
        let corners = move |shape: &LinkShape| {
            // Shapes that are equal have the same mesh.
            let number = shapes.description().shapes.iter().position(|one| one == shape);
            let given = number.and_then(|number| meshes.get(&number));
            given.cloned().ok_or_else(|| "its file was not given".to_owned())
        };
        let mut builder = robot_dynamics::simulation(&self.model).step(choice.step).meshes(corners);
        if let Some(method) = choice.method {
            builder = builder.method(method);
        }
        let by_hold = self.hold.is_some().then_some(Effect::Actuators);
        let by_loops = self.loose.is_some().then_some(Effect::Equalities);
        for effect in choice.off.iter().copied().chain(by_hold).chain(by_loops) {
            builder = builder.without(effect);
        }
        let contacts_act = !choice.off.contains(&Effect::Contacts);
        if !(choice.ground && contacts_act && self.floats() && !self.own_ground()) {
            return Ok((builder.build()?, Vec::new()));
        }
        if let Some(Method::Fixed(row)) = choice.method {
            let note = format!("the ground: `{}` knows no contact, `implicit` does", row.name());
            return Ok((builder.build()?, vec![note]));
        }
        match builder.ground(Ground::level(0.0)).build() {
            Err(error @ SimulationError::NothingTouches { .. }) => {
                let (simulation, _) = self.build(&Choice { ground: false, ..choice.clone() })?;
                Ok((simulation, vec![format!("the ground: {error}")]))
            }
            built => Ok((built?, Vec::new())),
        }
    }

    /// The plane of the file that lies under the robot.
    fn own_plane(&self) -> Option<&LinkShape> {
        let description = self.model.description();
        let hangs = |link: &str| description.joints.iter().any(|joint| joint.child == link);
        description.shapes.iter().find(|shape| {
            matches!(shape.shape, Shape::Plane { .. })
                && shape.role == ShapeRole::Collision
                && !hangs(&shape.link)
        })
    }
}

/// Lines `what: reason`, those of one reason once, with the first few and how many others there are.
fn grouped<'a>(lines: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut groups: Vec<(&str, Vec<&str>)> = Vec::new();
    for line in lines {
        let (what, reason) = line.split_once(": ").unwrap_or((line, ""));
        match groups.iter_mut().find(|group| group.0 == reason && !reason.is_empty()) {
            Some(group) => group.1.push(what),
            None => groups.push((reason, vec![what])),
        }
    }
    let written = |(reason, all): &(&str, Vec<&str>)| {
        let (named, others) = all.split_at(all.len().min(NAMED));
        let mut text = named.join(", ");
        if !others.is_empty() {
            let _ = write!(text, " and {} more", others.len());
        }
        if reason.is_empty() { text } else { format!("{text}: {reason}") }
    };
    groups.iter().map(written).collect()
}

#[cfg(test)]
mod tests {
    use super::grouped;

    #[test]
    fn lines_of_one_reason_are_one() {
        let contacts = ["a", "b", "c", "d", "e", "f"].map(|shape| format!("contact of {shape}: no mesh"));
        let lines = contacts.iter().map(String::as_str).chain(["limits: not by rk4", "springs"]);
        let expected = [
            "contact of a, contact of b, contact of c, contact of d and 2 more: no mesh",
            "limits: not by rk4",
            "springs",
        ];
        assert_eq!(grouped(lines), expected);
    }
}
