// Copies of a robot in threads.
#include <atomic>
#include <doctest/doctest.h>
#include <thread>
#include <vector>

#include "robot_dynamics.hpp"

namespace rd = robot_dynamics;

TEST_CASE("threads with copies of a robot compute the same numbers") {
    rd::Robot robot = rd::Robot::load(ROBOTS "panda.urdf");
    const rd::Vector q = robot.random_configuration(3), expected = robot.gravity_forces(q);
    std::atomic<int> wrong{0};
    std::vector<std::thread> threads;
    for (int k = 0; k < 4; ++k) {
        threads.emplace_back([&robot, &q, &expected, &wrong] {
            rd::Robot own(robot);
            rd::Vector g(own.nv());
            for (int call = 0; call < 2000; ++call) {
                own.gravity_forces(q, g);
                wrong += g != expected;
            }
        });
    }
    for (std::thread& thread : threads) {
        thread.join();
    }
    CHECK(wrong == 0);
}

TEST_CASE("two calls on one object at a time are right or refused") {
    rd::Robot robot = rd::Robot::load(ROBOTS "panda.urdf");
    const rd::Vector q = robot.random_configuration(3), expected = robot.gravity_forces(q);
    std::atomic<int> wrong{0}, right{0};
    auto work = [&] {
        rd::Vector g(robot.nv());
        for (int call = 0; call < 20000; ++call) {
            rd_status status = rd_gravity(robot.workspace(), q.data(), q.size(), g.data(), g.size());
            if (status == RD_STATUS_OK) {
                ++right;
                wrong += g != expected;
            } else {
                wrong += status != RD_STATUS_IN_USE;
            }
        }
    };
    std::thread one(work), other(work);
    one.join();
    other.join();
    CHECK(wrong == 0);
    CHECK(right > 0);
}
