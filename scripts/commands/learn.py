"""`armside learn`: any plant, several laws, one table and one figure."""

import time
from contextlib import closing
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING

from armside.sim.records.summary import summary

from ..shell.console import Report, run_folder
from ..shell.errors import RunFailed, checking_input
from ..shell.options import Common
from ..workbench.options import LearnCfg
from ..workbench.starts import Starts, starts

if TYPE_CHECKING:
    from armside.arrays import Array
    from armside.ilc.analysis import Eigenloci
    from armside.ilc.workbench.compare import LawRun
    from armside.ilc.workbench.task import Task


def learn(*, cfg: LearnCfg = LearnCfg(), common: Common = Common()) -> None:
    """Compare learning laws on any plant, with the convergence that its model predicts.

    Writes convergence.png, eigenloci of coupled models, a correction a law as CSV, reference.csv,
    state.npz (for --from) and summary.json.
    """
    from armside.ilc.workbench.compare import run_law, setting_of
    from armside.ilc.workbench.own import OwnCodeError
    from armside.ilc.workbench.predicted import predicted_loci
    from armside.sim.controller.gate import GateError

    from ..workbench.plant_option import is_folder, named_task

    report = Report(common)
    try:
        with checking_input():
            cfg, common, before = starts(cfg, common)
            by_hand = is_folder(cfg)
            task = None if by_hand else named_task(cfg, common.seed, before.followed)
        if task is None:
            _by_hand(cfg, common, report)
            return
        with closing(task):
            with checking_input():
                _check_laws(cfg, task, before)
            cases = list(product(cfg.laws, cfg.noise, range(cfg.repeats)))
            with report.progress("learning", total=len(cases) * (cfg.iterations + 1)) as step:
                runs = [
                    run_law(
                        task,
                        law,
                        cfg.iterations,
                        seed=common.seed,
                        noise=noise,
                        repetition=repetition,
                        resume=before.state(law, noise, repetition),
                        start=before.correction(law, task),
                        step=step,
                    )
                    for law, noise, repetition in cases
                ]
            record, setting = (task.reference, task.sample_time), setting_of(task)
            loci = {law: each for law in cfg.laws if (each := predicted_loci(law, setting))}
    except (OwnCodeError, GateError) as error:
        raise RunFailed(str(error)) from error
    _finish(cfg, common, report, runs, record, before, loci)


def _check_laws(cfg: LearnCfg, task: "Task", before: Starts) -> None:
    """Build each law once before any work is done."""
    from armside.ilc.workbench.compare import setting_of
    from armside.ilc.workbench.laws import build_law

    for law in cfg.laws:
        build_law(law, setting_of(task)).check(*task.reference.shape)
        start = before.correction(law, task)
        if start is not None and start.shape != task.reference.shape:
            shapes = f"{start.shape}, this task needs {task.reference.shape}"
            raise ValueError(f"the correction of {cfg.start} has the shape {shapes}")
        if start is not None:
            task.check(start)
        for case in product(cfg.noise, range(cfg.repeats)):
            if (state := before.state(law, *case)) is not None:
                state.loop.check(task.reference.shape, task.reference.shape)


def _by_hand(cfg: LearnCfg, common: Common, report: Report) -> None:
    from ..workbench.run_by_hand import Session

    with checking_input():
        session = Session.begin(cfg)
        state = session.advance()
        until = time.monotonic() + cfg.wait
        while state.k <= cfg.iterations and time.monotonic() < until:
            time.sleep(min(0.2, cfg.wait))
            state = session.advance()
    if state.k <= cfg.iterations:
        report.line(session.request(state.k))
        report.summary(summary("learn", cfg, common, status="waiting", k=state.k))
        return
    record = (session.reference, session.folder.sample_time)
    _finish(cfg, common, report, [session.result(state)], record, Starts(), {})


def _finish(
    cfg: LearnCfg,
    common: Common,
    report: Report,
    runs: "list[LawRun]",
    record: "tuple[Array, float]",
    before: Starts,
    loci: "dict[str, Eigenloci]",
) -> None:
    from ..figures.convergence import draw_convergence
    from ..figures.design import draw_eigenloci
    from ..workbench import law_results as results

    diverged = [run.law for run in runs if run.diverged]
    worse = results.of_the_tool(runs)
    outcome = summary(
        "learn",
        cfg,
        common,
        status="diverged" if diverged else "done",
        started_from=before.entry,
        laws=[results.row(run) for run in runs],
        notes=worse,
        eigenloci={
            law: {"largest": each.spectral_radius, "bound": each.bound}
            for law, each in loci.items()
        },
    )
    title = Path(cfg.plant).name if "/" in cfg.plant else cfg.plant
    with run_folder(outcome, common) as folder:
        draw_convergence(folder / "convergence.png", title, runs)
        for i, (law, each) in enumerate(loci.items()):
            draw_eigenloci(folder / f"eigenloci-{i + 1}.png", law, each, record[1])
        notes = results.write(folder, runs, *record)
    report.lines(before.lines)
    results.show(report, title, runs)
    for law, each in loci.items():
        report.line(f"Eigenloci of {law}: largest modulus {each.spectral_radius:.3g}")
    report.notes([*worse, *notes])
    report.results(outcome, folder.path)
    if diverged:
        raise RunFailed(f"learning diverged with {', '.join(dict.fromkeys(diverged))}")
