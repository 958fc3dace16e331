// Prints the torque that holds a rod, and its energy balance after a fall of two seconds.
import { load } from '@robot-dynamics/wasm';

const ROD = `<robot name="rod">
  <link name="base"/>
  <link name="rod">
    <inertial>
      <origin xyz="0.5 0 0"/>
      <mass value="2"/>
      <inertia ixx="0" ixy="0" ixz="0" iyy="0.16666666666666666" iyz="0" izz="0.16666666666666666"/>
    </inertial>
  </link>
  <joint name="hinge" type="continuous">
    <parent link="base"/>
    <child link="rod"/>
    <axis xyz="0 -1 0"/>
  </joint>
</robot>`;

const { Robot } = await load();
const robot = Robot.load(ROD, false, false);
const [hold] = robot.gravityForces(Float64Array.of(0));
console.log(`torque that holds the level rod: ${hold.toFixed(3)} N m`);

robot.place(Float64Array.of(0));
robot.advance(2000);
const { unaccounted } = robot.energyAccount;
console.log(`after ${robot.time.toFixed(3)} s: q = ${robot.q[0].toFixed(6)} rad`);
console.log(`energy residual: ${unaccounted.toExponential(1)} J`);
