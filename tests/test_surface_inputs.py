"""Every declared name with arguments that cannot be: an error that says so, or a stated result."""

import warnings

import numpy as np
import pyarrow as pa
import pytest
from tests.test_surface import homes

from armside import ilc, kinematics, sim

nan = np.nan
PHI = np.array([0.1, -0.2, 0.3, 0.4, -0.5, 0.6])
T = kinematics.compile(kinematics.IRB1400).pose(PHI)
DOWN = np.array([[1, 0, 0, 0.4], [0, -1, 0, 0.2], [0, 0, -1, 0.1], [0, 0, 0, 1.0]])
BENDS = np.pi / 2 * np.array([-1, 1, 1, -1, -1, 1, 0])
LENGTHS = [0.36, 0, 0.42, 0, 0.4, 0, 0.126]
SEVEN = kinematics.Robot(
    [kinematics.Link(d=d, alpha=a) for d, a in zip(LENGTHS, BENDS, strict=True)]
)
SLIDE = kinematics.Link(joint=kinematics.Joint.PRISMATIC)
SCARA = kinematics.Robot(
    [kinematics.Link(d=0.4, a=0.3), kinematics.Link(a=0.3, alpha=np.pi), SLIDE, kinematics.Link()]
)
STANFORD = kinematics.Robot(
    [
        *(kinematics.Link(d=d, alpha=a) for d, a in ((0.4, -np.pi / 2), (0.15, np.pi / 2))),
        SLIDE,
        *(kinematics.Link(d=d, alpha=a) for d, a in ((0, -np.pi / 2), (0, np.pi / 2), (0.26, 0))),
    ]
)
SERVO = ilc.System(np.array([0, 0.3]), np.array([1, -0.7]), 0.004)
REFERENCE = np.sin(np.linspace(0, np.pi, 100))[:, None] ** 2
Q = ilc.ZeroPhaseButterworth(10.0, 0.004)
LAW = ilc.Heuristic(Q=Q, gamma=0.9, delta=2)
PLANT = ilc.LinearPlant(T_u=SERVO, reference=REFERENCE)
OMEGA = np.linspace(0.01, np.pi, 50)
TIME = np.arange(100) * 0.01
TABLE = pa.table({"time": TIME, "reference_1": np.sin(TIME), "motor_angle_1": np.sin(TIME)})
TURNED = {"phi": np.tile(PHI, (5, 1)), "points": np.ones((5, 1, 3))}
LIMITS = {"lower": (-2.0, -2.0), "upper": (2.0, 2.0), "speed": (3.0, 3.0)}
INERTIA = {"mass": 10.0, "com": (-0.2, 0.0, 0.0), "inertia": (0.1, 0.2, 0.2, 0, 0, 0)}
DRIVE = {"inertia": 2.0, "viscous": 1.0, "coulomb": 0.5, "stiffness": 1e4, "damping": 10.0}
ZERO = np.zeros(6)

