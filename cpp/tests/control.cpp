// Controllers, inverse kinematics, identification and optimal control.
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>

#include "pendulum.hpp"
#include "robot_dynamics.hpp"

namespace rd = robot_dynamics;
using doctest::Approx;

TEST_CASE("computed torque at the reference is inverse dynamics") {
    rd::Robot robot = rd::Robot::load(ROBOTS "panda.urdf");
    const std::size_t n = robot.nv();
    rd::Vector q = robot.random_configuration(1), v(n, 0.2), a(n, 0.5), tau(n);
    auto control = rd::ComputedTorque::make(robot, rd::Vector(n, 100.0), rd::Vector(n, 20.0));
    control.set_reference(q, v, a);
    control.torque(q, v, tau);
    rd::Vector expected = robot.inverse_dynamics(q, v, a);
    for (std::size_t k = 0; k < n; ++k) {
        CHECK(tau[k] == Approx(expected[k]).epsilon(1e-12));
    }
}

TEST_CASE("a task controller at its target compensates the weight") {
    rd::Robot robot = rd::Robot::load(ROBOTS "panda.urdf");
    const std::size_t n = robot.nv();
    rd::Vector q = robot.random_configuration(5), rest(n), tau(n);
    rd::Frame hand = robot.frame("panda_link8");
    for (bool has_orientation : {false, true}) {
        auto control = rd::TaskControl::make(robot, hand, has_orientation, {});
        control.set_target(robot.frame_pose(hand, q));
        control.torque(q, rest, tau);
        rd::Vector weight = robot.gravity_forces(q);
        for (std::size_t k = 0; k < n; ++k) {
            CHECK(tau[k] == Approx(weight[k]).epsilon(1e-6).scale(1.0));
        }
    }
}

TEST_CASE("a momentum observer finds a constant external torque") {
    rd::Robot robot = rd::Robot::load_text(pendulum);
    auto simulation = rd::Simulation::make(robot);
    auto observer = rd::MomentumObserver::make(robot, {50.0});
    rd::Vector external(1);
    for (int k = 0; k < 1000; ++k) {
        simulation.set_torques({1.5});
        observer.update(simulation.q(), simulation.v(), {0.0}, 1e-3, external);
        simulation.step();
    }
    CHECK(external[0] == Approx(1.5).epsilon(1e-2));
}

TEST_CASE("the regulator of a double integrator is stable") {
    const double h = 0.1;
    rd::Matrix a(2, 2), b(2, 1), q(2, 2), r(1, 1);
    a(0, 0) = a(1, 1) = 1.0;
    a(0, 1) = h;
    b(0, 0) = 0.5 * h * h;
    b(1, 0) = h;
    q(0, 0) = q(1, 1) = r(0, 0) = 1.0;
    rd::Matrix gain = rd::dlqr(a, b, q, r);
    double x[2] = {1.0, 0.0};
    for (int k = 0; k < 200; ++k) {
        const double u = -(gain(0, 0) * x[0] + gain(0, 1) * x[1]);
        x[0] += h * x[1] + 0.5 * h * h * u;
        x[1] += h * u;
    }
    CHECK(std::fabs(x[0]) + std::fabs(x[1]) < 1e-6);
    CHECK_THROWS_AS(rd::dlqr(a, b, q, rd::Matrix(2, 2)), rd::Error);
}

TEST_CASE("inverse kinematics reaches poses and positions") {
    rd::Robot robot = rd::Robot::load(ROBOTS "panda.urdf");
    rd::Frame hand = robot.frame("panda_link8");
    rd::Vector start = robot.random_configuration(1);
    rd::Pose target = robot.frame_pose(hand, robot.random_configuration(2));
    auto solution = robot.inverse_kinematics(hand, target, start);
    CHECK(solution.report.position_error < 1e-8);
    CHECK(solution.report.angle_error < 1e-8);
    auto position = target.translation();
    solution = robot.inverse_kinematics(hand, position, start);
    CHECK(robot.frame_pose(hand, solution.q).translation()[0] == Approx(position[0]).epsilon(1e-8));
    rd::InverseKinematicsOptions once{};
    once.from_start_only = 1;
    try {
        robot.inverse_kinematics(hand, {50.0, 0.0, 0.0}, start, once);
        FAIL("a point at 50 m is out of reach");
    } catch (const rd::Error& error) {
        CHECK(error.status() == RD_STATUS_NOT_CONVERGED);
    }
}

TEST_CASE("identification finds the inertia of a pendulum") {
    rd::Robot robot = rd::Robot::load_text(pendulum);
    auto record = rd::MotionRecord::make(robot, true, RD_TERM_DAMPING);
    auto frictionless = rd::MotionRecord::make(robot);
    record.set_noise({0.01});
    frictionless.set_noise({0.01});
    for (int k = 0; k < 100; ++k) {
        const double t = 0.1 * k, q = std::sin(t), v = std::cos(t), a = -std::sin(t);
        rd::Vector tau = robot.inverse_dynamics({q}, {v}, {a});
        record.push({q}, {v}, {a}, {1.2 * tau[0] + 0.3 * v});
        frictionless.push({q}, {v}, {a}, {1.2 * tau[0]});
    }
    auto found = record.identify();
    auto named = [&](const std::string& name) {
        auto at = std::find_if(found.parameters.begin(), found.parameters.end(),
                               [&](const rd::BaseParameter& parameter) { return parameter.name == name; });
        REQUIRE(at != found.parameters.end());
        return at->value;
    };
    CHECK(named("rod.hx") == Approx(1.2 * mass * length).epsilon(1e-9));
    CHECK(named("rod.Iyy") == Approx(1.2 * inertia).epsilon(1e-9));
    CHECK(named("hinge.damping") == Approx(0.3).epsilon(1e-9));
    auto estimate = frictionless.identify_consistent(1e-4);
    CHECK(estimate.robot.gravity_forces({0.0})[0] == Approx(-1.2 * mass * gravity * length).epsilon(1e-2));
}

TEST_CASE("optimal control swings a pendulum up, and predictive control holds it there") {
    rd::Robot robot = rd::Robot::load_text(pendulum);
    const std::size_t nodes = 50;
    const double up = -1.5707963267948966;
    auto problem = rd::Problem::make(robot, "rk4", 0.02, nodes, {1.5, 0.0});
    problem.add_state_cost({nodes, nodes + 1}, {up, 0.0}, {1e3, 1e2});
    problem.add_control_cost({0, nodes}, {0.0}, {1e-3});
    problem.set_control_bounds({0, nodes}, {-30.0}, {30.0});
    rd::SolverReport report = problem.solve();
    CHECK(report.is_solved != 0);
    CHECK(problem.state(nodes)[0] == Approx(up).epsilon(1e-2));
    for (std::size_t node = 0; node < nodes; ++node) {
        CHECK(std::fabs(problem.control(node)[0]) <= 30.0);
    }
    CHECK(problem.gain(0).columns() == 2);
    CHECK_THROWS_AS(problem.state(nodes + 1), rd::Error);

    problem.add_state_cost({0, nodes}, {up, 0.0}, {1.0, 0.1});
    auto mpc = rd::Mpc::make(problem);
    auto simulation = rd::Simulation::make(robot);
    simulation.reset({up + 0.2}, {0.0});
    rd::Vector u(1);
    for (int k = 0; k < 100; ++k) {
        mpc.step({simulation.q()[0], simulation.v()[0]}, u);
        simulation.set_torques(u);
        simulation.step(20);
    }
    CHECK(simulation.q()[0] == Approx(up).epsilon(1e-2));
    CHECK(mpc.times().periods == 99);
}
