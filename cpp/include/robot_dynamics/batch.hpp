/// Quantities of many states.
#pragma once

#include <vector>

#include "robot.hpp"

namespace robot_dynamics {
ROBOT_DYNAMICS_NAMESPACE {

/// The memory and the threads for batches of one robot. Tables have one row for each state.
class Batch {
public:
    /// A batch. 0 threads select one for each core, 1 the calling thread alone.
    static Result<Batch> make(const Robot& robot, std::size_t threads = 0) {
        Batch batch;
        batch.nq_ = robot.nq();
        rd_status status = rd_batch_new(robot.model(), threads, batch.owner_.put());
        return detail::finish(status, std::move(batch));
    }

    /// M(q) of each state, states × nv × nv.
    Result<void> mass_matrix(View q, MutableView out) { return compute(RD_QUANTITY_MASS_MATRIX, q, out); }
    /// g(q) of each state, states × nv.
    Result<void> gravity_forces(View q, MutableView out) { return compute(RD_QUANTITY_GRAVITY, q, out); }
    /// C(q, v) v + g(q) of each state, states × nv.
    Result<void> bias(View q, View v, MutableView out) {
        rd_inputs inputs = states(q);
        inputs.v = v.data(), inputs.v_len = v.size();
        return compute(RD_QUANTITY_BIAS, inputs, out);
    }
    /// tau(q, v, a) of each state, states × nv.
    Result<void> inverse_dynamics(View q, View v, View a, MutableView out) {
        rd_inputs inputs = states(q);
        inputs.v = v.data(), inputs.v_len = v.size();
        inputs.a = a.data(), inputs.a_len = a.size();
        return compute(RD_QUANTITY_INVERSE_DYNAMICS, inputs, out);
    }
    /// a(q, v, tau) of each state, states × nv.
    Result<void> forward_dynamics(View q, View v, View tau, MutableView out) {
        rd_inputs inputs = states(q);
        inputs.v = v.data(), inputs.v_len = v.size();
        inputs.tau = tau.data(), inputs.tau_len = tau.size();
        return compute(RD_QUANTITY_FORWARD_DYNAMICS, inputs, out);
    }
    /// The poses of frames, states × frames × 12.
    Result<void> frame_poses(View q, const std::vector<Frame>& frames, MutableView out) {
        static_assert(sizeof(Frame) == sizeof(std::uint32_t), "a frame is its number");
        rd_inputs inputs = states(q);
        inputs.frames = reinterpret_cast<const std::uint32_t*>(frames.data());
        inputs.frames_len = frames.size();
        return compute(RD_QUANTITY_FRAME_POSES, inputs, out);
    }

    /// Any quantity of the table: see `rd_batch_compute`.
    Result<void> compute(rd_quantity quantity, const rd_inputs& inputs, const rd_results& results) {
        std::size_t count = nq_ == 0 ? 0 : inputs.q_len / nq_;
        return detail::finish(
            rd_batch_compute(owner_.get(), static_cast<std::uint32_t>(quantity), count, &inputs, &results));
    }

    rd_batch handle() const noexcept { return owner_.get(); }

private:
    static rd_inputs states(View q) {
        rd_inputs inputs{};
        inputs.q = q.data();
        inputs.q_len = q.size();
        return inputs;
    }

    Result<void> compute(rd_quantity quantity, View q, MutableView out) {
        return compute(quantity, states(q), out);
    }

    Result<void> compute(rd_quantity quantity, const rd_inputs& inputs, MutableView out) {
        rd_results results{};
        results.first = out.data();
        results.first_len = out.size();
        return compute(quantity, inputs, results);
    }

    detail::Owner<rd_batch, rd_batch_free> owner_;
    std::size_t nq_ = 0;
};

}
}  // namespace robot_dynamics
