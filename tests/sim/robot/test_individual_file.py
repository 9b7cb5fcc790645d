"""Files of individuals: read as written, to the last bit; refused in one line with the field."""

from dataclasses import fields

import numpy as np
import pytest

from armside import assets
from armside.sim.robot.alien import AlienEffect
from armside.sim.robot.individual import NOT_NUMBERS, HiddenHinge, Individual
from armside.sim.robot.individual_file import PARAMETERS, individual_toml, read_individual
from armside.sim.robot.model import load_model
from armside.sim.robot.spread import Drawn

HINGE = 'body = "tube"\naxis = [0, 1, 0]\nstiffness = 2e6\ndamping = 400\n'


def read(tmp_path, text):
    file = tmp_path / "mine.toml"
    file.write_text(text)
    return read_individual(file)


@pytest.mark.parametrize("xml", [assets.LARGE_ROBOT_XML, assets.IRB1400_XML])
def test_what_is_written_is_read_to_the_last_bit(tmp_path, xml):
    design = load_model(xml)
    for individual in (Drawn(number).of(design) for number in range(8)):
        again = read(tmp_path, individual_toml(individual))
        for name in PARAMETERS:
            assert np.array_equal(getattr(again, name), getattr(individual, name)), name
        assert again.hidden == individual.hidden


def test_every_parameter_can_be_written():
    assert {*PARAMETERS, *NOT_NUMBERS} == {field.name for field in fields(Individual)}


def test_an_alien_is_not_written_as_if_it_were_none():
    with pytest.raises(ValueError, match="no file: hose"):
        individual_toml(Individual(alien=(AlienEffect("hose"),)))


def test_an_empty_file_is_the_design(tmp_path):
    same = read(tmp_path, "")
    for name in PARAMETERS:
        assert np.array_equal(getattr(same, name), getattr(Individual(), name)), name


def test_one_factor_serves_all_hinges_of_the_structure(tmp_path):
    assert read(tmp_path, "structure_stiffness = 0.8").structure_stiffness == 0.8


def test_a_hidden_hinge_lies_on_the_origin_of_its_body_unless_told_otherwise(tmp_path):
    expected = HiddenHinge(body="tube", axis=(0, 1, 0), stiffness=2e6, damping=400)
    assert read(tmp_path, f"[[hidden]]\n{HINGE}").hidden == (expected,)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("frictoin = [1,1,1,1,1,1]", "the file has the unknown key 'frictoin'; keys: friction,"),
        ("friction = [[1,1]]", "friction must be one number or one for each axis, got shape"),
        ("friction = [1,1,1,1,1,0]", "friction must be from 0.01 to 100, got 0"),
        ("mass = [1,1,1,1,1,-2]", "mass must be from 0.01 to 100, got -2"),
        ("mass = [1,1,1,1,1,nan]", "mass must be from 0.01 to 100, got nan"),
        ("mass = [1,1,1,1,1,1e308]", "mass must be from 0.01 to 100, got 1e"),
        ("viscous = 'much'", "viscous must be numbers, got 'much'"),
        ("viscous = [true,true,true,true,true,true]", "viscous must be numbers, got"),
        ("viscous = []", "viscous must be numbers, got"),
        ("viscous = [[1,2],[1]]", "viscous must be rows of equal length"),
        (
            "gear_error = [1,1,1,1,1,1]",
            "gear_error must be one number or one row of 4",
        ),
        ("position = [[1,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0]]", "from -0.1 to 0.1 m, got"),
        ("hidden = 3", r"hidden must be tables \[\[hidden\]\], got 3"),
        ("hidden = [3]", r"hidden hinge 1 must be a table \[\[hidden\]\], got 3"),
        ("[[hidden]]\nbody = 'tube'", "hidden hinge 1 lacks axis, stiffness, damping"),
        (f"[[hidden]]\n{HINGE}spring = 1", "hidden hinge 1 has the unknown key 'spring'; keys: b"),
        (f"[[hidden]]\n{HINGE.replace('2e6', '0')}", "hidden hinge 1: stiffness must be from 1000"),
        (f"[[hidden]]\n{HINGE.replace('1, 0', '0, 0')}", "hidden hinge 1: axis must not be zero"),
        (f"[[hidden]]\n{HINGE.replace(', 0]', ']')}", "hidden hinge 1: axis must be 3 finite"),
        (
            f"[[hidden]]\n{HINGE.replace('400', '[400]')}",
            "hidden hinge 1: damping must be a finite",
        ),
        ("friction = [1,", "mine.toml: "),
        ("a = " + "[" * 50_000, "mine.toml: "),
        ("# " + "x" * 200_000, "at most 100000 bytes"),
        ("mass = [1,1,1,1,1," + "9" * 400 + "]", "mass must be from 0.01 to 100, got 9"),
    ],
)
def test_a_file_that_is_none_is_refused_in_one_line(tmp_path, text, said):
    with pytest.raises(ValueError, match=said) as caught:
        read(tmp_path, text)
    assert str(caught.value).startswith("mine.toml: ")
    assert "\n" not in str(caught.value)


def test_a_file_that_is_not_there_says_what_an_individual_can_be(tmp_path):
    with pytest.raises(ValueError, match="is no file; an individual is a number >= 0 or a TOML"):
        read_individual(tmp_path / "1e3")
    with pytest.raises(ValueError, match="is no file"):
        read_individual(tmp_path)
