//! The table of quantities: shapes, names, and batches against single states.

use std::collections::HashSet;

use robot_dynamics::batch::{BatchQuantity, BatchWorkspace};
use robot_dynamics::model::{Workspace, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::quantity::{Input, Inputs, Quantity, QuantityMemory, ResultShape};

use crate::common::{families, size};

#[test]
fn each_quantity_has_a_name_and_results() {
    let names: HashSet<_> = Quantity::ALL.iter().map(|quantity| quantity.name()).collect();
    assert_eq!(names.len(), Quantity::ALL.len());
    for quantity in Quantity::ALL {
        assert_eq!(Quantity::named(quantity.name()), Some(quantity));
        let results = quantity.results();
        let result_names: HashSet<_> = results.iter().map(|result| result.name).collect();
        assert!((1..=3).contains(&results.len()) && result_names.len() == results.len(), "{quantity:?}");
        assert!(results.len() == 1 || !result_names.contains(""), "{quantity:?}: several results have names");
    }
}

/// The product of the dimensions is the length.
#[test]
fn shapes_agree_with_lengths() {
    let model = families()[2].robots().next().unwrap().model;
    for quantity in Quantity::ALL {
        for result in quantity.results() {
            let ResultShape::Poses = result.shape else {
                assert_eq!(
                    result.shape.dimensions(&model, 0).iter().product::<usize>(),
                    result.shape.len(&model, 0)
                );
                continue;
            };
            assert_eq!(result.shape.dimensions(&model, 5), [5, 12]);
            assert_eq!(result.shape.len(&model, 5), 60);
        }
    }
}

/// Batches and single states use different forms of the recursions. Tolerance: 1e-12 of the largest number,
/// times the condition number of the robot where M is inverted.
#[test]
fn batches_match_single_states() {
    const STATES: usize = 11;
    let mut compared = 0;
    for family in families() {
        let Some(robot) = family.robots().find(|robot| robot.condition() < 1e3) else { continue };
        let model = &robot.model;
        let mut random = SplitMix64::new(robot.seed);
        let states: Vec<_> = (0..STATES).map(|_| random_state(model, &mut random)).collect();
        let table = |part: &dyn Fn(usize) -> Vec<f64>| (0..STATES).flat_map(part).collect::<Vec<f64>>();
        let (q, v) = (table(&|i| states[i].q.clone()), table(&|i| states[i].v.clone()));
        let (a, tau) = (table(&|i| states[i].a.clone()), table(&|i| states[i].tau.clone()));
        let all: Vec<_> = model.frames().iter().filter_map(|frame| model.frame(&frame.name)).collect();
        let (mut workspace, mut memory) = (Workspace::new(model), QuantityMemory::new(model));
        let mut lanes = BatchWorkspace::new(model);
        for quantity in Quantity::ALL {
            let frames = if quantity.reads(Input::Frame) { &all[all.len() - 1..] } else { &all[..] };
            let widths: Vec<_> =
                quantity.results().iter().map(|result| result.shape.len(model, all.len())).collect();
            let mut out = [(); 3].map(|()| Vec::new());
            for (out, width) in out.iter_mut().zip(&widths) {
                *out = vec![f64::NAN; width * STATES];
            }
            let [x, y, z] = &mut out;
            let inputs = Inputs { q: &q, v: &v, a: &a, tau: &tau, frames };
            let computed = quantity.compute_batch(model, &mut lanes, &inputs, [x, y, z]);
            assert_eq!(computed.is_some(), quantity.has_batch(), "{quantity:?}");
            let Some(computed) = computed else { continue };
            assert_eq!(computed, Ok(()), "{quantity:?}");
            for (i, state) in states.iter().enumerate() {
                let inputs = Inputs { q: &state.q, v: &state.v, a: &state.a, tau: &state.tau, frames };
                quantity.compute(model, &mut workspace, &inputs, &mut memory);
                let single = memory.results(quantity);
                for ((width, batch), single) in widths.iter().zip(&out).zip(single) {
                    let defect = crate::common::max_difference(&batch[i * width..(i + 1) * width], single);
                    let kappa = if quantity.inverts_mass() { robot.condition() } else { 1.0 };
                    let allowed = 1e-12 * kappa * size(single).max(1.0);
                    robot.require(&format!("{} of state {i}", quantity.name()), defect, allowed);
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 500, "only {compared} results");
}
