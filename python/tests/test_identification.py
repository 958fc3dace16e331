"""Joint terms, consistent estimates, exciting motions and payloads."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

import robot_dynamics as rd
from conftest import states

Array = NDArray[np.float64]

TERMS = ("damping", "friction")
ACCELERATION = [15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0]


@pytest.fixture(scope="module")
def panda() -> rd.Robot:
    return rd.example("panda")


def motion(n: int, seed: int = 1) -> tuple[Array, Array, Array]:
    random = np.random.default_rng(seed)
    q = random.uniform(-1.0, 1.0, (n, 7)) + [0, 0, 0, -1.6, 0, 1.9, 0]
    return q, random.uniform(-2.0, 2.0, (n, 7)), random.uniform(-5.0, 5.0, (n, 7))


def test_joint_terms_are_identified_by_name(panda: rd.Robot) -> None:
    q, v, a = motion(200)
    tau = panda.inverse_dynamics(q, v, a) + panda.dissipation(v) + 0.4 * v + 0.7 * np.sign(v)
    terms = ("damping", "panda_joint2.friction", "friction")[:2]
    base = panda.base_parameters(terms=terms)
    assert sum(name.endswith(".damping") for name in base.names) == 7 and base.names[-1] == "panda_joint2.friction"
    tau[:, [0, 2, 3, 4, 5, 6]] -= 0.7 * np.sign(v[:, [0, 2, 3, 4, 5, 6]])
    found = panda.identify(q, v, a, tau, base, terms=terms, noise=np.full(7, 0.1))
    own = [joint.passive.damping for joint in panda.joints if joint.kind == "revolute"]
    assert_allclose(found.values[-8:-1], np.add(own, 0.4), rtol=0, atol=1e-9)
    friction = next(joint.passive.friction for joint in panda.joints if joint.name == "panda_joint2")
    assert found.values[-1] == pytest.approx(friction + 0.7, abs=1e-9)
    assert_allclose(np.sqrt(np.diag(found.covariance)), found.standard_deviations, rtol=1e-9)
    assert found.residuals.shape == (7,) and found.weakest[0][0] in "".join(base.names)
    assert len(base.hidden) == 78 - len(base)
    with pytest.raises(rd.IdentificationError, match="no joint term `stiction`"):
        panda.identify(q, v, a, tau, terms=("stiction",))
    with pytest.raises(rd.IdentificationError, match="elbow"):
        panda.base_parameters(terms=("elbow.friction",))


def test_base_rows_with_contact_forces_need_no_joint_torques() -> None:
    robot = rd.example("quadruped", floating_base=True)
    s = states(robot, 150, seed=2)
    foot = robot.frame_names[-1]
    wrench = np.random.default_rng(3).uniform(-30.0, 30.0, (150, 6))
    jacobian = robot.frame_jacobian(s.q, foot, reference_frame="local")
    tau = robot.inverse_dynamics(s.q, s.v, s.a) - np.einsum("nij,ni->nj", jacobian, wrench)
    tau[:, 6:] = np.nan
    noise = np.full(robot.nv, np.inf)
    noise[:6] = 1.0
    found = robot.identify(s.q, s.v, s.a, tau, dissipation=False, noise=noise, wrenches={foot: wrench})
    assert len(found.base) == len(robot.base_parameters())
    true = found.base.values(robot.inertial_parameters)
    assert_allclose(found.values, true, rtol=0, atol=1e-7 * np.abs(true).max())
    assert np.isnan(found.residuals[6:]).all()


def test_consistent_estimates_are_bodies(panda: rd.Robot) -> None:
    real = panda.with_payload("panda_link8", 1.3, [0.03, 0.0, 0.08], np.diag([4e-3, 4e-3, 2e-3]))
    q, v, a = motion(60)
    tau = real.inverse_dynamics(q, v, a) + 0.4 * v + 0.7 * np.sign(v)
    tau += np.random.default_rng(4).normal(0.0, 0.5, tau.shape)
    hold = ["panda_link1"]
    found = panda.identify_consistent(
        q, v, a, tau, dissipation=True, terms=TERMS, noise=np.full(7, 0.5), hold=hold,
        joint_nominals={"damping": 0.5, "friction": 0.5},
    )
    assert all(link.is_consistent for link in panda.physical_consistency(found.parameters[:70]))
    assert_allclose(found.parameters[:10], panda.inertial_parameters[:10], rtol=0, atol=0)
    assert found.divergences[0] == 0.0 and (found.divergences[1:] > 0.0).all()
    assert (found.parameters[70:] > 0.0).all() and found.names[70] == "panda_joint1.damping"
    assert 0.85 < found.residual < 1.05 and found.effective_parameters < 60
    q, v, a = motion(50, seed=9)
    truth = real.inverse_dynamics(q, v, a)
    error = np.sqrt(np.mean((found.robot.inverse_dynamics(q, v, a) - truth) ** 2))
    by_file = np.sqrt(np.mean((panda.inverse_dynamics(q, v, a) - truth) ** 2))
    assert error < 0.5 and error < 0.3 * by_file
    assert found.robot.joints[1].passive.damping > 0.0
    with pytest.raises(rd.IdentificationError, match="nominal value of"):
        panda.identify_consistent(q, v, a, truth, terms=("armature",))
    with pytest.raises(rd.IdentificationError, match="regularization"):
        panda.identify_consistent(q, v, a, truth, regularization=0.0)


def test_designed_motions_stay_inside_their_limits(panda: rd.Robot) -> None:
    found = panda.design_excitation(8.0, 3, acceleration=ACCELERATION, terms=TERMS, steps=8, samples=24)
    t = np.linspace(0.0, 8.0, 500)
    q, v, a = found.series.evaluate(t)
    limits = panda.limits
    assert (q >= limits.lower).all() and (q <= limits.upper).all() and (np.abs(v) <= limits.velocity).all()
    assert (np.abs(a) <= ACCELERATION).all()
    tau = panda.inverse_dynamics(q, v, a) + panda.dissipation(v)
    assert (np.abs(tau) <= limits.effort).all() and 0.5 < found.usage <= 1.0
    assert_allclose(np.vstack([v[[0, -1]], a[[0, -1]]]), 0.0, atol=1e-11)
    assert_allclose(np.gradient(q, t, axis=0)[1:-1], v[1:-1], rtol=0, atol=2e-2)
    assert_allclose(np.gradient(v, t, axis=0)[1:-1], a[1:-1], rtol=0, atol=5e-2)
    again = panda.design_excitation(8.0, 3, acceleration=ACCELERATION, terms=TERMS, steps=8, samples=24)
    assert_allclose(again.series.sines, found.series.sines, rtol=0, atol=0)
    with pytest.raises(rd.IdentificationError, match="criterion"):
        panda.design_excitation(8.0, 3, criterion="best")
    with pytest.raises(rd.IdentificationError, match="torque limits"):
        panda.design_excitation(8.0, 3, torque=np.full(7, 0.1))


def test_payloads_are_found_while_the_robot_moves(panda: rd.Robot) -> None:
    loaded = panda.with_payload("panda_link8", 1.5, [0.01, 0.02, 0.1], np.diag([0.01, 0.02, 0.015]))
    payload = rd.PayloadEstimator(panda, "panda_link8", np.full(7, 0.1), forgetting=0.99)
    assert len(payload) == 0
    random = np.random.default_rng(5)
    for q, v, a in zip(*motion(400), strict=True):
        payload.push(q, v, a, loaded.inverse_dynamics(q, v, a) + random.normal(0.0, 0.1, 7))
    body = payload.payload()
    assert abs(body.mass - 1.5) < 4.0 * body.mass_deviation < 0.05
    assert (np.abs(body.center_of_mass - [0.01, 0.02, 0.1]) < 4.0 * body.center_of_mass_deviation).all()
    assert body.inertia.shape == (3, 3) and payload.covariance.shape == (10, 10) and len(payload) == 400
    assert payload.parameters[0] == body.mass
    payload.reset()
    assert not payload.parameters.any()
    known = rd.PayloadEstimator(
        panda, "panda_link8", np.full(7, 0.1), prior=[1.0, *[0.0] * 9], offsets=np.zeros(7)
    )
    assert known.parameters[0] == pytest.approx(1.0)
    with pytest.raises(rd.IdentificationError, match="forgetting"):
        rd.PayloadEstimator(panda, "panda_link8", np.full(7, 0.1), forgetting=0.0)
    with pytest.raises(rd.IdentificationError, match="moving link"):
        rd.PayloadEstimator(panda, "panda_link0", np.full(7, 0.1))
    with pytest.raises(rd.ShapeError):
        payload.push(np.zeros(6), np.zeros(7), np.zeros(7), np.zeros(7))


def test_stribeck_velocities_and_a_tilted_base_are_found(panda: rd.Robot) -> None:
    q, v, a = motion(250)
    v /= 2.0
    tilted = panda.with_parameters([*panda.parameters()[:-3], 0.6, -0.3, -np.sqrt(9.81**2 - 0.6**2 - 0.3**2)])
    tau = tilted.inverse_dynamics(q, v, a) + np.sign(v) * (0.5 + 0.8 * np.exp(-((v / 0.3) ** 2)))
    tau += np.random.default_rng(6).normal(0.0, 0.02, tau.shape)
    nominals, noise, start = {"friction": 1.0, "stribeck": 1.0}, np.full(7, 0.02), np.full(7, 0.15)
    found = panda.identify_nonlinear(
        q, v, a, tau, stribeck_velocities=start, gravity_direction=True, joint_nominals=nominals,
        terms=("friction",), noise=noise, dissipation=False,
    )
    deviations = found.standard_deviations
    assert (np.abs(np.log(found.stribeck_velocities / 0.3)) < 5.0 * deviations[:7]).all() and deviations.shape == (9,)
    assert_allclose(found.gravity, tilted.gravity_vector, rtol=0, atol=2e-2)
    assert_allclose(found.linear.robot.gravity_vector, found.gravity, rtol=0, atol=1e-15)
    assert 0.9 < found.linear.residual < 1.1 and found.linear.names[-1] == "panda_joint7.stribeck"
    with pytest.raises(rd.IdentificationError, match="Stribeck"):
        panda.identify_nonlinear(q, v, a, tau, terms=("friction",), joint_nominals=nominals)
