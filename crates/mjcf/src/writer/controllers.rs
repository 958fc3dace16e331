//! The attributes of `<pid>` and `<dcmotor>` for actuators with several inputs, or with cogging.

use robot_dynamics_description::{Activation, ActuatorDescription, Affine};

type Range = [f64; 2];

const UNBOUNDED: Range = [f64::NEG_INFINITY, f64::INFINITY];
const NO_FORM: &str = "MJCF has no controller with these inputs and gains";

/// A controller of MJCF.
pub(super) struct Controller {
    pub(super) element: &'static str,
    /// The words of `input`.
    pub(super) inputs: String,
    pub(super) ranges: Vec<(&'static str, Range)>,
    pub(super) numbers: Vec<(&'static str, Vec<f64>)>,
}

impl Controller {
    /// The controller of an actuator and of those that add to it. `None` stands for an actuator alone, and
    /// the error is the reason if MJCF cannot represent it.
    pub(super) fn new<'a>(
        first: &'a ActuatorDescription,
        others: impl Iterator<Item = &'a ActuatorDescription>,
    ) -> Result<Option<Self>, &'static str> {
        let others: Vec<&ActuatorDescription> = others.collect();
        if others.is_empty() && first.cogging.is_none() {
            return Ok(None);
        }
        let is_plain = |own: &ActuatorDescription| {
            own.muscle.is_none()
                && own.activation == Activation::None
                && own.gain == Affine::constant(own.gain.constant)
        };
        let is_input = |own: &&ActuatorDescription| {
            own.bias == Affine::default() && own.cogging.is_none() && own.force_range == UNBOUNDED
        };
        let all = core::iter::once(first).chain(others.iter().copied());
        if first.bias.constant != 0.0 || !all.clone().all(is_plain) || !others.iter().all(is_input) {
            return Err(NO_FORM);
        }
        let mut inputs = vec![first_input(first).ok_or(NO_FORM)?];
        for other in &others {
            let word = other.name.strip_prefix(&first.name).and_then(|end| end.strip_prefix('_'));
            let word = ["vel", "ff", "voltage"].into_iter().find(|known| Some(*known) == word);
            inputs.push(word.ok_or(NO_FORM)?);
        }
        let parts: Vec<(&'static str, &ActuatorDescription)> = inputs.into_iter().zip(all).collect();
        let is_ordered = parts.windows(2).all(|pair| rank(pair[0].0) < rank(pair[1].0));
        let bias = first.bias;
        let fits = |&(word, own): &(&str, &ActuatorDescription)| match word {
            "pos" => own.gain.constant == -bias.length,
            "vel" => own.gain.constant == -bias.velocity,
            "ff" => own.gain.constant == 1.0,
            _ => own.gain.constant > 0.0,
        };
        if !is_ordered || !parts.iter().all(fits) {
            return Err(NO_FORM);
        }
        let is_motor = first.cogging.is_some() || parts.iter().any(|(word, _)| *word == "voltage");
        if is_motor { Self::motor(first, &parts).map(Some) } else { Self::pid(first, &parts).map(Some) }
    }

    fn pid(
        first: &ActuatorDescription,
        parts: &[(&'static str, &ActuatorDescription)],
    ) -> Result<Self, &'static str> {
        let Affine { length, velocity, .. } = first.bias;
        if velocity > 0.0 {
            return Err("MJCF reads the negative damping of a servo as a damping ratio");
        }
        let range = |word: &str| match word {
            "pos" => "ctrlrange",
            "vel" => "velrange",
            _ => "ffrange",
        };
        let mut ranges: Vec<_> = parts.iter().map(|(word, own)| (range(word), own.control_range)).collect();
        ranges.push(("forcerange", first.force_range));
        let numbers = vec![("kp", vec![0.0 - length]), ("kv", vec![0.0 - velocity])];
        Ok(Self { element: "pid", inputs: words(parts), ranges, numbers })
    }

    /// The voltage has the gain K/R. Without other inputs the damping is K²/R; with them, R is any number.
    fn motor(
        first: &ActuatorDescription,
        parts: &[(&'static str, &ActuatorDescription)],
    ) -> Result<Self, &'static str> {
        let Affine { length, velocity, .. } = first.bias;
        let of_voltage = parts.iter().find(|(word, _)| *word == "voltage").map(|(_, own)| own.gain.constant);
        let is_controlled = parts.iter().any(|(word, _)| *word != "voltage");
        let [lower, upper] = first.force_range;
        if lower != -upper || parts.iter().any(|(_, own)| own.control_range != first.control_range) {
            return Err("a <dcmotor> has one range of its inputs, and a force with opposite bounds");
        }
        let (constant, resistance) = match of_voltage {
            Some(gain) if !is_controlled && velocity < 0.0 && length == 0.0 => {
                (-velocity / gain, -velocity / gain / gain)
            }
            Some(gain) if is_controlled => (gain, 1.0),
            None => (1.0, 1.0),
            Some(_) => return Err(NO_FORM),
        };
        let mut numbers = vec![("motorconst", vec![constant]), ("resistance", vec![resistance])];
        if is_controlled {
            numbers.push(("controller", vec![0.0 - length, 0.0, 0.0 - velocity]));
        }
        if upper.is_finite() {
            numbers.push(("saturation", vec![upper]));
        }
        if let Some(cogging) = first.cogging {
            numbers.push(("cogging", vec![cogging.amplitude, cogging.poles, cogging.phase]));
        }
        let ranges = vec![("ctrlrange", first.control_range)];
        Ok(Self { element: "dcmotor", inputs: words(parts), ranges, numbers })
    }
}

/// The input with this gain.
fn first_input(first: &ActuatorDescription) -> Option<&'static str> {
    let (gain, Affine { length, velocity, .. }) = (first.gain.constant, first.bias);
    if gain == -length && length != 0.0 {
        Some("pos")
    } else if first.cogging.is_some() && length == 0.0 && velocity < 0.0 && gain > 0.0 {
        Some("voltage")
    } else if gain == -velocity && velocity != 0.0 {
        Some("vel")
    } else {
        (gain == 1.0).then_some("ff")
    }
}

fn rank(word: &str) -> Option<usize> {
    ["pos", "vel", "ff", "voltage"].into_iter().position(|known| known == word)
}

fn words(parts: &[(&'static str, &ActuatorDescription)]) -> String {
    parts.iter().map(|(word, _)| *word).collect::<Vec<_>>().join(" ")
}
