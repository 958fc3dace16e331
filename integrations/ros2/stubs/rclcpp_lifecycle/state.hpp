// Stub for tests: rclcpp_lifecycle::State, which the plugins do not read.
#pragma once

namespace rclcpp_lifecycle {

class State {};

}  // namespace rclcpp_lifecycle
