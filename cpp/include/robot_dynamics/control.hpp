/// Controllers.
#pragma once

#include "robot.hpp"

namespace robot_dynamics {
ROBOT_DYNAMICS_NAMESPACE {

/// tau = M(a* + Kp (q* ⊖ q) + Kd (v* − v)) + C v + g. Calls do not allocate.
class ComputedTorque {
public:
    /// A controller with nv gains each; the reference is the neutral configuration at rest.
    static Result<ComputedTorque> make(const Robot& robot, View stiffness, View damping, bool dissipation = false) {
        ComputedTorque control;
        rd_status status =
            rd_computed_torque_new(robot.model(), stiffness.data(), stiffness.size(), damping.data(),
                                   damping.size(), dissipation, control.owner_.put());
        return detail::finish(status, std::move(control));
    }
    /// Sets q*, v* and a*.
    Result<void> set_reference(View q, View v, View a) {
        return detail::finish(rd_computed_torque_set_reference(owner_.get(), q.data(), q.size(), v.data(), v.size(),
                                                               a.data(), a.size()));
    }
    /// The torque at a state.
    Result<void> torque(View q, View v, MutableView tau) {
        return detail::finish(rd_computed_torque_torque(owner_.get(), q.data(), q.size(), v.data(), v.size(),
                                                        tau.data(), tau.size()));
    }

private:
    detail::Owner<rd_computed_torque, rd_computed_torque_free> owner_;
};

/// Gains of a frame's motion.
struct TaskGains {
    /// kp [1/s²].
    double stiffness = 100.0;
    /// kd [1/s].
    double damping = 20.0;
    /// The damping in the null space [1/s].
    double null_damping = 10.0;
};

/// Control of the position or the pose of a frame through its operational-space inertia, within the effort limits.
class TaskControl {
public:
    /// A controller of the frame's pose, or of its position alone. An empty posture leaves the null space damped
    /// only.
    static Result<TaskControl> make(const Robot& robot, Frame frame, bool has_orientation, TaskGains gains,
                                    View posture = {}, double posture_stiffness = 0.0) {
        TaskControl control;
        rd_status status = rd_task_control_new(robot.model(), frame.index, has_orientation, gains.stiffness,
                                               gains.damping, gains.null_damping, posture.data(), posture.size(),
                                               posture_stiffness, control.owner_.put());
        return detail::finish(status, std::move(control));
    }
    /// Sets the target, 12 numbers of a pose or 3 of a position, with its velocity and acceleration (6 each, or
    /// empty at rest).
    Result<void> set_target(View target, View velocity = {}, View acceleration = {}) {
        return detail::finish(rd_task_control_set_target(owner_.get(), target.data(), target.size(),
                                                         velocity.data(), velocity.size(), acceleration.data(),
                                                         acceleration.size()));
    }
    /// The torque at a state.
    Result<void> torque(View q, View v, MutableView tau) {
        return detail::finish(rd_task_control_torque(owner_.get(), q.data(), q.size(), v.data(), v.size(),
                                                     tau.data(), tau.size()));
    }

private:
    detail::Owner<rd_task_control, rd_task_control_free> owner_;
};

/// An observer of the external torques.
class MomentumObserver {
public:
    /// An observer with nv gains [1/s].
    static Result<MomentumObserver> make(const Robot& robot, View gains, bool dissipation = false) {
        MomentumObserver observer;
        rd_status status = rd_momentum_observer_new(robot.model(), gains.data(), gains.size(), dissipation,
                                                    observer.owner_.put());
        return detail::finish(status, std::move(observer));
    }
    /// Enters a sample, h seconds after the last one, and writes the external torques.
    Result<void> update(View q, View v, View tau, double h, MutableView external) {
        return detail::finish(rd_momentum_observer_update(owner_.get(), q.data(), q.size(), v.data(), v.size(),
                                                          tau.data(), tau.size(), h, external.data(),
                                                          external.size()));
    }
    /// Forgets all samples.
    Result<void> reset() { return detail::finish(rd_momentum_observer_reset(owner_.get())); }

private:
    detail::Owner<rd_momentum_observer, rd_momentum_observer_free> owner_;
};

/// The gain K, m × n, of u = −K x that minimizes Σ xᵀQ x + uᵀR u along x' = A x + B u.
inline Result<Matrix> dlqr(const Matrix& a, const Matrix& b, const Matrix& q, const Matrix& r) {
    std::size_t n = a.rows(), m = b.columns();
    bool fits = a.columns() == n && b.rows() == n && q.rows() == n && q.columns() == n && r.rows() == m &&
                r.columns() == m;
    Matrix gain(m, n);
    if (!fits) {
        Error error(RD_STATUS_INVALID_INPUT, "the matrices of dlqr must be n × n, n × m, n × n and m × m");
#ifdef ROBOT_DYNAMICS_NO_EXCEPTIONS
        return error;
#else
        throw error;
#endif
    }
    rd_status status =
        rd_dlqr(n, m, a.data(), b.data(), q.data(), r.data(), gain.data(), gain.size(), nullptr);
    return detail::finish(status, std::move(gain));
}

}
}  // namespace robot_dynamics
