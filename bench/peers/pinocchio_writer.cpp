// Writes C for one robot from Pinocchio's algorithms over a recording number type: CppADCodeGen's, or with -DCASADI
// CasADi's. WRITER ROBOT ALGORITHM FOLDER writes to FOLDER; `generated_side.cpp` has the inputs and results.
#ifdef CASADI
#include <pinocchio/autodiff/casadi.hpp>
#else
#include <pinocchio/codegen/cppadcg.hpp>
#endif
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/joint-configuration.hpp>
#include <pinocchio/algorithm/rnea.hpp>

#include "pinocchio_robot.hpp"

namespace pin = pinocchio;

// A quarter turn of a robot file leaves 2e-16 instead of zero, which no generator removes. It is cleared, so that the
// code is as short as possible.
void clear_rounding(pin::Model& model) {
  for (auto& place : model.jointPlacements)
    for (int k = 0; k < 9; ++k) {
      double& x = place.rotation().data()[k];
      if (std::abs(x - std::round(x)) < 1e-15) x = std::round(x);
    }
}

// The results: tau, a, or the upper triangle of M in row-major order. x = (q), (q, v, a) or (q, v, tau).
template <class Scalar, class Vector>
Vector evaluate(const pin::ModelTpl<Scalar>& model, const std::string& algorithm, const Vector& x) {
  pin::DataTpl<Scalar> data(model);
  const Vector q = x.head(model.nq);
  const bool world = algorithm.find("@world") != std::string::npos;
  const auto convention = world ? pin::Convention::WORLD : pin::Convention::LOCAL;
  if (algorithm.rfind("mass_matrix", 0) == 0) {
    pin::crba(model, data, q, convention);
    Vector upper(model.nv * (model.nv + 1) / 2);
    Eigen::Index k = 0;
    for (int i = 0; i < model.nv; ++i)
      for (int j = i; j < model.nv; ++j) upper[k++] = data.M(i, j);
    return upper;
  }
  const Vector v = x.segment(model.nq, model.nv), last = x.tail(model.nv);
  if (algorithm == "inverse_dynamics") return pin::rnea(model, data, q, v, last);
  return pin::aba(model, data, q, v, last, convention);
}

int main(int argc, char** argv) {
  if (argc != 4) side::fail("usage: pinocchio_writer ROBOT ALGORITHM FOLDER");
  pin::Model robot = peer::read_robot(argv[1]);
  clear_rounding(robot);
  const std::string algorithm = argv[2], folder = argv[3];
  const bool mass = algorithm.rfind("mass_matrix", 0) == 0;
  const int width = robot.nq + (mass ? 0 : 2 * robot.nv);

#ifdef CASADI
  using Scalar = casadi::SX;
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  const auto model = robot.cast<Scalar>();
  const Scalar input = Scalar::sym("x", width);
  Vector x(width);
  for (int i = 0; i < width; ++i) x[i] = input(i);
  const Vector y = evaluate<Scalar, Vector>(model, algorithm, x);
  Scalar output = Scalar::zeros(static_cast<casadi_int>(y.size()));
  for (Eigen::Index i = 0; i < y.size(); ++i) output(static_cast<casadi_int>(i)) = y[i];
  // Results that are always zero are not stored; the generator removes common subexpressions.
  const casadi::Function function("robot", {input}, casadi::SX::cse(std::vector<Scalar>{casadi::SX::sparsify(output)}));
  casadi::CodeGenerator generator("robot.c");
  generator.add(function);
  generator.generate(folder + "/");
  // The stored results.
  std::ofstream entries(folder + "/entries.txt");
  for (const auto row : function.sparsity_out(0).get_row()) entries << row << "\n";
#else
  using Recorded = CppAD::cg::CG<double>;
  using Scalar = CppAD::AD<Recorded>;
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  const auto model = robot.cast<Scalar>();
  Vector x = Vector::Zero(width);
  const Eigen::VectorXd neutral = pin::neutral(robot);
  for (int i = 0; i < robot.nq; ++i) x[i] = neutral[i];
  CppAD::Independent(x);
  const Vector y = evaluate<Scalar, Vector>(model, algorithm, x);
  CppAD::ADFun<Recorded> function(x, y);
  function.optimize("no_compare_op");
  CppAD::cg::ModelCSourceGen<double> source(function, "robot");
  source.setCreateForwardZero(true);
  CppAD::cg::ModelLibraryCSourceGen<double> library(source);
  CppAD::cg::SaveFilesModelLibraryProcessor<double>::saveLibrarySourcesTo(library, folder);
#endif
}
