// Stub for tests: a ros2_control element of a URDF file.
#pragma once

#include <string>
#include <unordered_map>
#include <vector>

namespace hardware_interface {

struct InterfaceInfo {
    std::string name;
    std::string initial_value;
};

struct ComponentInfo {
    std::string name;
    std::vector<InterfaceInfo> command_interfaces;
    std::vector<InterfaceInfo> state_interfaces;
};

struct HardwareInfo {
    std::string name;
    std::string type;
    std::unordered_map<std::string, std::string> hardware_parameters;
    std::vector<ComponentInfo> joints;
    std::vector<ComponentInfo> sensors;
    std::string original_xml;
};

}  // namespace hardware_interface
