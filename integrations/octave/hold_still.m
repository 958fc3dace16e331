function hold_still(path)
  % hold_still  Prints the torques that hold a robot still.
  robot = Robot(path);
  g = robot.gravity(robot.neutral());
  for k = 1:robot.nv
    fprintf('%-24s %10.4f\n', robot.names{k}, g(k));
  end
end
