// The program for Pinocchio, built twice: with the shipped library, and header-only for this machine.
// Inputs are plain VectorXd and results stay in Data, as in users' programs.
#include <pinocchio/algorithm/aba-derivatives.hpp>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/algorithm/rnea-derivatives.hpp>
#include <pinocchio/algorithm/rnea.hpp>

#include "pinocchio_robot.hpp"

namespace pin = pinocchio;
using Eigen::MatrixXd;
using Eigen::VectorXd;

void append(std::vector<double>& out, const MatrixXd& matrix) {
  for (Eigen::Index i = 0; i < matrix.rows(); ++i)
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) out.push_back(matrix(i, j));
}

int main(int argc, char** argv) {
  if (argc != 6) side::fail("usage: pinocchio_side ROBOT STATES ALGORITHM (time MS | calls N | write FILE)");
  const pin::Model model = peer::read_robot(argv[1]);
  pin::Data data(model);
  const side::States states = side::read_states(argv[2]);
  const std::string algorithm = argv[3];
  if (states.nq != static_cast<std::size_t>(model.nq) || states.nv != static_cast<std::size_t>(model.nv))
    side::fail("states of another robot");

  std::vector<VectorXd> q, v, a, tau;
  for (std::size_t i = 0; i < states.count; ++i) {
    q.emplace_back(Eigen::Map<const VectorXd>(states.q(i), model.nq));
    v.emplace_back(Eigen::Map<const VectorXd>(states.v(i), model.nv));
    a.emplace_back(Eigen::Map<const VectorXd>(states.a(i), model.nv));
    tau.emplace_back(Eigen::Map<const VectorXd>(states.tau(i), model.nv));
  }
  const pin::JointIndex tip = states.tip + (model.nq != model.nv ? 2 : 1);
  pin::Data::Matrix6x jacobian = pin::Data::Matrix6x::Zero(6, model.nv);

  auto run = [&](auto call, auto result) {
    side::run(states, argv + 4, call, result);
  };
  auto forward = [&](pin::Convention convention) {
    run([&](std::size_t i) { pin::aba(model, data, q[i], v[i], tau[i], convention); },
        [&](std::size_t, std::vector<double>& out) { append(out, data.ddq); });
  };
  auto mass = [&](pin::Convention convention) {
    run([&](std::size_t i) { pin::crba(model, data, q[i], convention); },
        [&](std::size_t, std::vector<double>& out) { append(out, data.M.selfadjointView<Eigen::Upper>()); });
  };

  if (algorithm == "inverse_dynamics") {
    run([&](std::size_t i) { pin::rnea(model, data, q[i], v[i], a[i]); },
        [&](std::size_t, std::vector<double>& out) { append(out, data.tau); });
  } else if (algorithm == "forward_dynamics") {
    forward(pin::Convention::LOCAL);
  } else if (algorithm == "forward_dynamics@world") {
    forward(pin::Convention::WORLD);
  } else if (algorithm == "mass_matrix") {
    mass(pin::Convention::LOCAL);
  } else if (algorithm == "mass_matrix@world") {
    mass(pin::Convention::WORLD);
  } else if (algorithm == "coriolis_matrix") {
    run([&](std::size_t i) { pin::computeCoriolisMatrix(model, data, q[i], v[i]); },
        [&](std::size_t, std::vector<double>& out) { append(out, data.C); });
  } else if (algorithm == "frame_poses") {
    run([&](std::size_t i) { pin::forwardKinematics(model, data, q[i]); },
        [&](std::size_t, std::vector<double>& out) {
          for (pin::JointIndex j = 1; j < static_cast<pin::JointIndex>(model.njoints); ++j) {
            append(out, data.oMi[j].rotation());
            append(out, data.oMi[j].translation());
          }
        });
  } else if (algorithm == "jacobian") {
    run(
        [&](std::size_t i) {
          pin::computeJointJacobians(model, data, q[i]);
          jacobian.setZero();
          pin::getJointJacobian(model, data, tip, pin::LOCAL_WORLD_ALIGNED, jacobian);
        },
        [&](std::size_t, std::vector<double>& out) { append(out, jacobian); });
  } else if (algorithm == "jacobian_in_frame") {
    run(
        [&](std::size_t i) {
          jacobian.setZero();
          pin::computeJointJacobian(model, data, q[i], tip, jacobian);
        },
        [&](std::size_t, std::vector<double>& out) { append(out, jacobian); });
  } else if (algorithm == "inverse_dynamics_derivatives") {
    // dtau/dq and dtau/dv; dtau/da = M is in the upper triangle of data.M.
    run([&](std::size_t i) { pin::computeRNEADerivatives(model, data, q[i], v[i], a[i]); },
        [&](std::size_t, std::vector<double>& out) {
          append(out, data.dtau_dq);
          append(out, data.dtau_dv);
        });
  } else if (algorithm == "forward_dynamics_derivatives") {
    // da/dq and da/dv; da/dtau = inverse of M is in the upper triangle of data.Minv.
    run([&](std::size_t i) { pin::computeABADerivatives(model, data, q[i], v[i], tau[i]); },
        [&](std::size_t, std::vector<double>& out) {
          append(out, data.ddq_dq);
          append(out, data.ddq_dv);
        });
  } else {
    side::fail("no algorithm " + algorithm);
  }
}
