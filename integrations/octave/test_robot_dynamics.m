function test_robot_dynamics(robots)
  % test_robot_dynamics  Checks the MEX function and the class; `robots` is the folder of the robots' files.
  pendulum_has_the_torques_of_its_equation();
  forward_dynamics_inverts_inverse_dynamics(robots);
  floating_base_has_six_more_coordinates(robots);
  invalid_calls_are_errors(robots);
  robot = Robot(fullfile(robots, 'panda.urdf'));
  assert(numel(robot.names), 7);
  hold_still(fullfile(robots, 'panda.urdf'));
  disp('ok');
end

function pendulum_has_the_torques_of_its_equation()
  % m l² a + d m g l cos(q) of a point of 2 kg at 0.5 m, along x, that turns about −y: upwards for q > 0.
  path = [tempname() '.urdf'];
  file = fopen(path, 'w');
  fprintf(file, ['<robot name="pendulum"><link name="base"/><link name="arm"><inertial><origin xyz="0.5 0 0"/>' ...
                 '<mass value="2"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>' ...
                 '</link><joint name="turn" type="continuous"><parent link="base"/><child link="arm"/>' ...
                 '<axis xyz="0 -1 0"/></joint></robot>']);
  fclose(file);
  robot = Robot(path);
  delete(path);
  assert(robot.names, {'turn'});
  inertia = 0.1 + 2 * 0.5 ^ 2;
  for q = [-1, 0, 0.4]
    g = 2 * 9.81 * 0.5 * cos(q);
    % Relative to 10 N m, rounding is of the order 1e-15.
    assert(robot.mass_matrix(q), inertia, 1e-13);
    assert(robot.gravity(q), g, 1e-13);
    assert(robot.inverse_dynamics(q, 3, 2), inertia * 2 + g, 1e-13);
  end
end

function forward_dynamics_inverts_inverse_dynamics(robots)
  robot = Robot(fullfile(robots, 'panda.urdf'));
  q = linspace(-1, 1, robot.nq)';
  v = linspace(1, 2, robot.nv)';
  a = linspace(-3, 2, robot.nv)';
  tau = robot.inverse_dynamics(q, v, a);
  M = robot.mass_matrix(q);
  assert(size(tau), [7, 1]);
  % The condition number of M, 1e4 or less, amplifies rounding of 1e-16.
  assert(robot.forward_dynamics(q, v, tau), a, 1e-10);
  assert(M, M', 1e-14);
  assert(min(eig(M)) > 0);
  assert(M * a + robot.inverse_dynamics(q, v, 0 * a), tau, 1e-11);
  assert(robot.inverse_dynamics(q', 0 * v', 0 * a'), robot.gravity(q), 1e-12);
end

function floating_base_has_six_more_coordinates(robots)
  path = fullfile(robots, 'quadruped.urdf');
  fixed = Robot(path);
  floating = Robot(path, true);
  assert(floating.nv, fixed.nv + 6);
  assert(floating.nq, floating.nv + 1);
  q = floating.neutral();
  assert(norm(q(4:7)), 1);
end

function invalid_calls_are_errors(robots)
  handle = robot_dynamics_mex('load', fullfile(robots, 'panda.urdf'));
  fails('robot_dynamics:invalid_input', @() robot_dynamics_mex('gravity', handle, zeros(3, 1)));
  fails('robot_dynamics:invalid_input', @() robot_dynamics_mex('gravity', handle, nan(7, 1)));
  fails('robot_dynamics:invalid_input', @() robot_dynamics_mex('gravity', handle, single(zeros(7, 1))));
  fails('robot_dynamics:invalid_input', @() robot_dynamics_mex('gravity', handle));
  fails('robot_dynamics:invalid_input', @() robot_dynamics_mex('fly', handle));
  fails('robot_dynamics:invalid_input', @() robot_dynamics_mex('gravity', 1, zeros(7, 1)));
  fails('robot_dynamics:file', @() robot_dynamics_mex('load', 'no/such/file.urdf'));
  robot_dynamics_mex('free', handle);
  fails('robot_dynamics:invalid_handle', @() robot_dynamics_mex('gravity', handle, zeros(7, 1)));
end

function fails(identifier, call)
  try
    call();
  catch error
    assert(error.identifier, identifier);
    assert(~isempty(error.message));
    return;
  end
  assert(false, ['expected ' identifier]);
end
