classdef Robot < handle
  % Robot  A robot of a URDF, MJCF, SDF or USD file.
  %
  %   robot = Robot(path)         on a fixed base
  %   robot = Robot(path, true)   with a floating base
  %   tau = robot.inverse_dynamics(q, v, a)

  properties (SetAccess = private)
    nq      % the length of q
    nv      % the length of v, a and tau
    names   % the names of the coordinates of v
  end

  properties (Access = private)
    id = uint64([])
  end

  methods
    function self = Robot(path, floating_base)
      if nargin < 2
        floating_base = false;
      end
      self.id = robot_dynamics_mex('load', path, floating_base);
      self.nq = robot_dynamics_mex('nq', self.id);
      self.nv = robot_dynamics_mex('nv', self.id);
      self.names = robot_dynamics_mex('names', self.id);
    end

    function delete(self)
      if ~isempty(self.id)
        robot_dynamics_mex('free', self.id);
        self.id = uint64([]);
      end
    end

    function q = neutral(self)
      q = robot_dynamics_mex('neutral', self.id);
    end

    function g = gravity(self, q)
      g = robot_dynamics_mex('gravity', self.id, q);
    end

    function M = mass_matrix(self, q)
      M = robot_dynamics_mex('mass_matrix', self.id, q);
    end

    function tau = inverse_dynamics(self, q, v, a)
      tau = robot_dynamics_mex('inverse_dynamics', self.id, q, v, a);
    end

    function a = forward_dynamics(self, q, v, tau)
      a = robot_dynamics_mex('forward_dynamics', self.id, q, v, tau);
    end
  end
end
