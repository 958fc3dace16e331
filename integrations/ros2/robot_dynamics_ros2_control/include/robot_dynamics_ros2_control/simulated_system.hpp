/// A hardware plugin of ros2_control that simulates the robot description.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "hardware_interface/system_interface.hpp"
#include "robot_dynamics.hpp"
#include "robot_dynamics_ros2_control/joint.hpp"

namespace robot_dynamics_ros2_control {

/// Takes efforts, simulates contact, limits and friction, and gives positions, velocities and efforts.
class SimulatedSystem : public hardware_interface::SystemInterface {
public:
    using CallbackReturn = hardware_interface::CallbackReturn;
    using return_type = hardware_interface::return_type;

    CallbackReturn on_init(const hardware_interface::HardwareComponentInterfaceParams& params) override;
    CallbackReturn on_configure(const rclcpp_lifecycle::State& previous) override;
    return_type read(const rclcpp::Time& time, const rclcpp::Duration& period) override;
    return_type write(const rclcpp::Time& time, const rclcpp::Duration& period) override;

private:
    /// An interface and the number that it shows: an index in q, v or the torques.
    struct Shown {
        std::string name;
        std::size_t index;
    };

    void load();
    void add_joint(const robot_dynamics::Robot& robot, const hardware_interface::ComponentInfo& joint);
    void add_base_sensor(const hardware_interface::ComponentInfo& sensor);
    void show_state();
    const std::string* parameter(const char* name) const;
    double number(const char* name, double otherwise) const;

    std::optional<robot_dynamics::Simulation> simulation_;
    double dt_ = 1e-3;
    /// The time that is not simulated yet, less than a step [s].
    double remaining_ = 0.0;
    bool floating_base_ = false;
    robot_dynamics::Vector start_, q_, v_, commands_, torques_;
    std::vector<Shown> positions_, velocities_, efforts_, effort_commands_;
};

}  // namespace robot_dynamics_ros2_control
