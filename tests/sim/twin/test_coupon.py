"""The coupon: contours that fit the sheet, and what a scan of them shows of a twin."""

from dataclasses import replace

import numpy as np
import pytest

from armside.sim.laser import prepare
from armside.sim.robot.effects import gear_phases
from armside.sim.scan.virtual_reading import CALIBRATED, virtual_scan
from armside.sim.twin.commission import commission
from armside.sim.twin.coupon import SHEET, beam_path, coupon, coupon_cut, scanned
from armside.sim.twin.identification import Identification, identify, parameters_of
from armside.sim.twin.recordings import ImplausibleError, measured_from
from armside.sim.twin.scan_sensor import SCAN, ScanComparison, check_scanned
from armside.sim.twin.simulation import design_of

from .conftest import INDIVIDUAL

CHOSEN = "circle-cw", "slot-ccw"
EDGE = 6e-6
"""[m], of the residual that the edge of a cut leaves: 4 um of noise, 3 um correlated."""


@pytest.fixture(scope="module")
def design():
    return design_of("large", None)


@pytest.fixture(scope="module")
def cut():
    """Two contours of the coupon: their runs, and what a scan by those errors makes of them."""
    contours = {name: coupon()[name] for name in CHOSEN}
    runs, paths, times = {}, {}, {}
    for name, one in contours.items():
        experiment = prepare(replace(coupon_cut(one), individual=INDIVIDUAL))
        run = experiment.plant.run(np.zeros_like(experiment.loaded.reference))
        runs[name], paths[name] = run.recording, beam_path(one, experiment, run)
        times[name] = experiment.motion.contour_time

    def by(errors=CALIBRATED):
        scan = virtual_scan(paths, np.random.default_rng(3), errors)
        return [
            scanned(measured_from(runs[name], name), name, contours, scan, times[name])
            for name in contours
        ]

    return runs, by


def of_sheet(comparison):
    """Columns (K, e) of what is unknown of the sheet."""
    columns = comparison.by_kinematics()
    own = [columns[block.name][:, 0] for block in SCAN.own(comparison.cut)]
    return np.concatenate(own, axis=1)


def without(columns, residual):
    return residual - columns @ np.linalg.lstsq(columns, residual, rcond=1e-9)[0]


def rms(residual):
    return float(np.sqrt(np.mean(residual**2)))


def test_contours_lie_apart_within_the_sheet_and_are_cut_both_ways():
    for sheet in (SHEET, (0.1, 0.1)):
        boxes = []
        for one in coupon(sheet).values():
            points = one.curve.point(np.linspace(0.0, one.curve.length, 400)) + one.middle
            boxes.append((points.min(axis=0), points.max(axis=0)))
            assert (np.abs(points) < 0.5 * np.array(sheet)).all()
        for i, (low, high) in enumerate(boxes):
            for other_low, other_high in boxes[:i]:
                assert ((high < other_low) | (low > other_high)).any()
    assert sum(one.clockwise for one in coupon().values()) == len(coupon()) / 2
    with pytest.raises(ValueError, match=r"30 by 30 mm leaves 4.5 mm .* at least 8"):
        coupon((0.03, 0.03))


@pytest.mark.parametrize("name", coupon())
def test_a_contour_is_cut_at_its_speed_in_its_direction(name):
    one = coupon()[name]
    motion = prepare(coupon_cut(one)).motion
    assert motion.reached_speed == pytest.approx(one.speed)
    x, y = (motion.plane.from_base(motion.position[motion.on_contour])[:, i] for i in (0, 1))
    area = 0.5 * np.sum(x * np.gradient(y) - y * np.gradient(x))
    assert (area < 0.0) == one.clockwise


def test_a_scan_of_the_twins_own_run_leaves_the_edge_of_the_cut(cut, design):
    """The sheet lies a millimetre beside its place, which is the sheet's and not the robot's."""
    runs, by = cut
    for one in by():
        comparison = ScanComparison(design.model, one)
        residual = comparison.residual(runs[one.name])[:, 0]
        assert np.abs(residual).max() > 100e-6
        assert rms(without(of_sheet(comparison), residual)) < EDGE


def test_scale_beam_and_direction_of_the_kerf_are_no_errors_of_the_robot(cut, design):
    runs, by = cut
    worse = replace(CALIBRATED, scale=1e-3, skew=1e-3, direction=60e-6)
    for one in by(worse):
        comparison = ScanComparison(design.model, one)
        residual, columns = comparison.residual(runs[one.name])[:, 0], of_sheet(comparison)
        placed = columns[:, :3]  # place and turn of the sheet alone
        assert rms(without(placed, residual)) > 2.0 * EDGE
        assert rms(without(columns, residual)) < EDGE


def test_errors_of_geometry_show_as_their_columns_say(cut, design):
    _, by = cut
    parameters, phases = parameters_of(design), gear_phases(design.model)
    theta = parameters.mean.copy()
    theta[parameters.at("position").start + 7] = theta[parameters.at("orientation").start + 4] = (
        5e-4
    )
    one = by()[1]
    comparison = ScanComparison(design.model, one)
    twins = [parameters.individual(each, phases) for each in (parameters.mean, theta)]
    before, after = design.run(twins, one.reference, one.correction)
    change = (comparison.residual(before) - comparison.residual(after))[:, 0]
    columns = comparison.by_kinematics()
    expected = sum(
        columns[name][:, 0] @ theta[parameters.at(name)] for name in ("position", "orientation")
    )
    assert np.std(change) > 100e-6
    assert np.std(change - expected) < 0.02 * np.std(change)


def test_what_is_unknown_of_the_sheet_is_no_parameter_of_the_twin(cut):
    found = commission(cut[1](), measure="scan", cfg=Identification(steps=2, linearised=(0,)))
    assert found.twin.sensor == "scan"
    assert found.twin.theta.shape == (found.twin.parameters.size,)
    assert np.linalg.eigvalsh(found.twin.covariance).min() > 0.0
    assert (found.identified.within < 100e-6).all()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda seen: None, "is not on the scanned sheet"),
        (lambda seen: waved(seen, 3e-3), "2.1. mm RMS from its drawing .* more than 1 mm"),
    ],
)
def test_a_scan_of_something_else_is_refused_by_name(cut, design, change, said):
    one = cut[1]()[0]
    with pytest.raises(ImplausibleError, match=f"circle-cw.*{said}"):
        check_scanned(design.model, replace(one, scan=change(one.scan)))
    check_scanned(design.model, one)


def waved(seen, size):
    turn = 2.0 * np.pi * seen.contour.arc_length / seen.curve.length
    contour = replace(seen.contour, deviation=size * np.sin(4.0 * turn))
    return replace(seen, contour=contour)


def test_a_record_of_another_contour_is_refused_by_name(cut, design):
    one = cut[1]()[1]
    middle = one.motor_angle.mean(axis=0)
    larger = replace(one, motor_angle=middle + 1.3 * (one.motor_angle - middle))
    check_scanned(design.model, one)
    with pytest.raises(ImplausibleError, match=r"slot-ccw: the motors' path lies .* than 2 mm"):
        check_scanned(design.model, larger)


def test_two_scans_of_one_contour_are_refused(cut, design):
    one = cut[1]()[0]
    with pytest.raises(ValueError, match="scanned twice"):
        identify(design, [one, one], sensor=SCAN)
