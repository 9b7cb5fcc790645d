"""The compiled functions beside Pinocchio and the Robotics Toolbox.

The time of a call from Python ends when the result is in a NumPy array. The peers have no coupling
and take joint variables, which favours them on the IRB1400.
"""

import tempfile
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from typing import Any

import numpy as np

from armside.kinematics import (
    IRB1400,
    IRB1400_IMU,
    LARGE_ROBOT,
    UR10,
    Body,
    InertialModel,
    Limits,
    Link,
    Robot,
    compile,
    compile_dynamics,
    inverse_branches,
    inverse_numeric,
    inverse_numeric_path,
)
from armside.scripts.thesis.peers import toolbox_robot

from ._arms import CIRCLES, PANDA, PANDA_LIMITS, PUMA_560, STANFORD_ARM, STANFORD_LIMITS, circle
from ._pinocchio import pinocchio_dynamics, pinocchio_functions
from ._timing import Row, interleaved

BATCH = 100_000
PATH = 2000
POSES = 100
TOLERANCE = 1e-6
"""[m] and [rad], of numeric inverse kinematics, ours and the peer's."""
ARMS = ((PUMA_560, None), (STANFORD_ARM, STANFORD_LIMITS), (PANDA, None), (PANDA, PANDA_LIMITS))


def measured() -> Sequence[Row]:
    """Rows of the benchmark; peers that are not installed are left out."""
    singles = [*_single_calls(), *_into_given_arrays()]
    inverse = [*_inverse(), *_numeric_inverse(), *_numeric_paths()]
    return [*singles, *_batches(), *_dynamics(), *inverse, *_symbolic(), _first_use()]


def _random(*shape: int) -> np.ndarray:
    return np.random.default_rng(0).uniform(-1.0, 1.0, size=shape)


def _peers() -> dict[str, Any]:
    """Name: object with pose, jacobian, acceleration of the IRB1400, of each installed peer."""
    found: dict[str, Any] = {}
    for name, build in (("Pinocchio", pinocchio_functions), ("Robotics Toolbox", toolbox_robot)):
        with suppress(ImportError):
            found[name] = build(IRB1400)
    return found


def _single_calls() -> list[Row]:
    ours, peers = compile(IRB1400), _peers()
    phi, rate, acceleration = _random(3, 6)
    rows = []
    for name, arguments, of_toolbox in (
        ("pose", (phi,), "fkine"),
        ("Jacobian", (phi,), "jacob0"),
        ("acceleration", (phi, rate, acceleration), "-"),
    ):
        function = name.lower()
        names = {"Pinocchio": function, "Robotics Toolbox": of_toolbox}
        candidates = {key: getattr(peers.get(key), names[key], None) for key in names}
        rows += _against(f"IRB1400 {name}", getattr(ours, function), candidates, arguments)
    return rows


def _against(
    name: str,
    ours: Callable[..., Any],
    peers: dict[str, Callable[..., Any] | None],
    arguments: tuple[np.ndarray, ...],
) -> list[Row]:
    """A row for each installed peer, or one row without."""
    rows = []
    for peer, function in peers.items():
        if function is not None:
            times = interleaved([lambda: ours(*arguments), lambda f=function: f(*arguments)])
            rows.append(Row(name, times[0], peer, times[1]))
    return rows or [Row(name, interleaved([lambda: ours(*arguments)])[0])]


def _into_given_arrays() -> list[Row]:
    """Single calls with `out=`: the peer's result is copied into the caller's array."""
    ours, peer = compile(IRB1400), _peers().get("Pinocchio")
    phi, rate, acceleration = _random(3, 6)
    rows = []
    for name, shape, arguments in (
        ("pose", (4, 4), (phi,)),
        ("Jacobian", (6, 6), (phi,)),
        ("acceleration", (6,), (phi, rate, acceleration)),
    ):
        out, theirs = np.empty(shape), np.empty(shape)
        function = getattr(ours, name.lower())
        copied = {"Pinocchio": _copying(getattr(peer, name.lower()), theirs) if peer else None}
        rows += _against(
            f"IRB1400 {name}, out=", lambda *a, f=function, o=out: f(*a, out=o), copied, arguments
        )
    return rows


