/// The C++17 interface of robot-dynamics: a layer of headers over `robot_dynamics.h`.
///
/// Objects own their handles. Arguments are views of `std::vector`, `std::array`, C arrays or Eigen vectors,
/// without copies. Each function has two forms: one returns a new array, the other writes into an array of the
/// caller and does not allocate.
///
/// Functions throw `robot_dynamics::Error`. With `ROBOT_DYNAMICS_NO_EXCEPTIONS` defined before the header, they
/// return `Result<T>`, which holds the value or the error.
///
/// An object serves one call at a time. Copies of a `Robot` share the model and have memory of their own, so each
/// thread takes a copy.
#pragma once

#include "robot_dynamics/batch.hpp"
#include "robot_dynamics/control.hpp"
#include "robot_dynamics/identification.hpp"
#include "robot_dynamics/optimal.hpp"
#include "robot_dynamics/result.hpp"
#include "robot_dynamics/robot.hpp"
#include "robot_dynamics/simulation.hpp"
#include "robot_dynamics/view.hpp"
