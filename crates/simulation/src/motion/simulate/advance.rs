//! One step of a run, with its events.

use robot_dynamics_integrators::EnergyAccount;

use super::event::EventDetector;
use super::interpolation::{Ends, StepInterpolation};
use super::shortened_step::RepeatableStep;
use super::{Run, RunError, RunLoop, Stepper};
use crate::{StepForces, StepWorkspace};

impl RunLoop<'_> {
    /// Takes one step, or the part of it up to a terminal event; (q, v) are scratch memory.
    pub(crate) fn advance_once<S: Stepper + Clone>(
        &self,
        run: &mut Run,
        stepper: &mut S,
        (workspace, detector, between): (
            &mut StepWorkspace,
            &mut EventDetector<'_, '_>,
            &mut StepInterpolation<'_>,
        ),
        forces: &StepForces<'_>,
        (q, v): (&mut Vec<f64>, &mut Vec<f64>),
    ) -> Result<(), RunError> {
        let (time, mut end) = (run.time, self.time(run.steps + 1));
        let before = detector.has_terminal().then(|| stepper.clone());
        let mut energy_account = self.take_step(stepper, workspace, run, forces, self.step, (q, v))?;
        if !detector.is_empty() {
            let ends = Ends { times: (time, end), from: (&run.q, &run.v), to: (q, v) };
            between.set_ends(&ends);
            let mut found =
                detector.find_crossings(time, end, &mut |t, q, v| between.state(&ends, t, q, v))?;
            let stop = found.iter().position(|found| found.is_terminal);
            if let (Some(index), Some(before)) = (stop, &before) {
                found.truncate(index + 1);
                let after = index.checked_sub(1).map_or(time, |k| found[k].occurrence.time);
                let last = &mut found[index].occurrence;
                if last.time < end {
                    let whole = RepeatableStep { run_loop: self, run, stepper: before, forces, ends };
                    let cut = whole.shorten(last, after, workspace, detector, between)?;
                    (last.time, last.q, last.v) = (cut.time, cut.q, cut.v);
                    (*stepper, energy_account, end) = (cut.stepper, cut.energy_account, cut.time);
                    q.copy_from_slice(&last.q);
                    v.copy_from_slice(&last.v);
                }
                run.ended_by_event = true;
            }
            run.events.extend(found.into_iter().map(|found| found.occurrence));
        }
        Self::enter(run, stepper, (energy_account, end), (q, v));
        Ok(())
    }

    /// Records a completed step: its end and the energy account there.
    pub(crate) fn enter<S: Stepper>(
        run: &mut Run,
        stepper: &S,
        (energy_account, end): (EnergyAccount, f64),
        (q, v): (&[f64], &[f64]),
    ) {
        run.energy_account = energy_account;
        run.losses = stepper.losses();
        run.contact_laws = stepper.contact_laws();
        run.contact_forces.clear();
        run.contact_forces.extend_from_slice(stepper.contact_forces());
        run.q.copy_from_slice(q);
        run.v.copy_from_slice(v);
        run.steps += 1;
        run.time = end;
    }
}
