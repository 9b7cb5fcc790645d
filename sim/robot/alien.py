"""Aliens: robots with effects that no estimator or forecast of ours has a parameter for.

A twin is parametrised by the physics that individuals are drawn from, hysteresis of gears and a
filter of set points; a real robot was not drawn from it. `ALIEN` names what an individual of the
line may have besides (`spread.Alien` draws it): changes of the parsed file, of the compiled model,
or of what enters the drives.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from armside.arrays import Array

from .drives import FRICTION_SPEED, Drives, GearError, OwnDrive
from .effects import TEMPERATURES, load_friction
from .mjcf import axes_of, has, numeric, scalar
from .model import RobotModel, robot_model


@dataclass(frozen=True)
class AlienEffect:
    """One effect of an individual."""

    name: str
    size: float = 1.0
    """Over the median of `ALIEN`."""
    number: int = 0
    """Phases are drawn with."""

    def __post_init__(self) -> None:
        if self.name not in ALIEN:
            raise ValueError(f"Unknown effect {self.name!r}. Effects: {', '.join(ALIEN)}")
        if not (np.isfinite(self.size) and self.size >= 0.0):
            raise ValueError(f"size of {self.name} must be >= 0, got {self.size}")


RUN_FRICTION = "run-friction"
"""Effect that goes with `Effect.LOAD_FRICTION` where that is left out."""
STIFFENING = 0.8
"""Tangent stiffness of a gear at its rated torque over that without load, less 1: K3 / K1 of strain
wave gears of size 25 (engineering data of CSF by Harmonic Drive, second hand, not verified). Of
cycloidal gears it is less."""
RATED = 0.5
"""Rated torque of a gear over the peak torque of its drive. ESTIMATE"""
HYSTERESIS = 0.03
"""Half height of the hysteresis loop of a gear, over its rated torque, dry. ESTIMATE, of the size
of the +-3 % at which makers state lost motion: that is no measured height."""
WARMING, WARMING_TIME = 5.0, 1.0
"""Rise of the grease's temperature in contact [K], and its time constant [s]. ESTIMATE"""
HOSE_STIFFNESS, HOSE_DAMPING, HOSE_FRICTION, HOSE_REST = 40.0, 4.0, 8.0, 0.5
"""Of a hose pack along axes 4 to 6 [N m/rad], [N m s/rad], [N m], and how far it is twisted when
the wrist is at zero [rad]. ESTIMATE"""
TOOL_STIFFNESS, TOOL_DAMPING_RATIO = 6e4, 0.02
"""Of the bracket of a laser head [N m/rad]: the head of 40 kg at 0.25 m swings at 21 Hz. ESTIMATE
"""
FLOOR_MASS, FLOOR_FREQUENCY, FLOOR_DAMPING_RATIO = 3000.0, 9.0, 0.03
"""What moves with the robot [kg] (ESTIMATE), and its mode [Hz]: floors of halls on steel have 4 to
9 Hz and damping ratios of 0.02 to 0.05 (AISC Design Guide 11, 2016; second hand, not verified)."""
ECCENTRICITY = (5.0, 3.0)
"""[arcmin] of the motor, once and three times a revolution: resolvers are good to 10 (Tamagawa,
Smartsyn TS2620; second hand, not verified). Once a revolution is also an order of the gear error
that a twin identifies; only the third is outside our models."""
NOTCH, NOTCH_QUALITY, NOTCH_DEPTH = 11.0, 1.0, 0.7
"""Set points of a servo that spares a mode: [Hz], quality, and the part of that frequency that is
taken out. ESTIMATE"""
ACCELERATING, SLIDING = 0.8, 0.5
"""Parts of dynamic torque and of Coulomb friction in a feedforward of its own. ESTIMATE"""


def _floor(spec: mujoco.MjSpec, size: float) -> None:
    base = spec.body("base")
    whole = sum(body.mass for body in spec.bodies if body.name != "world")
    base.mass = base.mass + FLOOR_MASS
    omega = 2.0 * np.pi * FLOOR_FREQUENCY / np.sqrt(size)
    stiffness = omega**2 * (whole + FLOOR_MASS)
    for name, axis in (("floor_x", (1.0, 0.0, 0.0)), ("floor_z", (0.0, 0.0, 1.0))):
        joint = base.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
        joint.stiffness = np.array([stiffness, 0.0, 0.0])
        joint.damping = np.array([2.0 * FLOOR_DAMPING_RATIO * stiffness / omega, 0.0, 0.0])
        joint.springref = axis[2] * 9.81 * (whole + FLOOR_MASS) / stiffness


