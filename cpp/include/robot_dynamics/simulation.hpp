/// Simulations: everything that a robot's file states, step by step.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "robot.hpp"

namespace robot_dynamics {
ROBOT_DYNAMICS_NAMESPACE {

/// A horizontal ground.
struct Ground {
    /// Its height [m].
    double height = 0.0;
    /// Its friction coefficient; without a value, that of the file and the library.
    std::optional<double> friction;
    /// Its restitution, between 0 and 1.
    double restitution = 0.0;
};

/// Options of a simulation.
struct SimulationOptions {
    /// The step [s].
    double dt = 1e-3;
    /// The method, such as `rk4`, `implicit` or `mujoco`; empty selects it by the robot.
    std::string method;
    /// No effect that removes or adds energy.
    bool conservative = false;
    /// Effects to leave out, separated by commas, such as `dissipation,link-contacts`.
    std::string without;
    /// A ground beside that of the file.
    std::optional<Ground> ground;
};

/// A contact of two surfaces.
using Contact = rd_contact;
/// The energies of a simulation [J].
using EnergyAccount = rd_energy_account;

/// A force and a moment on the link of a frame.
struct Wrench {
    Frame frame;
    /// Force [N], then moment [N m].
    std::array<double, 6> numbers{};
    ReferenceFrame reference = ReferenceFrame::LocalWorldAligned;
};

class Simulation;

/// The complete changing state of a simulation.
class Snapshot {
public:
    rd_snapshot handle() const noexcept { return owner_.get(); }

private:
    friend class Simulation;
    detail::Owner<rd_snapshot, rd_snapshot_free> owner_;
};

/// A simulation of one robot, at its initial configuration, at rest.
class Simulation {
public:
    static Result<Simulation> make(const Robot& robot, const SimulationOptions& options = {}) {
        rd_simulation_options c{};
        c.dt = options.dt;
        c.method = options.method.empty() ? nullptr : options.method.c_str();
        c.conservative = options.conservative;
        c.without = options.without.empty() ? nullptr : options.without.c_str();
        if (options.ground) {
            c.has_ground = 1;
            c.ground_height = options.ground->height;
            double friction = options.ground->friction.value_or(0.0);
            c.ground_friction = options.ground->friction && friction == 0.0 ? -1.0 : friction;
            c.ground_restitution = options.ground->restitution;
        }
        Simulation simulation;
        simulation.nq_ = robot.nq();
        simulation.nv_ = robot.nv();
        rd_status status = rd_simulation_new(robot.model(), &c, simulation.owner_.put());
        return detail::finish(status, std::move(simulation));
    }

    /// The method that takes the steps, and the reason for it.
    std::string method() const { return detail::text(rd_simulation_method(owner_.get())); }
    std::string reason() const { return detail::text(rd_simulation_reason(owner_.get())); }
    /// The features of the file that are left out, one in a line.
    std::string left_out() const { return detail::text(rd_simulation_left_out(owner_.get())); }
    /// The names of the actuators, in the order of the controls.
    std::vector<std::string> control_names() const {
        std::vector<std::string> names;
        for (std::size_t k = 0; k < rd_simulation_control_count(owner_.get()); ++k) {
            names.push_back(detail::text(rd_simulation_control_name(owner_.get(), k)));
        }
        return names;
    }
    /// The names of the sensors.
    std::vector<std::string> sensor_names() const {
        std::vector<std::string> names;
        for (std::size_t k = 0; k < rd_simulation_sensor_count(owner_.get()); ++k) {
            names.push_back(detail::text(rd_simulation_sensor_name(owner_.get(), k)));
        }
        return names;
    }

    /// The time [s].
    double time() const { return rd_simulation_time(owner_.get()); }
    /// Takes steps. The first one that fails ends the call.
    Result<void> step(std::size_t steps = 1) { return detail::finish(rd_simulation_step(owner_.get(), steps)); }

    /// The configuration.
    Result<Vector> q() const {
        Vector out(nq_);
        return detail::finish(rd_simulation_q(owner_.get(), out.data(), out.size()), std::move(out));
    }
    Result<void> q(MutableView out) const {
        return detail::finish(rd_simulation_q(owner_.get(), out.data(), out.size()));
    }
    /// The velocity.
    Result<Vector> v() const {
        Vector out(nv_);
        return detail::finish(rd_simulation_v(owner_.get(), out.data(), out.size()), std::move(out));
    }
    Result<void> v(MutableView out) const {
        return detail::finish(rd_simulation_v(owner_.get(), out.data(), out.size()));
    }
    /// The mean acceleration of the last step.
    Result<Vector> acceleration() const {
        Vector out(nv_);
        return detail::finish(rd_simulation_acceleration(owner_.get(), out.data(), out.size()), std::move(out));
    }
    /// The generalized forces of the last step, after effort limits.
    Result<Vector> applied_torques() const {
        Vector out(nv_);
        return detail::finish(rd_simulation_applied_torques(owner_.get(), out.data(), out.size()), std::move(out));
    }
    /// The energy account.
    Result<EnergyAccount> energy() const {
        EnergyAccount account{};
        rd_status status = rd_simulation_energy(owner_.get(), &account);
        return detail::finish(status, account);
    }
    /// The contacts of the last step.
    Result<std::vector<Contact>> contacts() const {
        std::size_t count = 0;
        rd_status status = rd_simulation_contacts(owner_.get(), nullptr, 0, &count);
        std::vector<Contact> contacts(count);
        if (status == RD_STATUS_OK && count > 0) {
            status = rd_simulation_contacts(owner_.get(), contacts.data(), contacts.size(), &count);
        }
        return detail::finish(status, std::move(contacts));
    }
    /// The values of all sensors, in the order of the file.
    Result<Vector> sensors() const {
        Vector out(rd_simulation_sensor_value_count(owner_.get()));
        return detail::finish(rd_simulation_sensors(owner_.get(), out.data(), out.size()), std::move(out));
    }

    /// Sets the state, and time and energy account to their start.
    Result<void> reset(View q, View v) {
        return detail::finish(rd_simulation_reset(owner_.get(), q.data(), q.size(), v.data(), v.size()));
    }
    /// Resets the state to a named pose of the robot's files.
    Result<void> reset_to(const std::string& pose) {
        return detail::finish(rd_simulation_reset_to(owner_.get(), pose.c_str()));
    }
    /// Sets the state; the time goes on.
    Result<void> set_state(View q, View v) {
        return detail::finish(rd_simulation_set_state(owner_.get(), q.data(), q.size(), v.data(), v.size()));
    }
    /// Sets the torques of the next steps, nv numbers [N m or N].
    Result<void> set_torques(View tau) {
        return detail::finish(rd_simulation_set_torques(owner_.get(), tau.data(), tau.size()));
    }
    /// Sets the controls of the actuators for the next steps.
    Result<void> set_controls(View controls) {
        return detail::finish(rd_simulation_set_controls(owner_.get(), controls.data(), controls.size()));
    }
    /// Sets the wrenches on frames for the next steps, in place of all earlier ones.
    Result<void> set_wrenches(const std::vector<Wrench>& wrenches) {
        std::vector<std::uint32_t> frames, references;
        Vector numbers;
        for (const Wrench& wrench : wrenches) {
            frames.push_back(wrench.frame.index);
            references.push_back(static_cast<std::uint32_t>(wrench.reference));
            numbers.insert(numbers.end(), wrench.numbers.begin(), wrench.numbers.end());
        }
        return detail::finish(rd_simulation_set_wrenches(owner_.get(), frames.data(), references.data(),
                                                         wrenches.size(), numbers.data(), numbers.size()));
    }

    /// Copies the complete changing state.
    Result<Snapshot> snapshot() const {
        Snapshot snapshot;
        rd_status status = rd_simulation_snapshot(owner_.get(), snapshot.owner_.put());
        return detail::finish(status, std::move(snapshot));
    }
    /// Restores a snapshot of this simulation, bit for bit.
    Result<void> restore(const Snapshot& snapshot) {
        return detail::finish(rd_simulation_restore(owner_.get(), snapshot.handle()));
    }

    rd_simulation handle() const noexcept { return owner_.get(); }

private:
    detail::Owner<rd_simulation, rd_simulation_free> owner_;
    std::size_t nq_ = 0;
    std::size_t nv_ = 0;
};

}
}  // namespace robot_dynamics
