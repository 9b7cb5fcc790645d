"""A robot individual with a loaded reference under a laser tracker, before its first run."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TypeVar

import numpy as np

from armside.arrays import Array

from ..instruments.imu import draw as draw_imu
from ..instruments.laser_tracker import LaserTrackerCfg, set_up
from ..robot.drives import gear_error_of
from ..robot.effects import available
from ..robot.individual import Individual, embodied, with_payload
from ..robot.kinematics_check import cell_model
from ..robot.model import RobotModel
from ..robot.run import LoadedReference
from ..robot.spread import Drawn, Spread, check_applies
from ..robot.statics import Statics
from ..robot.virtual_robot import VirtualRobot
from .plant import CuttingPlant, MountedImu
from .setup import Setup

Motion = TypeVar("Motion")


@dataclass(frozen=True, kw_only=True)
class Rig:
    """Robot, controller, reference and instruments."""

    seed: int
    individual: Individual = field(repr=False)
    """Parameters of the robot, without drift."""
    nominal: RobotModel = field(repr=False)
    """Nominal robot of the controller."""
    added_payload: float
    """Known mass of the tool beside that of the robot's file [kg]."""
    loaded: LoadedReference = field(repr=False)
    plant: CuttingPlant = field(repr=False)


def rig(
    setup: Setup,
    planned: Callable[[Statics], tuple[Motion, Array]],
    *,
    seed: int = 0,
    repetition: int = 0,
    nominal: RobotModel | None = None,
) -> tuple[Motion, Rig]:
    """Plan a motion, draw the robot individual, set up the instruments and load the reference.

    Args:
        planned: motion and reference (N, 6) [rad] of the controller's nominal robot.
        seed, repetition, nominal: as of `experiment.prepare`.

    Raises ValueError for a payload that the robot cannot carry, or a model of another robot.
    """
    drawing, tracking, noise, mounting, reading = np.random.SeedSequence(seed).spawn(5)
    if repetition:
        noise, reading = (stream.spawn(repetition)[-1] for stream in (noise, reading))
    design = cell_model(setup.cell, setup.model) if nominal is None else nominal
    known = controlled(setup, design)
    statics = Statics(known)
    motion, reference = planned(statics)
    if setup.gear_error:
        reference = reference - gear_error_of(setup.gear_error, design.n_axes)(reference)
    individual = _individual(setup, np.random.default_rng(drawing), design)
    friction = individual.friction * (1.0 + setup.friction_drift)
    real = embodied(
        design,
        replace(individual, friction=friction),
        available(design) - frozenset(setup.without),
        phi=reference[0],
        payload=setup.payload,
        temperature=setup.temperature,
    )
    loaded = VirtualRobot(real, nominal=statics).load(reference)
    tracker = set_up(LaserTrackerCfg(), np.random.default_rng(tracking))
    unit = None
    if setup.imu is not None:
        imu = draw_imu(setup.imu, np.random.default_rng(mounting))
        unit = MountedImu(imu, np.random.default_rng(reading))
    plant = CuttingPlant(loaded, tracker, np.random.default_rng(noise), unit)
    added = 0.0
    if setup.payload is not None and setup.payload_known:
        added = setup.payload - float(design.mj.body("tool").mass[0])
    return motion, Rig(
        seed=seed,
        individual=individual,
        nominal=known,
        added_payload=added,
        loaded=loaded,
        plant=plant,
    )


def controlled(setup: Setup, design: RobotModel) -> RobotModel:
    """The nominal robot of the controller, with the payload that it knows."""
    carrying = design if setup.payload is None else with_payload(design, setup.payload)
    known = carrying if setup.payload_known else design
    if setup.friction_feedforward is None:
        return known
    drives = replace(known.drives, friction_feedforward=setup.friction_feedforward)
    return replace(known, drives=drives)


def _individual(setup: Setup, rng: np.random.Generator, design: RobotModel) -> Individual:
    individual = setup.individual
    if individual is None:
        spread = setup.friction_spread
        individual = Individual(friction=1.0 + rng.uniform(-spread, spread, design.n_axes))
    elif isinstance(individual, int):
        individual = Drawn(individual, Spread()).of(design)
    elif isinstance(individual, Drawn):
        individual = individual.of(design)
    else:
        check_applies(design, individual)
    return individual
