// Stub for tests: a register of the exported classes.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>

namespace pluginlib::stub {

/// The makers of the classes that a base class loads, by the name of the class.
template <class Base>
std::map<std::string, std::function<std::shared_ptr<Base>()>>& classes() {
    static std::map<std::string, std::function<std::shared_ptr<Base>()>> makers;
    return makers;
}

}  // namespace pluginlib::stub

#define PLUGINLIB_EXPORT_CLASS(Class, Base)                                                                   \
    [[maybe_unused]] static const bool is_exported =                                                          \
        ::pluginlib::stub::classes<Base>().emplace(#Class, [] { return std::make_shared<Class>(); }).second;