def _tool(spec: mujoco.MjSpec, size: float) -> None:
    tool, stiffness = spec.body("tool"), TOOL_STIFFNESS / size
    inertia = tool.mass * tool.ipos[0] ** 2 + tool.inertia[1]
    for name, axis in (("tool_y", (0.0, 1.0, 0.0)), ("tool_z", (0.0, 0.0, 1.0))):
        joint = tool.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=axis)
        joint.stiffness = np.array([stiffness, 0.0, 0.0])
        joint.damping = np.array(
            [2.0 * TOOL_DAMPING_RATIO * np.sqrt(stiffness * inertia), 0.0, 0.0]
        )


def _hose(spec: mujoco.MjSpec, size: float) -> None:
    hose = spec.add_tendon(
        name="hose",
        stiffness=[size * HOSE_STIFFNESS, 0.0, 0.0],
        damping=[size * HOSE_DAMPING, 0.0, 0.0],
        frictionloss=size * HOSE_FRICTION,
        springlength=[HOSE_REST, HOSE_REST],
    )
    for axis in (4, 5, 6):
        hose.wrap_joint(f"motor_{axis}", 1.0)
        hose.wrap_joint(f"flex_{axis}", 1.0)


def gear_stiffness(model: RobotModel) -> Array:
    """(n,) [N m/rad], of each wound gear."""
    mj = model.mj
    whole = [float(mj.joint(f"flex_{i}").stiffness[0]) for i in axes_of(mj)]
    for i in axes_of(mj):
        if has(mj, mujoco.mjtObj.mjOBJ_TENDON, f"gear_{i}"):
            whole[i - 1] += float(mj.tendon_stiffness[mj.tendon(f"gear_{i}").id])
    return np.array(whole)


def rated_torque(model: RobotModel) -> Array:
    """(n,) [N m], of each gear, arm side."""
    return RATED * model.drives.torque_limit * np.abs(model.drives.gear)


def _hardening(model: RobotModel, effect: AlienEffect) -> RobotModel:
    """torque = k q + b q^3 with k + 3 b q^2 = (1 + STIFFENING) k at the wind-up of rated torque."""
    k = gear_stiffness(model)
    wound = rated_torque(model) / k
    joints = model.mj.dof_jntid[model.flex]
    model.mj.jnt_stiffnesspoly[joints, 1] = effect.size * STIFFENING * k / (3.0 * wound**2)
    return model


def _hysteresis(model: RobotModel, effect: AlienEffect) -> RobotModel:
    """Dry friction beside the spring, which a default constraint would let creep."""
    mj = model.mj
    mj.dof_frictionloss[model.flex] = effect.size * HYSTERESIS * rated_torque(model)
    mj.dof_solref[model.flex] = 2.0 * model.timestep, 1.0
    mj.dof_solimp[model.flex, :2] = 0.999
    return model


def _eccentric(model: RobotModel, effect: AlienEffect) -> RobotModel:
    """A reading off by d is one of a gear off by -d."""
    n, gear = model.n_axes, model.drives.gear
    radians = effect.size * np.deg2rad(np.array(ECCENTRICITY) / 60.0)
    own = GearError(
        amplitude=np.asarray(radians / np.abs(gear)[:, None], dtype=np.float64),
        order=np.column_stack([gear, 3.0 * gear]),
        phase=np.random.default_rng(effect.number).uniform(0.0, 2.0 * np.pi, (n, 2)),
    )
    if (known := model.gear_error) is None:
        return replace(model, gear_error=own)
    both = GearError(
        amplitude=np.hstack((known.amplitude, own.amplitude)),
        order=np.hstack((known.order, own.order)),
        phase=np.hstack((known.phase, own.phase)),
    )
    return replace(model, gear_error=both)


