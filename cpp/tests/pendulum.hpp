// A pendulum whose numbers are known in closed form: 2 kg at 0.5 m, about the y axis.
#pragma once

inline const char* const pendulum = R"(
<robot name="pendulum">
  <link name="base"/>
  <link name="rod">
    <inertial><origin xyz="0.5 0 0"/><mass value="2"/>
      <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <link name="tip"/>
  <joint name="hinge" type="revolute">
    <parent link="base"/><child link="rod"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" effort="40" velocity="10"/>
  </joint>
  <joint name="mount" type="fixed"><parent link="rod"/><child link="tip"/><origin xyz="0.5 0 0"/></joint>
</robot>)";

constexpr double mass = 2.0, length = 0.5, inertia = 0.01 + mass * length * length, gravity = 9.81;
