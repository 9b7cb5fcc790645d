"""Compiled functions: arguments, batches, the cache, and laws that hold for every robot."""

import os
import pickle
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armside.arrays import read_only
from armside.kinematics import (
    IRB1400,
    LARGE_ROBOT,
    Body,
    Convention,
    InertialModel,
    Link,
    Motor,
    Robot,
    compile,
    compile_dynamics,
    compile_measurement,
)
from armside.kinematics.equations import forward_kinematics
from armside.kinematics.rigid import link_frames

ROOT = Path(__file__).parents[2]
RNG = np.random.default_rng(0)
ROUNDING = 1e-14
"""Of numbers up to 10 that another function, or a loop of another length, computes likewise."""
PHI, PHI_DOT, PHI_DDOT = RNG.uniform(-1, 1, (3, 7, 6))
ONE_BODY = InertialModel(LARGE_ROBOT, [Body(mass=0)] * 3 + [Body(mass=10)] + [Body(mass=0)] * 2)


@pytest.fixture(scope="module")
def irb1400():
    return compile(IRB1400)


def test_a_batch_is_its_rows(irb1400):
    motion = PHI, PHI_DOT, PHI_DDOT
    for name, count in (("pose", 1), ("jacobian", 1), ("acceleration", 3)):
        function = getattr(irb1400, name)
        rows = [function(*one) for one in zip(*motion[:count], strict=True)]
        np.testing.assert_allclose(function(*motion[:count]), rows, rtol=0, atol=ROUNDING)


def test_out_is_filled_and_returned(irb1400):
    strided = np.zeros((6, 12))[:, ::2]
    for phi, out in ((PHI[0], np.empty((6, 6))), (PHI, np.empty((7, 6, 6))), (PHI[0], strided)):
        assert irb1400.jacobian(phi, out=out) is out
        assert np.array_equal(out, irb1400.jacobian(phi))


def test_any_array_like_gives_the_same_result(irb1400):
    phi, expected = read_only(PHI), irb1400.pose(PHI[0])
    for same in (PHI[0].tolist(), np.asfortranarray(PHI)[0], phi[0]):
        assert np.array_equal(irb1400.pose(same), expected)
    assert np.array_equal(irb1400.pose(phi), irb1400.pose(PHI))
    assert np.array_equal(irb1400.pose([1, 0, 0, 0, 0, 0]), irb1400.pose(np.eye(6)[0]))


REFUSED = [
    *(([x], {}, r"shapes \(6,\) or \(N, 6\)") for x in (np.zeros(5), np.zeros((2, 7)), 0.0)),
    ([np.zeros((1, 1, 6))], {}, r"shapes \(6,\) or \(N, 6\)"),
    ([PHI, PHI_DOT[:6], PHI_DDOT], {}, r"got \(7, 6\), \(6, 6\), \(7, 6\)"),
    ([PHI[0], PHI_DOT[0, :5], PHI_DDOT[0]], {}, "arguments must have shapes"),
    ([PHI[0]], {"out": np.empty((3, 4))}, r"out must be float64 of shape \(4, 4\)"),
    ([PHI[0]], {"out": np.empty((4, 4), np.float32)}, "got float32"),
    ([np.ones(6) * 1j], {}, "arguments must be real numbers"),
    ([np.ma.masked_array(np.zeros(6), [1] * 6)], {}, "arguments must be real numbers"),
    ([["0"] * 6], {}, "arguments must be real numbers"),
]


@pytest.mark.parametrize(("arguments", "options", "said"), REFUSED, ids=range(len(REFUSED)))
def test_what_no_function_can_take_is_refused(irb1400, arguments, options, said):
    function = irb1400.pose if len(arguments) == 1 else irb1400.acceleration
    with pytest.raises(ValueError, match=said):
        function(*arguments, **options)


def test_gravity_of_an_imu_has_three_components():
    with pytest.raises(ValueError, match=r"gravity must have shape \(3,\), got \(2,\)"):
        compile_measurement(IRB1400, gravity=(0.0, -9.82))


def test_an_imu_at_rest_reads_the_opposite_of_gravity_by_its_orientation_and_no_rate():
    arm, g = Robot([Link(a=0.4), Link(a=0.3, alpha=1.0)]), np.array([1.0, -2.0, -9.0])
    phi = np.array([0.3, -0.5])
    y = compile_measurement(arm, gravity=tuple(g)).reading(phi, 0 * phi, 0 * phi)
    R = compile(arm).pose(phi)[:3, :3]
    np.testing.assert_allclose(y[:2], phi)
    np.testing.assert_allclose(y[2:5], 0.0, atol=1e-12)
    np.testing.assert_allclose(y[5:], -R.T @ g, atol=1e-12)


