// Stub for tests: rclcpp's qualities of service.
#pragma once

namespace rclcpp {

class QoS {};
class SystemDefaultsQoS : public QoS {};

}  // namespace rclcpp
