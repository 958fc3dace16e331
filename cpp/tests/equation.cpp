// The equation of motion: closed forms of a pendulum, and identities between quantities of an arm.
#include <cmath>
#include <doctest/doctest.h>

#include "pendulum.hpp"
#include "robot_dynamics.hpp"

namespace rd = robot_dynamics;
using doctest::Approx;

namespace {

double distance(rd::View a, rd::View b) {
    REQUIRE(a.size() == b.size());
    double largest = 0.0;
    for (std::size_t k = 0; k < a.size(); ++k) {
        largest = std::fmax(largest, std::fabs(a[k] - b[k]));
    }
    return largest;
}

}  // namespace

TEST_CASE("a pendulum has its closed forms") {
    rd::Robot robot = rd::Robot::load_text(pendulum);
    const double q = 0.3, v = 1.0, a = 2.0;
    CHECK(robot.nv() == 1);
    CHECK(robot.name() == "pendulum");
    CHECK(robot.coordinate_names() == std::vector<std::string>{"hinge"});
    CHECK(robot.mass_matrix({q})(0, 0) == Approx(inertia).epsilon(1e-14));
    const double weight = -mass * gravity * length * std::cos(q);
    CHECK(robot.gravity_forces({q})[0] == Approx(weight).epsilon(1e-14));
    CHECK(robot.inverse_dynamics({q}, {v}, {a})[0] == Approx(inertia * a + weight).epsilon(1e-14));
    CHECK(robot.kinetic_energy({q}, {v}) == Approx(0.5 * inertia).epsilon(1e-14));
    CHECK(robot.effort_limits()[0] == 40.0);
    rd::Pose tip = robot.frame_pose(robot.frame("tip"), {q});
    CHECK(tip.translation()[0] == Approx(length * std::cos(q)).epsilon(1e-14));
    CHECK(tip.translation()[2] == Approx(-length * std::sin(q)).epsilon(1e-14));
    auto slope = robot.inverse_dynamics_derivatives({q}, {v}, {a}).by_position(0, 0);
    CHECK(slope == Approx(mass * gravity * length * std::sin(q)).epsilon(1e-12));
}

TEST_CASE("quantities of an arm agree with each other") {
    rd::Robot robot = rd::Robot::load(ROBOTS "panda.urdf");
    const std::size_t n = robot.nv();
    rd::Vector q = robot.random_configuration(7), v(n), a(n);
    for (std::size_t k = 0; k < n; ++k) {
        v[k] = 0.1 * static_cast<double>(k + 1);
        a[k] = 1.0 - 0.2 * static_cast<double>(k);
    }
    rd::Vector tau = robot.inverse_dynamics(q, v, a);
    rd::Matrix mass_matrix = robot.mass_matrix(q);
    rd::Vector sum = robot.bias(q, v);
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = 0; j < n; ++j) {
            sum[i] += mass_matrix(i, j) * a[j];
        }
    }
    CHECK(distance(tau, sum) < 1e-12);
    CHECK(distance(robot.forward_dynamics(q, v, tau), a) < 1e-9);
    rd::Matrix regressor = robot.joint_torque_regressor(q, v, a);
    rd::Vector parameters = robot.inertial_parameters(), product(n);
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = 0; j < parameters.size(); ++j) {
            product[i] += regressor(i, j) * parameters[j];
        }
    }
    CHECK(distance(product, tau) < 1e-10);
    rd::Frame hand = robot.frame("panda_link8");
    rd::Matrix jacobian = robot.frame_jacobian(hand, q);
    auto velocity = robot.frame_velocity(hand, q, v);
    for (std::size_t i = 0; i < 6; ++i) {
        double sum = 0.0;
        for (std::size_t j = 0; j < n; ++j) {
            sum += jacobian(i, j) * v[j];
        }
        CHECK(velocity[i] == Approx(sum).epsilon(1e-12));
    }
    rd::Vector displacement = robot.difference(q, robot.integrate(q, v));
    CHECK(distance(displacement, v) < 1e-12);
}

TEST_CASE("batches give the numbers of single states") {
    rd::Robot robot = rd::Robot::load(ROBOTS "panda.urdf");
    const std::size_t n = robot.nv(), states = 37;
    rd::Vector q, zero(states * n), out(states * n);
    for (std::size_t k = 0; k < states; ++k) {
        rd::Vector state = robot.random_configuration(k);
        q.insert(q.end(), state.begin(), state.end());
    }
    rd::Batch batch = rd::Batch::make(robot, 2);
    batch.inverse_dynamics(q, zero, zero, out);
    for (std::size_t k = 0; k < states; ++k) {
        rd::View state(q.data() + k * n, n), row(out.data() + k * n, n);
        CHECK(distance(robot.gravity_forces(state), row) < 1e-12);
    }
    CHECK_THROWS_AS(batch.inverse_dynamics(q, zero, rd::Vector(3), out), rd::Error);
}

TEST_CASE("a free body rotates by unit quaternions") {
    rd::LoadOptions options;
    options.floating_base = true;
    rd::Robot robot = rd::Robot::load_text(pendulum, options);
    CHECK(robot.nq() == 8);
    CHECK(robot.nv() == 7);
    rd::Vector q = robot.neutral();
    CHECK(q[6] == 1.0);
    q[6] = 0.5;
    try {
        robot.mass_matrix(q);
        FAIL("a quaternion of length 0.5 is refused");
    } catch (const rd::Error& error) {
        CHECK(error.status() == RD_STATUS_INVALID_INPUT);
    }
}

TEST_CASE("errors name the argument") {
    rd::Robot robot = rd::Robot::load_text(pendulum);
    auto message = [](auto&& call) {
        try {
            call();
        } catch (const rd::Error& error) {
            return std::string(error.what());
        }
        return std::string("no error");
    };
    CHECK(message([&] { robot.bias({0.1}, {NAN}); }).find("v[0]") == 0);
    CHECK(message([&] { robot.gravity_forces({0.1, 0.2}); }).find("q") == 0);
    CHECK(message([&] { robot.frame("hand"); }).find("hand") != std::string::npos);
    CHECK(message([] { rd::Robot::load("nowhere.urdf"); }).find("nowhere.urdf") != std::string::npos);
    rd::Robot moved = std::move(robot);
    CHECK(moved.nv() == 1);
    CHECK(message([&] { robot.gravity_forces({0.1}); }) != "no error");
}