def _copying(function: Callable[..., Any], out: np.ndarray) -> Callable[..., np.ndarray]:
    def copy(*arguments: np.ndarray) -> np.ndarray:
        out[...] = function(*arguments)
        return out

    return copy


def _batches() -> list[Row]:
    ours, phi = compile(IRB1400), _random(BATCH, 6)
    poses, jacobians = np.empty((BATCH, 4, 4)), np.empty((BATCH, 6, 6))
    calls = [lambda: ours.pose(phi, out=poses), lambda: ours.jacobian(phi, out=jacobians)]
    times = zip(("pose", "Jacobian"), interleaved(calls), strict=True)
    return [Row(f"IRB1400 {name}, each of {BATCH}", seconds / BATCH) for name, seconds in times]


def _dynamics() -> list[Row]:
    """Mass matrix and inverse dynamics of the large robot's geometry with bodies of round numbers.

    A batch stands beside a loop over the peer's single calls.
    """
    body = Body(mass=50.0, com=(-0.1, 0.05, 0.2), inertia=(3.0, 2.5, 2.0, 0.1, -0.2, 0.3))
    model = InertialModel(LARGE_ROBOT, (body,) * 6)
    ours, peer = compile_dynamics(model), None
    with suppress(ImportError):
        peer = pinocchio_dynamics(model)
    rows, loop = [], 1000
    for name, count in (("mass_matrix", 1), ("inverse_dynamics", 3)):
        function, arguments = getattr(ours, name), tuple(_random(count, 6))
        theirs = getattr(peer, name, None)
        label = name.replace("_", " ")
        rows += _against(f"LARGE_ROBOT {label}", function, {"Pinocchio": theirs}, arguments)
        batch = tuple(_random(count, loop, 6))
        looped = _looping(theirs) if theirs else None
        many = _against(f"LARGE_ROBOT {label}, {loop}", function, {"Pinocchio loop": looped}, batch)
        rows += many
    return rows


def _looping(function: Callable[..., Any]) -> Callable[..., None]:
    def loop(*arguments: np.ndarray) -> None:
        for row in zip(*arguments, strict=True):
            function(*row)

    return loop


def _inverse() -> list[Row]:
    """Closed forms: a spherical wrist, and beside it three parallel axes."""
    robots, phi = (LARGE_ROBOT, UR10), _random(PATH, 6)
    calls = [partial(inverse_branches, robot, compile(robot).pose(phi)) for robot in robots]
    wrist, parallel = interleaved(calls)
    what = f"inverse, all branches, {PATH} poses"
    return [
        Row(f"LARGE_ROBOT {what}", wrist),
        Row(f"UR10 {what}", parallel, "LARGE_ROBOT's spherical wrist", wrist),
    ]


def _numeric_inverse() -> list[Row]:
    """Time of a pose, over poses of random configurations, to TOLERANCE, limits kept if any.

    Both solve every pose; the peer's tolerance is on half the squared error.
    """
    rows = []
    for robot, limits in ARMS:
        T = compile(robot).pose(_within(robot, limits, POSES))
        start = _within(robot, limits, 1)[0]
        calls: list[Callable[[], Any]] = [partial(_solve, robot, T, start, limits)]
        with suppress(ImportError):
            calls.append(partial(_solve_there, toolbox_robot(robot, limits).ets().ik_LM, T))
        ours, *theirs = (seconds / POSES for seconds in interleaved(calls, repeats=5))
        name = f"{robot.name} numeric inverse{', limits' if limits else ''}, each of {POSES}"
        peer = "Robotics Toolbox" if theirs else None
        rows.append(Row(name, ours, peer, theirs[0] if theirs else None))
    return rows


