// The torques that hold a robot still.
#include <cstdio>

#include "robot_dynamics.hpp"

namespace rd = robot_dynamics;

int main(int argc, char** argv) try {
    rd::Robot robot = rd::Robot::load(argc > 1 ? argv[1] : "robots/panda.urdf");
    rd::Vector tau = robot.gravity_forces(robot.neutral());
    std::vector<std::string> names = robot.coordinate_names();
    for (std::size_t i = 0; i < tau.size(); ++i) {
        std::printf("%-24s %10.4f\n", names[i].c_str(), tau[i]);
    }
} catch (const rd::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
