//! Functions in stages: a step with contact and its pullback, whose sweeps are loops that call one
//! expression.

use robot_dynamics::model::Model;
use robot_dynamics_expression::{Arithmetic, Graph, Plan, interpret};

use crate::layout::Layout;
use crate::program::{
    Call, Case, Instruction, Place, Program, ProgramResult, Stage, Stages, outcomes, random_arguments,
    uncertainty,
};
use crate::stage_tables::StageTables;
use crate::{Function, GenerateError};

/// The program of a function in stages, or `None` if the function is one expression.
pub(crate) fn staged(
    function: &Function,
    model: &Model,
    arithmetic: Arithmetic,
    states: usize,
) -> Option<Result<Program, GenerateError>> {
    let stages = stages_of(function, model, arithmetic)?;
    Some(stages.map(|stages| program(function, stages, model, arithmetic, states)))
}

/// The stages of a function, or `None` if the function is one expression.
pub(crate) fn stages_of(
    function: &Function,
    model: &Model,
    arithmetic: Arithmetic,
) -> Option<Result<Stages, GenerateError>> {
    match function {
        Function::ContactStep { sweeps } => Some(Builder::new(model, arithmetic).step((*sweeps).into())),
        Function::Pullback(of) => match **of {
            Function::ContactStep { sweeps } => Some(Builder::new(model, arithmetic).pullback(sweeps.into())),
            _ => None,
        },
        _ => None,
    }
}

/// The program with expected values in random states.
fn program(
    function: &Function,
    stages: Stages,
    model: &Model,
    arithmetic: Arithmetic,
    states: usize,
) -> Program {
    let (arguments, outcomes) = (function.arguments(model), outcomes(function, model));
    let (mut cases, mut tolerance) = (Vec::new(), 0.0_f64);
    for inputs in random_arguments(function, model, arithmetic, states) {
        let tables = (arguments.iter().map(|x| x.name)).zip(inputs.iter().map(Vec::as_slice)).collect();
        let results = interpreted(&stages, arithmetic, tables, &outcomes);
        // The library's sine and the platform's differ, and a compiler may add in another order.
        tolerance = tolerance.max(uncertainty(arithmetic, &results, &results));
        cases.push(Case { arguments: inputs, results });
    }
    let graph = Graph::new(arithmetic.precision);
    Program {
        function: function.clone(),
        symbol: function.symbol(),
        arguments,
        outcomes,
        plan: Plan::new(&graph, &[]),
        graph,
        results: Vec::new(),
        cases,
        entries: Vec::new(),
        tolerance,
        stages: Some(stages),
    }
}

/// The results of one state, operation by operation.
fn interpreted(
    stages: &Stages,
    arithmetic: Arithmetic,
    inputs: Vec<(&str, &[f64])>,
    outcomes: &[ProgramResult],
) -> Vec<Vec<f64>> {
    let mut memory = StageTables::new(1, stages, inputs, outcomes);
    let call = |stage: usize, inputs: &[&[f64]], outputs: &mut [&mut [f64]]| {
        let Program { graph, plan, results, .. } = &stages.stages[stage].program;
        let inputs: Vec<Vec<f64>> = inputs.iter().map(|table| table.to_vec()).collect();
        let (values, _) = interpret(graph, plan, results, arithmetic, &inputs);
        outputs.iter_mut().zip(values).for_each(|(output, values)| output.copy_from_slice(&values));
    };
    memory.execute(stages, &stages.body, &mut { call }, &|x, y| arithmetic.precision.round(x + y));
    outcomes.iter().map(|outcome| memory.table(&outcome.name).to_vec()).collect()
}

/// Makes the stages of a step with contact.
struct Builder<'a> {
    model: &'a Model,
    arithmetic: Arithmetic,
    stages: Vec<Stage>,
    locals: Vec<(&'static str, usize)>,
}

impl<'a> Builder<'a> {
    fn new(model: &'a Model, arithmetic: Arithmetic) -> Self {
        Self { model, arithmetic, stages: Vec::new(), locals: Vec::new() }
    }

    /// Adds a stage, and returns its index.
    fn add(&mut self, function: &Function) -> Result<usize, GenerateError> {
        let program = Program::new(function, self.model, self.arithmetic, 1)?;
        let layout = Layout::straight(&program.graph, &program.plan);
        self.stages.push(Stage { program, layout });
        Ok(self.stages.len() - 1)
    }

    /// A table of the thread.
    fn local(&mut self, name: &'static str, length: usize) -> Place {
        self.locals.push((name, length));
        Place::Local { table: name, offset: 0 }
    }

    /// The length of a result of a stage.
    fn length(&self, stage: usize, result: usize) -> usize {
        self.stages[stage].program.outcomes[result].length()
    }

