"""`armside reproduce papers`: verdicts from results, and checks of their own form."""

from functools import partial

import numpy as np
import pytest

from armside.ilc.bench_study import ESTIMATES, BenchEstimation, BenchLearning
from armside.scripts.cli import main
from armside.scripts.commands import reproduce as command
from armside.scripts.thesis import chapter_papers as papers
from armside.scripts.thesis.entries import select
from armside.scripts.thesis.pages import columns, count, markdown
from armside.scripts.thesis.paper_bands import BANDS, DEVELOPMENT, JUDGEMENT
from armside.scripts.thesis.report import Asked
from armside.sim.laser.strokes import StrokesJob, fields_of_numbers
from armside.sim.papers.tool_estimates import ToolEstimates
from armside.sim.papers.two_stage import TwoStageJob
from armside.sim.papers.unseen import UnseenEdge, UnseenSpeed


def results(job, *, motor=0.05, motors_ring=1.4, better=0.4, doubled=0.45, left=0.4):
    """Those of a bench and an arm that do as the papers say."""
    if isinstance(job, BenchLearning):
        fall = np.linspace(1.0, 0.0, 10)[:, None] * [0.354, 0.91]
        last = {"reference": 0.03, "torque M": motor, "torque L": 0.02}
        return {law: np.maximum(fall, size) for law, size in last.items()}
    if isinstance(job, BenchEstimation):
        sizes = dict(zip(ESTIMATES, (0.3, 0.1, 0.1, 0.1, 0.2, 0.17, 0.15), strict=True))
        return {name: np.array(size) for name, size in sizes.items()}
    if isinstance(job, ToolEstimates):
        sizes = {"motor": 1.0, "smoother": 0.4, "online": 0.5, "smoother doubled": doubled}
        sizes |= {"online doubled": 0.6} | (
            {} if job.geometry else {"ours": 0.1, "ours doubled": 0.1}
        )
        return {name: 1e-3 * size * np.ones(3) for name, size in sizes.items()}
    if isinstance(job, UnseenEdge):
        ratios = {"position": left, "peak": 0.5, "acceleration": 0.6}
        sizes = {name: np.array([2e-3, 2e-3 * ratio]) for name, ratio in ratios.items()}
        return sizes | {"limits": np.zeros(2), "speed": np.array(0.5)}
    if isinstance(job, UnseenSpeed):
        sizes = {"basic": 2.0, "twin": 2.0 * left, "step": 0.8}
        return {name: 1e-3 * size * np.ones(2) for name, size in sizes.items()}
    assert isinstance(job, StrokesJob | TwoStageJob)
    side = job.measure if isinstance(job, StrokesJob) else job.side
    ends = dict.fromkeys(fields_of_numbers(), motors_ring if side == "motor" else better)
    ends["rest_acceleration_rms"] *= 2.0
    found = {name: np.linspace(2.0, 2.0 * end, 10) for name, end in ends.items()}
    return found | {"reached_speed": np.array(1.0)}


def drawn(draw, folder, **changed):
    section = draw(partial(results, **changed), folder)
    assert (folder / section.figures[0]).read_bytes().startswith(b"\x89PNG")
    return {check.id: check for check in section.checks}, section


def test_the_bench_of_the_papers_holds_and_another_order_does_not(tmp_path):
    checks, section = drawn(papers.bench, tmp_path)
    assert all(check.holds for check in checks.values())
    checks, _ = drawn(papers.bench, tmp_path, motor=0.025)
    assert [id for id, check in checks.items() if not check.holds] == ["bench-wrong"]
    assert checks["bench-wrong"].ours == 6.0
    assert "for none" in checks["bench-wrong"].reason
    assert count([section]) == "5 of 5 comparisons with papers hold"
    assert columns([section])[2] == "paper"
    assert "| paper | ours |" in markdown("", [section])


def test_the_ratio_of_the_dkf_is_that_of_the_worse_direction(tmp_path):
    checks, _ = drawn(papers.estimators, tmp_path)
    assert checks["T3-dkf"].ours == pytest.approx(1.7)
    assert checks["T3-kkf"].ours == pytest.approx(0.5)


def test_the_square_is_judged_by_its_last_run_over_its_first(tmp_path):
    draw = partial(papers.square, "large", "-large")
    checks, _ = drawn(draw, tmp_path)
    values = {"acceleration-motor": 1.4, "acceleration-load": 0.4, "tcp": 0.4, "rest": 2.8}
    for name, value in values.items():
        assert checks[f"T1-{name}-large"].ours == pytest.approx(value)
    assert all(check.holds for check in checks.values())
    checks, _ = drawn(draw, tmp_path, better=1.5)
    assert checks["T1-tcp-order-large"].ours == len(JUDGEMENT)


@pytest.mark.parametrize(("stopped", "left"), [(0, 0.4), (1, 0.4), (5, np.inf), (6, np.inf)])
def test_robots_that_are_stopped_count_as_the_worst(tmp_path, stopped, left):
    """Their estimate is refused in the sixth run."""

    def some(job):
        found = results(job)
        if isinstance(job, StrokesJob) and job.measure == "estimate":
            for name in fields_of_numbers() if job.individual - JUDGEMENT[0] < stopped else ():
                found[name] = np.where(np.arange(10) < 5, found[name], np.nan)
        return found

    section = papers.square("large", "-large", some, tmp_path)
    checks = {check.id: check for check in section.checks}
    assert checks["T1-tcp-large"].ours == pytest.approx(left)
    assert checks["T1-tcp-large"].holds == (left < 0.5)
    assert checks["T1-tcp-order-large"].ours == stopped
    assert (f"by estimate, counted as the worst: {stopped}." in section.caption) == (stopped > 0)


