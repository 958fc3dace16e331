// The form without exceptions.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#define DOCTEST_CONFIG_NO_EXCEPTIONS_BUT_WITH_ALL_ASSERTS
#include <doctest/doctest.h>

#define ROBOT_DYNAMICS_NO_EXCEPTIONS
#include "pendulum.hpp"
#include "robot_dynamics.hpp"

namespace rd = robot_dynamics;

TEST_CASE("results hold values") {
    rd::Result<rd::Robot> robot = rd::Robot::load_text(pendulum);
    CHECK(robot.has_value());
    rd::Result<rd::Vector> tau = robot->gravity_forces({0.0});
    CHECK(tau.has_value());
    CHECK((*tau)[0] == doctest::Approx(-mass * gravity * length));
    rd::Result<rd::Simulation> simulation = rd::Simulation::make(*robot);
    CHECK(simulation.has_value());
    rd::Result<void> stepped = simulation->step(10);
    CHECK(stepped.has_value());
}

TEST_CASE("results hold errors") {
    rd::Result<rd::Robot> missing = rd::Robot::load("nowhere.urdf");
    CHECK(!missing);
    CHECK(missing.error().status() == RD_STATUS_FILE);
    CHECK(std::string(missing.error().what()).find("nowhere.urdf") != std::string::npos);
    rd::Result<rd::Robot> robot = rd::Robot::load_text(pendulum);
    rd::Result<rd::Vector> wrong = robot->gravity_forces({0.0, 1.0});
    CHECK(!wrong);
    CHECK(wrong.error().status() == RD_STATUS_INVALID_INPUT);
}
