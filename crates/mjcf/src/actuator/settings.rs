//! The numbers of an actuator element: the shortcuts of MJCF, and `<general>`.

use core::f64::consts::PI;

use crate::element::Element;
use crate::reader::Reader;
use crate::tree::Id;

/// The attributes of `<muscle>` for the third and further numbers of its gain.
const MUSCLE_CURVES: [&str; 7] = ["force", "scale", "lmin", "lmax", "vmax", "fpmax", "fvmax"];

/// The numbers of an actuator in MJCF.
#[derive(Clone, Debug)]
pub(super) struct Settings {
    pub(super) gain_kind: String,
    pub(super) gain: [f64; 10],
    pub(super) bias_kind: String,
    pub(super) bias: [f64; 10],
    pub(super) dynamics: String,
    pub(super) dynamics_numbers: [f64; 10],
    pub(super) inherit_range: f64,
    /// Set for a damper and for adhesion, whose control is not negative.
    pub(super) control_is_limited: bool,
}

impl Default for Settings {
    fn default() -> Self {
        let mut first = [0.0; 10];
        first[0] = 1.0;
        Self {
            gain_kind: "fixed".into(),
            gain: first,
            bias_kind: "none".into(),
            bias: [0.0; 10],
            dynamics: "none".into(),
            dynamics_numbers: first,
            inherit_range: 0.0,
            control_is_limited: false,
        }
    }
}

impl Reader<'_> {
    /// The numbers of the actuator over the defaults of its class; `None` for a kind that is not supported.
    pub(super) fn settings(&mut self, element: &Element) -> Option<Settings> {
        let mut settings = Settings::default();
        let nodes: Vec<Id> = element.defaults.iter().copied().chain([element.node]).collect();
        for node in nodes {
            let one = self.raw_element(node);
            let name = self.tree.nodes[node].name.as_str();
            if !self.set(&one, name, &mut settings) && node == element.node {
                return None; // reported by `list_unread`
            }
        }
        Some(settings)
    }

    /// Sets the numbers of one element; `false` for a kind that is not supported.
    fn set(&mut self, one: &Element, kind: &str, settings: &mut Settings) -> bool {
        match kind {
            "general" | "actuator" => {
                for (attribute, text) in [
                    ("gaintype", &mut settings.gain_kind),
                    ("biastype", &mut settings.bias_kind),
                    ("dyntype", &mut settings.dynamics),
                ] {
                    if let Some(word) = self.text(one, attribute) {
                        word.trim().clone_into(text);
                    }
                }
                settings.gain = self.overlay(one, "gainprm", settings.gain);
                settings.bias = self.overlay(one, "biasprm", settings.bias);
                settings.dynamics_numbers = self.overlay(one, "dynprm", settings.dynamics_numbers);
            }
            "motor" => {
                settings.gain[0] = 1.0;
                settings.kinds("fixed", "none", "none");
            }
            "position" | "intvelocity" => {
                let stiffness = self.number(one, "kp").unwrap_or(settings.gain[0]);
                (settings.gain[0], settings.bias[1]) = (stiffness, -stiffness);
                if let Some(damping) = self.magnitude(one, "kv") {
                    settings.bias[2] = -damping;
                }
                if let Some(ratio) = self.magnitude(one, "dampratio") {
                    settings.bias[2] = ratio;
                }
                if let Some(time) = self.magnitude(one, "timeconst") {
                    settings.dynamics_numbers[0] = time;
                    settings.dynamics = if time == 0.0 { "none" } else { "filterexact" }.into();
                }
                settings.inherit_range = self.number(one, "inheritrange").unwrap_or(settings.inherit_range);
                let dynamics =
                    if kind == "position" { settings.dynamics.clone() } else { "integrator".into() };
                settings.kinds("fixed", "affine", &dynamics);
            }
            "velocity" => {
                let damping = self.number(one, "kv").unwrap_or(settings.gain[0]);
                settings.bias = [0.0; 10];
                (settings.gain[0], settings.bias[2]) = (damping, -damping);
                settings.kinds("fixed", "affine", "none");
            }
            "damper" => {
                let inherited = if settings.gain_kind == "affine" { -settings.gain[2] } else { 0.0 };
                let damping = self.magnitude(one, "kv").unwrap_or(inherited);
                settings.gain = [0.0; 10];
                settings.gain[2] = -damping;
                settings.control_is_limited = true;
                settings.kinds("affine", "none", "none");
            }
            "cylinder" => {
                settings.dynamics_numbers[0] =
                    self.number(one, "timeconst").unwrap_or(settings.dynamics_numbers[0]);
                let [a, b, c] = self.numbers::<3>(one, "bias").unwrap_or([
                    settings.bias[0],
                    settings.bias[1],
                    settings.bias[2],
                ]);
                settings.bias[..3].copy_from_slice(&[a, b, c]);
                settings.gain[0] = self.number(one, "area").unwrap_or(settings.gain[0]);
                if let Some(diameter) = self.magnitude(one, "diameter") {
                    settings.gain[0] = PI / 4.0 * diameter * diameter;
                }
                settings.kinds("fixed", "affine", "filter");
            }
            "adhesion" => {
                settings.gain[0] = self.number(one, "gain").unwrap_or(settings.gain[0]);
                settings.control_is_limited = true;
                settings.kinds("fixed", "none", "none");
            }
            "muscle" => self.set_muscle(one, settings),
            _ => return false,
        }
        true
    }

    /// The numbers of `<muscle>`. Numbers of the class that are still those of other actuators get a muscle's
    /// defaults.
    fn set_muscle(&mut self, one: &Element, settings: &mut Settings) {
        const GAIN: [(f64, f64); 9] = [
            (1.0, 0.75),
            (0.0, 1.05),
            (0.0, -1.0),
            (0.0, 200.0),
            (0.0, 0.5),
            (0.0, 1.6),
            (0.0, 1.5),
            (0.0, 1.3),
            (0.0, 1.2),
        ];
        let Settings { gain, bias, dynamics_numbers, .. } = settings;
        for (number, (general, muscle)) in gain.iter_mut().zip(GAIN) {
            if *number == general {
                *number = muscle;
            }
        }
        for (number, (general, muscle)) in dynamics_numbers.iter_mut().zip([(1.0, 0.01), (0.0, 0.04)]) {
            if *number == general {
                *number = muscle;
            }
        }
        // A negative number stands for a missing one.
        let set = |number: &mut f64, value: Option<f64>| {
            if let Some(value) = value.filter(|&value| value >= 0.0 || value.is_nan()) {
                *number = value;
            }
        };
        let [rise, fall, width, ..] = dynamics_numbers;
        let [a, b] = self.overlay(one, "timeconst", [-1.0; 2]);
        set(rise, Some(a));
        set(fall, Some(b));
        set(width, self.magnitude(one, "tausmooth"));
        let [lower, upper, curves @ ..] = gain;
        let [a, b] = self.overlay(one, "range", [-1.0; 2]);
        set(lower, Some(a));
        set(upper, Some(b));
        for (number, name) in curves.iter_mut().zip(MUSCLE_CURVES) {
            set(number, self.number(one, name));
        }
        bias[..9].copy_from_slice(&gain[..9]);
        settings.kinds("muscle", "muscle", "muscle");
    }
}

impl Settings {
    fn kinds(&mut self, gain: &str, bias: &str, dynamics: &str) {
        gain.clone_into(&mut self.gain_kind);
        bias.clone_into(&mut self.bias_kind);
        dynamics.clone_into(&mut self.dynamics);
    }
}
