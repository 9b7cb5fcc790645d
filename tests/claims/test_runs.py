"""Runs of claims: a small slice of each, with its notes, and what it is made of."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from armside.assets import IRB1400_XML
from armside.scripts.thesis.chapter9.table import STUDIES
from armside.sim.evaluation.check import Table
from armside.sim.laser import Cut
from armside.sim.laser.design import THESIS
from armside.sim.laser.job import LearningJob
from armside.sim.notes import Cause, Note, Tally
from armside.sim.robot.effects import Effect
from armside.sim.robot.individual import Individual
from armside.sim.robot.spread import Drawn
from armside.sim.robot_file.find import find_cell
from armside.sim.tuning.rules import Rules

from .. import evidence
from ..scripts.verdicts import failing, fails_by_itself
from . import (
    _episodes,
    _learned,
    _policies,
    _twins,
    ablations,
    chapter9,
    env,
    estimation,
    first_cut,
    imu,
    imu_twin,
    laser,
    laser_irb1400,
    long_way,
    programs,
    robots,
)
from ._engine import Rows, judged, tabled
from ._learned import Learned

pytestmark = pytest.mark.usefixtures("quick_identification")

HIT = Note(cause=Cause.SATURATION, text="drives saturate: torque limit of axis 2")
TWO_LINK = str(IRB1400_XML.parent / "two_link.toml")
SAMPLED = 0.02
"""Left of a circle that is cancelled exactly: polygons of the log's samples stand for it."""


def table_of(module, cases, **given) -> Table:
    """The table of some cases of a claim."""
    rows = Rows(row for case in cases for row in module.run(case, Tally(), **given))
    return tabled(module.CLAIM, rows)


@pytest.mark.parametrize(
    ("name", "seeds"),
    [
        *((name, [0]) for name in ("laser-irb1400", "laser-irb1400-design", "imu", "imu-causes")),
        *(("imu-rest", [0]), ("imu-large", [0]), ("kinematics", [3]), ("laser", [0, 1])),
    ],
)
def test_every_statement_of_a_claim_holds_on_one_seed_of_it(name, seeds):
    """Or on two. `make claims` runs the same functions over all their seeds."""
    assert failing(judged(evidence.claim(name), seeds)) == []


def test_claim_holds_for_one_seed_at_one_pose():
    """Ten seeds at three poses: `make claims NAME=estimation`."""
    assert failing(table_of(estimation, [(0, "p2")])) == []


def test_chapter_9_holds_on_the_virtual_robot():
    assert failing(table_of(chapter9, [0])) == []


def test_an_outline_of_700_mm_is_learned_from_the_estimate():
    """One cut of a seed of development."""
    assert failing(table_of(long_way, [(100, "p2", "300 x 80 mm, 80 mm/s")])) == []


def test_targets_are_learned_on_an_unseen_individual_and_by_another_controller():
    """Seed 100 and its individual are none of those that judge; the same bars, but that of a median
    of ten after five updates, which one robot may exceed: this one leaves 0.061 of 0.06."""
    circle = "circle, radius 5 mm, 40 mm/s"
    table = table_of(programs, [(100, 1001, circle, how) for how in ("tracker", "30 % dips")])
    assert [failed for failed in failing(table) if "after five: median" not in failed] == []


def test_two_axes_learn_from_the_estimate_as_from_the_tracker():
    """An arm of two axes turns its tool as its position asks: no error of the program."""
    (row,) = estimation.CLAIM_ARMS.run((100, TWO_LINK, "p1"), Tally())
    assert not row["diverged"]
    assert row["estimate"] < 0.1 * row["rigid"]
    assert row["learned"] < 0.05 * row["start"]
    assert row["learned"] < 1.2 * row["tracked"]
    assert row["learned"] < 0.5 * row["motor"]


def test_the_irb1400_learns_from_the_estimate():
    (row,) = estimation.run_arm((100, "irb1400", "p1"), Tally())
    assert not row["diverged"]
    assert row["estimate"] < 0.4 * row["rigid"]
    assert row["learned"] < estimation.LEFT * row["start"]
    assert row["learned"] < row["motor"]


def test_every_robot_file_that_ships_is_judged():
    names = {file.name for file in estimation.robot_files()}
    assert Path(TWO_LINK).name in names
    shipped = {file.name for file in IRB1400_XML.parent.glob("*.toml")}
    assert shipped - names == {"irb1400.toml", "large_robot.toml"}
    assert {robot for _, robot, _ in estimation.CLAIM_ARMS.cases([0])} == {
        str(file) for file in estimation.robot_files()
    }


