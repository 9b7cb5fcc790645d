"""Filters of records, and the gate that records pass."""

import inspect
import pkgutil
import subprocess
import sys
from collections.abc import Iterator
from importlib import import_module
from typing import Any

import numpy as np
import pytest

import armside.ilc
from armside.ilc.filters import AllPass, End, ZeroPhaseButterworth, butterworth, shift
from armside.ilc.models.system import System
from armside.ilc.records import as_record, records

NOT_RECORDS = {
    # responses and frequencies
    "omega", "frequency", "deltas", "cutoffs", "T_u", "L", "Q", "response",
    # matrices, covariances and coefficients
    "A", "B", "C", "R", "D", "B0", "B1", "G", "GWG", "W", "Z", "P", "num", "den", "a", "b",
    "matrix", "gamma", "covariance", "poles", "taps", "coefficients",
    "start", "start_covariance", "prior", "prior_sd", "pattern", "normal",
    # sizes of errors over iterations, other values of any shape
    "size", "first", "norms", "measure", "without_learning", "iterations", "radii", "r_ref",
    "memory", "second", "starts", "further", "place", "wanted",
    # lines of a spectrum, sizes of inputs, ratios of variances
    "lines", "rms", "ratio", "K", "start_factor",
    # functions of a basis, (N, n, p), and their parameters
    "basis", "bases", "corrections", "parameters",
}  # fmt: skip
"""Parameters that are arrays and no records; some of them are checked where they are used."""
CHECKED_INSIDE = {"as_real", "as_record", "as_samples", "as_measured", "as_whole"} | {
    "fit_circle",
    "KinematicFilter.filtered",
    "KinematicFilter.smoothed",
    "friction",
    "path_accuracy",
    "path_repeatability",
    "per_sample",
    "FirstOrderLaw.__call__",  # abstract
    "Task.check",  # a field: the gate of a controller, or nothing
    "learn",
}
"""Functions that call the gate themselves, with a test of their own below or elsewhere."""
INTERNAL = {
    "QuadraticProblem", "Factored", "Realisation",
    "solve_factored", "solve_matrix_free", "conjugate_gradients",
    "excess", "pairwise_independence",
    "by_frequency", "measured", "rms_and_peak",  # of a bench, which makes its records itself
}  # fmt: skip
"""Behind a law, a model or a fit, whose records have passed its gate."""


def public_functions() -> Iterator[tuple[str, Any]]:
    """Functions and methods of all modules, `__call__` among them."""
    for info in pkgutil.walk_packages(armside.ilc.__path__, "armside.ilc."):
        module = import_module(info.name)
        for name, value in vars(module).items():
            if name.startswith("_") or getattr(value, "__module__", None) != module.__name__:
                continue
            if inspect.isfunction(value):
                yield name, value
            elif inspect.isclass(value) and not getattr(value, "_is_protocol", False):
                for method, function in vars(value).items():
                    if inspect.isfunction(function) and (
                        method == "__call__" or not method.startswith("_")
                    ):
                        yield f"{name}.{method}", function


def array_parameters(function) -> list[str]:
    annotated = inspect.signature(function).parameters.values()
    return [
        p.name
        for p in annotated
        if any(kind in str(p.annotation) for kind in ("float64", "ArrayLike", "_SupportsArray"))
        and "Callable" not in str(p.annotation)
    ]


FUNCTIONS = dict(public_functions())
GATED = {name: f for name, f in FUNCTIONS.items() if hasattr(f, "__records__")}


def test_no_public_function_takes_a_record_past_the_gate():
    past = {
        name: missing
        for name, function in FUNCTIONS.items()
        if name not in CHECKED_INSIDE
        and name.split(".")[0] not in INTERNAL
        and (
            missing := sorted(
                set(array_parameters(function))
                - set(getattr(function, "__records__", ()))
                - NOT_RECORDS
            )
        )
    }
    assert past == {}


def test_the_walk_finds_the_surface():
    assert len(GATED) > 40
    some = {"shift", "System.simulate", "Heuristic.__call__", "fit_arx", "Smoother.__call__"}
    assert some <= set(GATED)


HOSTILE = {
    "complex": np.ones((20, 2), dtype=complex),
    "masked": np.ma.masked_less(np.arange(40.0).reshape(20, 2), 5),
    "infinite": np.full((20, 2), np.inf),
    "empty": np.empty((0, 2)),
    "no columns": np.empty((20, 0)),
    "one axis": np.ones(20),
    "three axes": np.ones((2, 20, 2)),
    "text": np.full((20, 2), "1"),
    "objects": np.full((20, 2), None),
}


