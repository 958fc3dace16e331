// Common parts of the C++ programs: the file of states, timing, and the output file.
// A program is called as: SIDE ROBOT STATES ALGORITHM (time MILLISECONDS | calls N | write FILE)
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

namespace side {

[[noreturn]] inline void fail(const std::string& what) {
  std::fprintf(stderr, "%s\n", what.c_str());
  std::exit(1);
}

// Random states in one file: count, nq, nv, tip as 64-bit integers, then q v a tau of each state.
struct States {
  std::uint64_t count, nq, nv, tip;
  std::vector<double> numbers;

  const double* q(std::size_t i) const { return numbers.data() + i * (nq + 3 * nv); }
  const double* v(std::size_t i) const { return q(i) + nq; }
  const double* a(std::size_t i) const { return v(i) + nv; }
  const double* tau(std::size_t i) const { return a(i) + nv; }
};

inline States read_states(const char* path) {
  States states{};
  std::ifstream file(path, std::ios::binary);
  file.read(reinterpret_cast<char*>(&states), 4 * sizeof(std::uint64_t));
  states.numbers.resize(states.count * (states.nq + 3 * states.nv));
  const auto bytes = static_cast<std::streamsize>(states.numbers.size() * sizeof(double));
  if (!file.read(reinterpret_cast<char*>(states.numbers.data()), bytes)) fail(std::string("cannot read ") + path);
  return states;
}

// Calls between two clock readings: short relative to time slices, long relative to the clock's resolution.
constexpr std::size_t BLOCK = 128;

// Runs through all states block by block for that long; prints median and smallest nanoseconds per call of a block.
template <class Call>
void time_blocks(std::size_t count, double milliseconds, Call call) {
  using clock = std::chrono::steady_clock;
  for (std::size_t i = 0; i < count; ++i) call(i);
  std::vector<double> blocks;
  const auto start = clock::now();
  do {
    for (std::size_t first = 0; first + BLOCK <= count; first += BLOCK) {
      const auto before = clock::now();
      for (std::size_t i = first; i < first + BLOCK; ++i) call(i);
      blocks.push_back(std::chrono::duration<double, std::nano>(clock::now() - before).count() / BLOCK);
    }
  } while (std::chrono::duration<double, std::milli>(clock::now() - start).count() < milliseconds);
  std::sort(blocks.begin(), blocks.end());
  std::printf("{\"median_ns\": %.3f, \"min_ns\": %.3f, \"blocks\": %zu}\n", blocks[blocks.size() / 2], blocks[0],
              blocks.size());
}

// Runs the task of the command line. `call(i)` computes state i; `result(i, out)` appends its numbers.
template <class Call, class Result>
void run(const States& states, char** how, Call call, Result result) {
  const std::string mode = how[0];
  if (mode == "time") {
    time_blocks(states.count, std::atof(how[1]), call);
  } else if (mode == "calls") {
    const long calls = std::atol(how[1]);
    for (long i = 0; i < calls; ++i) call(static_cast<std::size_t>(i) % states.count);
  } else if (mode == "write") {
    std::vector<double> out;
    for (std::size_t i = 0; i < states.count; ++i) {
      call(i);
      result(i, out);
    }
    std::ofstream file(how[1], std::ios::binary);
    file.write(reinterpret_cast<const char*>(out.data()), static_cast<std::streamsize>(out.size() * sizeof(double)));
    if (!file) fail(std::string("cannot write ") + how[1]);
  } else {
    fail("time, calls or write, not " + mode);
  }
}

}  // namespace side
