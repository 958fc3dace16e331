// Eigen vectors and matrices as arguments, without copies.
#include <Eigen/Dense>
#include <doctest/doctest.h>

#include "robot_dynamics.hpp"

namespace rd = robot_dynamics;

TEST_CASE("Eigen objects are arguments and results") {
    rd::Robot robot = rd::Robot::load(ROBOTS "panda.urdf");
    const auto n = static_cast<Eigen::Index>(robot.nv());
    Eigen::VectorXd q = rd::map(robot.random_configuration(1)), v = Eigen::VectorXd::Constant(n, 0.1), a(n), tau(n);
    a.setLinSpaced(-1.0, 1.0);
    robot.inverse_dynamics(q, v, a, tau);
    rd::RowMajorMatrix mass(n, n);
    robot.mass_matrix(q, mass);
    Eigen::VectorXd bias = rd::map(robot.bias(q, v));
    CHECK((mass * a + bias - tau).norm() < 1e-11);
    CHECK((mass - mass.transpose()).norm() == 0.0);
    rd::Matrix returned = robot.mass_matrix(q);
    CHECK(rd::map(returned) == mass);
    CHECK(rd::map(returned).data() == returned.data());
}

TEST_CASE("a block of an Eigen matrix is refused, since its rows have gaps") {
    rd::Robot robot = rd::Robot::load(ROBOTS "panda.urdf");
    const auto n = static_cast<Eigen::Index>(robot.nv());
    rd::RowMajorMatrix wide(n, 2 * n);
    auto block = wide.leftCols(n);
    CHECK_THROWS_AS(robot.mass_matrix(robot.neutral(), block), rd::Error);
}
