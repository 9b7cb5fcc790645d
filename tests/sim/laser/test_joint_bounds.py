"""Speeds of a plan keep the limits of joints and drives, and lose no more than they must."""

import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from armside.sim.laser import joint_bounds
from armside.sim.laser.experiment import prepare
from armside.sim.laser.joint_bounds import DRIVE, JointBounds
from armside.sim.laser.part_cut import PartCut
from armside.sim.motion import speed_profile
from armside.sim.motion.tool_motion import joint_reference
from armside.sim.part import plan as plan_module
from armside.sim.part.arcs import arc, joined, line
from armside.sim.part.beam_path import smooth
from armside.sim.part.drawing import DrawnChain, Reading
from armside.sim.part.part import part_of, read_part
from armside.sim.part.plan import Cutting
from armside.sim.robot.kinematics_check import cell_model
from armside.sim.robot.statics import Statics

W, H, R = 0.3, 0.08, 5e-3
OUTLINE = smooth(line((0.0, 0.0), (W, 0.0), (W, H), (0.0, H), (0.0, 0.0)), R)


@pytest.fixture(scope="module")
def outline():
    part = part_of([DrawnChain(joined([OUTLINE]), "outline", "")])
    return PartCut(part=part, cutting=Cutting(speed=0.167), pose="p2")


def test_limits_that_are_not_reached_cost_an_outline_nothing(outline):
    """The profile is that without a robot, of which tests of profiles say how fast it is."""
    (cut,), (free,) = outline.plan.cuts, plan_module.plan(outline.part, outline.cutting).cuts
    np.testing.assert_allclose(cut.profile.speed, free.profile.speed, rtol=1e-6)
    assert cut.profile.speed.max() == pytest.approx(0.167)


def test_no_limit_of_a_joint_or_a_drive_is_passed_in_the_run(outline):
    experiment = prepare(outline)
    run = experiment.plant.run(np.zeros_like(experiment.loaded.reference)).recording
    cell, drives = experiment.cut.cell, experiment.nominal.drives
    speed = np.gradient(run.truth.gear_angle, run.truth.time, axis=0)
    assert (np.abs(speed) <= 1.01 * np.array(cell.limits.speed)).all()
    assert (np.abs(run.motor_torque) <= 0.99 * drives.torque_limit).all()
    assert run.limits_hit == ()


def test_a_slow_joint_lowers_the_speed_where_it_needs_to(outline):
    """The profile keeps the programmed path within 1 % of the speeds of its joints, and uses them.

    The anticipated deflection is on top of it: nine per cent of limits that are as low as these.
    """
    cell = outline.cell
    slow = replace(cell.limits, speed=tuple(0.04 * v for v in cell.limits.speed))
    limited = replace(outline, robot=replace(cell, limits=slow))
    (cut,), (free,) = limited.plan.cuts, outline.plan.cuts
    assert cut.seconds > 1.05 * free.seconds
    phi = joint_reference(limited.motion, cell.robot, slow)
    use = np.abs(np.gradient(phi, limited.motion.step, axis=0)) / np.array(slow.speed)
    assert use.max() <= 1.01
    assert use.max() >= 0.95


def test_friction_takes_its_part_of_each_drive_at_the_motor(outline):
    """Of the motor: Coulomb friction and viscous friction times its speed, all through the gear."""
    model = cell_model(outline.cell, None)
    drives = replace(model.drives, viscous_friction=np.full(6, 2e-3))  # of the assets: 0 to 4e-3
    bounds = JointBounds(outline, Statics(model), outline.plane, outline.part.middle, speed=0.1)
    slope = np.array([[0.4, -0.3, 0.2, 0.1, -0.2, 0.3]])
    motor_speed = np.abs(drives.gear * slope * 0.1)
    at_motor = DRIVE * drives.torque_limit - drives.coulomb_friction - 2e-3 * motor_speed
    expected = np.abs(drives.gear) * at_motor
    np.testing.assert_allclose(bounds._available(drives, slope), expected, rtol=1e-12)


