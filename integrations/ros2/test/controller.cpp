// The computed-torque controller, with the simulated Panda.
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>

#include "allocations.hpp"
#include "rig.hpp"
#include "robot_dynamics.h"

using doctest::Approx;

namespace {

const std::vector<double> bent = {0.1, 0.3, -0.2, -1.5, 0.2, 1.4, 0.3};

/// The largest distance of a joint from a target [rad].
double distance(const Loop& loop, const std::vector<double>& target) {
    double largest = 0.0;
    for (std::size_t k = 0; k < target.size(); ++k) {
        double q = loop.system->get_state("panda_joint" + std::to_string(k + 1) + "/position");
        largest = std::max(largest, std::fabs(q - target[k]));
    }
    return largest;
}

std::vector<double> shifted(double by) {
    std::vector<double> target = bent;
    for (double& x : target) {
        x += by;
    }
    return target;
}

/// The largest distance from q* = bent + (1 − cos 3t) / 10 in two seconds [rad].
double tracking_error(const HardwareInfo& info, double period) {
    Loop loop(info, joint_names(info));
    REQUIRE(loop.start());
    auto reference = [](double t) { return shifted(0.1 * (1.0 - std::cos(3.0 * t))); };
    double largest = 0.0;
    for (int k = 0; k < std::lround(2.0 / period); ++k) {
        double t = k * period;
        std::vector<double> v(7, 0.3 * std::sin(3.0 * t)), a(7, 0.9 * std::cos(3.0 * t));
        loop.publish({reference(t), v, a, {}});
        REQUIRE(loop.step(period));
        REQUIRE(loop.system->read({}, {0, 0}) == hardware_interface::return_type::OK);
        largest = std::max(largest, distance(loop, reference(t + period)));
    }
    return largest;
}

bool log_contains(const std::string& text) {
    const auto& log = rclcpp::stub::log();
    auto has_it = [&](const std::string& line) { return line.find(text) != std::string::npos; };
    return std::any_of(log.begin(), log.end(), has_it);
}

}  // namespace

TEST_CASE("the controller holds the arm where it is activated") {
    HardwareInfo info = panda(bent);
    Loop loop(info, joint_names(info));
    REQUIRE(loop.start());
    for (int k = 0; k < 1000; ++k) {
        REQUIRE(loop.step());
    }
    // The torque at rest is g(q), so that rounding alone moves the arm, and the feedback does not amplify it.
    CHECK(distance(loop, bent) < 1e-9);
}

TEST_CASE("the controller reaches a point that a message states") {
    HardwareInfo info = panda(bent);
    Loop loop(info, joint_names(info));
    REQUIRE(loop.start());
    loop.publish({shifted(0.2), {}, {}, {}});
    for (int k = 0; k < 3000; ++k) {
        REQUIRE(loop.step());
    }
    // Critical damping at 10 / s leaves 0.2 (1 + 30) exp(−30) rad = 6e-13 rad after 3 s. A delay of 1 s by
    // effort limits leaves 0.2 (1 + 20) exp(−20) rad = 9e-9 rad.
    CHECK(distance(loop, shifted(0.2)) < 1e-8);
}

TEST_CASE("the controller follows a moving reference, with an error of the order of the period") {
    HardwareInfo info = panda(bent);
    info.hardware_parameters = {{"dt", "0.0005"}};
    double coarse = tracking_error(info, 1e-3), fine = tracking_error(info, 5e-4);
    // The torque is constant for a period h, in which the motion changes tau(q, v, a) in proportion to h. The
    // error of the position is that of tau, divided by M and Kp, so that it halves with h. The bound of the
    // coarse one is 0.5 % of the motion, 0.2 rad.
    CHECK(coarse < 1e-3);
    CHECK(fine / coarse == Approx(0.5).epsilon(0.1));
}

TEST_CASE("the torques stay within the effort limits of the robot description") {
    HardwareInfo info = panda(bent);
    Loop loop(info, joint_names(info));
    loop.controller->get_node()->parameters["stiffness"] = std::vector<double>{1e5};
    REQUIRE(loop.start());
    loop.publish({shifted(0.3), {}, {}, {}});
    REQUIRE(loop.step());
    for (int joint = 1; joint <= 7; ++joint) {
        double torque = loop.system->get_command("panda_joint" + std::to_string(joint) + "/effort");
        CHECK(std::fabs(torque) <= (joint <= 4 ? 87.0 : 12.0));
    }
    CHECK(loop.system->get_command("panda_joint1/effort") == 87.0);
}

TEST_CASE("a period does not allocate") {
    HardwareInfo info = panda(bent);
    Loop loop(info, joint_names(info));
    std::size_t before = allocations();
    rd_model model{0};
    REQUIRE(rd_load(ROBOTS "panda.urdf", nullptr, &model) == RD_STATUS_OK);
    // The counter sees the library.
    CHECK(allocations() > before);
    rd_model_free(model);
    REQUIRE(loop.start());
    for (int k = 0; k < 100; ++k) {
        loop.publish({shifted(1e-3 * k), {}, {}, {}});
        before = allocations();
        bool is_ok = loop.step();
        std::size_t after = allocations();
        REQUIRE(is_ok);
        CHECK(after == before);
    }
}

TEST_CASE("messages from before the activation and with wrong lengths do not count") {
    HardwareInfo info = panda(bent);
    Loop loop(info, joint_names(info));
    REQUIRE(loop.start());
    loop.publish({shifted(0.1), {}, {}, {}});
    REQUIRE(loop.controller->on_deactivate({}) == Callback::SUCCESS);
    CHECK(loop.system->get_command("panda_joint1/effort") == 0.0);
    REQUIRE(loop.controller->on_activate({}) == Callback::SUCCESS);
    loop.publish({{0.1, 0.2}, {}, {}, {}});
    CHECK(log_contains("reference ignored: it needs 7 finite positions"));
    loop.publish({std::vector<double>(7, std::nan("")), {}, {}, {}});
    for (int k = 0; k < 100; ++k) {
        REQUIRE(loop.step());
    }
    CHECK(distance(loop, bent) < 1e-9);
}

TEST_CASE("the controller refuses invalid parameters and descriptions with the reason") {
    HardwareInfo info = panda(bent);
    auto names = joint_names(info);

    Loop missing(info, {names.begin(), names.end() - 1});
    CHECK(!missing.start());
    CHECK(log_contains("\"panda_joint7\" is missing"));

    names.back() = "wheel";
    Loop unknown(info, names);
    CHECK(!unknown.start());
    CHECK(log_contains("no joint \"wheel\""));

    Loop gains(info, joint_names(info));
    gains.controller->get_node()->parameters["stiffness"] = std::vector<double>{-1.0};
    CHECK(!gains.start());
    CHECK(log_contains("\"stiffness\" has a number that is negative"));

    Loop lengths(info, joint_names(info));
    lengths.controller->get_node()->parameters["damping"] = std::vector<double>(2, 1.0);
    CHECK(!lengths.start());
    CHECK(log_contains("\"damping\" has 2 numbers"));

    info.original_xml = "<robot name=\"x\"><link name=\"a\"></robot>";
    auto controller = make_controller();
    controller->init("broken", info.original_xml);
    REQUIRE(controller->on_init() == Callback::SUCCESS);
    CHECK(controller->on_configure({}) == Callback::ERROR);
    CHECK(log_contains("ERROR broken: "));
}
