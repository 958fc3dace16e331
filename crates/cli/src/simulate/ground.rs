//! `--ground`: the ground, and the start of the robot on or above it.

use std::fmt::Write;

use robot_dynamics::contact::{ContactLaws, ContactSet, Ground};
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::simulation::Run;

use super::arguments::Arguments;
use super::option_values::GroundOption;
use super::setup::Setup;
use super::start::Start;
use crate::failure::{Context, Failure};
use crate::output::print_line;
use crate::table::{Table, short};

/// Height above the ground of a robot that would otherwise start in it \[m\].
const START_HEIGHT: f64 = 0.1;

/// Largest number of corrections of the height of a robot above a height field.
const MAX_LIFTS: usize = 100;

impl Arguments {
    /// The half-space of `--ground`; `None` without it, or for the grounds of the file.
    ///
    /// # Errors
    ///
    /// The slope is invalid.
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

/// The grounds of a run, and a text on the robot's position on them.
pub(crate) struct Floor {
    pub described: String,
    contacts: ContactSet,
}

impl Floor {
    /// The grounds, `None` without. A floating robot that would start in one is lifted, unless the position
    /// of its base is given.
    ///
    /// # Errors
    ///
    /// The grounds of the file are requested and missing, or an option needs `--ground`.
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
                    "--ground file: `{shown}` has no height field and no plane fixed to the world"
                ))),
                (Some(_), ..) => Err(Failure::new("--friction needs --ground")),
                (_, true, _) => Err(Failure::new("--standing needs --ground")),
                _ => Ok(None),
            };
        };
        if !contacts.left_out().is_empty() {
            print_line(format_args!(
                "warning: {shown}: shapes without ground contact{}",
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
                format!("level, z = {z} m")
            } else {
                format!("slope {} rad along x, z = {z} m at the origin", short(option.slope))
            }
        });
        let is_own = own.is_some();
        let mut described = own.into_iter().chain(of_file).collect::<Vec<_>>().join("; ");
        match arguments.friction {
            Some(friction) => {
                let _ = write!(described, ", friction {}", short(friction));
            }
            None if is_own => described += ", friction of the shapes",
            None => described += ", friction of the surfaces",
        }
        start.chosen += &placed;
        Ok(Some(Self { contacts: contacts.clone(), described }))
    }
}

/// A text on the number of pairs of shapes that can touch, apart from the ground.
pub(crate) fn touching_links(setup: &Setup) -> Option<String> {
    let contacts = setup.simulation.contact_set()?;
    match contacts.pairs().count() {
        0 => None,
        1 => Some("contact of one pair of shapes".into()),
        pairs => Some(format!("contact of {pairs} pairs of shapes")),
    }
}

impl Floor {
    /// The forces on links at the end, whether they move, and the violation of the contact laws.
    pub(crate) fn report(&self, model: &Model, run: &Run) -> String {
        let laws =
            run.contact_laws.filter(|laws| laws.solved > 0).map_or_else(String::new, |laws| kept(&laws));
        self.ends(model, run) + &laws
    }

    fn ends(&self, model: &Model, run: &Run) -> String {
        let gap = self.contacts.clearance(model, &mut Workspace::new(model), &run.q).unwrap_or(f64::NAN);
        let mut table = Table::new(&["ground contact", ">force x [N]", ">y", ">z"]);
        let forces = self.contacts.links().iter().zip(&run.contact_forces);
        let pressed: Vec<_> = forces.filter(|(_, force)| **force != [0.0; 3]).collect();
        if pressed.is_empty() {
            return format!(
                "\n  no contact with the ground at the end; the lowest point is {} m above it\n",
                short(gap)
            );
        }
        let mut sum = [0.0; 3];
        for (link, force) in &pressed {
            (0..3).for_each(|k| sum[k] += force[k]);
            table.row([(*link).clone()].into_iter().chain(force.map(short)));
        }
        if pressed.len() > 1 {
            table.row(["total".to_owned()].into_iter().chain(sum.map(short)));
        }
        let mut text = format!("\n{}", table.text());
        let fastest = run.v.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let rest = if fastest < REST_SPEED {
            "at rest at the end: all speeds are below"
        } else {
            "fastest coordinate at the end:"
        };
        let side = if gap < 0.0 { "below" } else { "above" };
        let _ = writeln!(
            text,
            "  {rest} {} rad/s or m/s; the lowest point is {:.1e} m {side} the ground",
            short(fastest),
            gap.abs()
        );
        text
    }
}

/// The violation of the contact laws as text.
fn kept(laws: &ContactLaws) -> String {
    let ContactLaws {
        violation, solved, without_solution, violation_without_solution: without, deepest, ..
    } = laws;
    let mut text = format!(
        "  largest penetration after a step: {deepest:.0e} m\n  \
         largest violation of the contact laws [m/s]: Signorini {:.0e}, Coulomb {:.0e}, maximum dissipation {:.0e}",
        violation.signorini, violation.coulomb, violation.dissipation
    );
    if *without_solution > 0 {
        let _ = write!(
            text,
            "; {without_solution} of {solved} solutions violate Coulomb's law (by up to {:.0e} m/s)",
            without.worst()
        );
    }
    text + "\n"
}

/// Speed below which the robot is at rest \[rad/s or m/s\].
const REST_SPEED: f64 = 1e-9;

/// The first reason, and the number of the others.
fn listed(left_out: &[String]) -> String {
    let Some(first) = left_out.first() else { return String::new() };
    let others = match left_out.len() - 1 {
        0 => String::new(),
        others => format!(" and {others} more"),
    };
    format!(": {first}{others}")
}

/// Moves the robot onto the ground or above it. Returns a text on its position.
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
        return Ok(", the robot is not above the ground".into());
    }
    let base = floating_base(model);
    let is_given = arguments.pose.iter().any(|pose| base.as_ref().is_some_and(|(name, _)| pose.names(name)));
    let wanted = match (arguments.standing, base.is_some() && !is_given && gap < 0.0) {
        (true, _) => 0.0,
        (false, true) => START_HEIGHT,
        (false, false) if gap < 0.0 => {
            return Ok(format!(
                ", lowest point {} m below the ground, from where contact pushes it out",
                short(-gap)
            ));
        }
        (false, false) => return Ok(format!(", lowest point {} m above the ground", short(gap))),
    };
    let Some((_, at)) = base else {
        return Err(Failure::new(format!(
            "--standing: the base of robot `{}` is fixed (--floating-base frees it)",
            model.name()
        )));
    };
    start.q[at + 2] += (wanted - gap) / steepness;
    // On a height field another point may then be the nearest.
    for _ in 0..MAX_LIFTS {
        let left = wanted - clearance(&start.q);
        if left.abs() < 1e-12 || left.is_infinite() {
            break;
        }
        start.q[at + 2] += left / steepness;
    }
    if wanted == 0.0 {
        return Ok(", moved vertically onto the ground".into());
    }
    Ok(format!(", lifted: lowest point {} m above the ground", short(wanted)))
}

/// The floating joint, and the index of its position in q.
fn floating_base(model: &Model) -> Option<(String, usize)> {
    let joint = model.joints().iter().find(|joint| joint.nq == 7)?;
    Some((joint.name.clone(), joint.q_index))
}
