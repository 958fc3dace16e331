// Stub for tests: interfaces, and loans of them to a controller.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>

namespace hardware_interface {

class Handle {
public:
    explicit Handle(std::string name) : name(std::move(name)) {}

    std::string name;
    double value = std::numeric_limits<double>::quiet_NaN();
};

class StateInterface : public Handle {
public:
    using Handle::Handle;
    using ConstSharedPtr = std::shared_ptr<const StateInterface>;
};

class CommandInterface : public Handle {
public:
    using Handle::Handle;
    using SharedPtr = std::shared_ptr<CommandInterface>;
};

class LoanedStateInterface {
public:
    explicit LoanedStateInterface(StateInterface::ConstSharedPtr handle) : handle_(std::move(handle)) {}

    const std::string& get_name() const { return handle_->name; }
    template <class T = double>
    [[nodiscard]] std::optional<T> get_optional(unsigned = 10) const {
        return handle_->value;
    }

private:
    StateInterface::ConstSharedPtr handle_;
};

class LoanedCommandInterface {
public:
    explicit LoanedCommandInterface(CommandInterface::SharedPtr handle) : handle_(std::move(handle)) {}

    const std::string& get_name() const { return handle_->name; }
    template <class T>
    [[nodiscard]] bool set_value(const T& value, unsigned = 10) {
        handle_->value = value;
        return true;
    }

private:
    CommandInterface::SharedPtr handle_;
};

}  // namespace hardware_interface
