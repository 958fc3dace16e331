/// Optimal control and model predictive control.
#pragma once

#include <string>

#include "simulation.hpp"

namespace robot_dynamics {
ROBOT_DYNAMICS_NAMESPACE {

/// Options of the solver; zeros select the defaults.
using SolverOptions = rd_solver_options;
/// The result of the solver.
using SolverReport = rd_solver_report;
/// The times of the periods of a predictive controller [s].
using MpcTimes = rd_mpc_times_report;

/// The nodes from `first` to `end` − 1; node N is the last state.
struct Nodes {
    std::size_t first, end;
};

/// An optimal control problem of N nodes. The state is (q, v).
class Problem {
public:
    /// A problem of steps without contact; the controls are the torques of the driven coordinates.
    static Result<Problem> make(const Robot& robot, const std::string& integrator, double dt, std::size_t nodes,
                                View state, bool dissipation = true) {
        Problem problem = sized(robot.nq(), robot.nv(), nodes);
        rd_status status = rd_problem_new(robot.model(), integrator.c_str(), dt, dissipation, nodes, state.data(),
                                          state.size(), problem.owner_.put());
        return detail::finish(status, std::move(problem));
    }
    /// A problem of the steps of a simulation. The controls are torques, or those of the actuators.
    static Result<Problem> from_simulation(const Robot& robot, const Simulation& simulation, std::size_t nodes,
                                           View state, bool actuators = false) {
        Problem problem = sized(robot.nq(), robot.nv(), nodes);
        rd_status status = rd_problem_from_simulation(simulation.handle(), actuators, nodes, state.data(),
                                                      state.size(), problem.owner_.put());
        return detail::finish(status, std::move(problem));
    }

    /// The number of nodes N and of controls.
    std::size_t nodes() const noexcept { return nodes_; }
    std::size_t controls() const { return rd_problem_control_count(owner_.get()); }

    /// Adds ½ Σ weight · (x ⊖ target)², with 2 nv weights.
    Result<void> add_state_cost(Nodes nodes, View target, View weights) {
        return add(RD_COST_KIND_STATE, nodes, Frame{0}, target, weights);
    }
    /// Adds ½ Σ weight · (u − target)².
    Result<void> add_control_cost(Nodes nodes, View target, View weights) {
        return add(RD_COST_KIND_CONTROL, nodes, Frame{0}, target, weights);
    }
    /// Adds the cost of a frame's position, 3 numbers and 3 weights.
    Result<void> add_frame_position_cost(Nodes nodes, Frame frame, View target, View weights) {
        return add(RD_COST_KIND_FRAME_POSITION, nodes, frame, target, weights);
    }
    /// Adds the cost of a frame's pose, 12 numbers and 6 weights.
    Result<void> add_frame_pose_cost(Nodes nodes, Frame frame, View target, View weights) {
        return add(RD_COST_KIND_FRAME_POSE, nodes, frame, target, weights);
    }
    /// Adds the cost of a frame's velocity, 6 numbers and 6 weights.
    Result<void> add_frame_velocity_cost(Nodes nodes, Frame frame, View target, View weights) {
        return add(RD_COST_KIND_FRAME_VELOCITY, nodes, frame, target, weights);
    }
    /// Adds the cost of the centre of mass, 3 numbers and 3 weights.
    Result<void> add_center_of_mass_cost(Nodes nodes, View target, View weights) {
        return add(RD_COST_KIND_CENTER_OF_MASS, nodes, Frame{0}, target, weights);
    }
    /// Removes all costs.
    Result<void> clear_costs() { return detail::finish(rd_problem_clear_costs(owner_.get())); }
    /// Bounds the controls of nodes.
    Result<void> set_control_bounds(Nodes nodes, View lower, View upper) {
        return detail::finish(rd_problem_set_control_bounds(owner_.get(), nodes.first, nodes.end, lower.data(),
                                                            lower.size(), upper.data(), upper.size()));
    }
    /// Sets the initial state.
    Result<void> set_initial_state(View state) {
        return detail::finish(rd_problem_set_initial_state(owner_.get(), state.data(), state.size()));
    }

    /// Solves the problem, from the last solution if there is one.
    Result<SolverReport> solve(const SolverOptions& options = {}) {
        SolverReport report{};
        rd_status status = rd_problem_solve(owner_.get(), &options, &report);
        return detail::finish(status, report);
    }
    /// The state of a node of the solution.
    Result<Vector> state(std::size_t node) const {
        Vector out(nq_ + nv_);
        return detail::finish(rd_problem_state(owner_.get(), node, out.data(), out.size()), std::move(out));
    }
    /// The controls of a node of the solution.
    Result<Vector> control(std::size_t node) const {
        Vector out(controls());
        return detail::finish(rd_problem_control(owner_.get(), node, out.data(), out.size()), std::move(out));
    }
    /// The gain K of u = u_k + K (x ⊖ x_k) at a node, controls × 2 nv.
    Result<Matrix> gain(std::size_t node) const {
        Matrix out(controls(), 2 * nv_);
        return detail::finish(rd_problem_gain(owner_.get(), node, out.data(), out.size()), std::move(out));
    }
    rd_problem handle() const noexcept { return owner_.get(); }

private:
    static Problem sized(std::size_t nq, std::size_t nv, std::size_t nodes) {
        Problem problem;
        problem.nq_ = nq;
        problem.nv_ = nv;
        problem.nodes_ = nodes;
        return problem;
    }

    Result<void> add(rd_cost_kind kind, Nodes nodes, Frame frame, View target, View weights) {
        return detail::finish(rd_problem_add_cost(owner_.get(), static_cast<std::uint32_t>(kind), nodes.first,
                                                  nodes.end, frame.index, target.data(), target.size(),
                                                  weights.data(), weights.size()));
    }

    detail::Owner<rd_problem, rd_problem_free> owner_;
    std::size_t nq_ = 0, nv_ = 0, nodes_ = 0;
};

/// A controller that solves a problem again at each period; one period is one node.
class Mpc {
public:
    /// A controller with at most this many iterations a period, within a time budget [s]; 0 for the defaults.
    static Result<Mpc> make(const Problem& problem, std::size_t iterations = 0, double time_budget = 0.0,
                            const SolverOptions& options = {}) {
        Mpc mpc;
        rd_status status = rd_mpc_new(problem.handle(), &options, iterations, time_budget, mpc.owner_.put());
        return detail::finish(status, std::move(mpc));
    }
    /// The controls of the next period, from the measured state.
    Result<void> step(View state, MutableView control) {
        return detail::finish(
            rd_mpc_step(owner_.get(), state.data(), state.size(), control.data(), control.size()));
    }
    /// Takes the present costs of the problem.
    Result<void> set_costs(const Problem& problem) {
        return detail::finish(rd_mpc_set_costs(owner_.get(), problem.handle()));
    }
    /// The times of the periods so far.
    Result<MpcTimes> times() const {
        MpcTimes times{};
        rd_status status = rd_mpc_times(owner_.get(), &times);
        return detail::finish(status, times);
    }

private:
    detail::Owner<rd_mpc, rd_mpc_free> owner_;
};

}
}  // namespace robot_dynamics
