/// Inertial parameters from measured motions.
#pragma once

#include <string>
#include <vector>

#include "robot.hpp"

namespace robot_dynamics {
ROBOT_DYNAMICS_NAMESPACE {

/// A base parameter: a combination of parameters that the motions determine.
struct BaseParameter {
    /// The name of the parameter that names it.
    std::string name;
    double value;
    double standard_deviation;
};

/// Estimated base parameters.
struct IdentificationResult {
    std::vector<BaseParameter> parameters;
    /// The root mean square of the torques' errors.
    double residual;
};

/// Parameters with which every link is a possible body.
struct ConsistentEstimate {
    /// The inertial parameters, then those of the joints.
    Vector parameters;
    double residual;
    /// The robot with these parameters.
    Robot robot;
};

/// A record of measured motions.
class MotionRecord {
public:
    /// An empty record. `joint_terms` are bits of `RD_TERM_…`.
    static Result<MotionRecord> make(const Robot& robot, bool dissipation = false, std::uint32_t joint_terms = 0) {
        MotionRecord record;
        rd_status status = rd_motion_record_new(robot.model(), dissipation, joint_terms, record.owner_.put());
        return detail::finish(status, std::move(record));
    }
    /// States the standard deviation of the noise of each torque [N m or N].
    Result<void> set_noise(View deviations) {
        return detail::finish(rd_motion_record_set_noise(owner_.get(), deviations.data(), deviations.size()));
    }
    /// Adds a state, its acceleration and the measured torque.
    Result<void> push(View q, View v, View a, View tau) {
        return detail::finish(rd_motion_record_push(owner_.get(), q.data(), q.size(), v.data(), v.size(), a.data(),
                                                    a.size(), tau.data(), tau.size()));
    }
    /// The names of all parameters.
    std::vector<std::string> parameter_names() const {
        std::vector<std::string> names;
        for (std::size_t k = 0; k < rd_motion_record_parameter_count(owner_.get()); ++k) {
            names.push_back(detail::text(rd_motion_record_parameter_name(owner_.get(), k)));
        }
        return names;
    }
    /// Estimates the base parameters by least squares.
    Result<IdentificationResult> identify() const {
        std::size_t capacity = rd_motion_record_parameter_count(owner_.get()), count = 0;
        std::vector<std::uint32_t> indices(capacity);
        Vector values(capacity), deviations(capacity);
        IdentificationResult out{{}, 0.0};
        rd_status status = rd_identify(owner_.get(), indices.data(), values.data(), deviations.data(), capacity,
                                       &count, &out.residual);
        for (std::size_t k = 0; status == RD_STATUS_OK && k < count; ++k) {
            std::string name = detail::text(rd_motion_record_parameter_name(owner_.get(), indices[k]));
            out.parameters.push_back({name, values[k], deviations[k]});
        }
        return detail::finish(status, std::move(out));
    }
    /// Estimates parameters with which every link is a possible body.
    Result<ConsistentEstimate> identify_consistent(double regularization = 1e-3) const {
        Vector parameters(rd_motion_record_parameter_count(owner_.get()));
        double residual = 0.0;
        rd_model model{0};
        rd_status status = rd_identify_consistent(owner_.get(), regularization, parameters.data(),
                                                  parameters.size(), &residual, &model);
#ifdef ROBOT_DYNAMICS_NO_EXCEPTIONS
        if (status != RD_STATUS_OK) {
            return Error(status);
        }
        return ConsistentEstimate{std::move(parameters), residual, *Robot::from_handle(model)};
#else
        detail::finish(status);
        return ConsistentEstimate{std::move(parameters), residual, Robot::from_handle(model)};
#endif
    }

private:
    detail::Owner<rd_motion_record, rd_motion_record_free> owner_;
};

}
}  // namespace robot_dynamics
