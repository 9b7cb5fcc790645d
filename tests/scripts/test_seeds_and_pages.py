"""Pages and fingerprints depend on what they should, and options reach the physics in SI."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from armside.scripts.cutting.cut_run import ready
from armside.scripts.cutting.options import LaserCfg
from armside.scripts.cutting.specification import cut, measure
from armside.scripts.jobs import store as room
from armside.scripts.jobs.resolved import key_of
from armside.scripts.jobs.store import code_fingerprint, digest, digest_of
from armside.scripts.thesis.pages import count, html, markdown
from armside.scripts.thesis.report import Section
from armside.sim.evaluation.check import Check, Table
from armside.sim.laser.specification import LeadIn
from armside.sim.robot.effects import Effect


@pytest.fixture
def pages(tmp_path):
    """A report with one check that holds and one that fails, as Markdown and HTML."""
    checks = [
        Check("a1", "small enough", "0.1", 0.05, high=0.1),
        Check("a2", "large enough", "0.1", 0.05, low=0.1, reason="because of this"),
    ]
    table = Table("numbers", ["k", "value"], [[0, 1.5]])
    parts = [Section("x", "Fig. X", "A caption.", (), checks, [table], {"Made by": "a command"})]
    return markdown("Title", parts), html("Title", parts, tmp_path), parts


def test_a_report_counts_what_holds_and_shows_what_fails_with_its_reason(pages):
    text, page, parts = pages
    assert count(parts) == "1 of 2 comparisons with the thesis hold"
    for made in (text, page):
        assert "1 of 2 comparisons with the thesis hold" in made
        assert "because of this" in made
        assert "a command" in made
        assert "1.5" in made
    assert "a2 fails: because of this" in text
    rows = [line for line in text.splitlines() if line.startswith("| a")]
    assert [row.split(" | ")[-1].strip("| ") for row in rows] == ["holds", "FAILS"]
    assert page.count('class="holds"') == 1
    assert page.count('class="fails"') == 1
    assert '<td class="fails">FAILS' in page


def test_numbers_that_the_thesis_does_not_have_are_no_comparisons_with_it():
    ours, its = Check("a", "ours", "", 1.0, low=0.0), Check("b", "its", "1", 2.0, high=1.0)
    both = [Section("x", "X", "", checks=[ours, its])]
    assert count(both) == (
        "0 of 1 comparisons with the thesis and 1 of 1 comparisons that it does not have hold"
    )
    assert count([Section("x", "X", "", checks=[ours])]) == "1 of 1 comparisons hold"


# Fingerprints


@pytest.fixture
def tree(tmp_path, monkeypatch):
    """Our packages as a small tree: one file of each kind that a result may depend on."""
    for package in ("assets", "kinematics", "ilc", "sim", "scripts"):
        for suffix in (".py", ".xml", ".toml", ".json", ".npz", ".md"):
            file = tmp_path / package / f"one{suffix}"
            file.parent.mkdir(exist_ok=True)
            file.write_text("1")
    monkeypatch.setattr(room, "OURS", tmp_path)
    code_fingerprint.cache_clear()
    yield tmp_path
    code_fingerprint.cache_clear()


def fingerprint(*module):
    code_fingerprint.cache_clear()
    return code_fingerprint(*module)


@pytest.mark.parametrize("package", ["assets", "kinematics", "ilc", "sim", "scripts"])
@pytest.mark.parametrize("suffix", [".py", ".xml", ".toml", ".json", ".npz"])
def test_a_result_depends_on_every_file_of_ours(tree, package, suffix):
    before, file = fingerprint(), tree / package / f"one{suffix}"
    file.write_text("2")
    assert fingerprint() != before
    file.write_text("1")
    assert fingerprint() == before
    file.rename(file.with_stem("two"))  # names count: they are imported
    assert fingerprint() != before


def test_a_result_does_not_depend_on_prose(tree):
    before = fingerprint()
    (tree / "sim/one.md").write_text("2")
    assert fingerprint() == before


@pytest.mark.parametrize("name", ["armside", "mujoco", "numpy"])
def test_a_result_depends_on_the_versions_of_what_computes_it(tree, monkeypatch, name):
    before, known = fingerprint(), room.version
    monkeypatch.setattr(room, "version", lambda n: "0.0" if n == name else known(n))
    assert fingerprint() != before


def test_a_result_depends_on_the_module_of_its_job(tree, tmp_path, monkeypatch):
    """A job of one's own, outside of our packages."""
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    module = folder / "a_job_of_mine.py"
    module.write_text("CONSTANT = 1\n")
    monkeypatch.syspath_prepend(folder)
    before = fingerprint("a_job_of_mine")
    assert before != fingerprint()
    module.write_text("CONSTANT = 2\n")
    assert fingerprint("a_job_of_mine") != before


