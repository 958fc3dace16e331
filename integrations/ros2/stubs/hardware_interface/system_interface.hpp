// Stub for tests: the base class of hardware plugins. It keeps the handles, as the framework does.
#pragma once

#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "hardware_interface/handle.hpp"
#include "hardware_interface/types/hardware_component_interface_params.hpp"
#include "hardware_interface/types/hardware_interface_return_values.hpp"
#include "rclcpp/duration.hpp"
#include "rclcpp/logging.hpp"
#include "rclcpp/time.hpp"
#include "rclcpp_lifecycle/node_interfaces/lifecycle_node_interface.hpp"

namespace hardware_interface {

using CallbackReturn = rclcpp_lifecycle::node_interfaces::LifecycleNodeInterface::CallbackReturn;

class SystemInterface : public rclcpp_lifecycle::node_interfaces::LifecycleNodeInterface {
public:
    virtual CallbackReturn on_init(const HardwareComponentInterfaceParams& params) {
        info_ = params.hardware_info;
        return CallbackReturn::SUCCESS;
    }
    virtual return_type read(const rclcpp::Time& time, const rclcpp::Duration& period) = 0;
    virtual return_type write(const rclcpp::Time& time, const rclcpp::Duration& period) = 0;

    rclcpp::Logger get_logger() const { return rclcpp::Logger(info_.name); }

    void set_state(const std::string& name, double value) { states.at(name)->value = value; }
    double get_state(const std::string& name) const { return states.at(name)->value; }
    void set_command(const std::string& name, double value) { commands.at(name)->value = value; }
    double get_command(const std::string& name) const { return commands.at(name)->value; }

    /// What the framework does after on_init: it makes the handles that the URDF file states.
    void export_interfaces() {
        for (const auto* components : {&info_.joints, &info_.sensors}) {
            for (const ComponentInfo& component : *components) {
                for (const InterfaceInfo& state : component.state_interfaces) {
                    std::string name = component.name + "/" + state.name;
                    states[name] = std::make_shared<StateInterface>(name);
                }
                for (const InterfaceInfo& command : component.command_interfaces) {
                    std::string name = component.name + "/" + command.name;
                    commands[name] = std::make_shared<CommandInterface>(name);
                }
            }
        }
    }

    std::map<std::string, std::shared_ptr<StateInterface>> states;
    std::map<std::string, std::shared_ptr<CommandInterface>> commands;

protected:
    HardwareInfo info_;
};

}  // namespace hardware_interface
