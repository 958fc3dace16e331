// The simulated system: contact, efforts, parameters, and the descriptions of the plugins.
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>

#include "rig.hpp"

namespace {

/// A quadruped with a floating base above a ground, with effort commands and a sensor of the base's pose.
HardwareInfo quadruped(double ground) {
    HardwareInfo info;
    info.name = "quadruped";
    info.type = "system";
    info.original_xml = description("quadruped.urdf");
    info.hardware_parameters = {{"floating_base", "true"},
                                {"ground_height", std::to_string(ground)},
                                {"base_height", std::to_string(ground + 0.6)},
                                {"dt", "0.0005"}};
    for (const char* leg : {"front_left", "front_right", "hind_left", "hind_right"}) {
        for (const char* joint : {"abduction", "hip_pitch", "knee"}) {
            info.joints.push_back({std::string(leg) + "_" + joint,
                                   {{"effort", ""}},
                                   {{"position", ""}, {"velocity", ""}, {"effort", ""}}});
        }
    }
    info.sensors.push_back({"base", {}, {{"position.x", ""}, {"position.y", ""}, {"position.z", ""},
                                         {"orientation.x", ""}, {"orientation.y", ""}, {"orientation.z", ""},
                                         {"orientation.w", ""}}});
    return info;
}

double height_after(SystemInterface& system, double seconds) {
    auto duration = rclcpp::Duration::from_seconds(usual_period);
    for (int k = 0; k < std::lround(seconds / usual_period); ++k) {
        REQUIRE(system.write({}, duration) == hardware_interface::return_type::OK);
    }
    REQUIRE(system.read({}, duration) == hardware_interface::return_type::OK);
    return system.get_state("base/position.z");
}

std::string refusal(const HardwareInfo& info) {
    rclcpp::stub::log().clear();
    CHECK(started(info) == nullptr);
    return rclcpp::stub::log().empty() ? "" : rclcpp::stub::log().back();
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("a quadruped without torques falls and rests on the ground") {
    auto system = started(quadruped(0.0));
    REQUIRE(system);
    CHECK(system->get_state("base/position.z") == doctest::Approx(0.6));
    CHECK(system->get_state("base/orientation.w") == 1.0);
    double fallen = height_after(*system, 3.0);
    double later = height_after(*system, 0.5);
    // The centre of the trunk rests above the ground. Friction and contact hold the legs, so that the trunk
    // moves by less than 0.1 mm in half a second.
    CHECK(fallen > 0.0);
    CHECK(fallen < 0.5);
    CHECK(std::fabs(later - fallen) < 1e-4);
}

TEST_CASE("the height of the ground shifts the motion") {
    auto low = started(quadruped(0.0)), high = started(quadruped(0.25));
    REQUIRE(low);
    REQUIRE(high);
    // Sums with 0.25 round differently; impacts amplify that.
    double difference = height_after(*high, 0.4) - height_after(*low, 0.4);
    CHECK(difference == doctest::Approx(0.25).epsilon(1e-6));
}

TEST_CASE("efforts reach their joints, and periods accumulate") {
    std::vector<double> start(7, 0.0);
    start[3] = -1.0;
    HardwareInfo info = panda(start);
    std::reverse(info.joints.begin(), info.joints.end());
    auto system = started(info);
    REQUIRE(system);
    CHECK(system->get_state("panda_joint4/position") == -1.0);
    system->set_command("panda_joint1/effort", 5.0);
    system->set_command("panda_joint2/effort", std::nan(""));
    auto half = rclcpp::Duration::from_seconds(usual_period / 2);
    REQUIRE(system->write({}, half) == hardware_interface::return_type::OK);
    REQUIRE(system->read({}, half) == hardware_interface::return_type::OK);
    CHECK(system->get_state("panda_joint1/velocity") == 0.0);
    REQUIRE(system->write({}, half) == hardware_interface::return_type::OK);
    REQUIRE(system->read({}, half) == hardware_interface::return_type::OK);
    CHECK(system->get_state("panda_joint1/velocity") > 0.0);
    CHECK(system->get_state("panda_joint1/effort") == doctest::Approx(5.0));
    CHECK(system->get_state("panda_joint2/effort") == doctest::Approx(0.0));
}

TEST_CASE("the system refuses invalid parameters, interfaces and joints with the reason") {
    HardwareInfo info = panda(std::vector<double>(7, -0.1));
    info.hardware_parameters = {{"dt", "fast"}};
    CHECK(contains(refusal(info), "parameter \"dt\" is not a number: \"fast\""));
    info.hardware_parameters = {{"method", "magic"}};
    CHECK(contains(refusal(info), "rk4"));
    info.hardware_parameters = {{"dt", "-1"}};
    CHECK(contains(refusal(info), "ERROR panda: "));
    info.hardware_parameters.clear();
    info.joints[0].command_interfaces[0].name = "position";
    CHECK(contains(refusal(info), "\"panda_joint1/position\" is not supported; use effort"));
    info.joints[0] = {"wheel", {}, {}};
    CHECK(contains(refusal(info), "no joint \"wheel\""));
    info.joints.erase(info.joints.begin());
    info.sensors.push_back({"base", {}, {{"position.x", ""}}});
    CHECK(contains(refusal(info), "floating base"));
    info.original_xml.clear();
    CHECK(contains(refusal(info), "ERROR panda: "));
}

TEST_CASE("the descriptions of the plugins name the exported classes") {
    auto type = [](const char* file) {
        std::string text = text_of(std::string(PACKAGE) + file);
        std::size_t start = text.find(" type=\"") + 7;
        return text.substr(start, text.find('"', start) - start);
    };
    CHECK(pluginlib::stub::classes<ControllerInterface>().count(type("controller_plugins.xml")) == 1);
    CHECK(pluginlib::stub::classes<SystemInterface>().count(type("hardware_plugins.xml")) == 1);
}
