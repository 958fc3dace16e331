// Model predictive control moves an arm to a configuration within its effort limits.
#include <cmath>
#include <cstdio>

#include "robot_dynamics.hpp"

namespace rd = robot_dynamics;

int main(int argc, char** argv) try {
    rd::Robot robot = rd::Robot::load(argc > 1 ? argv[1] : "robots/panda.urdf");
    const std::size_t n = robot.nv(), nodes = 20;
    const double dt = 0.02;
    rd::Vector start = robot.random_configuration(3), goal = robot.random_configuration(4);
    rd::Vector state(start), target(goal);
    state.resize(2 * n);
    target.resize(2 * n);

    auto problem = rd::Problem::make(robot, "semi-implicit-euler", dt, nodes, state);
    rd::Vector weights(2 * n, 10.0), last(2 * n, 1000.0), effort = robot.effort_limits(), lower(n);
    for (std::size_t i = 0; i < n; ++i) {
        weights[n + i] = 0.1;
        last[n + i] = 10.0;
        lower[i] = -effort[i];
    }
    problem.add_state_cost({0, nodes}, target, weights);
    problem.add_state_cost({nodes, nodes + 1}, target, last);
    problem.add_control_cost({0, nodes}, rd::Vector(n), rd::Vector(n, 1e-4));
    problem.set_control_bounds({0, nodes}, lower, effort);
    auto mpc = rd::Mpc::make(problem);

    rd::SimulationOptions options;
    options.dt = dt / 20.0;
    auto simulation = rd::Simulation::make(robot, options);
    simulation.reset(start, rd::Vector(n));
    rd::Vector tau(n);
    for (int k = 0; k < 150; ++k) {
        rd::Vector q = simulation.q(), v = simulation.v();
        std::copy(q.begin(), q.end(), state.begin());
        std::copy(v.begin(), v.end(), state.begin() + static_cast<std::ptrdiff_t>(n));
        mpc.step(state, tau);
        simulation.set_torques(tau);
        simulation.step(20);
    }
    rd::Vector rest = robot.difference(simulation.q(), goal);
    double worst = 0.0;
    for (double x : rest) {
        worst = std::fmax(worst, std::fabs(x));
    }
    rd::MpcTimes times = mpc.times();
    std::printf("after 3 s the largest distance of a joint is %.4f rad; a period takes %.2f ms (median)\n", worst,
                1e3 * times.median);
    return worst < 0.1 ? 0 : 1;
} catch (const rd::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