@pytest.mark.parametrize("first", [0, 3, 90])
def test_out_may_overlap_the_arguments_of_a_batch(first):
    """Rows of the result are written over rows of phi that are still to be read."""
    functions, n = compile_dynamics(ONE_BODY), 7
    memory = np.zeros(6 * n + 100)
    phi = memory[: 6 * n].reshape(n, 6)
    phi[:] = PHI
    expected = functions.gravity_torque(PHI)
    out = memory[first : first + 6 * n].reshape(n, 6)
    assert np.array_equal(functions.gravity_torque(phi, out=out), expected)


def test_out_may_be_the_argument_of_a_single_call():
    functions = compile_dynamics(ONE_BODY)
    phi, rate, torque = PHI[0].copy(), PHI_DOT[0].copy(), PHI_DDOT[0].copy()
    expected = functions.inverse_dynamics(phi, rate, torque)
    assert functions.inverse_dynamics(phi, rate, torque, out=torque) is torque
    assert np.array_equal(torque, expected)


@pytest.mark.parametrize("out", [np.empty((12, 12), int), np.empty((12, 11)), [[0.0] * 12] * 12])
def test_out_of_a_rate_jacobian_is_checked_like_any_other(out):
    with pytest.raises(ValueError, match=r"out must be float64 of shape \(12, 12\)"):
        compile_dynamics(ONE_BODY).rigid_rate_jacobian(np.zeros(12), np.zeros(6), out=out)


def test_nan_stays_nan_and_leaves_what_does_not_depend_on_it(irb1400):
    phi = PHI[0].copy()
    phi[5] = np.nan  # turns the tool about its own axis
    T = irb1400.pose(phi)
    assert np.isnan(T[:3, :2]).all()
    assert np.array_equal(T[:, 2:], irb1400.pose(PHI[0])[:, 2:])


def test_friction_of_a_rate_that_is_nan_is_nan():
    model = InertialModel(Robot([Link(a=1)]), [Body(mass=1)], [Motor(coulomb=1.0)], (0, 0, 0))
    assert np.isnan(compile_dynamics(model).bias_torque([0.0], [np.nan])).all()


def test_a_robot_with_symbols_cannot_be_compiled():
    import sympy

    with pytest.raises(ValueError, match="needs a robot of numbers; robot has symbols: a1"):
        compile(Robot([Link(a=sympy.Symbol("a1"))]))


CASES = [(n, convention) for n in (1, 2, 3, 5, 8) for convention in Convention]


@pytest.mark.parametrize(("n", "convention"), CASES)
def test_random_robots_obey_the_product_and_its_derivatives(
    n, convention, random_robot, interpreted
):
    rng = np.random.default_rng(n)
    robot = random_robot(rng, n, convention)
    pose, jacobian = (
        interpreted(forward_kinematics.pose(robot)),
        interpreted(forward_kinematics.jacobian(robot)),
    )
    phi, rate, rate_dot = rng.uniform(-1, 1, (3, n))
    np.testing.assert_allclose(pose(phi), link_frames(robot, phi)[-1], rtol=0, atol=1e-13)

    h = 1e-5  # central differences of O(1) lengths: truncation 1e-10, rounding 1e-11

    def twist(t: float) -> np.ndarray:
        at = phi + rate * t + rate_dot * t * t / 2
        return jacobian(at) @ (rate + rate_dot * t)

    T, ahead, behind = (link_frames(robot, phi + rate * t)[-1] for t in (0, h, -h))
    T_dot = (ahead - behind) / (2 * h)
    spin = T_dot[:3, :3] @ T[:3, :3].T
    expected = [*T_dot[:3, 3], spin[2, 1], spin[0, 2], spin[1, 0]]
    np.testing.assert_allclose(twist(0.0), expected, rtol=0, atol=3e-9)
    acceleration = interpreted(forward_kinematics.acceleration(robot))(phi, rate, rate_dot)
    differences = (twist(h) - twist(-h)) / (2 * h)
    np.testing.assert_allclose(acceleration, differences, rtol=0, atol=3e-9)
    J_dot = interpreted(forward_kinematics.jacobian_rate(robot))(phi, rate)
    np.testing.assert_allclose(
        jacobian(phi) @ rate_dot + J_dot @ rate, acceleration, rtol=0, atol=1e-12
    )