CALLS = {
    "System": (ilc.System, {"b": [0, 0.3], "a": [1, -0.7], "sample_time": 0.004}),
    "StateSpace": (
        ilc.StateSpace,
        {"A": [[0.5]], "B": [[1.0]], "C": [[1.0]], "D": [[0.0]], "sample_time": 0.004},
    ),
    "ZeroPhaseButterworth": (ilc.ZeroPhaseButterworth, {"cutoff": 10.0, "sample_time": 0.004}),
    "AllPass": (lambda signal: ilc.AllPass()(signal), {"signal": REFERENCE}),
    "Heuristic": (
        lambda gamma, delta, e: ilc.Heuristic(Q=Q, gamma=gamma, delta=delta)(REFERENCE, e),
        {"gamma": 0.9, "delta": 2, "e": REFERENCE},
    ),
    "FirstOrder": (
        lambda u, e: ilc.FirstOrder(L=ilc.ModelInverse(T_u=SERVO, learned=Q))(u, e),
        {"u": REFERENCE, "e": REFERENCE},
    ),
    "ModelInverse": (
        lambda e: ilc.ModelInverse(T_u=SERVO, learned=Q)(e),
        {"e": REFERENCE},
    ),
    "RegularisedInverse": (
        lambda **more: ilc.RegularisedInverse(G=ilc.SystemMatrix.diagonal([SERVO]), **more),
        {"sample_time": 0.004, "cutoff": 10.0, "output_weight": (1.0,), "input_size": (1.0,)},
    ),
    "NormOptimal": (
        lambda n_samples, e: ilc.NormOptimal(T_u=SERVO, n_samples=n_samples)(REFERENCE, e),
        {"n_samples": 100, "e": REFERENCE},
    ),
    "BasisFunctions": (
        lambda basis: ilc.BasisFunctions(T_u=SERVO, basis=basis),
        {"basis": np.stack((REFERENCE, REFERENCE**2), axis=2)},
    ),
    "Repetitive": (
        lambda period: ilc.Repetitive(L=ilc.ModelInverse(T_u=SERVO, learned=Q), period=period),
        {"period": 50},
    ),
    "Guarded": (lambda weight: ilc.Guarded(law=LAW, weight=weight), {"weight": (1.0,)}),
    "LinearPlant": (
        lambda reference, noise, u: ilc.LinearPlant(
            T_u=SERVO, reference=reference, noise=noise, rng=np.random.default_rng(0)
        ).run(u),
        {"reference": REFERENCE, "noise": 0.0, "u": REFERENCE},
    ),
    "TwoMassLoop": (
        lambda sample_time: ilc.TwoMassLoop(sample_time=sample_time).T_motor,
        {"sample_time": 0.01},
    ),
    "TwoMassPlant": (
        lambda arm_reference: ilc.TwoMassPlant(arm_reference=arm_reference),
        {"arm_reference": REFERENCE},
    ),
    "as_state_space": (
        lambda sample_time: ilc.as_state_space(_continuous(), sample_time),
        {"sample_time": 0.004},
    ),
    "criterion": (
        ilc.criterion,
        {
            "T_u": SERVO.response(OMEGA),
            "L": np.exp(1j * OMEGA),
            "Q": Q.response(OMEGA),
            "omega": OMEGA,
        },
    ),
    "propose": (lambda **more: ilc.propose(SERVO, **more), {"bandwidth": 10.0, "fraction": 0.6}),
    "ilc.learn": (
        lambda reference, first_correction, iterations, ratio: list(
            ilc.learn(
                PLANT,
                LAW,
                reference,
                iterations,
                first_correction=first_correction,
                divergence_ratio=ratio,
            )
        ),
        {"reference": REFERENCE, "first_correction": REFERENCE, "iterations": 1, "ratio": 3.0},
    ),
    "run_law": (
        lambda iterations, noise, start: ilc.run_law(
            ilc.Task(name="s", reference=REFERENCE, sample_time=0.004, start=lambda _: PLANT),
            "heuristic:gamma=0.9,delta=2",
            iterations,
            noise=noise,
            start=start,
        ),
        {"iterations": 1, "noise": 0.0, "start": REFERENCE},
    ),
    "Task": (
        lambda **more: ilc.Task(name="s", start=lambda _: PLANT, **more),
        {"reference": REFERENCE, "sample_time": 0.004},
    ),
    "Limits": (kinematics.Limits, LIMITS),
    "Link": (
        lambda **more: kinematics.Robot([kinematics.Link(**more)]),
        {"d": 0.1, "a": 0.2, "alpha": 0.3, "theta": 0.0},
    ),
    "CoupledRange": (
        kinematics.CoupledRange,
        {"coefficients": (1, 1), "lower": -2.0, "upper": 2.0},
    ),
    "Measurements": (kinematics.Measurements, TURNED),
    "Body": (
        lambda **more: kinematics.InertialModel(
            kinematics.Robot([kinematics.Link(a=0.5)]), [kinematics.Body(**more)]
        ),
        INERTIA,
    ),
    "Motor": (
        lambda **more: kinematics.InertialModel(
            kinematics.Robot([kinematics.Link(a=0.5)]),
            [kinematics.Body(**INERTIA)],
            [kinematics.Motor(**more)],
        ),
        DRIVE,
    ),
    "CompiledRobot": (lambda phi: kinematics.compile(kinematics.IRB1400).pose(phi), {"phi": PHI}),
    "compile_frame_pose": (
        lambda phi: kinematics.compile_frame_pose(kinematics.IRB1400, 3)(phi),
        {"phi": PHI},
    ),
    "compile_frame_jacobian": (
        lambda phi: kinematics.compile_frame_jacobian(kinematics.IRB1400, 3)(phi),
        {"phi": PHI},
    ),
    "inverse_branches": (lambda T: kinematics.inverse_branches(kinematics.IRB1400, T), {"T": T}),
    "inverse_nearest": (
        lambda **more: kinematics.inverse_nearest(kinematics.IRB1400, **more),
        {"T": T, "previous": PHI},
    ),
    "inverse_path": (
        lambda **more: kinematics.inverse_path(kinematics.IRB1400, **more),
        {"T": np.stack([T, T]), "start": PHI},
    ),
    "inverse_numeric": (
        lambda T, start: kinematics.inverse_numeric(kinematics.IRB1400, T, start),
        {"T": T, "start": PHI},
    ),
    "inverse_numeric_path": (
        lambda T, start: kinematics.inverse_numeric_path(kinematics.IRB1400, T, start=start),
        {"T": np.stack([T, T]), "start": PHI},
    ),
    "scara_branches": (lambda T: kinematics.scara_branches(SCARA, T), {"T": DOWN}),
    "stanford_branches": (lambda T: kinematics.stanford_branches(STANFORD, T), {"T": DOWN}),
    "seven_axis_branches": (
        lambda T, elbow: kinematics.seven_axis_branches(SEVEN, T, elbow),
        {"T": DOWN, "elbow": 0.3},
    ),
    "elbow_angle": (
        lambda phi: kinematics.elbow_angle(SEVEN, phi),
        {"phi": np.linspace(0.1, 0.7, 7)},
    ),
    "Cut": (
        lambda **more: sim.Cut(pose="p3", **more),
        {"radius": 0.005, "speed": 0.04, "payload": 40.0},
    ),
    "Circle": (sim.Circle, {"radius": 0.003}),
    "PathLimits": (sim.PathLimits, {"acceleration": 1.0}),
    "Design": (sim.Design, {"gamma": (0.9,), "delta": (3,), "cutoff": (10.0,)}),
    "Individual": (sim.Individual, {"friction": 1.1, "gear_stiffness": 0.9}),
    "rounded": (
        sim.rounded,
        {"points": 0.01 * np.array([[0, 0], [1, 0], [0, 1]]), "corner": 0.001},
    ),
    "CircleTurn": (sim.CircleTurn, {"radius": 0.005, "start": 0.0, "end": 1.0}),
    "measure_table": (lambda gear: sim.measure_table(TABLE, gear, None), {"gear": [100.0]}),
    "GearsCfg": (sim.GearsCfg, {"band": (2.5, 16.0)}),
    "ProcessingCfg": (sim.ProcessingCfg, {"cutoff": 3.0}),
    "GuidanceLimits": (
        sim.GuidanceLimits,
        {"lower": ZERO - 2, "upper": ZERO + 2, "speed": ZERO + 1},
    ),
    "Reading": (sim.Reading, {"join": 1e-4}),
}
"""A function of keyword arguments, and ordinary values of those that are numbers or arrays."""


