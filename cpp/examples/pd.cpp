// A control loop at 1 kHz: computed torque drives a simulated arm along a sine. No call in the loop allocates.
#include <cmath>
#include <cstdio>

#include "robot_dynamics.hpp"

namespace rd = robot_dynamics;

int main(int argc, char** argv) try {
    rd::Robot robot = rd::Robot::load(argc > 1 ? argv[1] : "robots/panda.urdf");
    const std::size_t n = robot.nv();
    rd::Vector kp(n, 400.0), kd(n, 40.0);
    auto control = rd::ComputedTorque::make(robot, kp, kd, true);
    auto simulation = rd::Simulation::make(robot);

    rd::Vector start = robot.lower_limits(), upper = robot.upper_limits();
    for (std::size_t i = 0; i < n; ++i) {
        start[i] = 0.5 * (start[i] + upper[i]);  // the middle of the range
    }
    simulation.reset(start, rd::Vector(n));
    rd::Vector q(n), v(n), tau(n), q_wanted(n), v_wanted(n), a_wanted(n);
    double worst = 0.0;
    for (int k = 0; k < 2000; ++k) {
        const double t = 1e-3 * k, w = 2.0;
        for (std::size_t i = 0; i < n; ++i) {
            q_wanted[i] = start[i] + 0.1 * (1.0 - std::cos(w * t));
            v_wanted[i] = 0.1 * w * std::sin(w * t);
            a_wanted[i] = 0.1 * w * w * std::cos(w * t);
        }
        simulation.q(q);
        simulation.v(v);
        control.set_reference(q_wanted, v_wanted, a_wanted);
        control.torque(q, v, tau);
        simulation.set_torques(tau);
        simulation.step();
        for (std::size_t i = 0; i < n; ++i) {
            worst = std::fmax(worst, std::fabs(q_wanted[i] - q[i]));
        }
    }
    std::printf("largest error of a joint in 2 s: %.2e rad\n", worst);
    return worst < 1e-3 ? 0 : 1;
} catch (const rd::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
