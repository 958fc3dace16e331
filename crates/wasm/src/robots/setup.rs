//! The options of a robot's motion, and the simulation that the library builds from them.
//!
//! The library chooses effects and method; these are the options of its builder.

use core::fmt::Write;
use std::sync::Arc;

use robot_dynamics::contact::Ground;
use robot_dynamics::description::{LinkShape, Shape, ShapeRole};
use robot_dynamics::simulation::{Effect, Method, Simulation, SimulationError};
use wasm_bindgen::prelude::wasm_bindgen;

use super::choice::Choice;
use super::robot::Robot;
use super::text::shown;
use crate::LabError;
use crate::input::positive;

/// Number of names in one line.
const MAX_NAMES: usize = 4;

#[wasm_bindgen]
impl Robot {
    /// Chooses the method by name (the library's choice if empty), the step \[s\], and the names of effects
    /// to switch off. The robot keeps its state, and the energy account is reset.
    ///
    /// # Errors
    /// Fails if a name is unknown, the step is not positive, or the method does not support an effect; the
    /// previous choice is kept.
    #[allow(clippy::needless_pass_by_value)] // wasm-bindgen passes lists by value
    pub fn choose(&mut self, method: &str, step: f64, off: Vec<String>) -> Result<(), LabError> {
        let method = if method.is_empty() { None } else { Some(method.parse::<Method>()?) };
        let off = off.iter().map(|name| Ok(name.parse::<Effect>()?)).collect::<Result<_, LabError>>()?;
        let choice = Choice { method, step: positive("the step", step)?, off, ground: self.choice.ground };
        self.set_up(choice)
    }

    /// Adds or removes level ground. It applies to floating robots whose file has no ground. The energy
    /// account is reset.
    ///
    /// # Errors
    /// Fails if the size or the surface of a contact shape is invalid.
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

    /// The name of the method.
    #[wasm_bindgen(getter)]
    pub fn method(&self) -> String {
        self.simulation.method().name().to_owned()
    }

    /// The reason for the method.
    #[wasm_bindgen(getter)]
    pub fn reason(&self) -> String {
        shown(self.simulation.reason())
    }

    /// The step \[s\].
    #[wasm_bindgen(getter)]
    pub fn step(&self) -> f64 {
        self.choice.step
    }

    /// The effects that act by the implicit method with nothing switched off: those that a switch can affect.
    pub fn effects(&self) -> Vec<String> {
        self.file_effects.iter().map(|effect| effect.name().to_owned()).collect()
    }

    /// The effects that act.
    pub fn acting(&self) -> Vec<String> {
        self.simulation.acting().iter().map(|effect| effect.name().to_owned()).collect()
    }

    /// Features of the file or of the page that the simulation leaves out, grouped by reason, with a
    /// count.
    #[wasm_bindgen(getter, js_name = leftOut)]
    pub fn left_out(&self) -> Vec<String> {
        let all = self.simulation.left_out().iter().chain(&self.notes).map(String::as_str);
        group_by_reason(all).iter().map(|line| shown(line)).collect()
    }

    /// Whether the file has ground of its own.
    #[wasm_bindgen(getter, js_name = ownGround)]
    pub fn own_ground(&self) -> bool {
        self.own_plane().is_some()
    }

    /// The height of the ground, present or not \[m\].
    #[wasm_bindgen(getter, js_name = groundHeight)]
    pub fn ground_height(&self) -> f64 {
        self.own_plane().map_or(0.0, |plane| plane.link_from_shape.translation[2])
    }

    /// Whether the robot touches the ground in its motion.
    #[wasm_bindgen(getter)]
    pub fn grounded(&self) -> bool {
        let grounds =
            self.simulation.contact_set().map_or(0, |set| set.ground_count() + set.height_field_count());
        grounds > 0 && self.simulation.acting().contains(&Effect::Contacts)
    }
}

impl Robot {
    /// Replaces the simulation by that of another choice, in the same state.
    pub(crate) fn set_up(&mut self, choice: Choice) -> Result<(), LabError> {
        let (mut simulation, notes) = self.build(&choice)?;
        simulation.reset(self.simulation.q(), self.simulation.v())?;
        self.since = self.time();
        (self.simulation, self.notes, self.choice, self.last) = (simulation, notes, choice, None);
        self.file_effects = self.all_effects()?;
        self.begin_samples();
        Ok(())
    }

    /// The effects that act by the method that supports all of them, with nothing switched off.
    pub(crate) fn all_effects(&self) -> Result<Vec<Effect>, LabError> {
        let all = Choice { method: Some(Method::Implicit), off: Vec::new(), ..self.choice.clone() };
        Ok(self.build(&all)?.0.acting().to_vec())
    }

    /// The simulation of a choice, and the reasons for leaving out the page's ground. Motors that hold a pose
    /// replace the file's actuators.
    pub(crate) fn build(&self, choice: &Choice) -> Result<(Simulation, Vec<String>), LabError> {
        let (shapes, meshes) = (Arc::clone(&self.model), self.meshes.clone());
        let corners = move |shape: &LinkShape| {
            // Equal shapes have the same mesh.
            let number = shapes.description().shapes.iter().position(|one| one == shape);
            let given = number.and_then(|number| meshes.get(&number));
            given.cloned().ok_or_else(|| "its file is missing".to_owned())
        };
        let mut builder = robot_dynamics::simulation(&self.model).dt(choice.step).meshes(corners);
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
            let note = format!("the ground: `{}` does not support contact, `implicit` does", row.name());
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

    /// The ground plane of the file.
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

/// Groups lines `feature: reason` by reason, with the first few names and the number of the others.
fn group_by_reason<'a>(lines: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut groups: Vec<(&str, Vec<&str>)> = Vec::new();
    for line in lines {
        let (what, reason) = line.split_once(": ").unwrap_or((line, ""));
        match groups.iter_mut().find(|group| group.0 == reason && !reason.is_empty()) {
            Some(group) => group.1.push(what),
            None => groups.push((reason, vec![what])),
        }
    }
    let written = |(reason, all): &(&str, Vec<&str>)| {
        let (named, others) = all.split_at(all.len().min(MAX_NAMES));
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
    use super::group_by_reason;

    #[test]
    fn lines_of_one_reason_are_one() {
        let contacts = ["a", "b", "c", "d", "e", "f"].map(|shape| format!("contact of {shape}: no mesh"));
        let lines = contacts.iter().map(String::as_str).chain(["limits: not by rk4", "springs"]);
        let expected = [
            "contact of a, contact of b, contact of c, contact of d and 2 more: no mesh",
            "limits: not by rk4",
            "springs",
        ];
        assert_eq!(group_by_reason(lines), expected);
    }
}