@dataclass(frozen=True, kw_only=True, eq=False)
class AlienDrive(OwnDrive):
    """Friction that changes within a run, and a servo of another make; sizes over the median."""

    friction: float = 0.0
    servo: float = 0.0
    scale: Array
    """(n,) `load_friction_scale` of the robot's file."""
    temperature: float
    """Of the gears at the start [deg C]."""

    def applied(self, drives: Drives, load: Array, velocity: Array, time: Array) -> Array:
        """(M, n) [N m], arm side: friction beyond that of the start, as torque on the motors.

        load: (M, n) [N m], of the motors, velocity (M, n) [rad/s], both arm side and as commanded:
        friction follows the asked motion. Where load falls or grease warms, the torque drives.
        """
        limit, gear = drives.torque_limit, np.abs(drives.gear)
        relative = load / gear / limit
        warm = self.temperature + WARMING * (1.0 - np.exp(-time / WARMING_TIME))
        hottest = max(t for t in TEMPERATURES)
        found = [load_friction(r, min(t, hottest)) for r, t in zip(relative, warm, strict=True)]
        coulomb = np.array([each[0] for each in found])
        viscous = np.array([each[2] for each in found])
        change = self.scale * (coulomb - coulomb[0]) * np.tanh(velocity / FRICTION_SPEED)
        more = change + (viscous - viscous[0])[:, None] * gear * velocity
        return -self.friction * more * limit * gear

    def feedforward(self, drives: Drives, torque: Array, velocity: Array) -> Array:
        """(M, n) [N m], arm side: that of the servo in place of ours."""
        own = torque[0] + ACCELERATING * (torque - torque[0])
        own = own + SLIDING * drives.coulomb_friction * drives.gear * np.tanh(
            velocity / FRICTION_SPEED
        )
        return torque + self.servo * (own - torque)

    def commands(self, controls: Array, step: float) -> Array:
        """Controls (M, n, 3): position and velocity without what the notch takes out."""
        from scipy.signal import iirnotch, lfilter

        if self.servo == 0.0:
            return controls
        b, a = iirnotch(NOTCH, NOTCH_QUALITY, 1.0 / step)
        moved = controls[:, :, :2] - controls[0, :, :2]
        without = np.asarray(lfilter(b, a, moved, axis=0), dtype=np.float64)
        out = controls.copy()
        out[:, :, :2] += min(self.servo * NOTCH_DEPTH, 1.0) * (without - moved)
        return out


def _drive(model: RobotModel) -> AlienDrive:
    if isinstance(model.own_drive, AlienDrive):
        return model.own_drive
    mj, kind = model.mj, mujoco.mjtObj.mjOBJ_NUMERIC
    known = has(mj, kind, "load_friction_scale")
    scale = numeric(mj, "load_friction_scale", model.n_axes) if known else np.ones(model.n_axes)
    warm = scalar(mj, "gear_temperature") if has(mj, kind, "gear_temperature") else 40.0
    return AlienDrive(scale=scale, temperature=warm)


def _friction(model: RobotModel, effect: AlienEffect) -> RobotModel:
    return replace(model, own_drive=replace(_drive(model), friction=effect.size))


def _servo(model: RobotModel, effect: AlienEffect) -> RobotModel:
    return replace(model, own_drive=replace(_drive(model), servo=effect.size))


_Built = Callable[[mujoco.MjSpec, float], None]
_Tuned = Callable[[RobotModel, AlienEffect], RobotModel]
ALIEN: Mapping[str, tuple[_Built | None, _Tuned | None]] = {
    "hardening": (None, _hardening),
    "hysteresis": (None, _hysteresis),
    RUN_FRICTION: (None, _friction),
    "hose": (_hose, None),
    "swinging-head": (_tool, None),
    "soft-floor": (_floor, None),
    "eccentric-encoder": (None, _eccentric),
    "own-servo": (None, _servo),
}
"""Name -> what is built into the parsed file, and what is set in the model of the individual."""


def built(design: RobotModel, effects: Sequence[AlienEffect]) -> RobotModel:
    """Design with the parts that effects need. Raises ModelError without a parsed file."""
    builders = [(ALIEN[each.name][0], each.size) for each in effects]
    if not any(build for build, _ in builders):
        return design
    spec = design.parsed()
    for build, size in builders:
        if build is not None:
            build(spec, size)
    return robot_model(spec)


def tuned(
    model: RobotModel, effects: Sequence[AlienEffect], temperature: float | None = None
) -> RobotModel:
    """Model of an individual, which is changed, with the effects of `built` and the others.

    temperature: of the gears at the start [deg C]; that of the robot's file if None.
    """
    for each in effects:
        if (tune := ALIEN[each.name][1]) is not None:
            model = tune(model, each)
    if temperature is not None and isinstance(model.own_drive, AlienDrive):
        model = replace(model, own_drive=replace(model.own_drive, temperature=temperature))
    return model
