"""Names of users' symbols, robots and functions: right in generated code, or refused."""

import numpy as np
import pytest
import sympy as sp

from armside.kinematics import Joint, Link, Robot
from armside.kinematics.codegen import Language, numba_module, write
from armside.kinematics.equations import dynamics, forward_kinematics
from armside.kinematics.equations.inertial_model import Body, InertialModel
from armside.kinematics.equations.program import program_of
from armside.kinematics.expressions.symbols import moving, symbol
from armside.kinematics.symbolic.lagrange import symbolic_dynamics

TAKEN = ("x0", "x1", "x7", "phi1", "phi2", "phid1", "phi1_rate", "T", "J", "J_dot", "parameters")
HARMFUL = ("a); system('x'); (", "a'", 'a"', "a\nb", "a b", "1a", "", "_a", "a.b", "é", "a" * 61)


@pytest.mark.parametrize("name", TAKEN)
@pytest.mark.parametrize("build", ["pose", "jacobian", "jacobian_rate", "acceleration"])
def test_parameters_may_have_the_names_of_generated_code(name, build, interpreted):
    """The same robot with numbers in place of its symbols gives the same result."""
    rng = np.random.default_rng(0)
    a, d = rng.uniform(0.1, 1.0, 2)

    def robot(first, second) -> Robot:
        slide = Link(0.3, second, 0.2, 0.7, joint=Joint.PRISMATIC)
        return Robot([Link(0.1, 0.2, first, 1.1), slide, Link(a=first, alpha=0.4)])

    symbolic = getattr(forward_kinematics, build)(robot(symbol(name), symbol("d")))
    numeric = getattr(forward_kinematics, build)(robot(a, d))
    given = {b.name: rng.uniform(-1, 1, 3) for b in numeric.inputs}
    expected = interpreted(numeric)(*given.values())
    order = {b.name: b.elements for b in symbolic.inputs}["parameters"]
    given["parameters"] = np.array([{name: a, "d": d}[s.name] for s in order])
    actual = interpreted(symbolic)(*(given[b.name] for b in symbolic.inputs))
    np.testing.assert_allclose(actual, expected, rtol=0, atol=1e-14)


def test_masses_may_have_the_names_of_the_regressor(interpreted):
    m1 = symbol("m1")
    model = InertialModel(Robot([Link(a=m1)]), [Body(mass=m1)])
    program = dynamics.parametric_torque(model)
    theta, motion = np.arange(1.0, 11.0), [[0.3], [0.4], [0.5]]
    of_one = InertialModel(Robot([Link(a=2.0)]), [Body(mass=2.0)])
    expected = interpreted(dynamics.parametric_torque(of_one))(*motion, theta)
    inputs = {"theta": theta, "parameters": [2.0]}
    given = [inputs.get(b.name) for b in program.inputs[3:]]
    np.testing.assert_allclose(interpreted(program)(*motion, *given), expected, atol=1e-12)


@pytest.mark.parametrize("language", Language)
@pytest.mark.parametrize("name", HARMFUL)
def test_names_that_are_no_names_are_refused(name, language):
    program = forward_kinematics.pose(Robot([Link(a=sp.Symbol(name, real=True))]))
    with pytest.raises(ValueError, match="cannot name a symbol in code"):
        write(program, language)


@pytest.mark.parametrize("name", [*HARMFUL[:6], "lambda", "double", "function"])
def test_functions_need_names_that_all_languages_have(name):
    program = program_of(name, symbol("a") + 1)
    with pytest.raises(ValueError, match="cannot name a function in code"):
        numba_module(program)
    with pytest.raises(ValueError, match="cannot name a function in code"):
        write(program_of("f", symbol("a") + 1), Language.C, name or "1")


def test_a_function_may_have_the_name_of_a_variable():
    program = forward_kinematics.jacobian(Robot([Link(a="a")]))
    for name in ("J", "phi1", "x0", "a"):
        (text,) = write(program, Language.FORTRAN, name).values()
        assert f"subroutine {name}(" in text
        assert f"real(dp) :: {name}\n" not in text


@pytest.mark.parametrize(
    "theta", [sp.Function("system")(symbol("a")), moving("q"), sp.atan(symbol("a")), sp.I * 1.0]
)
def test_what_code_cannot_compute_is_refused(theta):
    with pytest.raises(ValueError, match=r"code computes sums|must be a finite real number"):
        write(forward_kinematics.pose(Robot([Link(theta)])), Language.C)


def test_a_robots_name_ends_no_comment():
    name = 'x"""; open("pwned", "w").close(); """ */ int f(void); /* \nend\r\\N{x}'
    program = forward_kinematics.pose(Robot([Link(a=1)], name=name))
    for language in Language:
        for text in write(program, language).values():
            assert "pwned" in text
            code = [line for line in text.splitlines() if "pwned" not in line]
            assert not any("int f(void)" in line or line.strip() == "end\\N{x}" for line in code)
    compile(numba_module(program), "module", "exec")
    assert numba_module(program).count('"""') == 2
    assert "*/ int" not in write(program, Language.C)["pose.c"]


def test_one_name_for_two_variables_is_refused():
    """phi_1(t) becomes phi_1 in code, and so does phi[1]."""
    with pytest.raises(ValueError, match="two variables are called phi_1 in code"):
        program_of("f", moving("phi", 1) + symbol("phi", 1))


def test_expanded_dynamics_keep_the_names_of_the_motor_angles():
    model = InertialModel(Robot([Link(a="phi1")]), [Body(mass=1)])
    with pytest.raises(ValueError, match="phi1 of robot"):
        symbolic_dynamics(model)


def test_a_variable_without_an_index_comes_before_those_with_one():
    program = program_of("f", sum(sp.symbols("a_10 a_2 a a_1")))
    assert [str(one) for one in program.inputs[0].elements] == ["a", "a_1", "a_2", "a_10"]
