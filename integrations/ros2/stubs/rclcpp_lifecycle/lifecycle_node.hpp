// Stub for tests: a node with parameters and subscriptions.
#pragma once

#include <any>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "rclcpp/logging.hpp"
#include "rclcpp/qos.hpp"
#include "rclcpp/subscription.hpp"
#include "rclcpp_lifecycle/node_interfaces/lifecycle_node_interface.hpp"

namespace rclcpp {

class Parameter {
public:
    explicit Parameter(std::any value) : value_(std::move(value)) {}
    bool as_bool() const { return std::any_cast<bool>(value_); }
    std::vector<std::string> as_string_array() const { return std::any_cast<std::vector<std::string>>(value_); }
    std::vector<double> as_double_array() const { return std::any_cast<std::vector<double>>(value_); }

private:
    std::any value_;
};

}  // namespace rclcpp

namespace rclcpp_lifecycle {

class LifecycleNode {
public:
    explicit LifecycleNode(std::string name) : logger_(std::move(name)) {}

    rclcpp::Logger get_logger() const { return logger_; }
    rclcpp::Parameter get_parameter(const std::string& name) const {
        return rclcpp::Parameter(parameters.at(name));
    }

    template <class Message, class Callback>
    std::shared_ptr<rclcpp::Subscription<Message>> create_subscription(const std::string& topic,
                                                                       const rclcpp::QoS&, Callback&& callback) {
        static_assert(std::is_convertible_v<Callback, typename rclcpp::Subscription<Message>::Callback>);
        auto made = std::make_shared<rclcpp::Subscription<Message>>(topic, std::forward<Callback>(callback));
        subscriptions[topic] = made;
        return made;
    }

    std::map<std::string, std::any> parameters;
    std::map<std::string, std::any> subscriptions;

private:
    rclcpp::Logger logger_;
};

}  // namespace rclcpp_lifecycle
