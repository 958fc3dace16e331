// Stub for tests: the part of rclcpp's logging that the plugins use.
#pragma once

#include <cstdio>
#include <string>
#include <vector>

namespace rclcpp {

class Logger {
public:
    explicit Logger(std::string name) : name_(std::move(name)) {}
    const char* get_name() const { return name_.c_str(); }

private:
    std::string name_;
};

inline Logger get_logger(const std::string& name) { return Logger(name); }

namespace stub {

/// The lines of the log, for the assertions of tests.
inline std::vector<std::string>& log() {
    static std::vector<std::string> lines;
    return lines;
}

template <class... Arguments>
void write(const char* level, const Logger& logger, const char* format, Arguments... arguments) {
    char text[4096];
    std::snprintf(text, sizeof text, format, arguments...);
    log().push_back(std::string(level) + " " + logger.get_name() + ": " + text);
}

}  // namespace stub
}  // namespace rclcpp

#define RCLCPP_INFO(logger, ...) ::rclcpp::stub::write("INFO", logger, __VA_ARGS__)
#define RCLCPP_WARN(logger, ...) ::rclcpp::stub::write("WARN", logger, __VA_ARGS__)
#define RCLCPP_ERROR(logger, ...) ::rclcpp::stub::write("ERROR", logger, __VA_ARGS__)
