/// A simulated robot and, if wanted, its controller, as the controller manager runs them.
#pragma once

#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "controller_interface/controller_interface.hpp"
#include "hardware_interface/system_interface.hpp"
#include "pluginlib/class_list_macros.hpp"
#include "trajectory_msgs/msg/joint_trajectory_point.hpp"

using controller_interface::ControllerInterface;
using hardware_interface::HardwareInfo;
using hardware_interface::SystemInterface;
using Callback = rclcpp_lifecycle::node_interfaces::LifecycleNodeInterface::CallbackReturn;

/// The usual period of a loop [s].
constexpr double usual_period = 1e-3;

inline std::string text_of(const std::string& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// The text of a robot's file with an element of ros2_control, as robot descriptions have it.
inline std::string description(const std::string& file) {
    std::string text = text_of(ROBOTS + file);
    const char* element = "<ros2_control name=\"robot\" type=\"system\"><hardware>"
                          "<plugin>x</plugin></hardware></ros2_control>";
    return text.insert(text.rfind("</robot>"), element);
}

/// The seven joints of the Panda, with one start for each.
inline HardwareInfo panda(const std::vector<double>& start) {
    HardwareInfo info;
    info.name = "panda";
    info.type = "system";
    info.original_xml = description("panda.urdf");
    for (std::size_t k = 0; k < start.size(); ++k) {
        info.joints.push_back({"panda_joint" + std::to_string(k + 1),
                               {{"effort", ""}},
                               {{"position", std::to_string(start[k])}, {"velocity", ""}, {"effort", ""}}});
    }
    return info;
}

inline std::shared_ptr<SystemInterface> make_system() {
    return pluginlib::stub::classes<SystemInterface>().at("robot_dynamics_ros2_control::SimulatedSystem")();
}

inline std::shared_ptr<ControllerInterface> make_controller() {
    return pluginlib::stub::classes<ControllerInterface>().at(
        "robot_dynamics_ros2_control::ComputedTorqueController")();
}

/// A system after on_init and on_configure.
inline std::shared_ptr<SystemInterface> started(const HardwareInfo& info) {
    auto system = make_system();
    if (system->on_init({info}) != Callback::SUCCESS) {
        return nullptr;
    }
    system->export_interfaces();
    return system->on_configure({}) == Callback::SUCCESS ? system : nullptr;
}

/// A system and an active controller.
struct Loop {
    std::shared_ptr<SystemInterface> system;
    std::shared_ptr<ControllerInterface> controller = make_controller();

    explicit Loop(const HardwareInfo& info, const std::vector<std::string>& joints) : system(started(info)) {
        controller->init("computed_torque", info.original_xml);
        controller->get_node()->parameters["joints"] = joints;
    }
    bool start() {
        if (!system || controller->on_init() != Callback::SUCCESS ||
            controller->on_configure({}) != Callback::SUCCESS) {
            return false;
        }
        std::vector<hardware_interface::LoanedCommandInterface> commands;
        for (const std::string& name : controller->command_interface_configuration().names) {
            commands.emplace_back(system->commands.at(name));
        }
        std::vector<hardware_interface::LoanedStateInterface> states;
        for (const std::string& name : controller->state_interface_configuration().names) {
            states.emplace_back(system->states.at(name));
        }
        controller->assign_interfaces(std::move(commands), std::move(states));
        return controller->on_activate({}) == Callback::SUCCESS;
    }
    bool step(double period = usual_period) {
        auto duration = rclcpp::Duration::from_seconds(period);
        return system->read({}, duration) == hardware_interface::return_type::OK &&
               controller->update({}, duration) == controller_interface::return_type::OK &&
               system->write({}, duration) == hardware_interface::return_type::OK;
    }
    void publish(const trajectory_msgs::msg::JointTrajectoryPoint& point) {
        using Subscription = rclcpp::Subscription<trajectory_msgs::msg::JointTrajectoryPoint>;
        auto& topic = controller->get_node()->subscriptions.at("~/reference");
        std::any_cast<std::shared_ptr<Subscription>>(topic)->callback(
            std::make_shared<trajectory_msgs::msg::JointTrajectoryPoint>(point));
    }
};

/// The names of joints.
inline std::vector<std::string> joint_names(const HardwareInfo& info) {
    std::vector<std::string> names;
    for (const auto& joint : info.joints) {
        names.push_back(joint.name);
    }
    return names;
}
