#include "robot_dynamics_ros2_control/simulated_system.hpp"

#include <algorithm>
#include <cmath>
#include <exception>

#include "hardware_interface/lexical_casts.hpp"
#include "hardware_interface/types/hardware_interface_type_values.hpp"
#include "pluginlib/class_list_macros.hpp"
#include "rclcpp/logging.hpp"

namespace robot_dynamics_ros2_control {

namespace rd = robot_dynamics;
using hardware_interface::HW_IF_EFFORT;
using hardware_interface::HW_IF_POSITION;
using hardware_interface::HW_IF_VELOCITY;
using hardware_interface::return_type;

namespace {

/// The longest period that is simulated, so that a pause of the process does not cause a longer one [s].
constexpr double longest_period = 0.1;

/// The pose of a floating base, in the order of its coordinates in q.
constexpr const char* base_interfaces[] = {"position.x",    "position.y",    "position.z",   "orientation.x",
                                           "orientation.y", "orientation.z", "orientation.w"};

[[noreturn]] void refuse(const std::string& component, const std::string& interface, const char* known) {
    throw rd::Error(RD_STATUS_UNSUPPORTED,
                    "interface \"" + component + "/" + interface + "\" is not supported; use " + known);
}

}  // namespace

SimulatedSystem::CallbackReturn SimulatedSystem::on_init(
    const hardware_interface::HardwareComponentInterfaceParams& params) {
    if (SystemInterface::on_init(params) != CallbackReturn::SUCCESS) {
        return CallbackReturn::ERROR;
    }
    try {
        load();
    } catch (const std::exception& error) {
        RCLCPP_ERROR(get_logger(), "%s", error.what());
        return CallbackReturn::ERROR;
    }
    RCLCPP_INFO(get_logger(), "simulation by \"%s\": %s", simulation_->method().c_str(),
                simulation_->reason().c_str());
    return CallbackReturn::SUCCESS;
}

const std::string* SimulatedSystem::parameter(const char* name) const {
    auto found = info_.hardware_parameters.find(name);
    return found == info_.hardware_parameters.end() ? nullptr : &found->second;
}

double SimulatedSystem::number(const char* name, double otherwise) const {
    const std::string* text = parameter(name);
    try {
        return text ? hardware_interface::stod(*text) : otherwise;
    } catch (const std::exception&) {
        throw rd::Error(RD_STATUS_INVALID_INPUT,
                        std::string("parameter \"") + name + "\" is not a number: \"" + *text + "\"");
    }
}

void SimulatedSystem::load() {
    rd::LoadOptions loading;
    floating_base_ = parameter("floating_base") && hardware_interface::parse_bool(*parameter("floating_base"));
    loading.floating_base = floating_base_;
    rd::Robot robot = rd::Robot::load_text(info_.original_xml, loading);

    rd::SimulationOptions options;
    dt_ = options.dt = number("dt", 1e-3);
    options.method = parameter("method") ? *parameter("method") : "";
    if (parameter("ground_height")) {
        options.ground = rd::Ground{};
        options.ground->height = number("ground_height", 0.0);
        if (parameter("ground_friction")) {
            options.ground->friction = number("ground_friction", 0.0);
        }
    }
    simulation_ = rd::Simulation::make(robot, options);

    start_ = q_ = robot.neutral();
    if (floating_base_) {
        start_[2] = number("base_height", 0.0);
    }
    commands_.assign(robot.nv(), 0.0);
    v_ = torques_ = commands_;
    positions_.clear();
    velocities_.clear();
    efforts_.clear();
    effort_commands_.clear();
    for (const auto& joint : info_.joints) {
        add_joint(robot, joint);
    }
    for (const auto& sensor : info_.sensors) {
        add_base_sensor(sensor);
    }
}

void SimulatedSystem::add_joint(const rd::Robot& robot, const hardware_interface::ComponentInfo& joint) {
    JointIndices indices = find_joint(robot, joint.name);
    for (const auto& command : joint.command_interfaces) {
        if (command.name != HW_IF_EFFORT) {
            refuse(joint.name, command.name, "effort");
        }
        effort_commands_.push_back({joint.name + "/" + command.name, indices.v});
    }
    for (const auto& state : joint.state_interfaces) {
        std::string name = joint.name + "/" + state.name;
        if (state.name == HW_IF_POSITION) {
            positions_.push_back({name, indices.q});
            if (!state.initial_value.empty()) {
                start_[indices.q] = hardware_interface::stod(state.initial_value);
            }
        } else if (state.name == HW_IF_VELOCITY) {
            velocities_.push_back({name, indices.v});
        } else if (state.name == HW_IF_EFFORT) {
            efforts_.push_back({name, indices.v});
        } else {
            refuse(joint.name, state.name, "position, velocity or effort");
        }
    }
}

/// A sensor of the floating base's pose.
void SimulatedSystem::add_base_sensor(const hardware_interface::ComponentInfo& sensor) {
    for (const auto& state : sensor.state_interfaces) {
        auto found = std::find(std::begin(base_interfaces), std::end(base_interfaces), state.name);
        if (!floating_base_ || found == std::end(base_interfaces)) {
            refuse(sensor.name, state.name, "position.x to orientation.w, with a floating base");
        }
        positions_.push_back({sensor.name + "/" + state.name, static_cast<std::size_t>(found - base_interfaces)});
    }
}

SimulatedSystem::CallbackReturn SimulatedSystem::on_configure(const rclcpp_lifecycle::State&) {
    std::fill(commands_.begin(), commands_.end(), 0.0);
    rd::Vector rest(v_.size(), 0.0);
    remaining_ = 0.0;
    try {
        // The first step compiles machine code, so it is taken before the loop.
        simulation_->reset(start_, rest);
        simulation_->set_torques(commands_);
        simulation_->step();
        simulation_->reset(start_, rest);
        show_state();
    } catch (const std::exception& error) {
        RCLCPP_ERROR(get_logger(), "%s", error.what());
        return CallbackReturn::ERROR;
    }
    for (const Shown& command : effort_commands_) {
        set_command(command.name, 0.0);
    }
    return CallbackReturn::SUCCESS;
}

void SimulatedSystem::show_state() {
    simulation_->q(q_);
    simulation_->v(v_);
    rd_status status = rd_simulation_applied_torques(simulation_->handle(), torques_.data(), torques_.size());
    if (status != RD_STATUS_OK) {
        throw rd::Error(status);
    }
    auto show = [this](const std::vector<Shown>& interfaces, const rd::Vector& numbers) {
        for (const Shown& shown : interfaces) {
            set_state(shown.name, numbers[shown.index]);
        }
    };
    show(positions_, q_);
    show(velocities_, v_);
    show(efforts_, torques_);
}

return_type SimulatedSystem::read(const rclcpp::Time&, const rclcpp::Duration&) {
    try {
        show_state();
    } catch (const std::exception& error) {
        RCLCPP_ERROR(get_logger(), "%s", error.what());
        return return_type::ERROR;
    }
    return return_type::OK;
}

return_type SimulatedSystem::write(const rclcpp::Time&, const rclcpp::Duration& period) {
    try {
        for (const Shown& command : effort_commands_) {
            // Without a controller a command is NaN.
            double effort = get_command(command.name);
            commands_[command.index] = std::isfinite(effort) ? effort : 0.0;
        }
        simulation_->set_torques(commands_);
        remaining_ += std::clamp(period.seconds(), 0.0, longest_period);
        // A period of n steps is often less than n dt by rounding.
        double steps = std::floor(remaining_ / dt_ + 1e-6);
        if (steps > 0.0) {
            simulation_->step(static_cast<std::size_t>(steps));
            remaining_ -= steps * dt_;
        }
    } catch (const std::exception& error) {
        RCLCPP_ERROR(get_logger(), "%s", error.what());
        return return_type::ERROR;
    }
    return return_type::OK;
}

}  // namespace robot_dynamics_ros2_control

PLUGINLIB_EXPORT_CLASS(robot_dynamics_ros2_control::SimulatedSystem, hardware_interface::SystemInterface)