def test_motors_of_a_random_cut_are_learned_where_one_hardly_moves():
    (row,) = laser_irb1400.run_poses(104, Tally())
    assert 12.0 <= row["speed"] <= 77.0
    bar = laser_irb1400.LEARNED
    assert row["worst"] <= bar < min(row["first"], row["heuristic"])


def test_one_robot_at_one_pose_keeps_every_statement():
    rows = Rows(robots.run((7, "SCARA"), Tally(), ("p1",)))
    checks = list(robots.checks(rows, ("p1",)))
    assert len(checks) == 4
    assert all(check.holds for check in checks)


def test_no_robot_is_judged_where_or_on_whom_its_design_was_found():
    for task in robots.ROBOTS.values():
        cell = find_cell(task.path)
        assert cell.learning is not None
        judged_at = [cell.poses[name] for name in robots.POSES]
        assert all(task.training.position != pose.position for pose in judged_at)
    assert robots.TRAINING_SEED >= 100
    assert min(long_way.DEVELOPMENT) >= 100


def test_ablations_leave_out_each_effect_and_all():
    assert set(ablations.LEFT_OUT.values()) == {(), *((e,) for e in Effect), tuple(Effect)}


# Learned from motors, with measures that are made up


@pytest.fixture
def learned(monkeypatch):
    """Measures of cuts by a function of cut and seed; those asked for are listed."""

    def use(module, measures):
        asked = []

        def made_up(cut, seed, tally, design=None):
            asked.append((cut.pose, seed))
            found = Learned(measures(cut, seed, design))
            tally.add(found.notes or ([HIT] if (seed, cut.pose) == (1, "p1") else []))
            return found

        monkeypatch.setattr(module, "learned", made_up)
        return asked

    return use


def falling(last=0.4, motors=0.05):
    motor, arm = np.linspace(np.ones(6), np.full(6, motors), 6), np.linspace(1.0, last, 6)
    return dict(zip(_learned.NAMES, (motor, motor, arm, arm), strict=True))


def test_motor_side_learning_is_judged_for_every_seed_and_pose(learned):
    def measures(cut, seed, _):
        bad = seed == 6 and cut.pose == "p1"
        return falling(0.55 if bad else {"p1": 0.4, "p2": 0.6, "p3": 0.8}[cut.pose])

    asked = learned(laser, measures)
    table = judged(laser.CLAIM, [5, 6])
    fails_by_itself(failing(table), "b1:")
    assert [row[0] for row in table.rows] == [5, 6]
    assert set(asked) == {(pose, seed) for pose in ("p1", "p2", "p3") for seed in (5, 6)}
    assert failing(judged(laser.CLAIM, [5, 7])) == []
    assert laser.SHOWN == ("a1", "a3", "a4", "b1", "b6", "b7")


@pytest.mark.parametrize(
    ("module", "hit"), [(laser, "1 of 6"), (ablations, "6 of 24"), (laser_irb1400, "2 of 8")]
)
def test_claims_of_learning_count_their_limits(learned, module, hit):
    learned(module, lambda *_: falling())
    (note,) = judged(module.CLAIM, [0, 1]).notes
    assert note.text == f"{HIT.text} (in {hit} runs)"


def test_the_design_of_the_thesis_is_one_of_the_cuts_of_the_irb1400(learned):
    designs = []
    learned(laser_irb1400, lambda cut, seed, design: designs.append(design) or falling())
    (row,) = laser_irb1400.run(0, Tally())
    assert designs == [None, None, None, THESIS]
    assert row["arm p2, k = 0 [um]"] == pytest.approx(1e6)
    assert row["arm p2, k = 5 [um]"] == pytest.approx(0.4e6)


def test_a_learned_cut_is_that_of_its_seed_and_design(monkeypatch):
    asked, made = [], {"iterations": [], "notes": [HIT]}
    monkeypatch.setattr(_learned, "run", lambda *given: asked.append(given) or made)
    tally = Tally()
    _learned.learned(Cut(), 9, tally, THESIS)
    assert asked == [(Cut(), THESIS, 9)]
    assert tally.notes("runs")[0].text.endswith("(in 1 of 1 runs)")


# Notes of runs


