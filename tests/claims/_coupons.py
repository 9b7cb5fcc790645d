"""Coupons cut by a robot individual and scanned, and the twins that are made of them."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser.experiment import prepare
from armside.sim.robot.spread import Drawn
from armside.sim.scan.virtual_reading import BeamPath, ScanErrors, virtual_scan
from armside.sim.twin.commission import commission
from armside.sim.twin.coupon import beam_path, coupon, coupon_cut, scanned
from armside.sim.twin.recordings import MeasuredCut, measured_from
from armside.sim.twin.twin import Twin

from ._twins import commissioning_cuts


def coupon_cuts(robot: Drawn, errors: ScanErrors, seed: int) -> list[MeasuredCut]:
    """Motors of each contour of a coupon, with what one scan of the sheet says of it."""
    contours, logs = coupon(), dict[str, MeasuredCut]()
    paths, times = dict[str, BeamPath](), dict[str, tuple[float, float]]()
    for i, (name, one) in enumerate(contours.items()):
        experiment = prepare(replace(coupon_cut(one), individual=robot), seed=seed + i)
        run = experiment.plant.run(np.zeros_like(experiment.loaded.reference))
        logs[name] = measured_from(run.recording, name)
        paths[name], times[name] = beam_path(one, experiment, run), experiment.motion.contour_time
    scan = virtual_scan(paths, np.random.default_rng([seed, robot.number]), errors)
    return [scanned(logs[name], name, contours, scan, times[name]) for name in contours]


def twin_of(robot: Drawn, n_imu: int, errors: ScanErrors | None, seed: int) -> Twin:
    """Twin of some cuts by IMU and of one coupon, if it has errors."""
    cuts: Sequence[MeasuredCut] = commissioning_cuts(robot, n_imu, ImuCfg()) if n_imu else []
    sheet = [] if errors is None else coupon_cuts(robot, errors, seed)
    return commission([*cuts, *sheet], measure="imu" if n_imu else "scan").twin
