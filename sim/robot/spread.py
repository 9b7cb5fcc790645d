"""Distributions of robot individuals, and draws from them. All widths are ESTIMATES."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from armside.arrays import Array

from .alien import ALIEN, AlienEffect
from .drives import N_HARMONICS
from .effects import Effect, available
from .individual import OF_STRUCTURE, HiddenHinge, Individual, structure_hinges
from .linkage import Linkage
from .mjcf import ModelError, model_name
from .model import RobotModel

_NEEDS = {
    Effect.LOST_MOTION: ("lost motion", ("lost_motion",)),
    Effect.GEAR_ERROR: ("transmission error", ("gear_error", "gear_error_phase")),
    Effect.RIPPLE: ("torque ripple", ("ripple",)),
    Effect.LOAD_FRICTION: (
        "friction that depends on load",
        ("friction_constant", "friction_load", "static_excess"),
    ),
}
_DESIGN = Individual()


def inapplicable(design: RobotModel) -> dict[str, str]:
    """Fields of `Individual` that change nothing in a design, each with what the design lacks."""
    has, lacking = available(design), dict[str, str]()
    for effect, (what, names) in _NEEDS.items():
        if effect not in has:
            lacking |= dict.fromkeys(names, what)
    if not has & {Effect.RIPPLE, Effect.GEAR_ERROR}:
        lacking["ripple_phase"] = "torque ripple or transmission error"
    if not len(design.flex):
        lacking |= dict.fromkeys(("gear_stiffness", "gear_damping"), "flexible gears")
    if not structure_hinges(design):
        lacking |= dict.fromkeys(OF_STRUCTURE, "hinges of the structure")
    return lacking


def check_applies(design: RobotModel, individual: Individual) -> None:
    """Raise ModelError for a parameter that the design lacks, or a wrong number of its hinges."""
    for name, what in inapplicable(design).items():
        if np.any(getattr(individual, name) != getattr(_DESIGN, name)):
            raise ModelError(f"{name} does not apply to a robot without {what}: leave it out")
    individual.of(design.n_axes)
    n = len(structure_hinges(design))
    for name in OF_STRUCTURE:
        if np.ndim(value := getattr(individual, name)) and np.size(value) != n:
            allowed = f"one factor or {n}, one for each hinge of the structure"
            raise ModelError(f"{name} must be {allowed}, got {np.size(value)}")


@dataclass(frozen=True, kw_only=True)
class Spread:
    """Standard deviations between robots of one design.

    The defaults are the individuals of the verdicts on thesis chapter 9; `PRODUCTION` varies
    everything.
    """

    friction: float = 0.10
    """log(factor) on each axis: run-in, grease and temperature."""
    gear_stiffness: float = 0.10
    structure_stiffness: float = 0.10
    """log(factor) on each axis, and on each hinge of the structure."""
    position: float = 0.5e-3
    """[m], position of each joint on the link before it, each direction."""
    orientation: float = 0.5e-3
    """[rad], rotation of each joint's axis and zero, about each direction."""
    friction_law: float = 0.0
    """log(factor) on each constant of the friction law: load, static, Stribeck, viscous."""
    bristle_stiffness: float = 0.0
    ripple: float = 0.0
    lost_motion: float = 0.0
    gear_error: float = 0.0
    """log(factor) on each axis and order; where it is not 0, each order has a phase of its own."""
    mass: float = 0.0
    damping: float = 0.0
    """log(factor) on each link, and on each gear and hinge."""
    centre_of_mass: float = 0.0
    """[m], of each link, each direction."""
    hidden: float = 0.0
    """Fraction of robots with one to three hinges that the design lacks."""

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if not (np.isfinite(value) and value >= 0.0):
                raise ValueError(f"spread of {item.name} must be >= 0, got {value}")
        if self.hidden > 1.0:
            raise ValueError(f"the fraction of hidden hinges must be at most 1, got {self.hidden}")


PRODUCTION = Spread(
    friction_law=0.10,
    bristle_stiffness=0.15,
    ripple=0.2,
    lost_motion=0.2,
    gear_error=0.2,
    mass=0.015,
    centre_of_mass=5e-3,
    damping=0.2,
    hidden=0.5,
)
"""Robots of one production line: what `--individual N` is drawn from."""


@dataclass(frozen=True)
class _Link:
    body: str
    end: tuple[float, float, float]
    """Of the link, in its own axes [m]."""
    axis: tuple[float, float, float]
    """About which the robot's file has a joint whatever the place along the link."""
    stiffness: float
    """Median [N m/rad], twice that of the springs beside it."""


_LINKS: Mapping[str, tuple[_Link, ...]] = {
    "large_robot": (
        _Link("lower_arm", (0.0, 0.0, 1.075), (0.0, 0.0, 1.0), 8e6),
        _Link("tube", (1.142, 0.0, 0.0), (1.0, 0.0, 0.0), 2.5e6),
        _Link("tilt", (0.2, 0.0, 0.0), (0.0, 1.0, 0.0), 1e6),
    ),
    "irb1400": (
        _Link("tube", (0.72, 0.0, 0.0), (1.0, 0.0, 0.0), 3e5),
        # As soft as gear 6: about axis 4 a stiff one rings too fast for the step.
        _Link("tilt", (0.085, 0.0, 0.0), (0.0, 1.0, 0.0), 1e4),
    ),
}
"""By the name of the model; one of another name has no hidden hinges."""
_ALONG = 0.25, 0.6
"""Hidden hinges lie between these fractions of their link."""
_LEAN = np.deg2rad(15.0)
"""Largest angle between a hidden hinge and the plane across that axis: about the axis itself no
mass would lie between the two."""
_MOST_HINGES = 3
_STIFFNESS_SPREAD, _DAMPING_TIME = 0.4, 2e-4
"""log(factor); damping over stiffness [s], as for the hinges of the file."""