def test_an_estimate_that_refuses_a_run_is_said_beside_the_others(tmp_path):
    def some(job):
        found = results(job)
        if isinstance(job, ToolEstimates) and job.individual == JUDGEMENT[3] and not job.geometry:
            found["ours"] = np.full(3, np.nan)
        return found

    section = papers.tool(some, tmp_path)
    assert "Refused by ours: 1 of 10" in section.caption
    (ours,) = (row for row in section.tables[0].rows if row[0] == "ours")
    assert ours[2] == pytest.approx(0.1)


def test_the_two_stage_law_is_judged_by_the_side_that_it_learns(tmp_path):
    checks, _ = drawn(papers.two_stage, tmp_path)
    assert all(check.holds for check in checks.values())
    assert checks["T1-two-stage-rest"].ours == pytest.approx(2.8)
    checks, _ = drawn(papers.two_stage, tmp_path, better=0.7)
    failed = {id for id, check in checks.items() if not check.holds}
    assert failed == {"T1-two-stage-load", "T1-two-stage-tcp", "T1-two-stage-peak"}


def test_an_estimate_of_the_tool_is_judged_over_motor_angles_and_its_loss_over_itself(tmp_path):
    checks, section = drawn(papers.tool, tmp_path)
    assert checks["T2-smoother"].ours == pytest.approx(0.4)
    assert all(check.holds for check in checks.values())
    assert [row[0] for row in section.tables[0].rows if row[3] is None] == ["ours", "ours doubled"]
    checks, _ = drawn(papers.tool, tmp_path, doubled=0.53)
    assert [id for id, check in checks.items() if not check.holds] == ["T2-doubled-loss"]


def test_papers_are_made_by_their_name_alone():
    assert not {entry.id for entry in select([])} & {entry.id for entry in select(["papers"])}
    jobs = [job for entry in select(["papers"]) for job in entry.make(Asked()).jobs]
    seeds = {getattr(job, "seed", getattr(job, "individual", None)) for job in jobs}
    assert seeds == set(JUDGEMENT)
    assert not seeds & set(DEVELOPMENT)


@pytest.mark.parametrize(
    ("draw", "said"),
    [(papers.tool, "exact nominal stiffness"), (papers.edge, "less its mean")],
)
def test_a_caption_says_what_flatters_its_numbers(draw, said, tmp_path):
    assert said in drawn(draw, tmp_path)[1].caption


def test_what_is_left_of_an_unseen_motion_is_judged(tmp_path):
    checks, _ = drawn(papers.edge, tmp_path)
    assert {id: round(check.ours, 9) for id, check in checks.items()} == {
        "L1": 0.4,
        "L1-peak": 0.5,
        "L1-acceleration": 0.6,
    }
    assert all(check.holds for check in checks.values())
    checks, _ = drawn(papers.edge, tmp_path, left=0.5)
    assert [id for id, check in checks.items() if not check.holds] == ["L1"]
    assert drawn(papers.speeds, tmp_path)[0]["N1"].ours == pytest.approx(1.0)
    checks, _ = drawn(papers.speeds, tmp_path, left=0.6)
    assert checks["N1"].ours == pytest.approx(0.8 / 1.2)
    assert not checks["N1"].holds


@pytest.mark.parametrize(
    ("twin", "step", "share"),
    [(1.3, 1.0, 0.7), (2.7, 1.0, -0.7), (1.3, 3.0, 0.0), (1.3, 1.99, 0.0), (2.0, 2.0, 0.0)],
)
def test_a_twin_that_is_worse_or_a_step_that_does_nothing_has_no_share(twin, step, share):
    run = {"basic": np.array([2.0]), "twin": np.array([twin]), "step": np.array([step])}
    assert papers.step_share(run) == pytest.approx([share])


def test_checks_are_printed_with_the_number_of_the_paper(tmp_path, monkeypatch):
    found = {}

    class Quiet:
        common = command.ReportOptions()
        table = line = lines = staticmethod(lambda *_: None)
        summary = staticmethod(found.update)

    command._print(Quiet(), [drawn(papers.bench, tmp_path)[1]])
    first = found["checks"][0]
    band = BANDS["bench-first"].check("", 0.0).band
    expected = {"id": "bench-first", "paper": "0.354", "band": band, "value": 0.354, "holds": True}
    assert first | {"value": round(first["value"], 9)} == expected


ASKED = (
    *("T1-acceleration-motor", "T1-acceleration-load", "T1-tcp", "T1-rest", "T1-peak"),
    *("bench-first", "bench-ten", "bench-wrong", "T3-dkf", "T3-kkf"),
    *("T1-two-stage-motor", "T1-two-stage-load", "T2-smoother", "T2-doubled", "T2-online"),
    *("L1", "N1"),
)


def test_each_comparison_is_named(capsys):
    assert set(ASKED) <= set(BANDS)
    assert main(["reproduce", "papers", "--help"]) == 0
    text = " ".join(capsys.readouterr().out.split())
    for id in ASKED:
        assert id in text
