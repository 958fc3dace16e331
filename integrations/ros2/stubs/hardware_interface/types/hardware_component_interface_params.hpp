// Stub for tests: the argument of on_init.
#pragma once

#include "hardware_interface/hardware_info.hpp"

namespace hardware_interface {

struct HardwareComponentInterfaceParams {
    HardwareInfo hardware_info;
};

}  // namespace hardware_interface
