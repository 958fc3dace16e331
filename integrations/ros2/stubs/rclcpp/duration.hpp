// Stub for tests: rclcpp::Duration.
#pragma once

#include <cstdint>

namespace rclcpp {

class Duration {
public:
    Duration(std::int32_t seconds, std::uint32_t nanoseconds) : seconds_(seconds + 1e-9 * nanoseconds) {}
    static Duration from_seconds(double seconds) {
        Duration duration(0, 0);
        duration.seconds_ = seconds;
        return duration;
    }
    double seconds() const { return seconds_; }

private:
    double seconds_;
};

}  // namespace rclcpp
