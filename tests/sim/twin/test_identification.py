"""A twin explains the cuts that it was identified from, by sensitivities that are right."""

from dataclasses import replace

import numpy as np
import pytest

from armside.sim.robot.individual import embodied, structure_hinges
from armside.sim.twin.identification import Group, Identification, Solving
from armside.sim.twin.parameters import FRICTION as OF_FRICTION
from armside.sim.twin.parameters import MASS, Parameters
from armside.sim.twin.recordings import measured
from armside.sim.twin.sensitivities import Against

UNEXPLAINED, UNEXPLAINED_BY_KINEMATICS = 0.35, 0.65
"""Largest part of a small change that sensitivities may miss: they are of first order, and those
to geometry leave out that gravity then loads the springs in another way."""
FRICTION = ("ripple", "viscous", "friction", "static", "stribeck", "bristle")


def test_identification_explains_torque_and_tool(twin, passes):
    """Of two cuts, three steps from the design: more cuts and steps leave less."""
    for run in passes:
        against = Against(twin.design, twin.parameters, measured(run))
        before, after = against.residuals(twin.parameters.mean), against.residuals(twin.theta)
        for residual, share in (("tool", 0.5), ("torque", 0.4)):
            rms = [np.sqrt(np.mean(getattr(of, residual) ** 2)) for of in (after, before)]
            assert rms[0] < share * rms[1], residual


def test_sensitivities_predict_small_changes_of_every_block(around):
    against, theta, before, columns = around
    parameters, rng = against.parameters, np.random.default_rng(1)
    for block in parameters.blocks:
        change, at = np.zeros(parameters.size), parameters.at(block.name)
        change[at] = 0.05 * parameters.standard_deviation[at] * rng.standard_normal(block.size)
        after = against.residuals(theta + change)
        sensor = "torque" if block.name.startswith(FRICTION) else "tool"
        moved = getattr(before, sensor) - getattr(after, sensor)
        unexplained = np.linalg.norm(moved - getattr(columns, sensor) @ change)
        kinematic = block.name in ("gear_error", "position", "orientation")
        allowed = UNEXPLAINED_BY_KINEMATICS if kinematic else UNEXPLAINED
        assert unexplained < allowed * np.linalg.norm(moved), block.name


def test_a_held_out_cut_is_explained_worse_than_the_others_and_is_explained(commissioned):
    quality = commissioned.identified
    assert (quality.held_out >= quality.within).all()
    assert quality.held_out.max() < 100e-6  # the design leaves 100 to 400 um


def test_a_parameter_that_nothing_depends_on_keeps_its_prior(commissioned):
    parameters, found = commissioned.twin.parameters, commissioned.identified
    std = np.sqrt(np.diag(found.covariance))
    assert (std <= parameters.standard_deviation * (1.0 + 1e-9)).all()
    assert ((found.theta >= parameters.lower) & (found.theta <= parameters.upper)).all()


def test_a_compliance_softens_its_own_hinge(twin):
    design, parameters = twin.design, twin.parameters
    names = [design.nominal.mj.joint(i).name for i in structure_hinges(design.nominal)]
    stiff = embodied(design.model, _factors(twin, parameters.mean), (), phi=np.zeros(6))
    entries = range(parameters.size)[parameters.at("structure_stiffness")]
    for name, entry in zip(names, entries, strict=True):
        theta = parameters.mean
        theta[entry] = 0.5
        soft = embodied(design.model, _factors(twin, theta), (), phi=np.zeros(6))
        changed = np.flatnonzero(soft.mj.jnt_stiffness != stiff.mj.jnt_stiffness)
        assert [design.model.mj.joint(i).name for i in changed] == [name]
        # half as much again of the deflection under the same load
        ratio = stiff.mj.jnt_stiffness[changed] / soft.mj.jnt_stiffness[changed]
        np.testing.assert_allclose(ratio, 1.5)


def _factors(twin, theta):
    return replace(twin.parameters.individual(theta, twin.gear_phase), hidden=())


def test_a_step_is_the_least_squares_solution_of_data_and_prior_together():
    """With scales that are known: rows over their scale, and the distance from the prior's mean."""
    rng, parameters = np.random.default_rng(3), Parameters((*OF_FRICTION, MASS))
    m, scale = parameters.size, np.array([0.5, 2.0])
    theta = parameters.mean + 0.1 * parameters.standard_deviation * rng.standard_normal(m)
    A, b = rng.standard_normal((2, 20, m)), 0.02 * rng.standard_normal((2, 20))
    groups = [Group(a.T @ a, a.T @ y, float(y @ y), len(y)) for a, y in zip(A, b, strict=True)]
    change, covariance = Solving(parameters, theta, scale, np.zeros(2)).solve(groups)
    prior = np.diag(1.0 / parameters.standard_deviation)
    rows = np.vstack([*(A / scale[:, None, None]), prior])
    right = np.concatenate([*(b / scale[:, None]), prior @ (parameters.mean - theta)])
    expected = np.linalg.lstsq(rows, right)[0]
    assert ((theta + expected > parameters.lower) & (theta + expected < parameters.upper)).all()
    np.testing.assert_allclose(change, expected, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(covariance, np.linalg.inv(rows.T @ rows), rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize("block", [*OF_FRICTION, MASS], ids=lambda block: block.name)
def test_bounds_of_torque_parameters_leave_three_standard_deviations_to_either_side(block):
    """Or none is set; a prior is as wide for one number of the friction law as for another."""
    assert 3.0 * block.prior <= min(block.upper, -block.lower)
    if block is not MASS and np.isfinite(block.upper):
        assert block.prior == OF_FRICTION[0].prior


def test_the_first_step_simulates_what_torque_depends_on_alone(around):
    """Its solution reads no sensitivity of the tool."""
    against, theta, _, whole = around
    _, of_torque = against.linearised(theta, tool=False)
    np.testing.assert_array_equal(of_torque.torque, whole.torque)
    assert not of_torque.tool.any()


def test_the_covariance_is_that_of_the_last_step():
    assert max(Identification().linearised) == Identification().steps - 1


@pytest.mark.parametrize(
    ("steps", "linearised", "first"), [(6, (0, 1), False), (6, (0, 3), True), (1, (0, 1), True)]
)
def test_the_first_step_knows_the_tool_unless_the_second_looks_anew(steps, linearised, first):
    cfg = Identification(steps=steps, linearised=linearised)
    assert [cfg.of_tool(step) for step in range(2)] == [first, True]
