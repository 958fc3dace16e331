//! A function of one robot as an expression.

use robot_dynamics_core::{Model, MotionError, RandomState, random_state};
use robot_dynamics_expression::{Arithmetic, Graph, Operand, Plan, Traced, evaluate, trace};
use robot_dynamics_number::SplitMix64;

use crate::call::call;
use crate::derivatives::{derivatives_by_dual_numbers, differentiate};
use crate::function::DerivativeKind;
use crate::{Function, FunctionError};

/// The smallest number of successive equal links that can become a loop.
pub const LEAST_EQUAL_LINKS: usize = 6;

/// A function of one robot as an expression.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct TracedFunction {
    /// Its operations.
    pub graph: Graph,
    /// Its results, matrices by rows.
    pub results: Vec<Vec<Operand>>,
    /// The order of its operations.
    pub plan: Plan,
    /// For a pullback through the graph, the results of the function that is pulled back, which the graph
    /// contains as well; empty otherwise.
    pub primal: Vec<Vec<Operand>>,
    arithmetic: Arithmetic,
    /// The differentiated function, or the function itself, and the traced robot.
    of: Function,
    model: Model,
}

/// An expression whose operations have no order yet; see [`TracedFunction`].
pub(crate) struct Expression {
    pub graph: Graph,
    pub results: Vec<Vec<Operand>>,
    pub primal: Vec<Vec<Operand>>,
    of: Function,
    model: Model,
}

impl Function {
    /// DifferentiationInput its expression for this robot.
    ///
    /// # Errors
    /// [`FunctionError::Input`], [`FunctionError::NotDifferentiable`], [`FunctionError::Singular`].
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics_expression::Arithmetic;
    /// use robot_dynamics_functions::Function;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let traced = Function::Gravity.trace(&model, Arithmetic::default())?;
    /// assert!(traced.plan.steps() < 5); // -m g l cos q
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn trace(&self, model: &Model, arithmetic: Arithmetic) -> Result<TracedFunction, FunctionError> {
        let Expression { graph, results, primal, of, model } = self.expression(model, arithmetic)?;
        let plan = Plan::new(&graph, &results);
        Ok(TracedFunction { graph, results, plan, primal, arithmetic, of, model })
    }

    /// DifferentiationInput its expression, without an order of the operations.
    pub(crate) fn expression(
        &self,
        model: &Model,
        arithmetic: Arithmetic,
    ) -> Result<Expression, FunctionError> {
        let of_another = self.derivative_of();
        let of = of_another.map_or(self, |(of, _)| of);
        if of_another.is_some() && !of.is_differentiable() {
            return Err(FunctionError::NotDifferentiable { function: self.to_string() });
        }
        if of_another.is_some() && matches!(of, Self::ContactStep { .. }) {
            return Err(FunctionError::InStages { function: self.to_string() });
        }
        let source = of.traced_model(model);
        check_mass(self, &source)?;
        let compute = call::<Traced>(of, &source)?;
        let lengths: Vec<usize> = of.arguments(model).iter().map(|argument| argument.length).collect();
        let traces = trace(arithmetic, &lengths, &compute);
        drop(compute);
        let is_pullback = matches!(of_another, Some((_, DerivativeKind::Pullback)));
        let primal = if is_pullback { traces.1.clone() } else { Vec::new() };
        let (graph, results) = match of_another {
            Some(of_another) => differentiate(of_another, &source, arithmetic, &traces),
            None => traces,
        };
        Ok(Expression { graph, results, primal, of: of.clone(), model: source })
    }

    /// The robot that is traced: its motion is the same to rounding, with fewer operations.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics_functions::Function;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// assert_eq!(Function::Bias.traced_model(&model).nv(), 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn traced_model(&self, model: &Model) -> Model {
        let exact = model.with_right_angles();
        if self.regroups(model) { exact.regrouped() } else { exact }
    }

    /// Whether mass is regrouped to the body that it moves with. It is if the result stays the same and links
    /// that would make a loop stay equal.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics_functions::Function;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// assert!(Function::Bias.regroups(&model) && !Function::KineticEnergy.regroups(&model));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn regroups(&self, model: &Model) -> bool {
        self.is_of_equation_of_motion() && model.longest_run_of_equal_links() < LEAST_EQUAL_LINKS
    }

    /// The derivatives or pullback in one state, computed by the library's recursions over dual numbers: an
    /// independent route. `None` for functions that are not differentiated through a graph.
    ///
    /// # Errors
    /// [`FunctionError::Input`].
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics_functions::Function;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let derivatives = Function::PotentialEnergy.derivatives().derivatives_by_dual_numbers(&model, &[vec![0.0]])?;
    /// assert!((derivatives.expect("derivatives")[0][0] + 2.0 * 9.81 * 0.5).abs() < 1e-12); // at q = 0 the bob is level with the hinge
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn derivatives_by_dual_numbers(
        &self,
        model: &Model,
        arguments: &[Vec<f64>],
    ) -> Result<Option<Vec<Vec<f64>>>, FunctionError> {
        self.derivative_of()
            .map(|derivatives| derivatives_by_dual_numbers(derivatives, model, arguments))
            .transpose()
    }
}

impl TracedFunction {
    /// The function's values in one state, operation by operation; for derivatives and pullbacks, those of
    /// the differentiated function.
    ///
    /// # Panics
    /// If an argument has the wrong length; see [`Function::arguments`].
    pub fn evaluate(&self, arguments: &[Vec<f64>]) -> Vec<Vec<f64>> {
        self.evaluate_in(self.arithmetic, arguments)
    }

    /// The same in another arithmetic.
    ///
    /// # Panics
    /// As [`evaluate`](Self::evaluate).
    pub fn evaluate_in(&self, arithmetic: Arithmetic, arguments: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let compute = call::<Traced>(&self.of, &self.model).expect("it was traced");
        let own = self.of.rows_of_arguments().len();
        evaluate(arithmetic, &arguments[..own], compute)
    }
}

/// Rejects functions that invert M if M is singular in a random state.
fn check_mass(function: &Function, model: &Model) -> Result<(), FunctionError> {
    if !function.inverts_mass() {
        return Ok(());
    }
    let RandomState { q, .. } = random_state(model, &mut SplitMix64::new(1));
    match model.check_rank(&q) {
        Err(MotionError::SingularMass(cause)) => {
            Err(FunctionError::Singular { robot: model.name().into(), function: function.to_string(), cause })
        }
        _ => Ok(()),
    }
}