    /// The problem, the velocity with the initial multipliers, sweeps, the end.
    fn step(mut self, sweeps: usize) -> Result<Stages, GenerateError> {
        let problem = self.add(&Function::ContactProblem)?;
        let start = self.add(&Function::ContactStart)?;
        let sweep = self.add(&Function::ContactSweep)?;
        let end = self.add(&Function::ContactEnd)?;
        let (nv, np) = (self.model.nv(), self.length(sweep, 1));
        let table = self.local("problem", self.length(problem, 0));
        let [v0, v1] = ["v0", "v1"].map(|name| self.local(name, nv));
        let [p0, p1] = ["p0", "p1"].map(|name| self.local(name, np));
        let once =
            |from: [Place; 2], to: [Place; 2]| call(sweep, [&[table], &from[..]].concat(), to.to_vec());
        let (there, back) = (once([v0, p0], [v1, p1]), once([v1, p1], [v0, p0]));
        let mut body = vec![
            call(problem, ["q", "v", "tau", "h", "friction"].map(Place::State).to_vec(), vec![table, v1]),
            call(start, vec![table, v1, Place::State("impulses")], vec![v0]),
            Instruction::Copy { from: Place::State("impulses"), to: p0, count: np },
            Instruction::Repeat { count: sweeps / 2, body: vec![there.clone(), back] },
        ];
        let mut last = (v0, p0);
        if sweeps % 2 == 1 {
            body.push(there);
            last = (v1, p1);
        }
        body.extend([
            call(
                end,
                vec![table, last.0, Place::State("q"), Place::State("h")],
                ["q_next", "v_next"].map(Place::State).to_vec(),
            ),
            Instruction::Copy { from: last.1, to: Place::State("impulses_next"), count: np },
        ]);
        Ok(Stages { stages: self.stages, locals: self.locals, body })
    }

    /// The adjoint at the multipliers p of a step, by the implicit function theorem: p = T(p, w), where w is
    /// the problem. The weights λ of p satisfy λ = T_pᵀλ + U_pᵀμ, where μ are those of the velocity U(p, w).
    /// The same number of iterations computes them, each of which is one pullback of (U, T).
    fn pullback(mut self, sweeps: usize) -> Result<Stages, GenerateError> {
        let problem = self.add(&Function::ContactProblem)?;
        let start = self.add(&Function::ContactStart)?;
        let end = self.add(&Function::ContactEnd.pullback())?;
        let fixed = self.add(&Function::ContactFixedPoint.pullback())?;
        let begun = self.add(&Function::ContactProblem.pullback())?;
        let (nv, np, nw) = (self.model.nv(), self.length(fixed, 2), self.length(problem, 0));
        let table = self.local("problem", nw);
        let [free, velocity, by_q] = ["free", "velocity", "by_q"].map(|name| self.local(name, nv));
        // The weights of the problem and the free velocity: those of the end, and of the fixed point.
        let of_end = self.local("of_end", nw);
        let of_fixed = self.local("of_fixed", nw + nv);
        // μ and λ.
        let weights = self.local("weights", nv + np);
        let next = self.local("next_weights", np);
        let state = Place::State;
        let inputs = ["q", "v", "tau", "h", "friction"].map(state).to_vec();
        let p = state("impulses");
        let once = call(fixed, vec![table, free, p, weights], vec![of_fixed, of_fixed.shifted(nw), next]);
        let keep = Instruction::Copy { from: next, to: weights.shifted(nv), count: np };
        let body = vec![
            call(problem, inputs.clone(), vec![table, free]),
            call(start, vec![table, free, p], vec![velocity]),
            call(
                end,
                vec![table, velocity, state("q"), state("h"), state("cotangent")],
                vec![of_end, weights, by_q],
            ),
            Instruction::Clear { place: weights.shifted(nv), count: np },
            Instruction::Repeat { count: sweeps, body: vec![once.clone(), keep] },
            once,
            Instruction::Add { from: of_end, to: of_fixed, count: nw },
            call(
                begun,
                [inputs, vec![of_fixed]].concat(),
                ["by_position", "by_velocity", "by_force", "by_friction"].map(state).to_vec(),
            ),
            Instruction::Add { from: by_q, to: state("by_position"), count: nv },
        ];
        Ok(Stages { stages: self.stages, locals: self.locals, body })
    }
}

fn call(stage: usize, arguments: Vec<Place>, results: Vec<Place>) -> Instruction {
    Instruction::Call(Call { stage, arguments, results })
}

#[cfg(test)]
mod tests {
    use robot_dynamics::description::{
        Base, LinkDescription, LinkShape, MassProperties, Pose, Shape, ShapeRole, pendulum,
    };
    use robot_dynamics::model::Workspace;
    use robot_dynamics::nalgebra::{Matrix3, Vector3};
    use robot_dynamics::number::SplitMix64;
    use robot_dynamics::simulation::{ContactStep, ContactStepInputs};

    use super::*;

    const SWEEPS: u16 = 400;
    const H: f64 = 5e-3;

