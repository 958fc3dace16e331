// Stub for tests: rclcpp::Time, which the plugins do not read.
#pragma once

namespace rclcpp {

class Time {};

}  // namespace rclcpp
