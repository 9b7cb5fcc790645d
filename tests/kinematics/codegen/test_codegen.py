"""One program in five languages: all of them compute the same numbers."""

import ctypes
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from armside.kinematics import IRB1400, IRB1400_IMU, LARGE_ROBOT, Convention, Joint, Link, Robot
from armside.kinematics.codegen import Language, write
from armside.kinematics.equations import dynamics, forward_kinematics, imu_equations
from armside.kinematics.equations.program import StraightLineProgram, program_of
from armside.kinematics.expressions.symbols import moving
from armside.kinematics.symbolic import procedures as symbolic

RNG = np.random.default_rng(0)
# Names that generated code has for itself, and a name that would end a comment of each language.
CONFUSING = Robot(
    [Link(a="x0", d="phi1"), Link(a="x1", alpha="x2"), Link(a="phid2", theta="T"), Link(a="NaN")],
    name='x"""; open("pwned", "w").close(); """ */ int f(void); /* \nend\r\u2028\\N{x} %} #}',
)


STRICT = {
    Language.C: ["-std=c99", "-pedantic", "-Wextra"],
    Language.FORTRAN: ["-std=f2008", "-Wno-unused-dummy-argument"],
}


def run(
    language: Language,
    program: StraightLineProgram,
    arguments: list[np.ndarray],
    folder: Path,
    compiler: str,
) -> np.ndarray:
    symbol = f"f{len(list(folder.iterdir()))}"  # a library is loaded once for each name
    files = write(program, language, symbol)
    for name, text in files.items():
        (folder / name).write_text(text)
    library, source = folder / f"{symbol}.so", folder / list(files)[-1]
    strict = ["-Wall", "-Wno-unused-variable", "-Werror", *STRICT[language]]
    command = [compiler, *strict, "-O1", "-shared", "-fPIC", "-o", library, source, "-lm"]
    subprocess.run(command, check=True, cwd=folder)
    out = np.empty(program.outputs[0].shape, order="C" if language is Language.C else "F")
    pointers = [a.ctypes.data_as(ctypes.c_void_p) for a in [*arguments, out]]
    getattr(ctypes.CDLL(str(library)), symbol)(*pointers)
    return out


def run_octave(
    programs: list[tuple[StraightLineProgram, list[np.ndarray]]], folder: Path, octave: str
):
    """All programs in one start of Octave, results printed with all their digits."""
    script = []
    for k, (program, arguments) in enumerate(programs):
        (text,) = write(program, Language.MATLAB, f"f{k}").values()
        (folder / f"f{k}.m").write_text(text)
        columns = ", ".join(f"[{';'.join(repr(float(x)) for x in a)}]" for a in arguments)
        script.append(f"y = f{k}({columns})'; printf('%.17g ', y(:)); printf('\\n');")
    command = [octave, "--no-gui", "--quiet", "--eval", f"cd '{folder}'; {' '.join(script)}"]
    output = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    lines = output.strip().splitlines()
    return [
        np.array([float(x) for x in line.split()]).reshape(program.outputs[0].shape)
        for line, (program, _) in zip(lines, programs, strict=True)
    ]


@pytest.fixture(scope="module")
def programs(random_model, random_robot):
    """Kinematics of the two robots, and a few random ones, dynamics among them, with arguments."""
    rng, fk = np.random.default_rng(1), forward_kinematics
    robots = [random_robot(rng, 2, Convention.STANDARD), random_robot(rng, 7, Convention.MODIFIED)]
    model = random_model(rng, random_robot(rng, 3, Convention.STANDARD))
    symbols = [Link("q[1](t)", "d[1]", "a[1]", "alpha[1]"), Link("q[2](t)", 0, "a[2]", 0)]
    built = [
        *(build(IRB1400) for build in (fk.pose, fk.jacobian, fk.jacobian_rate)),
        *(fk.acceleration(robot) for robot in (IRB1400_IMU, *robots, CONFUSING)),
        *(dynamics.inverse_dynamics(model), dynamics.mass_matrix(model)),
        fk.jacobian(LARGE_ROBOT),
        imu_equations.measurement(IRB1400_IMU),
        program_of("velocity", symbolic.velocity(symbols)),
        fk.jacobian(Robot([Link(0, "d[1]", "a", "phi"), Link(a="lambda")])),
    ]
    return [(p, [RNG.uniform(-1, 1, b.shape) for b in p.inputs]) for p in built]


def assert_close(actual, expected):
    scale = max(1.0, float(np.abs(expected).max()))
    np.testing.assert_allclose(actual / scale, expected / scale, rtol=0, atol=1e-12)


def test_c99_computes_what_python_computes(programs, interpreted, tmp_path, require_program):
    cc = require_program("cc")
    for program, arguments in programs:
        found = run(Language.C, program, arguments, tmp_path, cc)
        assert_close(found, interpreted(program)(*arguments))


