/// Robots: loading, facts, and the quantities of the equation of motion.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "view.hpp"

namespace robot_dynamics {
ROBOT_DYNAMICS_NAMESPACE {

/// Options of loading a robot.
struct LoadOptions {
    /// The base floats, which adds six degrees of freedom.
    bool floating_base = false;
    /// Warnings are errors.
    bool strict = false;
    /// Inertias that no rigid body has are repaired, and both values are reported.
    bool repair_inertia = false;
    /// Other files must be in the folder of the robot's file.
    bool confined = false;
    /// A folder that is searched for `package://NAME/…` first.
    std::string package_path;
    /// The path of the robot's SRDF file.
    std::string srdf;
};

/// The axes and the point of a frame's velocity, acceleration or Jacobian.
enum class ReferenceFrame : std::uint32_t {
    /// The world's axes, and the frame's origin.
    LocalWorldAligned = RD_REFERENCE_FRAME_LOCAL_WORLD_ALIGNED,
    /// The frame's own axes, and its origin.
    Local = RD_REFERENCE_FRAME_LOCAL,
    /// The world's axes, and the point of the body at the world's origin.
    World = RD_REFERENCE_FRAME_WORLD,
};

/// A frame of one robot.
struct Frame {
    std::uint32_t index;
};

/// Options of inverse kinematics; zeros select the defaults.
using InverseKinematicsOptions = rd_inverse_kinematics_options;

/// A configuration and its distance from the target.
struct InverseKinematicsSolution {
    Vector q;
    rd_inverse_kinematics_report report;
};

/// ∂tau/∂q and ∂tau/∂v, nv × nv each; ∂tau/∂a is the mass matrix.
struct InverseDynamicsDerivatives {
    Matrix by_position, by_velocity;
};

/// ∂a/∂q, ∂a/∂v and ∂a/∂tau, nv × nv each.
struct ForwardDynamicsDerivatives {
    Matrix by_position, by_velocity, by_force;
};

/// A = ∂(q₁, v₁)/∂(q₀, v₀), 2nv × 2nv, and B = ∂(q₁, v₁)/∂tau, 2nv × nv, of a step.
struct LinearizedStep {
    Matrix by_state, by_force;
};

/// The accelerations and the multipliers of a constrained motion.
struct ConstrainedMotion {
    Vector acceleration, multipliers;
};

class Robot;

/// Constraints of one robot: closed loops of its file, or supports.
class Constraints {
public:
    /// The loops, couplings and other equalities of the robot's file.
    static Result<Constraints> from_file(const Robot& robot);

    /// Supports that hold the origins of frames at points of the world, 3 numbers each [m].
    static Result<Constraints> at_points(const Robot& robot, const std::vector<Frame>& frames, View points);

    /// The number of rows.
    std::size_t size() const { return rd_constraints_row_count(owner_.get()); }
    /// The name of a row.
    std::string row_name(std::size_t row) const { return detail::text(rd_constraints_row_name(owner_.get(), row)); }
    rd_constraints handle() const noexcept { return owner_.get(); }

private:
    detail::Owner<rd_constraints, rd_constraints_free> owner_;
};

/// A robot: an immutable model, which copies share, and memory for one call at a time.
class Robot {
public:
    /// Loads a URDF, MJCF, SDF, USD or scene file. Suspicious values are reported by `report`.
    static Result<Robot> load(const std::string& path, const LoadOptions& options = {}) {
        rd_model model{0};
        rd_load_options c = c_options(options);
        return made(rd_load(path.c_str(), &c, &model), model);
    }

    /// Loads a robot from the text of its file.
    static Result<Robot> load_text(const std::string& text, const LoadOptions& options = {}) {
        rd_model model{0};
        rd_load_options c = c_options(options);
        return made(rd_load_text(text.c_str(), &c, &model), model);
    }

    /// The robot of a handle, which it then owns.
    static Result<Robot> from_handle(rd_model model) { return made(RD_STATUS_OK, model); }

    Robot(const Robot& other) : model_(other.model_), nq_(other.nq_), nv_(other.nv_) {
        rd_workspace_new(model(), workspace_.put());
    }
    Robot(Robot&&) noexcept = default;
    Robot& operator=(Robot other) noexcept {
        model_.swap(other.model_);
        std::swap(workspace_, other.workspace_);
        nq_ = other.nq_;
        nv_ = other.nv_;
        return *this;
    }

    /// The number of coordinates of q.
    std::size_t nq() const noexcept { return nq_; }
    /// The number of degrees of freedom: the length of v, a and tau.
    std::size_t nv() const noexcept { return nv_; }
    /// The name.
    std::string name() const { return detail::text(rd_model_name(model())); }
    /// Everything that was read, defaulted, suspicious or ignored, by line.
    std::string report() const { return detail::text(rd_model_report(model())); }
    /// The mass of the moving bodies [kg].
    double mass() const { return rd_model_mass(model()); }
    /// A hash of the description.
    std::uint64_t fingerprint() const { return rd_model_fingerprint(model()); }
    /// The names of the joints.
    std::vector<std::string> joint_names() const {
        return names(rd_model_joint_count(model()), rd_model_joint_name);
    }
    /// The names of the coordinates of v.
    std::vector<std::string> coordinate_names() const { return names(nv_, rd_model_coordinate_name); }
    /// The names of the frames; every link is one.
    std::vector<std::string> frame_names() const {
        return names(rd_model_frame_count(model()), [](rd_model model, std::size_t index) {
            return rd_model_frame_name(model, static_cast<std::uint32_t>(index));
        });
    }
    /// The names of the poses in the robot's files.
    std::vector<std::string> pose_names() const {
        return names(rd_model_pose_count(model()), rd_model_pose_name);
    }
    /// The frame of this name.
    Result<Frame> frame(const std::string& name) const {
        Frame frame{0};
        rd_status status = rd_model_frame(model(), name.c_str(), &frame.index);
        return detail::finish(status, frame);
    }
    /// The lower position limits, nv numbers [rad or m]; −∞ without a limit.
    Result<Vector> lower_limits() const { return limits(rd_model_lower_limits); }
    /// The upper position limits, nv numbers [rad or m]; ∞ without a limit.
    Result<Vector> upper_limits() const { return limits(rd_model_upper_limits); }
    /// The velocity limits, nv numbers [rad/s or m/s]; ∞ without a limit.
    Result<Vector> velocity_limits() const { return limits(rd_model_velocity_limits); }
    /// The effort limits, nv numbers [N m or N]; ∞ without a limit.
    Result<Vector> effort_limits() const { return limits(rd_model_effort_limits); }

    /// The neutral configuration: zeros, and identity quaternions.
    Result<Vector> neutral() const {
        Vector q(nq_);
        return detail::finish(rd_neutral(model(), q.data(), q.size()), std::move(q));
    }
    /// A random configuration within the limits; equal seeds give equal configurations.
    Result<Vector> random_configuration(std::uint64_t seed) const {
        Vector q(nq_);
        return detail::finish(rd_random_configuration(model(), seed, q.data(), q.size()), std::move(q));
    }
    /// The configuration of a named pose of the robot's files.
    Result<Vector> named_pose(const std::string& name) const {
        Vector q(nq_), v(nv_);
        rd_status status = rd_named_pose(model(), name.c_str(), q.data(), q.size(), v.data(), v.size());
        return detail::finish(status, std::move(q));
    }
    /// q ⊕ displacement: along a velocity for one second.
    Result<Vector> integrate(View q, View displacement) const {
        Vector moved(nq_);
        rd_status status = rd_integrate(model(), q.data(), q.size(), displacement.data(), displacement.size(),
                                        moved.data(), moved.size());
        return detail::finish(status, std::move(moved));
    }
    /// The same, without an allocation.
    Result<void> integrate(View q, View displacement, MutableView moved) const {
        return detail::finish(rd_integrate(model(), q.data(), q.size(), displacement.data(),
                                           displacement.size(), moved.data(), moved.size()));
    }
    /// q1 ⊖ q0, nv numbers.
    Result<Vector> difference(View q0, View q1) const {
        Vector out(nv_);
        rd_status status =
            rd_difference(model(), q0.data(), q0.size(), q1.data(), q1.size(), out.data(), out.size());
        return detail::finish(status, std::move(out));
    }
    /// The configuration between q0 (s = 0) and q1 (s = 1).
    Result<Vector> interpolate(View q0, View q1, double s) const {
        Vector out(nq_);
        rd_status status =
            rd_interpolate(model(), q0.data(), q0.size(), q1.data(), q1.size(), s, out.data(), out.size());
        return detail::finish(status, std::move(out));
    }

    /// M(q), nv × nv.
    Result<Matrix> mass_matrix(View q) {
        Matrix out(nv(), nv());
        return detail::finish(rd_mass_matrix(workspace_.get(), q.data(), q.size(), out.data(), out.size()), std::move(out));
    }
    /// The same, without an allocation.
    Result<void> mass_matrix(View q, MutableView out) {
        return detail::finish(rd_mass_matrix(workspace_.get(), q.data(), q.size(), out.data(), out.size()));
    }

    /// The inverse of M(q), nv × nv.
    Result<Matrix> inverse_mass_matrix(View q) {
        Matrix out(nv(), nv());
        return detail::finish(rd_inverse_mass_matrix(workspace_.get(), q.data(), q.size(), out.data(), out.size()), std::move(out));
    }
    /// The same, without an allocation.
    Result<void> inverse_mass_matrix(View q, MutableView out) {
        return detail::finish(rd_inverse_mass_matrix(workspace_.get(), q.data(), q.size(), out.data(), out.size()));
    }

    /// L and D of M(q) = LᵀDL, nv × nv: D on the diagonal, L below it.
    Result<Matrix> mass_matrix_factor(View q) {
        Matrix out(nv(), nv());
        return detail::finish(rd_mass_matrix_factor(workspace_.get(), q.data(), q.size(), out.data(), out.size()), std::move(out));
    }
    /// The same, without an allocation.
    Result<void> mass_matrix_factor(View q, MutableView out) {
        return detail::finish(rd_mass_matrix_factor(workspace_.get(), q.data(), q.size(), out.data(), out.size()));
    }

    /// g(q), nv numbers, springs included.
    Result<Vector> gravity_forces(View q) {
        Vector out(nv());
        return detail::finish(rd_gravity(workspace_.get(), q.data(), q.size(), out.data(), out.size()), std::move(out));
    }
    /// The same, without an allocation.
    Result<void> gravity_forces(View q, MutableView out) {
        return detail::finish(rd_gravity(workspace_.get(), q.data(), q.size(), out.data(), out.size()));
    }

    /// ∂g/∂q, nv × nv.
    Result<Matrix> gravity_derivative(View q) {
        Matrix out(nv(), nv());
        return detail::finish(rd_gravity_derivative(workspace_.get(), q.data(), q.size(), out.data(), out.size()), std::move(out));
    }
    /// The same, without an allocation.
    Result<void> gravity_derivative(View q, MutableView out) {
        return detail::finish(rd_gravity_derivative(workspace_.get(), q.data(), q.size(), out.data(), out.size()));
    }

    /// C(q, v) v + g(q), nv numbers.
    Result<Vector> bias(View q, View v) {
        Vector out(nv());
        return detail::finish(rd_bias(workspace_.get(), q.data(), q.size(), v.data(), v.size(), out.data(), out.size()), std::move(out));
    }
    /// The same, without an allocation.
    Result<void> bias(View q, View v, MutableView out) {
        return detail::finish(rd_bias(workspace_.get(), q.data(), q.size(), v.data(), v.size(), out.data(), out.size()));
    }

    /// C(q, v) of the Christoffel symbols, nv × nv.
    Result<Matrix> coriolis_matrix(View q, View v) {
        Matrix out(nv(), nv());
        return detail::finish(rd_coriolis_matrix(workspace_.get(), q.data(), q.size(), v.data(), v.size(), out.data(), out.size()), std::move(out));
    }
    /// The same, without an allocation.
    Result<void> coriolis_matrix(View q, View v, MutableView out) {
        return detail::finish(rd_coriolis_matrix(workspace_.get(), q.data(), q.size(), v.data(), v.size(), out.data(), out.size()));
    }

    /// C(q, v) v, nv numbers.
    Result<Vector> velocity_product(View q, View v) {
        Vector out(nv());
        return detail::finish(rd_velocity_product(workspace_.get(), q.data(), q.size(), v.data(), v.size(), out.data(), out.size()), std::move(out));
    }
    /// The same, without an allocation.
    Result<void> velocity_product(View q, View v, MutableView out) {
        return detail::finish(rd_velocity_product(workspace_.get(), q.data(), q.size(), v.data(), v.size(), out.data(), out.size()));
    }

    /// M(q) v, nv numbers.
    Result<Vector> momentum(View q, View v) {
        Vector out(nv());
        return detail::finish(rd_momentum(workspace_.get(), q.data(), q.size(), v.data(), v.size(), out.data(), out.size()), std::move(out));
    }
    /// The same, without an allocation.
    Result<void> momentum(View q, View v, MutableView out) {
        return detail::finish(rd_momentum(workspace_.get(), q.data(), q.size(), v.data(), v.size(), out.data(), out.size()));
    }

    /// tau = M(q) a + C(q, v) v + g(q), nv numbers [N m or N].
    Result<Vector> inverse_dynamics(View q, View v, View a) {
        Vector out(nv());
        return detail::finish(rd_inverse_dynamics(workspace_.get(), q.data(), q.size(), v.data(), v.size(), a.data(), a.size(), out.data(), out.size()), std::move(out));
    }
    /// The same, without an allocation.
    Result<void> inverse_dynamics(View q, View v, View a, MutableView out) {
        return detail::finish(rd_inverse_dynamics(workspace_.get(), q.data(), q.size(), v.data(), v.size(), a.data(), a.size(), out.data(), out.size()));
    }

    /// a = M(q)⁻¹(tau − C(q, v) v − g(q)), nv numbers [rad/s² or m/s²].
    Result<Vector> forward_dynamics(View q, View v, View tau) {
        Vector out(nv());
        return detail::finish(rd_forward_dynamics(workspace_.get(), q.data(), q.size(), v.data(), v.size(), tau.data(), tau.size(), out.data(), out.size()), std::move(out));
    }
    /// The same, without an allocation.
    Result<void> forward_dynamics(View q, View v, View tau, MutableView out) {
        return detail::finish(rd_forward_dynamics(workspace_.get(), q.data(), q.size(), v.data(), v.size(), tau.data(), tau.size(), out.data(), out.size()));
    }

    /// The Jacobian of the centre of mass, 3 × nv.
    Result<Matrix> center_of_mass_jacobian(View q) {
        Matrix out(3, nv());
        return detail::finish(rd_center_of_mass_jacobian(workspace_.get(), q.data(), q.size(), out.data(), out.size()), std::move(out));
    }
    /// The same, without an allocation.
    Result<void> center_of_mass_jacobian(View q, MutableView out) {
        return detail::finish(rd_center_of_mass_jacobian(workspace_.get(), q.data(), q.size(), out.data(), out.size()));
    }

    /// The centroidal momentum matrix, 6 × nv: linear rows, then angular ones.
    Result<Matrix> centroidal_momentum_matrix(View q) {
        Matrix out(6, nv());
        return detail::finish(rd_centroidal_momentum_matrix(workspace_.get(), q.data(), q.size(), out.data(), out.size()), std::move(out));
    }
    /// The same, without an allocation.
    Result<void> centroidal_momentum_matrix(View q, MutableView out) {
        return detail::finish(rd_centroidal_momentum_matrix(workspace_.get(), q.data(), q.size(), out.data(), out.size()));
    }

    /// K(q, v) [J].
    Result<double> kinetic_energy(View q, View v) {
        double energy = 0.0;
        rd_status status =
            rd_kinetic_energy(workspace_.get(), q.data(), q.size(), v.data(), v.size(), &energy);
        return detail::finish(status, energy);
    }
    /// V(q) [J].
    Result<double> potential_energy(View q) {
        double energy = 0.0;
        rd_status status = rd_potential_energy(workspace_.get(), q.data(), q.size(), &energy);
        return detail::finish(status, energy);
    }
    /// The centre of mass in the world [m].
    Result<std::array<double, 3>> center_of_mass(View q) {
        std::array<double, 3> out{};
        return detail::finish(rd_center_of_mass(workspace_.get(), q.data(), q.size(), out.data(), 3), out);
    }
    /// The velocity of the centre of mass [m/s].
    Result<std::array<double, 3>> center_of_mass_velocity(View q, View v) {
        std::array<double, 3> out{};
        rd_status status = rd_center_of_mass_velocity(workspace_.get(), q.data(), q.size(), v.data(), v.size(),
                                                      out.data(), 3);
        return detail::finish(status, out);
    }
    /// ∂tau/∂q and ∂tau/∂v of tau(q, v, a).
    Result<InverseDynamicsDerivatives> inverse_dynamics_derivatives(View q, View v, View a) {
        InverseDynamicsDerivatives out{Matrix(nv_, nv_), Matrix(nv_, nv_)};
        rd_status status = rd_inverse_dynamics_derivatives(
            workspace_.get(), q.data(), q.size(), v.data(), v.size(), a.data(), a.size(), out.by_position.data(),
            out.by_position.size(), out.by_velocity.data(), out.by_velocity.size());
        return detail::finish(status, std::move(out));
    }
    /// The same, without an allocation.
    Result<void> inverse_dynamics_derivatives(View q, View v, View a, MutableView by_position,
                                              MutableView by_velocity) {
        return detail::finish(rd_inverse_dynamics_derivatives(
            workspace_.get(), q.data(), q.size(), v.data(), v.size(), a.data(), a.size(), by_position.data(),
            by_position.size(), by_velocity.data(), by_velocity.size()));
    }
    /// ∂a/∂q, ∂a/∂v and ∂a/∂tau of a(q, v, tau).
    Result<ForwardDynamicsDerivatives> forward_dynamics_derivatives(View q, View v, View tau) {
        ForwardDynamicsDerivatives out{Matrix(nv_, nv_), Matrix(nv_, nv_), Matrix(nv_, nv_)};
        rd_status status = rd_forward_dynamics_derivatives(
            workspace_.get(), q.data(), q.size(), v.data(), v.size(), tau.data(), tau.size(),
            out.by_position.data(), out.by_position.size(), out.by_velocity.data(), out.by_velocity.size(),
            out.by_force.data(), out.by_force.size());
        return detail::finish(status, std::move(out));
    }
    /// The same, without an allocation.
    Result<void> forward_dynamics_derivatives(View q, View v, View tau, MutableView by_position,
                                              MutableView by_velocity, MutableView by_force) {
        return detail::finish(rd_forward_dynamics_derivatives(
            workspace_.get(), q.data(), q.size(), v.data(), v.size(), tau.data(), tau.size(), by_position.data(),
            by_position.size(), by_velocity.data(), by_velocity.size(), by_force.data(), by_force.size()));
    }
    /// The derivatives of a step without contact by an integrator such as `rk4`.
    Result<LinearizedStep> linearize_step(const std::string& integrator, double dt, View q, View v, View tau,
                                          bool dissipation = true) {
        LinearizedStep out{Matrix(2 * nv_, 2 * nv_), Matrix(2 * nv_, nv_)};
        rd_status status = rd_linearize_step(
            workspace_.get(), integrator.c_str(), dt, dissipation, q.data(), q.size(), v.data(), v.size(),
            tau.data(), tau.size(), out.by_state.data(), out.by_state.size(), out.by_force.data(),
            out.by_force.size());
        return detail::finish(status, std::move(out));
    }
    /// The pose of a frame in the world.
    Result<Pose> frame_pose(Frame frame, View q) {
        Pose pose;
        rd_status status =
            rd_frame_pose(workspace_.get(), frame.index, q.data(), q.size(), pose.data(), pose.size());
        return detail::finish(status, pose);
    }
    /// The velocity of a frame, linear then angular [m/s, rad/s].
    Result<std::array<double, 6>> frame_velocity(Frame frame, View q, View v, ReferenceFrame reference = {}) {
        std::array<double, 6> out{};
        rd_status status =
            rd_frame_velocity(workspace_.get(), frame.index, static_cast<std::uint32_t>(reference), q.data(),
                              q.size(), v.data(), v.size(), out.data(), out.size());
        return detail::finish(status, out);
    }
    /// The time derivative of the frame's velocity, linear then angular [m/s², rad/s²].
    Result<std::array<double, 6>> frame_acceleration(Frame frame, View q, View v, View a,
                                                     ReferenceFrame reference = {}) {
        std::array<double, 6> out{};
        rd_status status = rd_frame_acceleration(workspace_.get(), frame.index,
                                                 static_cast<std::uint32_t>(reference), q.data(), q.size(),
                                                 v.data(), v.size(), a.data(), a.size(), out.data(), out.size());
        return detail::finish(status, out);
    }
    /// J̇ v, linear then angular.
    Result<std::array<double, 6>> frame_bias_acceleration(Frame frame, View q, View v,
                                                          ReferenceFrame reference = {}) {
        std::array<double, 6> out{};
        rd_status status = rd_frame_bias_acceleration(workspace_.get(), frame.index,
                                                      static_cast<std::uint32_t>(reference), q.data(), q.size(),
                                                      v.data(), v.size(), out.data(), out.size());
        return detail::finish(status, out);
    }
    /// J, 6 × nv: linear rows, then angular ones.
    Result<Matrix> frame_jacobian(Frame frame, View q, ReferenceFrame reference = {}) {
        Matrix out(6, nv_);
        rd_status status = jacobian(frame, reference, q, out);
        return detail::finish(status, std::move(out));
    }
    /// The same, without an allocation.
    Result<void> frame_jacobian(Frame frame, View q, MutableView out, ReferenceFrame reference = {}) {
        return detail::finish(jacobian(frame, reference, q, out));
    }
    /// The wrench that each joint transmits to its child link, 6 numbers for each joint.
    Result<Matrix> joint_reactions(View q, View v, View a) {
        Matrix out(rd_model_joint_count(model()), 6);
        rd_status status = rd_joint_reactions(workspace_.get(), q.data(), q.size(), v.data(), v.size(), a.data(),
                                              a.size(), out.data(), out.size());
        return detail::finish(status, std::move(out));
    }
    /// Y with tau = Y p, nv × 10 links; p are `inertial_parameters`.
    Result<Matrix> joint_torque_regressor(View q, View v, View a) {
        Matrix out(nv_, rd_inertial_parameter_count(workspace_.get()));
        rd_status status = rd_joint_torque_regressor(workspace_.get(), q.data(), q.size(), v.data(), v.size(),
                                                     a.data(), a.size(), out.data(), out.size());
        return detail::finish(status, std::move(out));
    }
    /// The inertial parameters of the moving links, ten for each.
    Result<Vector> inertial_parameters() {
        Vector out(rd_inertial_parameter_count(workspace_.get()));
        rd_status status = rd_inertial_parameters(workspace_.get(), out.data(), out.size());
        return detail::finish(status, std::move(out));
    }
    /// A configuration within the limits in which a frame has a pose (12 numbers) or a position (3 numbers).
    Result<InverseKinematicsSolution> inverse_kinematics(Frame frame, View target, View start,
                                                         const InverseKinematicsOptions& options = {}) {
        InverseKinematicsSolution out{Vector(nq_), {}};
        rd_status status =
            rd_inverse_kinematics(workspace_.get(), frame.index, target.data(), target.size(), start.data(),
                                  start.size(), &options, out.q.data(), out.q.size(), &out.report);
        return detail::finish(status, std::move(out));
    }
    /// The acceleration and the multipliers under constraints.
    Result<ConstrainedMotion> constrained_forward_dynamics(const Constraints& constraints, View q, View v,
                                                           View tau) {
        ConstrainedMotion out{Vector(nv_), Vector(constraints.size())};
        rd_status status = rd_constrained_forward_dynamics(
            workspace_.get(), constraints.handle(), q.data(), q.size(), v.data(), v.size(), tau.data(), tau.size(),
            out.acceleration.data(), out.acceleration.size(), out.multipliers.data(), out.multipliers.size());
        return detail::finish(status, std::move(out));
    }
    /// The nearest configuration that meets the constraints.
    Result<Vector> project_position(const Constraints& constraints, View q, double tolerance = 1e-10) {
        Vector out(q.begin(), q.end());
        rd_status status =
            rd_project_position(workspace_.get(), constraints.handle(), tolerance, out.data(), out.size());
        return detail::finish(status, std::move(out));
    }

    /// The handles, for functions of `robot_dynamics.h`.
    rd_model model() const noexcept { return model_ ? model_->get() : rd_model{0}; }
    rd_workspace workspace() const noexcept { return workspace_.get(); }

private:
    using Model = detail::Owner<rd_model, rd_model_free>;

    explicit Robot(rd_model model) : model_(std::make_shared<Model>(model)) {
        // A failed call has no model, and its message must stay.
        if (model.id != 0) {
            nq_ = rd_model_nq(model);
            nv_ = rd_model_nv(model);
            rd_workspace_new(model, workspace_.put());
        }
    }

    static Result<Robot> made(rd_status status, rd_model model) {
        return detail::finish(status, Robot(model));
    }

    static rd_load_options c_options(const LoadOptions& options) {
        rd_load_options c{};
        c.floating_base = options.floating_base;
        c.strict = options.strict;
        c.repair_inertia = options.repair_inertia;
        c.confined = options.confined;
        c.package_path = options.package_path.empty() ? nullptr : options.package_path.c_str();
        c.srdf = options.srdf.empty() ? nullptr : options.srdf.c_str();
        return c;
    }

    template <class F>
    std::vector<std::string> names(std::size_t count, F name) const {
        std::vector<std::string> out;
        for (std::size_t index = 0; index < count; ++index) {
            out.push_back(detail::text(name(model(), index)));
        }
        return out;
    }

    template <class F>
    Result<Vector> limits(F function) const {
        Vector out(nv_);
        return detail::finish(function(model(), out.data(), out.size()), std::move(out));
    }

    rd_status jacobian(Frame frame, ReferenceFrame reference, View q, MutableView out) {
        return rd_frame_jacobian(workspace_.get(), frame.index, static_cast<std::uint32_t>(reference), q.data(),
                                 q.size(), out.data(), out.size());
    }

    std::shared_ptr<Model> model_;
    detail::Owner<rd_workspace, rd_workspace_free> workspace_;
    std::size_t nq_ = 0;
    std::size_t nv_ = 0;
};

inline Result<Constraints> Constraints::from_file(const Robot& robot) {
    Constraints constraints;
    rd_status status = rd_constraints_from_file(robot.model(), constraints.owner_.put());
    return detail::finish(status, std::move(constraints));
}

inline Result<Constraints> Constraints::at_points(const Robot& robot, const std::vector<Frame>& frames,
                                                  View points) {
    Constraints constraints;
    std::vector<std::uint32_t> indices;
    for (Frame frame : frames) {
        indices.push_back(frame.index);
    }
    rd_status status = rd_constraints_at_points(robot.model(), indices.data(), indices.size(), points.data(),
                                                points.size(), constraints.owner_.put());
    return detail::finish(status, std::move(constraints));
}

}
}  // namespace robot_dynamics
