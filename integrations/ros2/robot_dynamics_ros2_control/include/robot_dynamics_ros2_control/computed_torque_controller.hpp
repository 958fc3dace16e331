/// A controller of ros2_control: tau = M(a* + Kp (q* ⊖ q) + Kd (v* − v)) + C v + g.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "controller_interface/controller_interface.hpp"
#include "rclcpp/subscription.hpp"
#include "realtime_tools/realtime_buffer.hpp"
#include "robot_dynamics.hpp"
#include "robot_dynamics_ros2_control/joint.hpp"
#include "trajectory_msgs/msg/joint_trajectory_point.hpp"

namespace robot_dynamics_ros2_control {

/// Holds the joints where they are when it is activated, and follows the points of the topic `~/reference`.
class ComputedTorqueController : public controller_interface::ControllerInterface {
public:
    using CallbackReturn = controller_interface::CallbackReturn;
    using Point = trajectory_msgs::msg::JointTrajectoryPoint;

    CallbackReturn on_init() override;
    controller_interface::InterfaceConfiguration command_interface_configuration() const override;
    controller_interface::InterfaceConfiguration state_interface_configuration() const override;
    CallbackReturn on_configure(const rclcpp_lifecycle::State& previous) override;
    CallbackReturn on_activate(const rclcpp_lifecycle::State& previous) override;
    CallbackReturn on_deactivate(const rclcpp_lifecycle::State& previous) override;
    controller_interface::return_type update(const rclcpp::Time& time, const rclcpp::Duration& period) override;

private:
    /// A reference in the order of the robot's coordinates.
    struct Reference {
        robot_dynamics::Vector q, v, a;
        /// The activation during which it arrived; references of earlier ones do not count.
        std::uint64_t activation = 0;
    };

    void configure();
    void receive(const Point& point);
    void read_state();

    std::vector<std::string> names_;
    std::vector<JointIndices> joints_;
    std::optional<robot_dynamics::ComputedTorque> control_;
    /// The limits of the torques, in the order of the robot's coordinates [N m or N].
    robot_dynamics::Vector effort_limits_;
    /// The measured state and the torque.
    robot_dynamics::Vector q_, v_, torque_;
    /// The state at the activation, at rest.
    Reference hold_;
    std::atomic<std::uint64_t> activation_{0};
    realtime_tools::RealtimeBuffer<Reference> reference_;
    rclcpp::Subscription<Point>::SharedPtr subscription_;
};

}  // namespace robot_dynamics_ros2_control
