"""
Robot dynamics by the C interface of robot-dynamics.

The environment variable `ROBOT_DYNAMICS_LIBRARY` has the path of `librobot_dynamics.so`; without it the
system's loader searches. Units are SI. A `Robot` serves one call at a time: load one for each task.
"""
module RobotDynamics

export Robot, RobotDynamicsError
export coordinate_names, neutral, gravity, mass_matrix, inverse_dynamics, forward_dynamics

const library = get(ENV, "ROBOT_DYNAMICS_LIBRARY", "librobot_dynamics")

"A handle of a model, as in C."
struct Model
    id::UInt64
end

"A handle of a workspace, as in C."
struct Workspace
    id::UInt64
end

"The options of loading, as in C."
struct LoadOptions
    floating_base::Int32
    strict::Int32
    repair_inertia::Int32
    confined::Int32
    package_path::Cstring
    srdf::Cstring
end

"The status and the text of a failed call."
struct RobotDynamicsError <: Exception
    status::Int32
    message::String
end

Base.showerror(io::IO, error::RobotDynamicsError) = print(io, "RobotDynamicsError: ", error.message)

"Throws the error of a call. Nothing lets another task onto the thread before its text is read."
function check(status::Int32)
    status == 0 && return nothing
    throw(RobotDynamicsError(status, unsafe_string(ccall((:rd_error_message, library), Cstring, ()))))
end

"""
    Robot(path; floating_base = false)

The robot of a URDF, MJCF, SDF or USD file.
"""
mutable struct Robot
    model::Model
    workspace::Workspace
    nq::Int
    nv::Int

    function Robot(path::AbstractString; floating_base::Bool = false)
        options = Ref(LoadOptions(floating_base, 0, 0, 0, Cstring(C_NULL), Cstring(C_NULL)))
        model = Ref(Model(0))
        workspace = Ref(Workspace(0))
        check(ccall((:rd_load, library), Int32, (Cstring, Ref{LoadOptions}, Ref{Model}), path, options, model))
        status = ccall((:rd_workspace_new, library), Int32, (Model, Ref{Workspace}), model[], workspace)
        if status != 0
            ccall((:rd_model_free, library), Int32, (Model,), model[])
            check(status)
        end
        nq = ccall((:rd_model_nq, library), Csize_t, (Model,), model[])
        nv = ccall((:rd_model_nv, library), Csize_t, (Model,), model[])
        return finalizer(free, new(model[], workspace[], nq, nv))
    end
end

function free(robot::Robot)
    ccall((:rd_workspace_free, library), Int32, (Workspace,), robot.workspace)
    ccall((:rd_model_free, library), Int32, (Model,), robot.model)
    return nothing
end

"The names of the coordinates of v."
function coordinate_names(robot::Robot)
    name(k) = ccall((:rd_model_coordinate_name, library), Cstring, (Model, Csize_t), robot.model, k)
    return GC.@preserve robot [unsafe_string(name(k)) for k in 0:(robot.nv - 1)]
end

"The neutral configuration: zeros, and identity quaternions."
function neutral(robot::Robot)
    q = zeros(robot.nq)
    GC.@preserve robot check(
        ccall((:rd_neutral, library), Int32, (Model, Ptr{Cdouble}, Csize_t), robot.model, q, length(q)))
    return q
end

"g(q)"
function gravity(robot::Robot, q::Vector{Float64})
    g = zeros(robot.nv)
    GC.@preserve robot check(
        ccall((:rd_gravity, library), Int32, (Workspace, Ptr{Cdouble}, Csize_t, Ptr{Cdouble}, Csize_t),
              robot.workspace, q, length(q), g, length(g)))
    return g
end

"M(q). It is symmetric, so that its rows are also the columns that Julia stores."
function mass_matrix(robot::Robot, q::Vector{Float64})
    mass = zeros(robot.nv, robot.nv)
    GC.@preserve robot check(
        ccall((:rd_mass_matrix, library), Int32, (Workspace, Ptr{Cdouble}, Csize_t, Ptr{Cdouble}, Csize_t),
              robot.workspace, q, length(q), mass, length(mass)))
    return mass
end

"tau = M(q) a + C(q, v) v + g(q)"
function inverse_dynamics(robot::Robot, q::Vector{Float64}, v::Vector{Float64}, a::Vector{Float64})
    tau = zeros(robot.nv)
    GC.@preserve robot check(
        ccall((:rd_inverse_dynamics, library), Int32,
              (Workspace, Ptr{Cdouble}, Csize_t, Ptr{Cdouble}, Csize_t, Ptr{Cdouble}, Csize_t, Ptr{Cdouble},
               Csize_t),
              robot.workspace, q, length(q), v, length(v), a, length(a), tau, length(tau)))
    return tau
end

"a = M(q)⁻¹ (tau − C(q, v) v − g(q))"
function forward_dynamics(robot::Robot, q::Vector{Float64}, v::Vector{Float64}, tau::Vector{Float64})
    a = zeros(robot.nv)
    GC.@preserve robot check(
        ccall((:rd_forward_dynamics, library), Int32,
              (Workspace, Ptr{Cdouble}, Csize_t, Ptr{Cdouble}, Csize_t, Ptr{Cdouble}, Csize_t, Ptr{Cdouble},
               Csize_t),
              robot.workspace, q, length(q), v, length(v), tau, length(tau), a, length(a)))
    return a
end

end # module
