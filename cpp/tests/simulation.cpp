// Simulations: energy, contact, inputs and snapshots.
#include <cmath>
#include <doctest/doctest.h>

#include "pendulum.hpp"
#include "robot_dynamics.hpp"

namespace rd = robot_dynamics;
using doctest::Approx;

TEST_CASE("a conservative motion keeps its energy") {
    rd::Robot robot = rd::Robot::load(ROBOTS "panda.urdf");
    rd::SimulationOptions options;
    options.conservative = true;
    auto simulation = rd::Simulation::make(robot, options);
    simulation.reset(robot.random_configuration(1), rd::Vector(robot.nv()));
    simulation.step(1000);
    CHECK(simulation.time() == Approx(1.0));
    CHECK(simulation.energy().drift < 1e-6);
    CHECK(!simulation.method().empty());
    CHECK(!simulation.reason().empty());
}

TEST_CASE("a quadruped that rests on the ground presses with its weight") {
    rd::LoadOptions floating;
    floating.floating_base = true;
    rd::Robot robot = rd::Robot::load(ROBOTS "quadruped.urdf", floating);
    rd::SimulationOptions options;
    options.ground = rd::Ground{};
    auto simulation = rd::Simulation::make(robot, options);
    rd::Vector q = robot.neutral();
    q[2] = 0.6;
    simulation.reset(q, rd::Vector(robot.nv()));
    simulation.step(4000);
    double force = 0.0;
    for (const rd::Contact& contact : simulation.contacts()) {
        if (contact.other_link == UINT32_MAX) {
            CHECK(contact.normal[2] == Approx(1.0));
            force += contact.force[2];
        }
    }
    CHECK(force == Approx(9.81 * robot.mass()).epsilon(1e-2));
    CHECK(std::fabs(simulation.energy().relative_imbalance) < 1e-2);
}

TEST_CASE("a snapshot brings back every bit") {
    rd::Robot robot = rd::Robot::load_text(pendulum);
    auto simulation = rd::Simulation::make(robot);
    simulation.step(50);
    rd::Snapshot snapshot = simulation.snapshot();
    simulation.step(50);
    rd::Vector first = simulation.q();
    simulation.restore(snapshot);
    CHECK(simulation.time() == Approx(0.05));
    simulation.step(50);
    CHECK(simulation.q() == first);
    auto other = rd::Simulation::make(robot);
    CHECK_THROWS_AS(other.restore(snapshot), rd::Error);
}

TEST_CASE("torques and wrenches hold a pendulum level") {
    rd::Robot robot = rd::Robot::load_text(pendulum);
    auto simulation = rd::Simulation::make(robot);
    simulation.set_torques({-mass * gravity * length});
    simulation.step(100);
    CHECK(std::fabs(simulation.q()[0]) < 1e-12);
    simulation.set_torques({0.0});
    simulation.set_wrenches({{robot.frame("tip"), {0.0, 0.0, mass * gravity, 0.0, 0.0, 0.0}}});
    simulation.step(100);
    CHECK(std::fabs(simulation.q()[0]) < 1e-12);
    CHECK_THROWS_AS(simulation.set_torques({1.0, 2.0}), rd::Error);
}

TEST_CASE("unknown methods and effects are errors that list the known ones") {
    rd::Robot robot = rd::Robot::load_text(pendulum);
    rd::SimulationOptions options;
    options.method = "magic";
    try {
        rd::Simulation::make(robot, options);
        FAIL("there is no such method");
    } catch (const rd::Error& error) {
        CHECK(error.status() == RD_STATUS_UNKNOWN_NAME);
        CHECK(std::string(error.what()).find("rk4") != std::string::npos);
    }
    options.method.clear();
    options.without = "weather";
    CHECK_THROWS_AS(rd::Simulation::make(robot, options), rd::Error);
}
