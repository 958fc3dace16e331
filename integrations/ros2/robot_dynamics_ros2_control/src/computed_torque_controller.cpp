#include "robot_dynamics_ros2_control/computed_torque_controller.hpp"

#include <algorithm>
#include <cmath>
#include <exception>

#include "hardware_interface/types/hardware_interface_type_values.hpp"
#include "pluginlib/class_list_macros.hpp"
#include "rclcpp/logging.hpp"
#include "rclcpp/qos.hpp"

namespace robot_dynamics_ros2_control {

namespace rd = robot_dynamics;
using controller_interface::InterfaceConfiguration;
using controller_interface::return_type;

namespace {

constexpr auto individual = controller_interface::interface_configuration_type::INDIVIDUAL;

/// One gain for each joint: those of a parameter with as many numbers, or its only number.
rd::Vector gains(const char* name, const std::vector<double>& values, const std::vector<JointIndices>& joints) {
    if (values.size() != joints.size() && values.size() != 1) {
        throw rd::Error(RD_STATUS_INVALID_INPUT,
                        std::string("parameter \"") + name + "\" has " + std::to_string(values.size()) +
                            " numbers; give 1 or one for each of the " + std::to_string(joints.size()) +
                            " joints");
    }
    for (double value : values) {
        if (!std::isfinite(value) || value < 0.0) {
            throw rd::Error(RD_STATUS_INVALID_INPUT, std::string("parameter \"") + name +
                                                         "\" has a number that is negative or not finite: " +
                                                         std::to_string(value));
        }
    }
    rd::Vector sorted(joints.size());
    for (std::size_t k = 0; k < joints.size(); ++k) {
        sorted[joints[k].v] = values[values.size() == 1 ? 0 : k];
    }
    return sorted;
}

bool fits(const std::vector<double>& values, std::size_t count) {
    auto is_finite = [](double value) { return std::isfinite(value); };
    return values.size() == count && std::all_of(values.begin(), values.end(), is_finite);
}

}  // namespace

controller_interface::CallbackReturn ComputedTorqueController::on_init() {
    auto_declare<std::vector<std::string>>("joints", {});
    auto_declare<std::vector<double>>("stiffness", {100.0});
    auto_declare<std::vector<double>>("damping", {20.0});
    auto_declare<bool>("compensate_dissipation", false);
    return CallbackReturn::SUCCESS;
}

InterfaceConfiguration ComputedTorqueController::command_interface_configuration() const {
    InterfaceConfiguration configuration{individual, {}};
    for (const std::string& name : names_) {
        configuration.names.push_back(name + "/" + hardware_interface::HW_IF_EFFORT);
    }
    return configuration;
}

InterfaceConfiguration ComputedTorqueController::state_interface_configuration() const {
    InterfaceConfiguration configuration{individual, {}};
    for (const std::string& name : names_) {
        configuration.names.push_back(name + "/" + hardware_interface::HW_IF_POSITION);
        configuration.names.push_back(name + "/" + hardware_interface::HW_IF_VELOCITY);
    }
    return configuration;
}

controller_interface::CallbackReturn ComputedTorqueController::on_configure(const rclcpp_lifecycle::State&) {
    subscription_.reset();
    try {
        configure();
    } catch (const std::exception& error) {
        RCLCPP_ERROR(get_node()->get_logger(), "%s", error.what());
        return CallbackReturn::ERROR;
    }
    subscription_ = get_node()->create_subscription<Point>(
        "~/reference", rclcpp::SystemDefaultsQoS(), [this](const Point::ConstSharedPtr point) { receive(*point); });
    return CallbackReturn::SUCCESS;
}

void ComputedTorqueController::configure() {
    rd::Robot robot = rd::Robot::load_text(get_robot_description());
    names_ = get_node()->get_parameter("joints").as_string_array();
    joints_.clear();
    std::vector<bool> is_listed(robot.nv(), false);
    for (const std::string& name : names_) {
        joints_.push_back(find_joint(robot, name));
        if (is_listed[joints_.back().v]) {
            throw rd::Error(RD_STATUS_INVALID_INPUT, "parameter \"joints\" has \"" + name + "\" twice");
        }
        is_listed[joints_.back().v] = true;
    }
    for (std::size_t k = 0; k < robot.nv(); ++k) {
        if (!is_listed[k]) {
            throw rd::Error(RD_STATUS_INVALID_INPUT, "parameter \"joints\" must list every joint of the robot; \"" +
                                                         robot.coordinate_names()[k] + "\" is missing");
        }
    }
    rd::Vector stiffness = gains("stiffness", get_node()->get_parameter("stiffness").as_double_array(), joints_);
    rd::Vector damping = gains("damping", get_node()->get_parameter("damping").as_double_array(), joints_);
    bool dissipation = get_node()->get_parameter("compensate_dissipation").as_bool();
    control_ = rd::ComputedTorque::make(robot, stiffness, damping, dissipation);
    effort_limits_ = robot.effort_limits();
    q_ = robot.neutral();
    v_.assign(robot.nv(), 0.0);
    torque_ = v_;
    hold_.q = q_;
    hold_.v = hold_.a = v_;
    // The first call compiles machine code, so it is made before the loop.
    control_->set_reference(hold_.q, hold_.v, hold_.a);
    control_->torque(q_, v_, torque_);
}

controller_interface::CallbackReturn ComputedTorqueController::on_activate(const rclcpp_lifecycle::State&) {
    if (command_interfaces_.size() != joints_.size() || state_interfaces_.size() != 2 * joints_.size()) {
        RCLCPP_ERROR(get_node()->get_logger(), "effort, position or velocity interfaces of joints are missing");
        return CallbackReturn::ERROR;
    }
    read_state();
    hold_.q = q_;
    ++activation_;
    return CallbackReturn::SUCCESS;
}

controller_interface::CallbackReturn ComputedTorqueController::on_deactivate(const rclcpp_lifecycle::State&) {
    for (auto& command : command_interfaces_) {
        static_cast<void>(command.set_value(0.0));
    }
    return CallbackReturn::SUCCESS;
}

/// Enters a message of the topic, on the thread of the subscription.
void ComputedTorqueController::receive(const Point& point) {
    std::size_t count = joints_.size();
    bool has_velocity = !point.velocities.empty(), has_acceleration = !point.accelerations.empty();
    if (!fits(point.positions, count) || (has_velocity && !fits(point.velocities, count)) ||
        (has_acceleration && !fits(point.accelerations, count))) {
        RCLCPP_WARN(get_node()->get_logger(),
                    "reference ignored: it needs %zu finite positions, and as many velocities and accelerations "
                    "or none",
                    count);
        return;
    }
    Reference reference{rd::Vector(count), rd::Vector(count), rd::Vector(count), activation_};
    for (std::size_t k = 0; k < count; ++k) {
        reference.q[joints_[k].q] = point.positions[k];
        reference.v[joints_[k].v] = has_velocity ? point.velocities[k] : 0.0;
        reference.a[joints_[k].v] = has_acceleration ? point.accelerations[k] : 0.0;
    }
    reference_.writeFromNonRT(reference);
}

/// Reads the state interfaces. A value that another thread holds at this moment remains the last one.
void ComputedTorqueController::read_state() {
    for (std::size_t k = 0; k < joints_.size(); ++k) {
        q_[joints_[k].q] = state_interfaces_[2 * k].get_optional().value_or(q_[joints_[k].q]);
        v_[joints_[k].v] = state_interfaces_[2 * k + 1].get_optional().value_or(v_[joints_[k].v]);
    }
}

return_type ComputedTorqueController::update(const rclcpp::Time&, const rclcpp::Duration&) {
    read_state();
    const Reference* latest = reference_.readFromRT();
    const Reference& reference = latest->activation == activation_ ? *latest : hold_;
    try {
        control_->set_reference(reference.q, reference.v, reference.a);
        control_->torque(q_, v_, torque_);
    } catch (const rd::Error& error) {
        RCLCPP_ERROR(get_node()->get_logger(), "%s", error.what());
        return return_type::ERROR;
    }
    for (std::size_t k = 0; k < joints_.size(); ++k) {
        double limit = effort_limits_[joints_[k].v];
        // The base class counts failed writes, and the last value remains.
        static_cast<void>(command_interfaces_[k].set_value(std::clamp(torque_[joints_[k].v], -limit, limit)));
    }
    return return_type::OK;
}

}  // namespace robot_dynamics_ros2_control

PLUGINLIB_EXPORT_CLASS(robot_dynamics_ros2_control::ComputedTorqueController,
                       controller_interface::ControllerInterface)