def counted(claim, seeds) -> list[str]:
    return [note.text for note in judged(claim, seeds).notes]


@pytest.fixture
def saturated(monkeypatch):
    """Runs of the IMU that all saturate."""
    measures = SimpleNamespace(
        clock_offset_error=1e-4,
        acceleration_rms=np.full(3, 0.05),
        acceleration_window_max=np.full(3, 0.2),
        angular_velocity_rms=np.full(3, 0.01),
        **{"tool_distance": 1e-3, "loop_error": 5e-7, "idle_peaks": np.array([np.nan, 1e-4])},
    )
    inside = np.array([True, True, False])
    result = SimpleNamespace(measures=measures, fast_over_slow=4.0, largest_in_rectangle=inside)
    seeds = []
    for name, made_up in {
        "prepare": lambda experiment: [None] * (1 + (experiment.motion == "sequential")),
        "run_one": lambda *given: seeds.append(given[-1]) or result,
        "reprocessed": lambda result, _: result,
        "notes": lambda runs: [HIT for run in runs if run is result],
    }.items():
        monkeypatch.setattr(imu, name, made_up)
    imu.motions.cache_clear()
    yield SimpleNamespace(result=result, seeds=seeds)
    imu.motions.cache_clear()


def test_claims_of_the_imu_count_their_limits(saturated, monkeypatch):
    # simultaneous, and twice two in sequence
    assert counted(imu.CLAIM, [4, 6]) == [f"{HIT.text} (in 10 of 10 runs)"]
    assert saturated.seeds == [*[4] * 5, *[6] * 5]
    assert counted(imu.CLAIM_LARGE, [0, 1]) == [f"{HIT.text} (in 2 of 2 runs)"]
    assert saturated.seeds[-2:] == [0, 1]
    names = ("as chosen", "sensor delays left in", "central differences", "mapped, then filtered")

    def causes(experiment, seed, each):
        each(saturated.result)
        return [(n, saturated.result.measures) for n in (*names, "both", "rigid robot, both")]

    monkeypatch.setattr(imu, "causes", causes)
    assert counted(imu.CLAIM_CAUSES, [0, 1]) == [f"{HIT.text} (in 2 of 2 runs)"]
    rest = SimpleNamespace(
        **dict.fromkeys(("off_rms", "on_rms", "on_level"), np.full(3, 0.01)),
        **{"frequency": np.arange(50.0), "on_spectrum": np.ones((50, 3))},
    )
    run = SimpleNamespace(recording=None)
    monkeypatch.setattr(imu, "run_rest", lambda *_: SimpleNamespace(run=run, rest=rest))
    monkeypatch.setattr(imu, "saturation", lambda recording: [HIT])
    assert counted(imu.CLAIM_REST, [0, 1]) == [f"{HIT.text} (in 2 of 2 runs)"]


def test_chapter_9_runs_its_experiments_once_with_its_seed_and_counts_their_limits(monkeypatch):
    ran = []

    def noted(job):
        ran.append(job)
        return {}, [HIT] if len(ran) == 1 else []

    monkeypatch.setattr(LearningJob, "noted", noted)
    monkeypatch.setattr(chapter9, "bands_of", lambda results: [])
    tally = Tally()
    found = chapter9.results(23, tally)
    assert set(found) == set(chapter9.EXPERIMENTS)
    assert {job.seed for job in ran} == {23}
    assert len(ran) == len(set(ran))
    assert {10.0, 80.0, 100.0} <= {round(1e3 * job.cut.speed, 6) for job in ran}
    (note,) = tally.notes(chapter9.CLAIM.counted)
    assert note.text.endswith(f"(in 1 of {len(ran)} experiments)")
    for study in (*chapter9.EXPERIMENTS.values(), *STUDIES.values()):
        jobs = study.jobs(17)
        assert {job.seed for job in jobs.values()} == {17}
        assert len(set(jobs.values())) == len(jobs)


def test_sealed_episodes_are_counted_from_the_seeds_with_their_notes(monkeypatch):
    asked = []
    episode = SimpleNamespace(
        **{"ratio": 0.5, "rms_true": [1.0, 0.5], "diverged": False, "decisions": []},
        notes=([HIT], []),
    )

    def evaluate(rules, seeds, policy, threads):
        asked.append((rules.sealed, seeds))
        return [episode] * len(seeds)

    monkeypatch.setattr(_episodes, "evaluate", evaluate)
    tally = Tally()
    rules = {_episodes.BY_THESIS: Rules(sealed=True)}
    assert len(list(_episodes.episodes([3, 5], rules, tally))) == 2
    assert asked == [(True, [_episodes.TEST_SEEDS[3], _episodes.TEST_SEEDS[5]])]
    assert tally.notes("runs")[0].text.endswith("(in 2 of 4 runs)")


