"""Chapters 5 and 8 in the report: drawn, compared, and honest about what differs."""

from dataclasses import replace

import numpy as np
import pytest

from armside.scripts.figures import two_mass as two_mass_figures
from armside.scripts.jobs.store import Store, digest
from armside.scripts.thesis import chapter5, chapter8, imu_checks
from armside.scripts.thesis.imu_job import ImuJob, RestJob
from armside.scripts.thesis.report import Asked
from armside.sim.evaluation.check import Table
from armside.sim.imu import ImuExperiment, reprocessed, run_imu

ENTRIES = [*chapter5.ENTRIES, *(entry for entry in chapter8.ENTRIES if not entry.alone)]
CHAPTER = {entry.id: entry.make for entry in ENTRIES}
KNOWN_TO_DIFFER = {"E05.3", "E07.3", "S03.3", "S04.6", "S05.6", "S05.7"}
"""Idle motors that the feedforward holds; the elastic deflection of the tool, larger than the
prototype's; 11 Hz in Fig 8.6, the shift of 5 in Figs 8.7 and 8.8."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("report")


@pytest.fixture(scope="module")
def read(folder):
    """Results as a report reads them: through files."""
    store = Store(folder / "results")

    def result(job):
        if store.status(digest(job)) is None:
            store.keep(digest(job), job, job.run())
        return store.load(job)

    return result


@pytest.fixture(scope="module")
def sections(read, folder):
    """Each drawn from the results of the jobs it names, and no others."""
    drawn = {}
    for name, make in CHAPTER.items():
        part = make(Asked())
        results = {job: read(job) for job in part.jobs}
        drawn[name] = part.draw(results.__getitem__, folder)
    return drawn


def test_chapter_8_has_each_of_its_figures_and_runs_no_experiment():
    names = [name for name in CHAPTER if name.startswith("8.")]
    assert names == [f"8.{i}" for i in range(3, 13)]
    assert not any(CHAPTER[name](Asked()).jobs for name in names)


@pytest.mark.parametrize("name", CHAPTER)
def test_every_section_is_drawn_captioned_and_compared(name, sections, folder, assert_complete):
    section = sections[name]
    assert section.id == name
    assert section.checks
    if name.startswith("8."):
        assert section.figures == [f"{name}.png"]
    assert_complete(section, folder)


def test_what_differs_from_the_thesis_is_known_and_says_why(sections):
    checks = [check for section in sections.values() for check in section.checks]
    assert len({check.id for check in checks}) == len(checks)
    failing = {check.id: check.reason for check in checks if not check.holds}
    assert set(failing) == KNOWN_TO_DIFFER
    assert all(len(reason) > 40 for reason in failing.values())


def test_what_a_job_leaves_is_what_the_experiment_measured(read):
    experiment = ImuExperiment()
    done = run_imu(experiment, seed=0)[0]
    thesis = reprocessed(done, experiment.processing.as_in_the_thesis).measures
    left = read(ImuJob(individuals=chapter5.INDIVIDUALS))
    for name in ("acceleration_rms", "acceleration_window_max", "tool_distance", "since"):
        assert np.array_equal(left[name], getattr(done.measures, name))
        assert np.array_equal(left[f"as_thesis_{name}"], getattr(thesis, name))
    assert np.array_equal(left["motor_angle"], done.run.recording.motor_angle)
    assert sum(array.nbytes for array in left.values()) < 1e6


@pytest.mark.parametrize(
    ("changed", "fails"),
    [
        ({"acceleration_window_max": [0.5, 0.9, 0.2]}, {"E10.1"}),
        ({"acceleration_window_max": [0.15, 0.3, 0.2]}, {"E10.2"}),
        ({"largest_in_rectangle": [True, False, True]}, {"E10.3"}),
        ({"fast_over_slow": 2.0}, {"E10.4"}),
        ({"as_thesis_acceleration_window_max": [0.1, 0.3, 0.1]}, {"E10.5"}),
        ({"as_thesis_acceleration_window_max": [0.2, 0.3, 0.5]}, {"E10.7", "E10.8"}),
    ],
)
def test_another_error_along_the_motion_fails_where_it_differs(changed, fails, read):
    result = read(ImuJob(individuals=chapter5.INDIVIDUALS))
    other = result | {name: np.array(value) for name, value in changed.items()}
    assert {check.id for check in imu_checks.windows(other) if not check.holds} == fails


def test_a_robot_that_stands_still_has_another_noise(read):
    result = read(RestJob())
    silent = result | {"on_rms": result["off_rms"], "on_level": 3.0 * result["off_rms"]}
    flat = silent | {"on_spectrum": np.ones_like(result["on_spectrum"])}
    failing = {check.id for check in imu_checks.noise(flat) if not check.holds}
    assert failing == {"E02.2", "E02.3", "E02.4", "E02.5", "E02.6"}


@pytest.mark.parametrize(
    ("name", "row", "column", "factor", "fails"),
    [
        ("8.3", 1, "frequency [Hz]", 1.01, {"S01.1"}),
        ("8.5", 0, "2-norm of the error [rad]", 1.003, {"S02.3"}),
        ("8.6", 1, "max |1-LTu| [dB]", -1.0, {"S03.1"}),
        ("8.6", 2, "largest cutoff [Hz]", 0.9, {"S03.5"}),
        ("8.7", 7, two_mass_figures.AT_THESIS_SHIFT, 1.001, {"S04.3"}),
        ("8.7", 12, "gamma |Tu(0)|", 20.0, {"S04.5"}),
        ("8.8", 4, "k = 500", 1.01, {"S05.4"}),
        ("8.8", 2, "largest rise", 2.0, {"S05.5"}),
        ("8.11", 3, "k = 500", 0.9, {"S06.9"}),
        ("8.12", 4, "overshoot [rad]", 0.5, {"S06.11"}),
    ],
)
def test_a_figure_that_says_something_else_fails_there(
    name, row, column, factor, fails, sections, monkeypatch, folder
):
    """The verdict is that of the table that was drawn."""
    (drawn,) = sections[name].tables
    rows = [list(cells) for cells in drawn.rows]
    rows[row][drawn.columns.index(column)] *= factor
    table = replace(drawn, rows=rows)
    monkeypatch.setitem(two_mass_figures.FIGURES, name, lambda file, seed: table)
    section = CHAPTER[name](Asked()).draw({}.__getitem__, folder)
    assert {check.id for check in section.checks if not check.holds} - KNOWN_TO_DIFFER == fails


def test_a_number_of_a_table_is_found_by_the_beginning_of_its_row():
    table = Table(title="t", columns=("side", "k", "norm"), rows=[("arm", 1, 2.0), ("arm", 2, 3.0)])
    assert table.value("norm", "arm", 2) == 3.0
    with pytest.raises(KeyError, match="begins with"):
        replace(table, rows=[]).value("norm", "arm", 2)
