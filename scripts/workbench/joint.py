"""Joint, design and law of the figures of chapter 8 from words."""

from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Any

from armside.ilc.models.two_mass import TwoMassJoint, TwoMassLoop
from armside.ilc.two_mass_study import Study
from armside.ilc.workbench.laws import build_law
from armside.ilc.workbench.task import Setting
from armside.ilc.workbench.words import number, unknown_name

FACTOR = 1e3
"""Largest change of a number."""
CONTROLLER = ("Kp", "Kd", "Tf")


def loop_of(words: Sequence[str]) -> TwoMassLoop:
    """Joint and controller with numbers of KEY=VALUE. ValueError, also for an unstable loop."""
    of_joint, loop = tuple(each.name for each in fields(TwoMassJoint)), TwoMassLoop()
    joint, controller = dict[str, Any](), dict[str, Any]()
    for word in words:
        key, sign, text = word.partition("=")
        if not sign:
            raise ValueError(f"joint takes KEY=VALUE, got {word!r}")
        if key not in (*of_joint, *CONTROLLER):
            raise ValueError(unknown_name("number of the joint", key, (*of_joint, *CONTROLLER)))
        value = float(number(text, key))
        known = getattr(loop.controller if key in CONTROLLER else loop.joint, key)
        if not known / FACTOR <= value <= known * FACTOR:
            ends = f"{known / FACTOR:g} to {known * FACTOR:g}"
            raise ValueError(f"{key} must be {ends}, got {value:g}")
        (controller if key in CONTROLLER else joint)[key] = value
    made = replace(
        loop, joint=replace(loop.joint, **joint), controller=replace(loop.controller, **controller)
    )
    _ = made.T_motor, made.F_r  # raise for a loop that is unstable
    return made


def study_of(
    words: Sequence[str], gamma: float, delta: int, cutoff: float, law: str | None
) -> Study:
    """Study with these numbers. Raises ValueError, OwnCodeError for what a law's file raises."""
    study = Study(loop=loop_of(words), gamma=gamma, delta=delta, cutoff=cutoff)
    if law is None:
        return study
    plant = study.plant
    setting = Setting(
        sample_time=study.loop.sample_time,
        reference=plant.motor_reference,
        model=study.loop.T_motor,
        cutoff=cutoff,
        experiment=lambda correction: plant.run(correction).motor,
    )
    return replace(study, law=build_law(law, setting), name=law)