def _solve(robot: Robot, T: np.ndarray, start: np.ndarray, limits: Limits | None) -> None:
    for pose in T:
        inverse_numeric(robot, pose, start, TOLERANCE, limits=limits)


def _solve_there(ik: Callable[..., Any], T: np.ndarray) -> None:
    for pose in T:
        ik(pose, tol=TOLERANCE**2 / 2)


def _within(robot: Robot, limits: Limits | None, count: int) -> np.ndarray:
    n = robot.n_joints
    lower, upper = (limits.lower, limits.upper) if limits else (-np.pi, np.pi)
    return np.random.default_rng(count).uniform(lower, upper, (count, n))


def _numeric_paths() -> list[Row]:
    """Paths of 1,000 poses, one compiled call each: a change of all joints, and a circle."""
    rows = []
    for robot, limits in ARMS:
        first, last = _within(robot, limits, 2)
        phi = first + 0.1 * (last - first) * np.linspace(0, 1, 1000)[:, None]
        T = compile(robot).pose(phi)
        (seconds,) = interleaved([lambda r=robot, T=T, s=first: inverse_numeric_path(r, T, s)])
        rows.append(Row(f"{robot.name} numeric inverse along 1000 poses", seconds))
    for robot, limits, start in CIRCLES:
        T = circle(robot, start)
        call = partial(inverse_numeric_path, robot, T, start, limits=limits)
        axes = f"{robot.name}, {robot.n_joints} axes"
        rows.append(Row(f"{axes}: 1000 poses of a 100 mm circle, limits", interleaved([call])[0]))
    return rows


def _symbolic() -> list[Row]:
    """Example 4.1 of the thesis: the Jacobian of six revolute joints, all parameters symbolic.

    Expanded as in the thesis, and by a recursion that shares the parts; time to build, operations.
    """
    import sympy as sp

    from armside.kinematics.equations import forward_kinematics
    from armside.kinematics.expressions.symbols import moving, symbol, t
    from armside.kinematics.symbolic import procedures

    def six(theta: Callable[[int], Any]) -> Robot:
        rows = [[symbol(name, i) for name in ("d", "a", "alpha")] for i in range(1, 7)]
        return Robot([Link(theta(i), *row) for i, row in enumerate(rows, 1)])  # pyright: ignore

    constant, timed = six(lambda i: symbol("theta", i)), six(lambda i: moving("theta", i))
    J, expanded = _timed(lambda: procedures.jacobian(constant))
    J_dot, differentiated = _timed(lambda: procedures.jacobian(timed).diff(t))
    program, shared = _timed(lambda: forward_kinematics.jacobian(six(lambda i: 0)))
    rate, shared_rate = _timed(lambda: forward_kinematics.jacobian_rate(six(lambda i: 0)))
    return [
        Row(f"symbolic Jacobian: {sp.count_ops(J)} operations", expanded),
        Row(f"symbolic Jacobian rate: {sp.count_ops(J_dot)} operations", differentiated),
        Row(f"symbolic Jacobian, parts shared: {program.operations} operations", shared),
        Row(f"symbolic Jacobian rate, parts shared: {rate.operations} operations", shared_rate),
    ]


def _timed(build: Callable[[], Any]) -> tuple[Any, float]:
    start = time.perf_counter()
    return build(), time.perf_counter() - start


def _first_use() -> Row:
    """Time to generate and compile pose, Jacobian and acceleration with an empty cache."""
    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        fresh = compile(IRB1400_IMU, cache=folder)
        for function in (fresh.pose, fresh.jacobian):
            function(np.zeros(6))
        fresh.acceleration(np.zeros(6), np.zeros(6), np.zeros(6))
        return Row("first use of pose, Jacobian, acceleration", time.perf_counter() - start)
