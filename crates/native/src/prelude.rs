//! Sines of several angles of one state at once, before the rest of its program.

use expression::{Operand, Operation as Node};
use number::InstructionSet;

use crate::list::{Address, Base, Extent, List};
use crate::lower::{Given, Lowering, Source};
use crate::pool::Pool;
use crate::target::{Target, Width};

/// Sines of angles that stand beside each other in an argument.
pub(crate) struct Prelude {
    pub(crate) list: List,
    /// Where in scratch memory the sines and cosines are.
    pub(crate) given: Given,
    /// Bytes of scratch memory.
    pub(crate) scratch_end: i32,
    pub(crate) target: Target,
}

/// An angle that is a number of an argument.
struct Angle {
    node: usize,
    argument: usize,
    index: usize,
}

impl Prelude {
    /// Registers of 256 bits, or pairs of 128.
    fn target(target: Target) -> Target {
        let instructions = match target.instructions {
            InstructionSet::Avx512 => InstructionSet::Avx2,
            other => other,
        };
        Target { instructions, width: Width::Lanes, ..target }
    }

    /// The prelude of a program, if at least two angles share a register. The largest magnitude of an angle is stored at the beginning of
    /// the scratch memory.
    pub(crate) fn new(
        target: Target,
        source: Source<'_>,
        lengths: &[usize],
        pool: &mut Pool,
    ) -> Option<Self> {
        // Behind the largest angle of this and that of the rest of the program.
        let mut scratch_end = target.value_bytes();
        let target = Self::target(target);
        scratch_end += target.value_bytes();
        let (size, lanes) = (target.size(), target.lanes());
        let angles = angles(source);
        let mut lowering = Lowering::new(target, pool);
        let mut given = Given::new();
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
            let angle = lowering.list.value(Some(Address { extent: Extent::Register, ..place }));
            let (sine, cosine) = lowering.sine_and_cosine(angle, magnitude);
            let [sines, cosines] = [scratch_end, scratch_end + target.value_bytes()];
            scratch_end += 2 * target.value_bytes();
            lowering.list.store(sine, Address::new(Base::Scratch, sines, Extent::Register));
            lowering.list.store(cosine, Address::new(Base::Scratch, cosines, Extent::Register));
            for angle in group {
                let lane = i32::try_from(angle.index - from).expect("a few lanes");
                let at = |begin: i32| Address::new(Base::Scratch, begin + size * lane, Extent::Number);
                given.insert(angle.node, (at(sines), at(cosines)));
            }
        }
        let largest = lowering.largest_angle?;
        lowering.list.store(largest, Address::new(Base::Scratch, 0, Extent::Register));
        let list = lowering.list.swept();
        Some(Self { list, given, scratch_end, target })
    }
}

/// Pairs whose angle is a number of an argument, in the order of the arguments.
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