@dataclass(frozen=True)
class Drawn:
    """An individual by its number."""

    number: int
    spread: Spread = PRODUCTION

    def __post_init__(self) -> None:
        if self.number < 0:
            raise ValueError(f"individual must be >= 0, got {self.number}")

    def of(self, design: RobotModel) -> Individual:
        """Parameters, for a design."""
        return draw(np.random.default_rng(self.number), design, self.spread)


EVERY = "all"
_ALIEN_SPREAD = 0.2  # log(size). ESTIMATE


@dataclass(frozen=True)
class Alien(Drawn):
    """Robot `number` of the line with an effect of `alien.ALIEN`, by its name, or with all."""

    effect: str = EVERY

    def of(self, design: RobotModel) -> Individual:
        """Raises ValueError for an unknown effect."""
        names = tuple(ALIEN) if self.effect == EVERY else (self.effect,)
        rng = np.random.default_rng([self.number, 0xA1])
        sizes = dict(
            zip(ALIEN, np.exp(_ALIEN_SPREAD * rng.standard_normal(len(ALIEN))), strict=True)
        )
        effects = tuple(
            AlienEffect(name, float(sizes.get(name, 1.0)), self.number) for name in names
        )
        return replace(super().of(design), alien=effects)


def draw(rng: np.random.Generator, design: RobotModel, spread: Spread = Spread()) -> Individual:
    """Individual of a design: factors log-normal, phases uniform, the rest normal.

    Parameters that the design lacks keep their default; the draws do not depend on which those are.
    """
    n_structure, n = len(structure_hinges(design)), design.n_axes

    def factor(std: float, *shape: int) -> Array:
        return np.exp(std * rng.standard_normal(shape))

    friction = factor(spread.friction, n)
    gear_stiffness = factor(spread.gear_stiffness, n)
    structure_stiffness = factor(spread.structure_stiffness, n_structure)
    ripple_phase = rng.uniform(0.0, 2.0 * np.pi, n)
    position = spread.position * rng.standard_normal((n, 3))
    orientation = spread.orientation * rng.standard_normal((n, 3))
    # Whatever came later is drawn later: earlier individuals stay who they were.
    phases = rng.uniform(0.0, 2.0 * np.pi, (n, N_HARMONICS))
    drawn = Individual(
        friction=friction,
        gear_stiffness=gear_stiffness,
        structure_stiffness=structure_stiffness if n_structure else 1.0,
        ripple_phase=ripple_phase,
        position=position,
        orientation=orientation,
        gear_error_phase=phases if spread.gear_error > 0.0 else np.zeros_like(phases),
        gear_error=factor(spread.gear_error, n, N_HARMONICS),
        friction_load=factor(spread.friction_law, n),
        static_excess=factor(spread.friction_law, n),
        stribeck_speed=factor(spread.friction_law, n),
        viscous=factor(spread.friction_law, n),
        bristle_stiffness=factor(spread.bristle_stiffness, n),
        ripple=factor(spread.ripple, n),
        lost_motion=factor(spread.lost_motion, n),
        mass=factor(spread.mass, n),
        gear_damping=factor(spread.damping, n),
        structure_damping=factor(spread.damping, n_structure) if n_structure else 1.0,
        centre_of_mass=spread.centre_of_mass * rng.standard_normal((n, 3)),
    )
    if not Linkage(design.mj).is_open:
        # Its constraints know nothing of dampers: more damping makes a run in fifty unstable.
        drawn = replace(drawn, structure_damping=1.0)
    links = _LINKS.get(model_name(design.mj), ())
    if rng.uniform() < spread.hidden and links:
        most = min(_MOST_HINGES, len(links))
        chosen = rng.choice(len(links), size=rng.integers(1, most + 1), replace=False)
        drawn = replace(drawn, hidden=tuple(_hinge(links[i], rng) for i in sorted(chosen)))
    nothing: dict[str, Any] = {name: getattr(_DESIGN, name) for name in inapplicable(design)}
    return replace(drawn, **nothing)


def _hinge(link: _Link, rng: np.random.Generator) -> HiddenHinge:
    stiffness = float(link.stiffness * np.exp(_STIFFNESS_SPREAD * rng.standard_normal()))
    x, y, z = rng.uniform(*_ALONG) * np.array(link.end)
    taken = np.array(link.axis)
    about, lean = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(-_LEAN, _LEAN)
    across = np.roll(taken, 1), np.roll(taken, 2)
    level = np.cos(about) * across[0] + np.sin(about) * across[1]
    a, b, c = np.cos(lean) * level + np.sin(lean) * taken
    return HiddenHinge(
        body=link.body,
        axis=(float(a), float(b), float(c)),
        position=(float(x), float(y), float(z)),
        stiffness=stiffness,
        damping=_DAMPING_TIME * stiffness,
    )