def test_compiled_code_is_the_interpreted_code(interpreted, random_robot, tmp_path):
    rng = np.random.default_rng(8)
    robot = random_robot(rng, 3, Convention.MODIFIED)
    functions = compile(robot, cache=tmp_path)
    phi, rate, rate_dot = rng.uniform(-1, 1, (3, 3))
    for name, arguments in (("pose", (phi,)), ("acceleration", (phi, rate, rate_dot))):
        expected = interpreted(getattr(forward_kinematics, name)(robot))(*arguments)
        actual = getattr(functions, name)(*arguments)
        np.testing.assert_allclose(actual, expected, rtol=0, atol=1e-14)


PROGRAM = """
import sys, time
from armside.kinematics import LARGE_ROBOT, compile
import numpy as np
start = time.process_time()  # other work on the machine does not count
functions = compile(LARGE_ROBOT, cache=sys.argv[1] or None)
for name in sys.argv[2:]:
    result = getattr(functions, name)(*np.ones((3 if name == "acceleration" else 1, 6)))
print(time.process_time() - start, "sympy" in sys.modules, result.tobytes().hex())
"""


def run_program(folder: str, *names: str, **environment: str) -> tuple[float, bool, str]:
    output = subprocess.run(
        [sys.executable, "-c", PROGRAM, folder, *names],
        cwd=ROOT,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    seconds, sympy_loaded, result = output.split()
    return float(seconds), sympy_loaded == "True", result


def test_first_use_is_quick_and_the_next_process_finds_the_cache(tmp_path):
    names = ("pose", "jacobian", "acceleration")
    first, generated, result = run_program(str(tmp_path), *names)
    second, generated_again, same = run_program(str(tmp_path), *names)
    assert generated
    assert not generated_again
    assert same == result
    assert first < 3 * 5.0, "first use of pose, Jacobian and acceleration: 5 s"
    assert second < 1.0


def test_without_a_writable_home_everything_works(tmp_path):
    """The cache folder cannot be made below a file, by any user."""
    blocked = tmp_path / "file"
    blocked.write_text("")
    places = {"HOME": str(blocked), "XDG_CACHE_HOME": str(blocked / "cache")}
    hexadecimal = run_program("", "pose", **places)[2]
    T = np.frombuffer(bytes.fromhex(hexadecimal)).reshape(4, 4)
    np.testing.assert_allclose(T, link_frames(LARGE_ROBOT, np.ones(6))[-1], rtol=0, atol=1e-13)


def test_compiled_functions_can_be_sent_to_another_process(irb1400):
    copy = pickle.loads(pickle.dumps(irb1400))
    assert np.array_equal(copy.pose(PHI[0]), irb1400.pose(PHI[0]))


@settings(max_examples=100, deadline=None)
@given(phi=st.tuples(*[st.floats(-7, 7)] * 6).map(np.array))
def test_pose_is_a_rigid_motion_and_the_jacobian_its_derivative_anywhere(irb1400, phi):
    R = irb1400.pose(phi)[:3, :3]
    np.testing.assert_allclose(R.T @ R, np.eye(3), rtol=0, atol=1e-14)
    assert np.linalg.det(R) > 0
    h, J = 1e-6, irb1400.jacobian(phi)
    for i, step in enumerate(h * np.eye(6)):
        T_dot = (irb1400.pose(phi + step) - irb1400.pose(phi - step)) / (2 * h)
        spin = T_dot[:3, :3] @ R.T
        column = [*T_dot[:3, 3], spin[2, 1], spin[0, 2], spin[1, 0]]
        np.testing.assert_allclose(J[:, i], column, rtol=0, atol=1e-8)


def test_results_do_not_depend_on_threads(irb1400):
    from concurrent.futures import ThreadPoolExecutor

    phi = RNG.uniform(-1, 1, (20_000, 6))
    whole = irb1400.jacobian(phi)
    with ThreadPoolExecutor(2) as pool:
        parts = list(pool.map(irb1400.jacobian, np.split(phi, 8)))
    np.testing.assert_allclose(np.concatenate(parts), whole, rtol=0, atol=ROUNDING)


def test_batches_cost_less_than_a_microsecond_each(irb1400):
    """0.3 us each on an idle core; three times that here."""
    phi = RNG.uniform(-1, 1, (100_000, 6))
    for function, shape in ((irb1400.pose, (4, 4)), (irb1400.jacobian, (6, 6))):
        out, times = np.empty((len(phi), *shape)), []
        for _ in range(5):
            start = time.process_time()
            function(phi, out=out)
            times.append(time.process_time() - start)
        assert np.median(times) / len(phi) < 3 * 0.3e-6
