//! `--ground`: what the robot stands on.

use std::fmt::Write;
use std::str::FromStr;

use multibody::{ContactLaws, ContactSet, Ground, Model, Run, Workspace};

use super::Arguments;
use super::setup::Setup;
use super::start::Start;
use crate::failure::{Context, Failure};
use crate::output::tell;
use crate::table::{Table, short};

/// How far above the ground a robot starts that would else start in it \[m\].
const DROP: f64 = 0.1;

/// How often a robot that starts in a height field is lifted anew, at most.
const MOST_LIFTS: usize = 100;

/// `--ground` as it is written.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct GroundOption {
    z: f64,
    /// \[rad\].
    slope: f64,
    /// The height fields of the robot's file instead.
    of_file: bool,
}

impl FromStr for GroundOption {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let mut ground = Self { z: 0.0, slope: 0.0, of_file: text.trim() == "file" };
        if ground.of_file {
            return Ok(ground);
        }
        for part in text.split(',').map(str::trim).filter(|part| !part.is_empty()) {
            let Some((key, value)) = part.split_once('=') else {
                return Err(format!("`{part}` is not of the form z=NUMBER or slope=NUMBER, nor file"));
            };
            let number = value.trim().parse::<f64>().ok().filter(|number| number.is_finite());
            let number = number.ok_or_else(|| format!("`{value}` is not a finite number"))?;
            match key.trim() {
                "z" => ground.z = number,
                "slope" => ground.slope = number,
                other => return Err(format!("the ground has no `{other}`: it has z [m] and slope [rad]")),
            }
        }
        Ground::slope(ground.slope).map_err(|error| error.to_string())?;
        Ok(ground)
    }
}

/// A coefficient of friction.
pub(crate) fn friction(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x >= 0.0 && x.is_finite() => Ok(x),
        Ok(_) => Err("it must be a finite number, 0 or more".into()),
        Err(_) => Err("it is not a number".into()),
    }
}

impl Arguments {
    /// The half-space asked for; `None` without, or for the grounds of the file.
    ///
    /// # Errors
    /// Its slope is invalid.
    pub(crate) fn half_space(&self) -> Result<Option<Ground>, Failure> {
        let Some(option) = self.ground.map(Option::unwrap_or_default).filter(|option| !option.of_file) else {
            return Ok(None);
        };
        let mut ground = Ground::slope(option.slope).context("--ground")?;
        ground.offset = option.z * ground.normal[2];
        Ok(Some(match self.friction {
            Some(friction) => ground.with_friction(friction),
            None => ground,
        }))
    }
}

/// The grounds of a run, and in words where the robot is on them.
pub(crate) struct Floor {
    pub described: String,
    contacts: ContactSet,
}

impl Floor {
    /// The grounds that there are, `None` without; a robot that would start in one is lifted, if nothing was said of where its base is.
    ///
    /// # Errors
    /// The grounds of the file were asked for and there are none, or an option of grounds goes with none.
    pub(crate) fn choose(
        arguments: &Arguments,
        model: &Model,
        setup: &Setup,
        start: &mut Start,
    ) -> Result<Option<Self>, Failure> {
        let contacts = setup.simulation.contact_set();
        let shown = arguments.robot.shown().to_string();
        let is_ground = |set: &&ContactSet| set.ground_count() + set.height_field_count() > 0;
        let Some(contacts) = contacts.filter(is_ground).filter(|set| set.has_shapes()) else {
            return match (arguments.friction, arguments.standing, arguments.ground) {
                (_, _, Some(Some(GroundOption { of_file: true, .. }))) => Err(Failure::new(format!(
                    "--ground file: `{shown}` has no height field and no plane that the world carries"
                ))),
                (Some(_), ..) => Err(Failure::new("--friction is that of the ground: give --ground, too")),
                (_, true, _) => Err(Failure::new("--standing stands on the ground: give --ground, too")),
                _ => Ok(None),
            };
        };
        if !contacts.left_out().is_empty() {
            tell(format_args!(
                "warning: {shown}: shapes that do not touch the ground{}",
                listed(contacts.left_out())
            ));
        }
        let option = arguments.ground.map(Option::unwrap_or_default);
        let own = option.filter(|option| !option.of_file);
        let steepness = own.map_or(1.0, |option| option.slope.cos());
        let placed = place(arguments, model, start, (contacts, steepness))?;
        let of_file = [
            (contacts.ground_count() - usize::from(own.is_some()), "plane"),
            (contacts.height_field_count(), "height field"),
        ];
        let of_file: Vec<String> = of_file
            .into_iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| if count == 1 { format!("the {what}") } else { format!("{count} {what}s") })
            .collect();
        let of_file = (!of_file.is_empty()).then(|| format!("{} of the file", of_file.join(" and ")));
        let own = own.map(|option| {
            let z = short(option.z);
            if option.slope == 0.0 {
                format!("level at z = {z} m")
            } else {
                format!("rises along x by {} rad, at z = {z} m under the origin", short(option.slope))
            }
        });
        let is_own = own.is_some();
        let mut described = own.into_iter().chain(of_file).collect::<Vec<_>>().join("; ");
        match arguments.friction {
            Some(friction) => {
                let _ = write!(described, ", friction {}", short(friction));
            }
            None if is_own => described += ", friction as the shapes state",
            None => described += ", friction as the surfaces state",
        }
        start.chosen += &placed;
        Ok(Some(Self { contacts: contacts.clone(), described }))
    }
}

