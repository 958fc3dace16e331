# julia integrations/julia/test.jl
using LinearAlgebra
using Test

include("RobotDynamics.jl")
using .RobotDynamics

const robots = joinpath(@__DIR__, "..", "..", "robots")

@testset "forward dynamics inverts inverse dynamics" begin
    robot = Robot(joinpath(robots, "panda.urdf"))
    q = collect(range(-1.0, 1.0, length = robot.nq))
    v = collect(range(1.0, 2.0, length = robot.nv))
    a = collect(range(-3.0, 2.0, length = robot.nv))
    tau = inverse_dynamics(robot, q, v, a)
    mass = mass_matrix(robot, q)
    # The condition number of M, 1e4 or less, amplifies rounding of 1e-16.
    @test forward_dynamics(robot, q, v, tau) ≈ a atol = 1e-10
    @test isposdef(Symmetric(mass))
    @test mass ≈ mass' atol = 1e-14
    @test mass * a + inverse_dynamics(robot, q, v, zero(a)) ≈ tau atol = 1e-11
    @test inverse_dynamics(robot, q, zero(v), zero(a)) ≈ gravity(robot, q) atol = 1e-12
    @test length(coordinate_names(robot)) == 7
end

@testset "a floating base has six more coordinates" begin
    path = joinpath(robots, "quadruped.urdf")
    fixed, floating = Robot(path), Robot(path, floating_base = true)
    @test floating.nv == fixed.nv + 6
    @test norm(neutral(floating)[4:7]) == 1.0
end

@testset "invalid calls are errors" begin
    robot = Robot(joinpath(robots, "panda.urdf"))
    @test_throws RobotDynamicsError gravity(robot, zeros(3))
    @test_throws RobotDynamicsError gravity(robot, fill(NaN, 7))
    @test_throws RobotDynamicsError Robot("no/such/file.urdf")
end
