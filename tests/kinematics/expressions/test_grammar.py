"""Arguments of Table 4.1: each form is accepted, everything else is refused and never run."""

import contextlib

import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from armside.kinematics import Link
from armside.kinematics.expressions.grammar import GrammarError, parse
from armside.kinematics.expressions.symbols import differentiate, moving, symbol, t

phi = symbol("phi")
phi1, phi2 = symbol("phi", 1), symbol("phi", 2)
f, f1, f2 = moving("phi"), moving("phi", 1), moving("phi", 2)
half = sp.pi / 2

# Every row of thesis Table 4.1, in its order.
TABLE = {
    "5": 5,
    "5.0": 5,
    "pi": sp.pi,
    "Pi/2": half,
    "phi": phi,
    "phi[1]": phi1,
    "phi(t)": f,
    "phi[1](t)": f1,
    "phi(t) + 5": f + 5,
    "phi(t) + Pi": f + sp.pi,
    "phi(t) + Pi/2": f + half,
    "phi(t) - 5": f - 5,
    "phi(t) - 5.0": f - 5,
    "phi(t) - Pi": f - sp.pi,
    "phi(t) - Pi/2": f - half,
    "-phi(t) - 5": -f - 5,
    "-phi[1](t) + 0": -f1,
    "phi[1] - phi[2]": phi1 - phi2,
    "phi[1](t) - phi[2](t)": f1 - f2,
    "phi[1] - phi[2] - 5": phi1 - phi2 - 5,
    "phi[1] - phi[2] - Pi/2": phi1 - phi2 - half,
    "phi[1](t) - phi[2](t) - 5": f1 - f2 - 5,
    "phi[1](t) - phi[2](t) - Pi": f1 - f2 - sp.pi,
}


@pytest.mark.parametrize(("text", "expected"), TABLE.items())
def test_every_form_of_table_4_1_is_read(text, expected):
    assert parse(text) == expected
    assert Link(theta=text).theta == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [("3*pi/4", 3 * sp.pi / 4), ("-π/2", -half), ("2*q[3]", 2 * symbol("q", 3)), ("1e-3", 0.001)],
)
def test_multiples_and_other_spellings_are_read(text, expected):
    assert sp.simplify(parse(text) - sp.nsimplify(expected)) == 0


@pytest.mark.parametrize(
    "text",
    [
        "",
        "__import__('os').system('true')",
        "phi.diff",
        "exec(1)",
        "phi(x)",
        "phi[1][2]",
        "phi[-1]",
        "phi1*phi2",
        "1/phi",
        "1/0",
        "phi**2",
        "(phi)",
        "5 5",
        "phi +",
        "*phi",
        "cos(t)*2)",
        "lambda: 0",
        "9" * 300,
    ],
)
def test_everything_else_is_refused(text):
    with pytest.raises(GrammarError, match=r"cannot read|at most"):
        parse(text)


@given(st.text(max_size=30))
def test_any_text_is_read_or_refused_with_a_grammar_error(text):
    with contextlib.suppress(GrammarError):
        assert isinstance(parse(text), sp.Expr)


def test_phi_and_phi_of_t_and_phi_1_of_t_are_different_variables():
    assert len({phi, phi1, f, f1}) == 4


def test_derivative_with_respect_to_a_function_of_time():
    """(4.6) is what the thesis cannot do directly; (4.7) is its result."""
    q1 = moving("q", 1)
    assert differentiate(5 * q1 + sp.cos(q1), q1) == 5 - sp.sin(q1)


def test_derivative_leaves_variables_of_similar_names_alone():
    """The trap of 4.2.2: d/dq must not reach into q_i, q(t) or dq/dt."""
    q, q_t, q1_t = symbol("q"), moving("q"), moving("q", 1)
    expression = q**2 + 3 * q_t + sp.sin(q1_t) + q_t.diff(t) * q1_t
    assert differentiate(expression, q) == 2 * q
    assert differentiate(expression, q_t) == 3
    assert differentiate(expression, q1_t) == sp.cos(q1_t) + q_t.diff(t)


@pytest.mark.parametrize("text", ["1e99999999", "1e-99999999", "1e301", "1e300*1e300", "-1e308"])
def test_numbers_beyond_floats_are_refused_at_once(text):
    with pytest.raises(GrammarError, match="is out of range: allowed are 0 and magnitudes"):
        parse(text)


@pytest.mark.parametrize("text", ["0", ".0", "0e99999999", "0.000e5"])
def test_zero_has_any_exponent(text):
    assert parse(text) == 0