/// The number of pairs of shapes that may touch beside grounds, in words.
pub(crate) fn touching_links(setup: &Setup) -> Option<String> {
    let contacts = setup.simulation.contact_set()?;
    match contacts.pairs().count() {
        0 => None,
        1 => Some("one pair of shapes may touch".into()),
        pairs => Some(format!("{pairs} pairs of shapes may touch")),
    }
}

impl Floor {
    /// Which links stand on it at the end, whether they move, and how well the laws of contact were kept.
    pub(crate) fn report(&self, model: &Model, run: &Run) -> String {
        let laws =
            run.contact_laws.filter(|laws| laws.solved > 0).map_or_else(String::new, |laws| kept(&laws));
        self.ends(model, run) + &laws
    }

    fn ends(&self, model: &Model, run: &Run) -> String {
        let gap = self.contacts.clearance(model, &mut Workspace::new(model), &run.q).unwrap_or(f64::NAN);
        let mut table = Table::new(&["on the ground", ">force x [N]", ">y", ">z"]);
        let forces = self.contacts.links().iter().zip(&run.contact_forces);
        let pressed: Vec<_> = forces.filter(|(_, force)| **force != [0.0; 3]).collect();
        if pressed.is_empty() {
            return format!(
                "\n  nothing touches the ground at the end: the lowest point is {} m above it\n",
                short(gap)
            );
        }
        let mut sum = [0.0; 3];
        for (link, force) in &pressed {
            (0..3).for_each(|k| sum[k] += force[k]);
            table.row([(*link).clone()].into_iter().chain(force.map(short)));
        }
        if pressed.len() > 1 {
            table.row(["together".to_owned()].into_iter().chain(sum.map(short)));
        }
        let mut text = format!("\n{}", table.text());
        let fastest = run.v.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let rest = if fastest < AT_REST {
            "at rest: no coordinate moves faster than"
        } else {
            "the fastest coordinate moves at"
        };
        let side = if gap < 0.0 { "below" } else { "above" };
        let _ = writeln!(
            text,
            "  {rest} {} rad/s or m/s at the end; the lowest point is {:.1e} m {side} the ground",
            short(fastest),
            gap.abs()
        );
        text
    }
}

/// How well the laws of contact were kept, in words.
fn kept(laws: &ContactLaws) -> String {
    let ContactLaws {
        violation, solved, without_solution, violation_without_solution: without, deepest, ..
    } = laws;
    let mut text = format!(
        "  deepest point after any step: {deepest:.0e} m in what it touches\n  \
         largest violation of the contact laws over the run: {:.0e} m/s of Signorini's, {:.0e} of Coulomb's, {:.0e} of maximum \
         dissipation",
        violation.signorini, violation.coulomb, violation.dissipation
    );
    if *without_solution > 0 {
        let _ = write!(
            text,
            "; in {without_solution} of {solved} solutions Coulomb's law was not met (by up to {:.0e} m/s)",
            without.worst()
        );
    }
    text + "\n"
}

/// Speeds below are rest.
const AT_REST: f64 = 1e-9;

/// The first of some reasons, and how many there are.
fn listed(left_out: &[String]) -> String {
    let Some(first) = left_out.first() else { return String::new() };
    let others = match left_out.len() - 1 {
        0 => String::new(),
        others => format!(" and {others} more"),
    };
    format!(": {first}{others}")
}

/// Lifts the robot onto the ground or above it; what was done, in words.
fn place(
    arguments: &Arguments,
    model: &Model,
    start: &mut Start,
    (contacts, steepness): (&ContactSet, f64),
) -> Result<String, Failure> {
    let clearance =
        |q: &[f64]| contacts.clearance(model, &mut Workspace::new(model), q).unwrap_or(f64::INFINITY);
    let gap = clearance(&start.q);
    if gap == f64::INFINITY {
        return Ok(", the robot not above it".into());
    }
    let base = floating_base(model);
    let is_given = arguments.pose.iter().any(|pose| base.as_ref().is_some_and(|(name, _)| pose.names(name)));
    let wanted = match (arguments.standing, base.is_some() && !is_given && gap < 0.0) {
        (true, _) => 0.0,
        (false, true) => DROP,
        (false, false) if gap < 0.0 => {
            return Ok(format!(
                ", its lowest point {} m below the ground, from where it comes back",
                short(-gap)
            ));
        }
        (false, false) => return Ok(format!(", its lowest point {} m above the ground", short(gap))),
    };
    let Some((_, at)) = base else {
        return Err(Failure::new(format!(
            "--standing: the base of robot `{}` is fixed where it is (--floating-base frees it)",
            model.name()
        )));
    };
    start.q[at + 2] += (wanted - gap) / steepness;
    // Among hills the nearest point may be another one then.
    for _ in 0..MOST_LIFTS {
        let left = wanted - clearance(&start.q);
        if left.abs() < 1e-12 || left.is_infinite() {
            break;
        }
        start.q[at + 2] += left / steepness;
    }
    if wanted == 0.0 {
        return Ok(", lowered or lifted until it touches the ground".into());
    }
    Ok(format!(", lifted until its lowest point is {} m above the ground", short(wanted)))
}

/// The joint by which the robot floats, and where its position begins in q.
fn floating_base(model: &Model) -> Option<(String, usize)> {
    let joint = model.joints().iter().find(|joint| joint.nq == 7)?;
    Some((joint.name.clone(), joint.q_index))
}