def test_fortran_computes_what_python_computes(programs, interpreted, tmp_path, require_program):
    fc = require_program("gfortran")
    for program, arguments in programs:
        found = run(Language.FORTRAN, program, arguments, tmp_path, fc)
        assert_close(found, interpreted(program)(*arguments))


def test_matlab_computes_what_python_computes(programs, interpreted, tmp_path, require_program):
    octave = require_program("octave-cli")
    results = run_octave(programs, tmp_path, octave)
    for result, (program, arguments) in zip(results, programs, strict=True):
        assert_close(result, interpreted(program)(*arguments))


def test_python_computes_what_the_symbols_say(interpreted):
    """The full expressions of K15, evaluated by SymPy with 30 digits."""
    phi = RNG.uniform(-1, 1, 6)
    exact = [sp.Rational(repr(float(x))) for x in phi]
    for robot in (IRB1400, LARGE_ROBOT):
        T = symbolic.matrix_t(symbolic.at(robot, exact))[-1].evalf(30)
        assert_close(interpreted(forward_kinematics.pose(robot))(phi), np.array(T, dtype=float))
        J = symbolic.motor_jacobian(robot, exact).evalf(30)
        assert_close(interpreted(forward_kinematics.jacobian(robot))(phi), np.array(J, dtype=float))


def test_python_acceleration_is_the_symbolic_one(interpreted):
    phi = symbolic.motor_functions(IRB1400)
    a = symbolic.acceleration(symbolic.at(IRB1400, phi))
    program = program_of("a", a)
    names = [f"phi_{i}{d}" for d in ("", "d", "dd") for i in range(1, 7)]
    used = [str(s) for s in program.inputs[0].elements]
    assert used == [name for name in names if name != "phi_6"]  # the last axis shows no angle
    motion_ = RNG.uniform(-1, 1, (3, 6))
    values = [x for name, x in zip(names, motion_.ravel(), strict=True) if name in used]
    actual = interpreted(forward_kinematics.acceleration(IRB1400))(*motion_)
    assert_close(actual, interpreted(program)(values))


def test_c_allocates_nothing_and_states_robot_convention_units_and_orders():
    header, source = write(forward_kinematics.jacobian(IRB1400), Language.C).values()
    assert "void jacobian(const double *phi, double *J);" in header
    assert not re.search(r"malloc|static|\[\d*\]\s*=\s*\{", source)
    for text in (header, source):
        for fact in ("IRB1400", "standard Denavit-Hartenberg", "[rad]", "row by row", "6 x 6"):
            assert fact in text


def test_units_of_prismatic_joints_are_metres():
    robot = Robot([Link(a=1), Link(joint=Joint.PRISMATIC)])
    (text,) = write(forward_kinematics.pose(robot), Language.PYTHON).values()
    assert "joint variables: [rad, m]" in text
    assert "[rad];" not in text


def test_the_coupling_is_stated_in_every_language():
    for language in Language:
        text = "".join(write(forward_kinematics.pose(IRB1400), language).values())
        assert "-1.0, 1.0" in text


def test_latex_has_one_line_for_each_intermediate():
    program = forward_kinematics.pose(IRB1400)
    (text,) = write(program, Language.LATEX).values()
    assert text.count(r"\\") >= len(program.steps)
    assert r"\cos{\left(\phi_{1} \right)}" in text


def test_names_that_languages_reserve_or_confuse_are_changed():
    robot = Robot([Link(a="lambda", d="phi"), Link(a="X0", joint=Joint.PRISMATIC)])
    for language in (Language.C, Language.PYTHON, Language.FORTRAN):
        text = "".join(write(forward_kinematics.jacobian(robot), language).values())
        names = re.findall(r"^\s*(?:const double )?(\w+) = ", text, re.MULTILINE)
        assert "lambda" not in names
        assert len(names) == len({name.lower() for name in names})


def test_a_file_name_that_is_no_name_is_refused():
    with pytest.raises(ValueError, match="letters, digits and _"):
        write(forward_kinematics.pose(IRB1400), Language.C, "../pose")


def test_functions_of_time_become_names_that_code_can_use():
    """Thesis 4.2.2: q_1(t) -> q_1, its derivative -> q_1d."""
    program = program_of("w", symbolic.angular_velocity([Link("q[1](t)", 0, 0, "Pi/2")] * 2))
    assert [str(s) for s in program.inputs[0].elements] == ["q_1", "q_1d"]
    assert not any(e.has(moving("q", 1)) for _, e in program.steps)


def test_a_line_of_fortran_has_at_most_132_characters_without_an_option_of_a_compiler():
    """ISO/IEC 1539-1, free source form."""
    loads = sp.symbols("load_of_axis_1:25")
    (text,) = write(program_of("w", sp.Matrix([sum(loads)])), Language.FORTRAN, "f").values()
    lines = text.splitlines()
    assert sum(line.endswith(" &") for line in lines) == 3
    assert max(map(len, lines)) <= 132