def test_a_plan_is_refused_where_a_joint_leaves_its_range(outline):
    """At planning, before anything runs."""
    limits = outline.cell.limits
    phi = joint_reference(outline.motion, outline.cell.robot, limits)
    first = float(np.quantile(phi[:, 0], 0.8))
    upper = (first, *limits.upper[1:])
    narrow = replace(outline, robot=replace(outline.cell, limits=replace(limits, upper=upper)))
    there = r"leaves the joint limits .* at \(-?[\d.]+, -?[\d.]+\) mm: motor 1 "
    with pytest.raises(ValueError, match=there):
        _ = narrow.plan


@pytest.mark.parametrize("share", [1.0, 0.5])
def test_drives_that_can_only_just_hold_the_arm_limit_a_plan(outline, share):
    """With half of their torque, axes 2 and 3 spend more than 70 % of it on gravity."""
    model = cell_model(outline.cell, None)
    drives = replace(model.drives, torque_limit=share * model.drives.torque_limit)
    bounds = joint_bounds.JointBounds(
        outline, Statics(replace(model, drives=drives)), outline.plane, outline.part.middle, 0.1
    )
    (limit,) = bounds.along([joined([line((0.0, 0.0), (W, 0.0))])])
    assert (limit is None) == (share == 1.0)
    if limit is not None:
        found, acceleration = limit(np.linspace(0.0, W, 20)), outline.limits.acceleration
        used = acceleration * np.abs(found.along) + np.abs(found.offset)
        by_drive = (used + 0.1**2 * np.abs(found.bend)).max(axis=0)[6:]
        assert by_drive.argmax() == 1
        assert by_drive.max() > 1.0
        assert np.abs(found.offset[:, 7:9]).max(axis=0).min() > 0.7


@pytest.mark.parametrize("speed", [0.1, 0.16])
def test_a_part_near_a_singularity_of_the_wrist_has_a_plan(speed):
    file = Path(__file__).parents[3] / "docs/examples/bracket.dxf"
    part = read_part(file, Reading(layers=("CUT",)))
    found = PartCut(part=part, cutting=Cutting(speed=speed), pose="p1").plan
    for cut in found.cuts:
        assert (cut.profile.speed <= cut.profile.allowed.max() * (1.0 + 1e-6)).all()


def holes(count):
    """A sheet with round holes of different radii, in rows of ten."""
    radii = np.linspace(1.5e-3, 4e-3, count)
    places = [0.01 * np.array(divmod(i, 10)) + 0.006 for i in range(count)]
    rows = [arc(at, radius, 0.0, 2.0 * np.pi) for at, radius in zip(places, radii, strict=True)]
    size = 0.01 * np.ceil(count / 10) + 0.012
    frame = line((0.0, 0.0), (size, 0.0), (size, 0.112), (0.0, 0.112), (0.0, 0.0))
    return part_of([DrawnChain(one, f"{i}", "") for i, one in enumerate([frame, *rows])])


def sheet(count):
    return PartCut(part=holes(count), cutting=Cutting(speed=0.1), pose="p1")


def test_paths_have_the_same_limits_together_as_alone(monkeypatch):
    monkeypatch.setattr(joint_bounds, "TOGETHER", 100)
    found = [cut.path for cut in sheet(6).plan.cuts]
    cut = sheet(6)
    controller = Statics(cell_model(cut.cell, None))
    bounds = joint_bounds.JointBounds(cut, controller, cut.plane, cut.part.middle, 0.1)
    s = np.linspace(0.0, 0.005, 20)
    limited = 0
    for path, together in zip(found, bounds.along(found), strict=True):
        (alone,) = bounds.along([path])
        assert (together is None) == (alone is None)
        if together is not None and alone is not None:
            limited += 1
            for name in ("speed", "along", "bend", "offset"):
                np.testing.assert_array_equal(getattr(together(s), name), getattr(alone(s), name))
    assert limited > 0


def test_memory_of_a_plan_does_not_grow_with_its_contours(monkeypatch):
    """The peak above what the plan itself keeps; joints limit each of the different holes."""
    monkeypatch.setattr(plan_module, "TOGETHER", 8)
    monkeypatch.setattr(joint_bounds, "TOGETHER", 500)
    monkeypatch.setattr(speed_profile, "TOGETHER", 500)
    sheet(2).plan  # noqa: B018 - compiled functions are loaded
    above = []
    for count in (15, 45):
        cut = sheet(count)
        tracemalloc.start()
        made = cut.plan
        kept, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert len(made.cuts) == count + 1
        above.append(peak - kept)
    assert above[1] < 1.2 * above[0]
