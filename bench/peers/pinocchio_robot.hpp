// The robot file of Pinocchio's programs, written by `robots.py`.
#pragma once

#include <pinocchio/multibody.hpp>

#include "side.hpp"

namespace peer {

namespace pin = pinocchio;
using Eigen::Matrix3d;
using Eigen::Vector3d;

struct Reader {
  std::ifstream file;
  double number() {
    double x;
    if (!(file >> x)) side::fail("the robot file ends early");
    return x;
  }
  Vector3d vector() {
    const double x = number(), y = number(), z = number();
    return {x, y, z};
  }
  Matrix3d matrix() {
    Matrix3d m;
    for (int i = 0; i < 9; ++i) m(i / 3, i % 3) = number();
    return m;
  }
  // Mass, centre of mass, inertia about it: xx xy xz yy yz zz.
  pin::Inertia inertia() {
    const double mass = number();
    const Vector3d center = vector();
    const double xx = number(), xy = number(), xz = number(), yy = number(), yz = number(), zz = number();
    Matrix3d about;
    about << xx, xy, xz, xy, yy, yz, xz, yz, zz;
    return {mass, center, about};
  }
};

// The joint type that Pinocchio's URDF reader chooses: a special one if the axis is x, y or z.
inline pin::JointModel joint_model(bool slides, const Vector3d& axis) {
  if (axis == Vector3d::UnitX()) return slides ? pin::JointModel(pin::JointModelPX()) : pin::JointModelRX();
  if (axis == Vector3d::UnitY()) return slides ? pin::JointModel(pin::JointModelPY()) : pin::JointModelRY();
  if (axis == Vector3d::UnitZ()) return slides ? pin::JointModel(pin::JointModelPZ()) : pin::JointModelRZ();
  if (slides) return pin::JointModelPrismaticUnaligned(axis);
  return pin::JointModelRevoluteUnaligned(axis);
}

// First line: floating, joints. A floating root's inertia. Each joint: parent (0 is the root link), slides,
// rotation by rows, translation, axis, inertia of its child.
inline pin::Model read_robot(const char* path) {
  Reader in{std::ifstream(path)};
  pin::Model model;
  const bool floating = in.number() != 0;
  const int joints = static_cast<int>(in.number());
  if (floating) {
    model.addJoint(0, pin::JointModelFreeFlyer(), pin::SE3::Identity(), "root");
    model.appendBodyToJoint(1, in.inertia(), pin::SE3::Identity());
  }
  for (int i = 0; i < joints; ++i) {
    const auto parent = static_cast<pin::JointIndex>(in.number()) + (floating ? 1 : 0);
    const bool slides = in.number() != 0;
    const Matrix3d rotation = in.matrix();
    const Vector3d translation = in.vector();
    const Vector3d axis = in.vector();
    const auto id =
        model.addJoint(parent, joint_model(slides, axis), pin::SE3(rotation, translation), "j" + std::to_string(i));
    model.appendBodyToJoint(id, in.inertia(), pin::SE3::Identity());
  }
  return model;
}

}  // namespace peer
