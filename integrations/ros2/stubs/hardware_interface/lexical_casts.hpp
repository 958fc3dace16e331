// Stub for tests: numbers and truth values of parameters.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

namespace hardware_interface {

inline double stod(const std::string& text) {
    std::size_t end = 0;
    double number = std::stod(text, &end);
    if (end != text.size()) {
        throw std::invalid_argument("not a number: " + text);
    }
    return number;
}

inline bool parse_bool(const std::string& text) { return text == "true" || text == "True"; }

}  // namespace hardware_interface
