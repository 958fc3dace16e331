// The program for this project's C++ layer: states, timing and output as in `side.hpp`.
#include "robot_dynamics.hpp"

#include "side.hpp"

namespace rd = robot_dynamics;

int main(int argc, char** argv) {
  if (argc != 6) side::fail("usage: robot_dynamics_side ROBOT STATES ALGORITHM (time MS | calls N | write FILE)");
  const side::States states = side::read_states(argv[2]);
  rd::LoadOptions options;
  options.floating_base = states.nq != states.nv;
  rd::Robot robot = rd::Robot::load(argv[1], options);
  const std::string algorithm = argv[3];
  const std::size_t nq = robot.nq(), nv = robot.nv();
  if (states.nq != nq || states.nv != nv) side::fail("states of another robot");
  // The joint of state coordinate i is named j and i, after the floating base.
  const std::vector<std::string> names = robot.coordinate_names();
  for (std::size_t i = options.floating_base ? 6 : 0, k = 0; i < nv; ++i, ++k) {
    if (names[i] != "j" + std::to_string(k)) side::fail("the coordinates have another order: " + names[i]);
  }
  const rd::Frame tip = robot.frame("l" + std::to_string(states.tip));

  rd::Vector vector(nv), one(nv * nv), two(nv * nv), three(nv * nv), jacobian(6 * nv);
  auto view_q = [&](std::size_t i) { return rd::View(states.q(i), nq); };
  auto view = [&](const double* x) { return rd::View(x, nv); };
  auto append = [](std::vector<double>& out, const rd::Vector& x) { out.insert(out.end(), x.begin(), x.end()); };
  auto run = [&](auto call, auto result) { side::run(states, argv + 4, call, result); };

  if (algorithm == "inverse_dynamics") {
    run([&](std::size_t i) { robot.inverse_dynamics(view_q(i), view(states.v(i)), view(states.a(i)), vector); },
        [&](std::size_t, std::vector<double>& out) { append(out, vector); });
  } else if (algorithm == "forward_dynamics") {
    run([&](std::size_t i) { robot.forward_dynamics(view_q(i), view(states.v(i)), view(states.tau(i)), vector); },
        [&](std::size_t, std::vector<double>& out) { append(out, vector); });
  } else if (algorithm == "mass_matrix") {
    run([&](std::size_t i) { robot.mass_matrix(view_q(i), one); },
        [&](std::size_t, std::vector<double>& out) { append(out, one); });
  } else if (algorithm == "coriolis_matrix") {
    run([&](std::size_t i) { robot.coriolis_matrix(view_q(i), view(states.v(i)), one); },
        [&](std::size_t, std::vector<double>& out) { append(out, one); });
  } else if (algorithm == "jacobian") {
    run([&](std::size_t i) { robot.frame_jacobian(tip, view_q(i), jacobian); },
        [&](std::size_t, std::vector<double>& out) { append(out, jacobian); });
  } else if (algorithm == "jacobian_in_frame") {
    run([&](std::size_t i) { robot.frame_jacobian(tip, view_q(i), jacobian, rd::ReferenceFrame::Local); },
        [&](std::size_t, std::vector<double>& out) { append(out, jacobian); });
  } else if (algorithm == "inverse_dynamics_derivatives") {
    run([&](std::size_t i) {
          robot.inverse_dynamics_derivatives(view_q(i), view(states.v(i)), view(states.a(i)), one, two);
        },
        [&](std::size_t, std::vector<double>& out) { append(out, one), append(out, two); });
  } else if (algorithm == "forward_dynamics_derivatives") {
    run([&](std::size_t i) {
          robot.forward_dynamics_derivatives(view_q(i), view(states.v(i)), view(states.tau(i)), one, two, three);
        },
        [&](std::size_t, std::vector<double>& out) { append(out, one), append(out, two); });
  } else {
    side::fail("no algorithm " + algorithm);
  }
}