def _continuous():
    from scipy.signal import StateSpace

    return StateSpace([[-1.0]], [[1.0]], [[1.0]], [[0.0]])


BAD = {
    "nan": lambda given: np.full(np.shape(given), nan)[()],
    "empty": lambda given: np.zeros((0, *np.shape(given)[1:])),
    "another shape": lambda given: np.ones((2, 3, 4, 5)),
}
STATED = {
    ("Measurements", "points", "nan"): "NaN where a target was not seen",
    ("CompiledRobot", "phi", "nan"): "NaN gives NaN, by `compile`",
    ("compile_frame_pose", "phi", "nan"): "NaN gives NaN, by `compile`",
    ("compile_frame_jacobian", "phi", "nan"): "NaN gives NaN, by `compile`",
    ("inverse_path", "T", "empty"): "a path without poses has no angles",
    ("inverse_numeric_path", "T", "empty"): "a path without poses has no angles",
}
"""Results that are documented, of arguments that are not ordinary."""
CONSTANT = (
    "CATALOGUE IMU_LINKS IRB1400 IRB1400_IMU IRB1400_LIMITS IRB1400_XML LARGE_CELL LARGE_ROBOT "
    "LARGE_ROBOT_LIMITS LARGE_ROBOT_XML UR10 UR10_LIMITS assets ilc kinematics sim "
    "Convention Edge End Joint LeadIn Singularity Source Unit "
    "NotConvergedError UnreachableError UnsolvableGeometryError"
)
"""Data, packages, enumerations and errors."""
NO_NUMBERS = (
    "Arm Cell Experiment FirstOrderLaw InertialModel Iteration Law MotorAngles PartCut Plant Robot "
    "Scheduled SystemMatrix ToolPath Trial compile compile_dynamics compile_measurement "
    "compile_inverse_dynamics_jacobian h_infinity robot_toml run_imu ImuExperiment prepare"
)
"""Made of other objects of this list, which check themselves; `compile` gives functions."""
FILES = (
    "load_robot read_contour read_cut read_gear_error read_motion read_part read_poses read_robot "
    "read_run read_table read_urdf Twin"
)
"""Of a file: bad ones are in tests of their rooms, and in tests/contract."""
LONG = (
    "Egm Rsi StreamedPlant IlcTuningEnv IlcTuningVectorEnv analyse_gears calibrate commission "
    "design_from_data forecast learn reprocessed"
)
"""A connection, or seconds of work; bad input is in tests of their rooms."""