    /// A body with an arm; its balls touch the ground.
    fn robot() -> Model {
        let mut robot = pendulum(0.4, 0.3);
        robot.base = Base::Floating;
        let trunk = robot.links[0].name.clone();
        let inertia = Matrix3::from_diagonal(&Vector3::new(0.02, 0.03, 0.04));
        let mass = MassProperties::new(2.0, Vector3::new(0.01, 0.02, 0.0), inertia).unwrap();
        robot.links[0] = LinkDescription::new(trunk.clone(), mass);
        let ball = |link: &str, x: f64, y: f64| {
            let pose = Pose::from_translation([x, y, 0.0]);
            LinkShape::new(link, ShapeRole::Collision, pose, Shape::Sphere { radius: 0.05 })
        };
        robot.shapes = vec![ball(&trunk, -0.1, 0.1), ball(&trunk, -0.1, -0.1), ball("rod", 0.2, 0.0)];
        Model::new(robot).unwrap()
    }

    /// The gradient through contact is that of central differences of converged steps, in states in which the
    /// balls stick, slide and leave the ground. Differences have errors of 1e-12/1e-6 and 1e-6².
    #[test]
    fn the_pullback_is_that_of_differences() {
        let model = robot();
        let function = Function::ContactStep { sweeps: SWEEPS }.pullback();
        let stages = Builder::new(&model, Arithmetic::default()).pullback(SWEEPS.into()).unwrap();
        let step = ContactStep::new(&model, 4000).unwrap();
        let (nq, nv, np) = (model.nq(), model.nv(), step.impulse_count());
        let mut random = SplitMix64::new(17);
        let (mut pushing, mut sliding, mut apart) = (0, 0, 0);
        for _ in 0..12 {
            let mut uniform = |count: usize, size: f64| -> Vec<f64> {
                (0..count).map(|_| random.uniform(-size, size)).collect()
            };
            let mut q = vec![0.0, 0.0, 0.05 + uniform(1, 2e-3)[0], 0.0, 0.0, 0.0, 1.0, 0.0];
            q[7] = uniform(1, 5e-3)[0];
            let (v, tau) = ([uniform(3, 0.2), uniform(4, 0.2)].concat(), uniform(nv, 0.2));
            let (cotangent, friction) = (uniform(2 * nv, 1.0), 0.3);
            let advance = |q: &[f64], v: &[f64], tau: &[f64], friction: f64| {
                let (mut q1, mut v1, mut p1) = (vec![0.0; nq], vec![0.0; nv], vec![0.0; np]);
                let rest = vec![0.0; np];
                let inputs = ContactStepInputs::new([q, v, tau], H, friction, &rest);
                step.step(&model, &mut Workspace::new(&model), &inputs, &mut q1, &mut v1, &mut p1);
                (q1, v1, p1)
            };
            let (q_end, _, impulses) = advance(&q, &v, &tau, friction);
            for impulse in impulses.chunks(3) {
                pushing += usize::from(impulse[0] > 0.0);
                apart += usize::from(impulse[0] == 0.0);
                let tangential = impulse[1].hypot(impulse[2]);
                sliding += usize::from(impulse[0] > 0.0 && tangential > 0.999 * friction * impulse[0]);
            }
            let inputs =
                [q.clone(), v.clone(), tau.clone(), vec![H], vec![friction], impulses, cotangent.clone()];
            let arguments = function.arguments(&model);
            let tables = (arguments.iter().map(|x| x.name)).zip(inputs.iter().map(Vec::as_slice)).collect();
            let found = interpreted(&stages, Arithmetic::default(), tables, &outcomes(&function, &model));
            let gradient = found.concat();
            let weighted = |(q1, v1, _): (Vec<f64>, Vec<f64>, Vec<f64>)| -> f64 {
                let mut displacement = vec![0.0; nv];
                robot_dynamics::model::difference(&model, &q_end, &q1, &mut displacement);
                let all = displacement.iter().chain(&v1);
                all.zip(&cotangent).map(|(x, weight)| x * weight).sum()
            };
            let differences = |k: usize| {
                let at = |e: f64| {
                    let (mut q, mut v, mut tau, mut friction) = (q.clone(), v.clone(), tau.clone(), friction);
                    match k / nv {
                        0 => {
                            let mut displacement = vec![0.0; nv];
                            displacement[k] = e;
                            let from = q.clone();
                            robot_dynamics::model::integrate(&model, &from, &displacement, &mut q);
                        }
                        1 => v[k - nv] += e,
                        2 => tau[k - 2 * nv] += e,
                        _ => friction += e,
                    }
                    weighted(advance(&q, &v, &tau, friction))
                };
                (at(1e-6) - at(-1e-6)) / 2e-6
            };
            assert_eq!(gradient.len(), 3 * nv + 1);
            for (k, found) in gradient.iter().enumerate() {
                let expected = differences(k);
                assert!(
                    (found - expected).abs() < 1e-5 * (1.0 + expected.abs()),
                    "{k}: {found} for {expected}"
                );
            }
        }
        assert!(pushing > 10 && sliding > 3 && apart > 5, "{pushing} {sliding} {apart}");
    }
}
