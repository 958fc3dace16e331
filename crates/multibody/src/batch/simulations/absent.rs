//! Without machine code each simulation takes its own steps.

use std::sync::Arc;

use dynamics::Integrator;

use crate::Model;
use crate::simulator::side_by_side::StepStart;

pub(super) const SIDE_BY_SIDE: usize = 1;

/// There are none.
#[derive(Debug)]
pub(super) enum StepKernels {}

#[derive(Clone, Copy)]
pub(super) struct TakenStep {
    pub(super) is_far: bool,
    pub(super) is_regular: bool,
}

impl StepKernels {
    pub(super) fn new(_: &Arc<Model>, _: Integrator, _: bool) -> Option<Self> {
        None
    }

    pub(super) fn are_of(&self, _: &Arc<Model>, _: Integrator, _: bool) -> bool {
        match *self {}
    }

    pub(super) fn clear(&mut self) {
        match *self {}
    }

    pub(super) fn push(&mut self, _: &StepStart<'_>) {
        match *self {}
    }

    pub(super) fn step(&mut self, _: f64) {
        match *self {}
    }

    pub(super) fn end(&self, _: usize) -> (TakenStep, (&[f64], &[f64]), (f64, f64)) {
        match *self {}
    }
}
