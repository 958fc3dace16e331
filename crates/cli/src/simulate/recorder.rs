//! The record of a run of any length: a bounded number of samples for the plot and the table, and the
//! extremes.

use robot_dynamics::model::Model;
use robot_dynamics::simulation::{EnergyAccount, StepInfo};

use super::csv::numbers;

/// Largest number of samples, about the width of a plot in pixels.
const MAX_SAMPLES: usize = 2048;

/// The record of a run.
pub(crate) struct Recorder {
    pub samples: Vec<Sample>,
    pub extremes: Vec<Extremes>,
    /// The largest |v| of each coordinate.
    pub peak_speed: Vec<f64>,
    /// Number of steps between samples.
    stride: usize,
    /// The largest |energy error| since the last sample \[J\].
    worst_error: f64,
    /// The last step if it is not a sample yet. It becomes one if the run ends there.
    latest: Option<Sample>,
    is_apart: bool,
    limits: Vec<(f64, f64)>,
}

/// One sample.
#[derive(Clone, Debug)]
pub(crate) struct Sample {
    pub time: f64,
    pub q: Vec<f64>,
    pub kinetic: f64,
    pub potential: f64,
    /// E − E₀ − work + dissipated energy \[J\].
    pub error: f64,
    /// The largest |error| since the previous sample \[J\].
    pub worst_error: f64,
    /// Energy losses so far \[J\].
    pub losses: [f64; 6],
    /// |f| of the ground force on each link \[N\].
    pub contact: Vec<f64>,
}

/// The range of an entry of q.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extremes {
    pub least: f64,
    pub most: f64,
    /// The time when it first left its limits \[s\].
    pub left_limits: Option<f64>,
}

impl Recorder {
    pub(crate) fn new(model: &Model) -> Self {
        let mut limits = vec![(f64::NEG_INFINITY, f64::INFINITY); model.nq()];
        for joint in model.joints().iter().filter(|joint| joint.nq == joint.nv) {
            limits[joint.q()].fill((joint.limits.lower, joint.limits.upper));
        }
        Self {
            samples: Vec::new(),
            extremes: vec![
                Extremes { least: f64::INFINITY, most: f64::NEG_INFINITY, left_limits: None };
                model.nq()
            ],
            peak_speed: vec![0.0; model.nv()],
            stride: 1,
            worst_error: 0.0,
            latest: None,
            is_apart: false,
            limits,
        }
    }

    /// Records one step.
    pub(crate) fn record(&mut self, info: &StepInfo<'_>) {
        // The command is compiled without optimisation, where indices are faster than iterators and
        // comparisons than calls.
        let (extremes, limits, mut k) = (&mut self.extremes[..], &self.limits[..], 0);
        while k < info.q.len() {
            let (q, extremes, (lower, upper)) = (info.q[k], &mut extremes[k], limits[k]);
            if q < extremes.least {
                extremes.least = q;
            }
            if q > extremes.most {
                extremes.most = q;
            }
            if (q < lower || q > upper) && extremes.left_limits.is_none() {
                extremes.left_limits = Some(info.time);
            }
            k += 1;
        }
        let (peaks, mut k) = (&mut self.peak_speed[..], 0);
        while k < info.v.len() {
            let speed = if info.v[k] < 0.0 { -info.v[k] } else { info.v[k] };
            if speed > peaks[k] {
                peaks[k] = speed;
            }
            k += 1;
        }
        self.worst_error = self.worst_error.max(info.energy_account.imbalance().abs());
        self.is_apart = !info.step.is_multiple_of(self.stride);
        if self.is_apart {
            match &mut self.latest {
                Some(latest) => latest.record(info, self.worst_error),
                None => self.latest = Some(Sample::of(info, self.worst_error)),
            }
            return;
        }
        self.samples.push(Sample::of(info, self.worst_error));
        self.worst_error = 0.0;
        if self.samples.len() == 2 * MAX_SAMPLES {
            self.thin();
        }
    }

    /// The scale of an energy error, and its name. It is the energy account's scale for a conservative
    /// motion, and the energy moved for a motion with motors or losses. The largest K of a diverged motion is
    /// meaningless, so its scale is |E₀|, or the K that nine tenths of the samples stay below.
    pub(crate) fn energy_scale(&self, energy_account: &EnergyAccount, diverged: bool) -> (f64, &'static str) {
        let start = energy_account.start().abs();
        if !diverged && !energy_account.is_conservative() {
            return (energy_account.energy_moved(), "energy moved");
        }
        if energy_account.scale() == start || (diverged && start > 0.0) {
            return (start, "|E0|");
        }
        if !diverged {
            return (energy_account.scale(), "max K");
        }
        let mut kinetic: Vec<f64> = self.samples.iter().map(|sample| sample.kinetic).collect();
        kinetic.sort_by(f64::total_cmp);
        (kinetic.get(kinetic.len() * 9 / 10).copied().unwrap_or(1.0), "typical K")
    }

    /// Adds the last step to the record.
    pub(crate) fn finish(&mut self) {
        if self.is_apart {
            self.samples.extend(self.latest.take());
        }
    }

    /// Drops every second sample; the next one takes over its largest error. The last one is kept apart, as
    /// it may be the last of the run.
    fn thin(&mut self) {
        let errors: Vec<f64> = self.samples.iter().map(|sample| sample.worst_error).collect();
        (self.latest, self.is_apart) = (self.samples.pop(), true);
        let mut index = 0;
        self.samples.retain_mut(|sample| {
            let keep = index % 2 == 0;
            if keep && index > 0 {
                sample.worst_error = sample.worst_error.max(errors[index - 1]);
            }
            index += 1;
            keep
        });
        // The next sample takes over this error.
        self.worst_error = errors[index];
        self.stride *= 2;
    }
}

impl Sample {
    fn of(info: &StepInfo<'_>, worst_error: f64) -> Self {
        let contact = vec![0.0; info.contact_forces.len()];
        let (time, kinetic, potential, error, losses) = (0.0, 0.0, 0.0, 0.0, [0.0; 6]);
        let mut sample =
            Self { time, q: info.q.to_vec(), kinetic, potential, error, worst_error, losses, contact };
        sample.record(info, worst_error);
        sample
    }

    fn record(&mut self, info: &StepInfo<'_>, worst_error: f64) {
        self.time = info.time;
        self.q.copy_from_slice(info.q);
        self.kinetic = info.energy_account.kinetic();
        self.potential = info.energy_account.potential();
        self.error = info.energy_account.imbalance();
        self.worst_error = worst_error;
        self.losses = numbers(&info.losses.unwrap_or_default());
        let (sizes, mut k) = (&mut self.contact[..], 0);
        while k < sizes.len() {
            let [x, y, z] = info.contact_forces[k];
            sizes[k] = (x * x + y * y + z * z).sqrt();
            k += 1;
        }
    }
}
