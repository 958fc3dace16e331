// The driver of a robot's generated C, linked with it: this project's, CppADCodeGen's (-DCPPAD) or CasADi's
// (-DCASADI). SIDE has the arguments of the other programs. In place of a robot it reads the number of results and, if
// they are a part of the upper triangle of M, their indices. The algorithm is that of the linked code; for this
// project's code -DFUNCTION is its name and -DARGUMENTS 1 or 3.
#include "side.hpp"

#if defined(CPPAD)
struct LangCAtomicFun {
  void* model;
  int (*forward)(void*, int, int, int, const void*, void*);
  int (*reverse)(void*, int, int, const void*, void*, const void*);
};
extern "C" void robot_forward_zero(double const* const* in, double* const* out, LangCAtomicFun atomic);
#elif defined(CASADI)
extern "C" {
int robot(const double** arguments, double** results, long long* iw, double* w, int memory);
int robot_work(long long* arguments, long long* results, long long* iw, long long* w);
}
#elif ARGUMENTS == 1
extern "C" void FUNCTION(const double* q, double* out);
#else
extern "C" void FUNCTION(const double* q, const double* v, const double* x, double* out);
#endif

// The number of results, and their indices in the upper triangle of M (row-major) if they are a part of it.
std::vector<std::size_t> read_results(const char* path) {
  std::vector<std::size_t> found;
  std::ifstream file(path);
  for (std::size_t number; file >> number;) found.push_back(number);
  if (found.empty()) side::fail(std::string("cannot read ") + path);
  return found;
}

int main(int argc, char** argv) {
  if (argc != 6) side::fail("usage: generated_side RESULTS STATES ALGORITHM (time MS | calls N | write FILE)");
  const std::vector<std::size_t> described = read_results(argv[1]);
  const side::States states = side::read_states(argv[2]);
  const std::string algorithm = argv[3];
  const bool mass = algorithm.rfind("mass_matrix", 0) == 0, forward = algorithm.rfind("forward_dynamics", 0) == 0;
  const std::size_t nq = states.nq, nv = states.nv, width = nq + 2 * nv, results = described[0];
  // q, v and a or tau of each state in one row, the single argument of the generators' code.
  std::vector<double> x(states.count * width), out(results);
  for (std::size_t i = 0; i < states.count; ++i) {
    double* row = x.data() + i * width;
    std::copy_n(states.q(i), nq, row);
    std::copy_n(states.v(i), nv, row + nq);
    std::copy_n(forward ? states.tau(i) : states.a(i), nv, row + nq + nv);
  }
#if defined(CPPAD)
  double* outs[] = {out.data()};
  auto call = [&](std::size_t i) {
    const double* ins[] = {x.data() + i * width};
    robot_forward_zero(ins, outs, LangCAtomicFun{});
  };
#elif defined(CASADI)
  long long sizes[4];
  robot_work(&sizes[0], &sizes[1], &sizes[2], &sizes[3]);
  std::vector<const double*> ins(static_cast<std::size_t>(sizes[0]) + 1);
  std::vector<double*> outs(static_cast<std::size_t>(sizes[1]) + 1);
  std::vector<long long> iw(static_cast<std::size_t>(sizes[2]) + 1);
  std::vector<double> w(static_cast<std::size_t>(sizes[3]) + 1);
  auto call = [&](std::size_t i) {
    ins[0] = x.data() + i * width;
    outs[0] = out.data();
    robot(ins.data(), outs.data(), iw.data(), w.data(), 0);
  };
#elif ARGUMENTS == 1
  auto call = [&](std::size_t i) { FUNCTION(x.data() + i * width, out.data()); };
#else
  auto call = [&](std::size_t i) {
    const double* row = x.data() + i * width;
    FUNCTION(row, row + nq, row + nq + nv, out.data());
  };
#endif
  const bool all_places = described.size() == 1;
  auto result = [&](std::size_t, std::vector<double>& all) {
    if (!mass) return void(all.insert(all.end(), out.begin(), out.begin() + static_cast<std::ptrdiff_t>(nv)));
    std::vector<double> upper(nv * (nv + 1) / 2), dense(nv * nv);
    for (std::size_t k = 0; k < results; ++k) upper[all_places ? k : described[k + 1]] = out[k];
    for (std::size_t i = 0, k = 0; i < nv; ++i)
      for (std::size_t j = i; j < nv; ++j, ++k) dense[i * nv + j] = dense[j * nv + i] = upper[k];
    all.insert(all.end(), dense.begin(), dense.end());
  };
  side::run(states, argv + 4, call, result);
}
