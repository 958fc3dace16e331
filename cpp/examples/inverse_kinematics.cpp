// A configuration in which the hand is 10 cm lower than at the start.
#include <cmath>
#include <cstdio>

#include "robot_dynamics.hpp"

namespace rd = robot_dynamics;

int main(int argc, char** argv) try {
    rd::Robot robot = rd::Robot::load(argc > 1 ? argv[1] : "robots/panda.urdf");
    rd::Frame hand = robot.frame(argc > 2 ? argv[2] : "panda_link8");
    rd::Vector start = robot.random_configuration(2);
    rd::Pose target = robot.frame_pose(hand, start);
    target.numbers[11] -= 0.1;
    auto solution = robot.inverse_kinematics(hand, target, start);
    double height = robot.frame_pose(hand, solution.q).translation()[2];
    std::printf("height %.9f m, wanted %.9f m, after %zu steps\n", height, target.translation()[2],
                solution.report.iterations);
    return std::fabs(height - target.translation()[2]) < 1e-8 ? 0 : 1;
} catch (const rd::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
