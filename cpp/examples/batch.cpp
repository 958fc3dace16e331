// Inverse and forward dynamics of 10 000 states, in lanes and on all cores.
#include <chrono>
#include <cmath>
#include <cstdio>

#include "robot_dynamics.hpp"

namespace rd = robot_dynamics;

int main(int argc, char** argv) try {
    rd::Robot robot = rd::Robot::load(argc > 1 ? argv[1] : "robots/panda.urdf");
    const std::size_t states = 10'000, nv = robot.nv();
    rd::Vector q, v(states * nv), a(states * nv, 1.0), tau(states * nv), back(states * nv);
    for (std::size_t k = 0; k < states; ++k) {
        rd::Vector state = robot.random_configuration(k);
        q.insert(q.end(), state.begin(), state.end());
    }
    auto batch = rd::Batch::make(robot);
    batch.inverse_dynamics(q, v, a, tau);
    auto begin = std::chrono::steady_clock::now();
    batch.inverse_dynamics(q, v, a, tau);
    std::chrono::duration<double> time = std::chrono::steady_clock::now() - begin;
    batch.forward_dynamics(q, v, tau, back);
    double worst = 0.0;
    for (std::size_t k = 0; k < back.size(); ++k) {
        worst = std::fmax(worst, std::fabs(back[k] - 1.0));
    }
    std::printf("%.1f ns a state; the accelerations return to %.1e\n", 1e9 * time.count() / states, worst);
    return worst < 1e-6 ? 0 : 1;
} catch (const rd::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
