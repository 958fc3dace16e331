//! The vector prelude of a program for one state: sines of several angles at once, and stores of equal
//! constants.

use robot_dynamics_expression::{Operand, Operation as Node};
use robot_dynamics_number::InstructionSet;

use crate::list::{Address, Base, List, LoadExtent};
use crate::lowering::{Lowering, PreludeValues, Source};
use crate::pool::Pool;
use crate::target::{Target, Width};

/// Sines of adjacent angles of an argument, and adjacent equal constants of a result, computed in whole
/// registers.
pub(crate) struct Prelude {
    pub(crate) list: List,
    /// The locations of sines and cosines in scratch memory, and the stored constants.
    pub(crate) given: PreludeValues,
    /// Bytes of scratch memory.
    pub(crate) scratch_end: i32,
    pub(crate) target: Target,
    /// Whether the largest magnitude of an angle is at the beginning of the scratch memory.
    pub(crate) has_sines: bool,
}

/// An angle that is a number of an argument.
struct Angle {
    node: usize,
    argument: usize,
    index: usize,
}

impl Prelude {
    /// The target of the prelude: registers of 256 bits, or pairs of 128.
    fn target(target: Target) -> Target {
        let instructions = match target.instructions {
            InstructionSet::Avx512 => InstructionSet::Avx2,
            other => other,
        };
        Target { instructions, width: Width::Lanes, ..target }
    }

    /// The prelude of a program, if at least two angles or enough constants share a register.
    pub(crate) fn new(
        target: Target,
        source: Source<'_>,
        lengths: &[usize],
        pool: &mut Pool,
    ) -> Option<Self> {
        // After the largest angles of the prelude and of the rest of the program.
        let mut scratch_end = target.value_bytes();
        let target = Self::target(target);
        scratch_end += target.value_bytes();
        let (size, lanes) = (target.size(), target.lanes());
        let angles = angles(source);
        let mut lowering = Lowering::new(target, pool);
        let mut given = PreludeValues::default();
        let mut rest = &angles[..];
        while let Some(first) = rest.first() {
            let (argument, length) = (first.argument, lengths[first.argument]);
            if length < lanes {
                rest = &rest[1..];
                continue;
            }
            // The last group begins earlier, so that no number behind the argument is read.
            let from = first.index.min(length - lanes);
            let is_within = |angle: &&Angle| angle.argument == argument && angle.index < from + lanes;
            let count = rest.iter().take_while(is_within).count();
            let (group, others) = rest.split_at(count);
            rest = others;
            if count < 2 {
                continue;
            }
            let has_angle = |lane: usize| group.iter().any(|angle| angle.index == from + lane);
            let magnitude = lowering.sign_bit() - 1;
            let lane_bits = |lane| if has_angle(lane) { magnitude } else { 0 };
            let bytes = usize::try_from(size).expect("4 or 8");
            let pattern = lowering.pool.pattern((0..lanes).map(lane_bits), bytes);
            let magnitude = lowering.list.value(Some(pattern));
            let place = Lowering::number_at(argument, from, size);
            let angle = lowering.list.value(Some(Address { extent: LoadExtent::Register, ..place }));
            let (sine, cosine) = lowering.sine_and_cosine(angle, magnitude);
            let [sines, cosines] = [scratch_end, scratch_end + target.value_bytes()];
            scratch_end += 2 * target.value_bytes();
            lowering.list.store(sine, Address::new(Base::Scratch, sines, LoadExtent::Register));
            lowering.list.store(cosine, Address::new(Base::Scratch, cosines, LoadExtent::Register));
            for angle in group {
                let lane = i32::try_from(angle.index - from).expect("a few lanes");
                let at = |begin: i32| Address::new(Base::Scratch, begin + size * lane, LoadExtent::Number);
                given.sines.insert(angle.node, (at(sines), at(cosines)));
            }
        }
        store_constants(&mut lowering, source, lengths.len(), &mut given);
        let has_sines = lowering.largest_angle.is_some();
        if let Some(largest) = lowering.largest_angle {
            lowering.list.store(largest, Address::new(Base::Scratch, 0, LoadExtent::Register));
        }
        let list = lowering.list.remove_dead_code();
        (!list.steps.is_empty()).then_some(Self { list, given, scratch_end, target, has_sines })
    }
}

/// Stores runs of equal constants that fill at least a register. The last store may overlap the one before.
fn store_constants(
    lowering: &mut Lowering<'_>,
    source: Source<'_>,
    first_table: usize,
    given: &mut PreludeValues,
) {
    let (size, lanes) = (lowering.target.size(), lowering.target.lanes());
    for (result, numbers) in source.results.iter().enumerate() {
        let mut begin = 0;
        for run in numbers.chunk_by(|a, b| a == b) {
            if let (Some(x), true) = (run[0].known(), run.len() >= lanes) {
                let constant = lowering.constant(x);
                for at in (0..run.len()).step_by(lanes) {
                    let index = begin + at.min(run.len() - lanes);
                    let place = Lowering::number_at(first_table + result, index, size);
                    lowering.list.store(constant, Address { extent: LoadExtent::Register, ..place });
                }
                given.constants.extend((begin..begin + run.len()).map(|index| (result, index)));
            }
            begin += run.len();
        }
    }
}

/// Pairs whose angle is a number of an argument, sorted by argument and index.
fn angles(source: Source<'_>) -> Vec<Angle> {
    let Source { graph, order, .. } = source;
    let angle = |&node: &usize| {
        let Node::SineCosine(Operand::Plus(angle)) = graph.nodes[node] else { return None };
        let Node::Input { argument, index } = graph.nodes[angle as usize] else { return None };
        Some(Angle { node, argument: argument as usize, index: index as usize })
    };
    let mut angles: Vec<Angle> = order.iter().filter_map(angle).collect();
    angles.sort_by_key(|angle| (angle.argument, angle.index));
    angles
}
