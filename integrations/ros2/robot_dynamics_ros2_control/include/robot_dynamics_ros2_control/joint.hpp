/// The joints of a robot by name.
#pragma once

#include <cstddef>
#include <string>

#include "robot_dynamics.hpp"

namespace robot_dynamics_ros2_control {

/// The indices of a joint's coordinate in q and in v.
struct JointIndices {
    std::size_t q, v;
};

/// The joint of this name. Throws `robot_dynamics::Error` if it is missing or has not exactly one coordinate.
inline JointIndices find_joint(const robot_dynamics::Robot& robot, const std::string& name) {
    std::size_t count = rd_model_joint_count(robot.model());
    for (std::size_t joint = 0; joint < count; ++joint) {
        if (name != rd_model_joint_name(robot.model(), joint)) {
            continue;
        }
        JointIndices indices{};
        std::size_t nq = 0, nv = 0;
        rd_status status = rd_model_joint_indices(robot.model(), joint, &indices.q, &nq, &indices.v, &nv);
        if (status != RD_STATUS_OK) {
            throw robot_dynamics::Error(status);
        }
        if (nq != 1 || nv != 1) {
            std::string text = "joint \"" + name + "\" has " + std::to_string(nv) + " coordinates";
            throw robot_dynamics::Error(RD_STATUS_UNSUPPORTED, text + "; joints with one are supported");
        }
        return indices;
    }
    throw robot_dynamics::Error(RD_STATUS_UNKNOWN_NAME, "the robot description has no joint \"" + name + "\"");
}

}  // namespace robot_dynamics_ros2_control