def test_every_declared_name_is_called_or_has_a_reason():
    elsewhere = " ".join((CONSTANT, NO_NUMBERS, FILES, LONG)).split()
    called = [name.removeprefix("ilc.") for name in CALLS if name != "ilc.learn"]
    assert len({*elsewhere, *called}) == len(elsewhere) + len(called)
    assert {*elsewhere, *called} == {name for _, name in homes()}


NUMPYS = (
    "broadcast",
    "zero-size",
    "at least one array",
    "out of bounds",
    "ufunc",
    "reshape",
    "matmul",
    "truth value of an array",
    "singular matrix",
    "not supported",
    "subscript",
    "could not convert",
    "only length-1",
    "inhomogeneous",
    "too many values",
    "unsupported",
    "einsum",
    "concatenat",
    "dimensions",
    "has no attribute",
    "not enough values",
    "ambiguous",
)
"""Words of messages that are numpy's or Python's own: they name no argument."""


@pytest.mark.parametrize("name", CALLS)
def test_an_ordinary_call_is_answered(name):
    function, given = CALLS[name]
    function(**given)


@pytest.mark.parametrize("kind", BAD)
@pytest.mark.parametrize(("name", "argument"), [(n, a) for n, (_, g) in CALLS.items() for a in g])
def test_what_cannot_be_is_refused_in_our_words(name, argument, kind):
    function, given = CALLS[name]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            function(**given | {argument: BAD[kind](given[argument])})
        except (ValueError, TypeError) as error:
            text = str(error)
            assert text
            assert "\n" not in text
            assert not [word for word in NUMPYS if word in text], text
            assert (name, argument, kind) not in STATED
            return
        assert (name, argument, kind) in STATED, f"{argument} of {kind} is accepted"
