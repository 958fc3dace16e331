// The program for MuJoCo: its C API, contacts off, the shortest chain of calls for each quantity.
// The linear part of a free joint's velocity is in world axes here; run.py converts.
#include <mujoco/mujoco.h>

#include <cstring>

#include "side.hpp"

int main(int argc, char** argv) {
  if (argc != 6) side::fail("usage: mujoco_side ROBOT STATES ALGORITHM (time MS | calls N | write FILE)");
  char error[1000] = "";
  mjModel* m = mj_loadXML(argv[1], nullptr, error, sizeof error);
  if (m == nullptr) side::fail(error);
  mjData* d = mj_makeData(m);
  const side::States states = side::read_states(argv[2]);
  const std::string algorithm = argv[3];
  const auto nq = static_cast<std::size_t>(m->nq), nv = static_cast<std::size_t>(m->nv);
  if (states.nq != nq || states.nv != nv) side::fail("states of another robot");
  const int tip = static_cast<int>(states.tip) + (nq != nv ? 2 : 1);

  std::vector<double> result(nv), matrix(6 * nv), full(nv * nv);
  auto set_q = [&](std::size_t i) { std::memcpy(d->qpos, states.q(i), nq * sizeof(double)); };
  auto set_v = [&](std::size_t i) { std::memcpy(d->qvel, states.v(i), nv * sizeof(double)); };
  auto append = [](std::vector<double>& out, const double* from, std::size_t count) {
    out.insert(out.end(), from, from + count);
  };
  auto run = [&](auto call, auto read) { side::run(states, argv + 4, call, read); };

  if (algorithm == "inverse_dynamics") {
    run(
        [&](std::size_t i) {
          set_q(i);
          set_v(i);
          std::memcpy(d->qacc, states.a(i), nv * sizeof(double));
          mj_kinematics(m, d);
          mj_comPos(m, d);
          mj_comVel(m, d);
          mj_rne(m, d, 1, result.data());
        },
        [&](std::size_t, std::vector<double>& out) { append(out, result.data(), nv); });
  } else if (algorithm == "forward_dynamics") {
    run(
        [&](std::size_t i) {
          set_q(i);
          set_v(i);
          mj_kinematics(m, d);
          mj_comPos(m, d);
          mj_makeM(m, d);
          mj_factorM(m, d);
          mj_comVel(m, d);
          mj_rne(m, d, 0, result.data());
          const double* tau = states.tau(i);
          for (std::size_t k = 0; k < nv; ++k) result[k] = tau[k] - result[k];
          mj_solveM(m, d, d->qacc, result.data(), 1);
        },
        [&](std::size_t, std::vector<double>& out) { append(out, d->qacc, nv); });
  } else if (algorithm == "mass_matrix") {
    run(
        [&](std::size_t i) {
          set_q(i);
          mj_kinematics(m, d);
          mj_comPos(m, d);
          mj_makeM(m, d);
        },
        [&](std::size_t, std::vector<double>& out) {
          mj_fullM(m, d, full.data());
          append(out, full.data(), nv * nv);
        });
  } else if (algorithm == "frame_poses") {
    run(
        [&](std::size_t i) {
          set_q(i);
          mj_kinematics(m, d);
        },
        [&](std::size_t, std::vector<double>& out) {
          for (int body = 1; body < m->nbody; ++body) {
            append(out, d->xmat + 9 * body, 9);
            append(out, d->xpos + 3 * body, 3);
          }
        });
  } else if (algorithm == "jacobian") {
    run(
        [&](std::size_t i) {
          set_q(i);
          mj_kinematics(m, d);
          mj_comPos(m, d);
          mj_jacBody(m, d, matrix.data(), matrix.data() + 3 * nv, tip);
        },
        [&](std::size_t, std::vector<double>& out) { append(out, matrix.data(), 6 * nv); });
  } else {
    side::fail("no algorithm " + algorithm);
  }
  mj_deleteData(d);
  mj_deleteModel(m);
}
