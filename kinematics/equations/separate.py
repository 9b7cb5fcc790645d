"""Parameters whose symbols are also variables of generated code, such as a length x1 or phi1."""

import re
from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from typing import Any, Concatenate, ParamSpec, TypeVar

import sympy as sp

from ..dh import Robot
from ..expressions.symbols import internal
from .inertial_model import InertialModel
from .program import StraightLineProgram

_GENERATED = re.compile(r"(x|(phi|psi)d{0,2}|tau)\d+(_rate)?")
Subject = TypeVar("Subject", Robot, InertialModel)
Arguments = ParamSpec("Arguments")
Builder = Callable[Concatenate[Subject, Arguments], StraightLineProgram]


def separated(build: Builder[Subject, Arguments]) -> Builder[Subject, Arguments]:
    """A builder of programs whose robot or model keeps its parameters apart from generated names.

    Each parameter that is equal to a variable of generated code becomes another symbol with its
    name; `codegen` then gives the two different names.
    """

    @wraps(build)
    def with_own_names(
        subject: Subject, *arguments: Arguments.args, **named: Arguments.kwargs
    ) -> StraightLineProgram:
        return build(_separated(subject), *arguments, **named)

    return with_own_names


def _separated(subject: Subject) -> Subject:
    own = {
        s: internal(s.name)
        for s in subject.free_symbols
        if s == sp.Symbol(s.name, real=True) and _GENERATED.fullmatch(s.name)
    }
    if not own:
        return subject
    return _robot(subject, own) if isinstance(subject, Robot) else _model(subject, own)


def _robot(robot: Robot, own: dict[Any, Any]) -> Robot:
    links = [replace(link, **_renamed(link, own)) for link in robot.links]
    return Robot(links, robot.coupling, robot.offset, robot.convention, robot.name)


def _model(model: InertialModel, own: dict[Any, Any]) -> InertialModel:
    bodies = tuple(replace(body, **_renamed(body, own)) for body in model.bodies)
    motors = tuple(replace(motor, **_renamed(motor, own)) for motor in model.motors)
    return InertialModel(_robot(model.robot, own), bodies, motors, _value(model.gravity, own))


def _renamed(data: Any, own: dict[Any, Any]) -> dict[str, Any]:
    return {name: _value(value, own) for name, value in vars(data).items()}


def _value(value: Any, own: dict[Any, Any]) -> Any:
    if isinstance(value, tuple):
        return tuple(_value(each, own) for each in value)
    return value.xreplace(own) if isinstance(value, sp.Basic) else value
