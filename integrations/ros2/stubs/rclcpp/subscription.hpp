// Stub for tests: a subscription, whose messages a test delivers.
#pragma once

#include <functional>
#include <memory>
#include <string>

namespace rclcpp {

template <class Message>
class Subscription {
public:
    using SharedPtr = std::shared_ptr<Subscription>;
    using Callback = std::function<void(std::shared_ptr<const Message>)>;

    Subscription(std::string topic, Callback callback)
        : topic(std::move(topic)), callback(std::move(callback)) {}

    std::string topic;
    Callback callback;
};

}  // namespace rclcpp