@pytest.mark.parametrize("name", GATED)
def test_the_gate_refuses_each_hostile_record_by_name(name):
    function = GATED[name]
    for record in function.__records__:
        for what, hostile in HOSTILE.items():
            given = {
                p: np.ones((20, 2)) if p in function.__records__ else None
                for p in inspect.signature(function).parameters
            } | {record: hostile}
            positional = given.values()
            if what == "infinite" and name in ("two_norm", "inf_norm"):
                continue  # sizes of a diverged error
            with pytest.raises(ValueError, match=f"^{record} must"):
                function(*positional)


def test_a_missing_value_is_refused_where_it_has_no_meaning():
    record = np.ones((20, 1))
    record[3] = np.nan
    with pytest.raises(ValueError, match="signal must be finite, got nan at sample 3, column 0"):
        ZeroPhaseButterworth(10.0, 0.004)(record)


def test_records_of_one_law_must_have_one_shape():
    @records("u", "e")
    def gated(u, e):
        return u + e

    law: Any = gated

    with pytest.raises(ValueError, match=r"u and e must have one shape, got \(5, 1\) and \(5, 6\)"):
        law(np.ones((5, 1)), np.ones((5, 6)))
    with pytest.raises(ValueError, match="one shape"):
        law(np.ones((5, 1)), e=np.ones((4, 1)))
    with pytest.raises(TypeError, match="positional"):
        law(*[np.ones((5, 1)), np.ones((5, 1)), np.ones(3)])


@pytest.mark.parametrize("dtype", [np.int8, np.int64, np.float32])
def test_filters_and_shifts_compute_in_double_precision(dtype):
    record = np.random.default_rng(0).integers(0, 50, (80, 6))
    cutoff = (5.0, 10.0, 15.0, 20.0, 25.0, 30.0)
    functions = [
        ZeroPhaseButterworth(cutoff, 0.004),
        System(np.array([0, 0.5]), np.array([1, -0.5]), 0.004).simulate,
        lambda signal: shift(signal, 2),
    ]
    for function in functions:
        result = function(record.astype(dtype))
        assert result.dtype == np.float64
        np.testing.assert_array_equal(result, function(record.astype(float)))


def test_lists_and_masked_arrays_without_masked_values_are_records():
    assert as_record([[1, 2], [3, 4]], "u").dtype == np.float64
    assert as_record(np.ma.masked_array(np.ones((3, 1))), "u").shape == (3, 1)


SAMPLE_TIME = 0.004


def test_coefficients_are_the_reference_values_m5():
    (b, a), *others = butterworth(17.0, 0.01, 2)
    assert not others
    np.testing.assert_allclose(b, [0.159987886, 0.319975772, 0.159987886], atol=1e-8)
    np.testing.assert_allclose(a, [1, -0.594888940, 0.234840484], atol=1e-8)


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_the_gain_is_one_half_at_the_cutoff_and_one_at_rest(order):
    Q = ZeroPhaseButterworth(10.0, SAMPLE_TIME, order)
    gains = Q.response([0.0, 2 * np.pi * 10.0 * SAMPLE_TIME])
    np.testing.assert_allclose(gains, [1.0, 0.5], atol=1e-12)


def test_the_shift_looks_ahead_for_positive_delta_and_holds_or_clears_the_end():
    record = np.array([[1.0], [2.0], [3.0], [4.0]])
    assert shift(record, 1)[:, 0].tolist() == [2, 3, 4, 4]
    assert shift(record, 1, End.ZERO)[:, 0].tolist() == [2, 3, 4, 0]
    assert shift(record, -2)[:, 0].tolist() == [1, 1, 1, 2]
    assert shift(record, -2, End.ZERO)[:, 0].tolist() == [0, 0, 1, 2]
    assert shift(record, 0)[:, 0].tolist() == [1, 2, 3, 4]


def test_q_equal_to_one_returns_a_copy():
    record = np.ones((3, 1))
    filtered = AllPass()(record)
    assert filtered is not record
    np.testing.assert_array_equal(filtered, record)
    np.testing.assert_array_equal(AllPass().response([0.0, 1.0]), [1.0, 1.0])


def test_importing_the_laws_spares_the_slow_imports():
    slow = ("scipy.signal", "control", "matplotlib", "numba", "sympy")
    code = f"import sys, ilc; print([m for m in {slow} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("cutoff", [[5.0, 10.0], np.array([5.0, 10.0])], ids=["list", "array"])
def test_cutoffs_are_the_same_filter_in_whatever_they_are_given(cutoff):
    filters = {ZeroPhaseButterworth(given, 0.004) for given in (cutoff, (5.0, 10.0))}
    assert len(filters) == 1
