// Measures each call of a control loop at 1 kHz: its median, its 99.9th percentile and its worst time.
//
//   real_time ROBOT [SECONDS]
//
// The program locks its memory and asks for the scheduler SCHED_FIFO. It prints whether the kernel allowed them.
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#if defined(__linux__)
#include <sched.h>
#include <sys/mman.h>
#include <time.h>
#endif

#include "robot_dynamics.hpp"

namespace rd = robot_dynamics;
using Clock = std::chrono::steady_clock;

namespace {

/// The times of one kind of call [µs].
struct Times {
    std::string name;
    std::vector<double> all;

    template <class Call>
    void measure(Call call) {
        const auto begin = Clock::now();
        call();
        all.push_back(std::chrono::duration<double, std::micro>(Clock::now() - begin).count());
    }

    void print() {
        std::sort(all.begin(), all.end());
        const std::size_t last = all.size() - 1;
        std::printf("| %s | %.2f | %.2f | %.2f |\n", name.c_str(), all[last / 2], all[last * 999 / 1000], all[last]);
    }
};

/// Locks memory and raises the priority, and prints what the kernel allowed.
void prepare() {
#if defined(__linux__)
    const int locked = mlockall(MCL_CURRENT | MCL_FUTURE);
    std::printf("mlockall: %s\n", locked == 0 ? "allowed" : std::strerror(errno));
    sched_param priority{};
    priority.sched_priority = 80;
    const int scheduled = sched_setscheduler(0, SCHED_FIFO, &priority);
    std::printf("SCHED_FIFO, priority 80: %s\n", scheduled == 0 ? "allowed" : std::strerror(errno));
#endif
}

/// Waits until a time of the clock.
void wait_until(Clock::time_point end) {
#if defined(__linux__)
    const auto since = std::chrono::duration_cast<std::chrono::nanoseconds>(end.time_since_epoch()).count();
    timespec at{since / 1'000'000'000, since % 1'000'000'000};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr);
#else
    while (Clock::now() < end) {
    }
#endif
}

}  // namespace

int main(int argc, char** argv) try {
    const char* const file = argc > 1 ? argv[1] : "robots/panda.urdf";
    const double seconds = argc > 2 ? std::atof(argv[2]) : 2.0;
    rd::Robot robot = rd::Robot::load(file);
    const std::size_t n = robot.nv();
    const rd::Frame tip = robot.frame(robot.frame_names().back());
    const rd::Vector gains(n, 100.0), damping(n, 20.0), zero(n);
    auto control = rd::ComputedTorque::make(robot, gains, damping);
    auto task = rd::TaskControl::make(robot, tip, true, {});
    auto observer = rd::MomentumObserver::make(robot, damping);
    auto simulation = rd::Simulation::make(robot);
    rd::Vector q = robot.random_configuration(1), v(n), tau(n), out(n), matrix(n * n), square(n * n), third(n * n);
    rd::Vector jacobian(6 * n);
    simulation.reset(q, v);
    task.set_target(robot.frame_pose(tip, q));
    control.set_reference(q, zero, zero);

    std::vector<Times> times{{"inverse_dynamics", {}},          {"forward_dynamics", {}},
                             {"mass_matrix", {}},               {"frame_jacobian", {}},
                             {"forward_dynamics_derivatives", {}}, {"ComputedTorque::torque", {}},
                             {"TaskControl::torque", {}},       {"MomentumObserver::update", {}},
                             {"Simulation::step", {}},          {"start of the period, late by", {}}};
    const std::size_t periods = static_cast<std::size_t>(1000.0 * seconds);
    for (Times& one : times) {
        one.all.reserve(periods + 1);
    }
    auto calls = [&] {
        times[0].measure([&] { robot.inverse_dynamics(q, v, zero, out); });
        times[1].measure([&] { robot.forward_dynamics(q, v, tau, out); });
        times[2].measure([&] { robot.mass_matrix(q, matrix); });
        times[3].measure([&] { robot.frame_jacobian(tip, q, jacobian); });
        times[4].measure([&] { robot.forward_dynamics_derivatives(q, v, tau, matrix, square, third); });
        times[5].measure([&] { control.torque(q, v, tau); });
        times[6].measure([&] { task.torque(q, v, out); });
        times[7].measure([&] { observer.update(q, v, tau, 1e-3, out); });
        simulation.set_torques(tau);
        times[8].measure([&] { simulation.step(); });
        simulation.q(q);
        simulation.v(v);
    };
    calls();  // the first calls compile machine code
    for (Times& one : times) {
        one.all.clear();
    }
    prepare();
    auto next = Clock::now();
    for (std::size_t k = 0; k < periods; ++k) {
        next += std::chrono::milliseconds(1);
        wait_until(next);
        times[9].all.push_back(std::chrono::duration<double, std::micro>(Clock::now() - next).count());
        calls();
    }
    std::printf("%s, %zu periods of 1 ms\n\n| call | median, µs | 99.9 %%, µs | worst, µs |\n", file, periods);
    std::printf("| --- | ---: | ---: | ---: |\n");
    for (Times& one : times) {
        one.print();
    }
    return 0;
} catch (const rd::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