def test_each_run_of_a_task_is_counted_with_its_notes():
    """A corner lowers the speed of the task, in the run of a robot and of one without noise."""
    tally = Tally()
    imu_twin.uncorrected(Cut(pose="p2", speed=0.1), Drawn(1001), tally)
    _twins.left_alone(Cut(pose="p2", speed=0.1), Drawn(1001), tally)
    (note,) = tally.notes("runs")
    assert note.cause is Cause.SPEED
    assert note.text.endswith("(in 2 of 2 runs)")


def test_a_job_has_the_notes_of_its_cut():
    arrays, notes = LearningJob(cut=Cut(speed=0.1), iterations=0).noted()
    assert [note.cause for note in notes] == [Cause.SPEED]
    assert arrays["reached_speed"] < 0.1


def test_an_episode_has_the_notes_of_each_of_its_runs():
    episode = _policies.run_episode(Rules(iterations=1), 0, lambda observed: np.zeros(3))
    assert len(episode.notes) == 2


def test_random_actions_stay_in_the_spaces_with_every_kind_of_env(monkeypatch):
    monkeypatch.setattr(env, "AT_ONCE", 2)
    table = judged(env.CLAIM, range(2 * len(env.KINDS)))
    assert len(table.rows) == len(env.KINDS)
    assert failing(table) == []


# Twins by an IMU


def _turned(gear: float, ripple: float) -> Individual:
    return Individual(gear_error_phase=np.full((6, 4), gear), ripple_phase=np.full(6, ripple))


@pytest.mark.parametrize(
    ("block", "gear", "ripple"),
    [("nothing", 0.3, 0.3), ("gear errors", 0.7, 0.3), ("torque ripple", 0.3, 0.5)],
)
def test_truth_of_a_block_turns_no_other(block, gear, ripple):
    """An individual's ripple phase turns its gear error too: their sum is what a gear has."""
    blocks = imu_twin.BLOCKS[block]
    given = imu_twin.with_truth(_turned(0.2, 0.1), _turned(0.2, 0.5), blocks)
    phase = given.gear_error_phase + given.ripple_phase[:, None]
    assert phase == pytest.approx(np.full((6, 4), gear))
    assert given.ripple_phase == pytest.approx(0.1 if ripple == 0.3 else ripple)


def test_what_a_twin_predicts_is_taken_from_the_robot():
    run = imu_twin.uncorrected(Cut(pose="p2", speed=0.08), Drawn(1001), Tally())
    assert run.left(run.tool) < SAMPLED
    program = run.motion.position - run.motion.position[0]
    assert run.left(program) == pytest.approx(1.0)


def test_the_interval_of_a_task_that_is_not_corrected_does_not_count():
    ends = SimpleNamespace(low=1.0, high=3.0)
    corrections = [SimpleNamespace(prediction=ends, trusted=t) for t in (True, True, True, False)]
    inside = _twins.in_its_interval(np.array([1.0, 3.1, 0.9, 2.0]), corrections)
    assert inside.tolist() == [True, False, False]


def test_rows_of_first_cuts_have_a_cell_for_each_column():
    each, held = np.full(10, 0.01), np.arange(10) < 9
    found = {f"left_{n}": each for n in first_cut.COUNTS}
    found |= {f"inside_{n}": held for n in first_cut.COUNTS}
    found |= {"drift": each, "feedback": each, "beyond": np.append(each[:5], np.full(5, 0.5))}
    found |= {"flagged": held, "number": 1, "hinges": 0, "seconds": 1.0}
    row = first_cut.cells(found | {"correction_seconds": 1.0})
    assert (row["bad ones flagged"], row["good ones flagged"]) == ("4 of 5", "5 of 5")
    assert row["10 cuts: worst left"] == 0.01
    row = first_cut.cells_by_imu(1, 0, np.append(each, 1.1), held, 1.0)
    assert (row["worse than without"], row["inside the interval"]) == (1, 0.9)
    assert row["worst left"] == 1.1