@dataclass(frozen=True)
class AJob:
    """A job with one option."""

    option: float = 1.0


@dataclass(frozen=True)
class AnotherJob(AJob):
    """The same options, other work."""


def test_a_digest_names_the_job_and_its_options():
    assert digest(AJob()) == digest(AJob(1.0))
    assert len({digest(AJob()), digest(AJob(2.0)), digest(AnotherJob())}) == 3
    assert digest_of({"a": 1, "b": 2}) == digest_of({"b": 2, "a": 1}) != digest_of({"a": 1})


def test_the_key_of_a_cut_has_every_option_its_seed_and_the_content_of_its_files(tmp_path):
    file = tmp_path / "part.toml"
    file.write_text("points = [[0, 0], [40, 0], [40, 40], [0, 40]]\ncorner = 5\n")
    options = {
        **{"pose": "p2", "radius": 6.0, "speed": 30.0, "gamma": (0.8,), "delta": (4,)},
        **{"cutoff": (12.0,), "iterations": 3, "payload": 50.0, "plane": "tool"},
        **{"friction_spread": 1.0, "without": ("ripple",), "measure": "tracker"},
        **{"path_acceleration": 1.0, "lead_in": "spiral", "contour": file},
    }
    keys = {key_of({}, 0), key_of({}, 1)}
    keys |= {key_of({name: value}, 0) for name, value in options.items()}
    assert len(keys) == 2 + len(options)
    before = key_of({"contour": file}, 0)
    file.write_text(file.read_text().replace("corner = 5", "corner = 6"))
    assert key_of({"contour": file}, 0) != before


# Options of a cut


def test_options_of_a_cut_reach_it_in_si():
    """Millimetres, mm/s and per cent of the command line."""
    cfg = LaserCfg(
        pose="p3",
        radius=7.0,
        speed=35.0,
        payload=60.0,
        plane="tool",
        lead_in="spiral",
        path_acceleration=1.1,
        friction_spread=3.0,
        without=("ripple", "lost-motion"),
    )
    made = cut(cfg)
    assert made.curve.radius == pytest.approx(0.007)
    assert made.speed == pytest.approx(0.035)
    assert made.friction_spread == pytest.approx(0.03)
    assert (made.payload, made.across_tool, made.lead_in) == (60.0, True, LeadIn.SPIRAL)
    assert made.limits.acceleration == 1.1
    assert set(made.without) == {Effect.RIPPLE, Effect.LOST_MOTION}
    assert made.tool_pose.position == (2.2, 0.2, 1.5992)
    assert made.imu is None
    assert cut(replace(cfg, measure="estimate")).imu is not None
    moved = cut(replace(cfg, position=(1500.0, 10.0, 1600.0)))
    assert moved.tool_pose.position == pytest.approx((1.5, 0.01, 1.6))


def test_the_design_of_the_options_is_that_of_the_law():
    law = measure(LaserCfg(gamma=(0.7,), delta=(5,), cutoff=(12.0,))).design
    assert (law.gamma, law.delta, law.cutoff) == ((0.7,), (5,), (12.0,))
    path = measure(LaserCfg(measure="estimate", gamma=(0.6,), cutoff=(11.0,)))
    assert (path.law.gamma, path.law.cutoff) == (0.6, 11.0)
    assert path.stiffness_error == pytest.approx(0.3)


def test_the_seed_of_a_cut_is_that_of_its_robot_and_noise():
    first, again, other = (
        ready(cut(LaserCfg()), measure(LaserCfg()), seed).experiment for seed in (4, 4, 5)
    )
    friction = [e.loaded.model.mj.actuator_biasprm[:, 3] for e in (first, again, other)]
    assert np.array_equal(friction[0], friction[1])
    assert (friction[0] != friction[2]).all()
    assert first.seed == 4


@pytest.mark.parametrize(
    "line",
    [
        "laser --iterations 0",
        "laser --robot irb1400 --iterations 0",
        "imu --motion rest --off 3 --on 3",
    ],
)
def test_a_command_gives_the_same_numbers_for_the_same_seed_and_others_for_another(
    summary_of, monkeypatch, line
):
    for name in ("commands.laser.write", "figures.imu_results.write_rest"):
        monkeypatch.setattr(f"armside.scripts.{name}", lambda *_: None)  # files of the same numbers
    outcomes = []
    for i, seed in enumerate((3, 3, 4)):
        summary = summary_of(f"{line} --seed {seed} --quiet --out run-{i}")
        assert summary["config"]["seed"] == seed
        outcomes.append({k: v for k, v in summary.items() if k != "config"})
    assert outcomes[0] == outcomes[1]
    assert outcomes[0] != outcomes[2]
