"""Trials of mutants in copies of the tree, in parallel; results are kept and resumed."""

import multiprocessing
import os
import re
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, replace
from pathlib import Path

from cosmic_ray.work_db import use_db
from cosmic_ray.work_item import MutationSpec, TestOutcome, WorkerOutcome, WorkItem, WorkResult

from .mutant import Mutant
from .warm import TIMED_OUT, run_pytest, warm_up
from .workspace import commit, copied, mutated

FOLDER = Path("build/mutation")
DATABASE = "session.sqlite"
NEAREST_LIMIT, WIDER_LIMIT = 300.0, 1800.0
"""[s] of processor time for the nearest tests of a mutant, and for those of its package. A mutant
that runs into a limit counts as killed: the suite would have a limit of its own."""
_FAILED = re.compile(r"^(?:FAILED|ERROR) (\S+)", re.MULTILINE)
_NOT_LOADED = re.compile(r"^ImportError while loading conftest '.*/(tests/\S+)'", re.MULTILINE)


@dataclass(frozen=True)
class Trial:
    """Outcome of one mutant."""

    killed: bool
    by: str
    """The test that failed first, `time limit`, or the widest tests that passed."""
    commit: str = ""
    """Commit of the tree that was mutated."""


def trial(mutant: Mutant, root: Path = Path(), *, wider: bool) -> Trial:
    """Run the nearest tests of a mutant, then those of its package; stop at the first failure."""
    stages = [(mutant.tests, NEAREST_LIMIT)]
    if wider:
        stages.append(((mutant.wider_tests,), WIDER_LIMIT))
    with mutated(mutant, root):
        for tests, limit in stages:
            status, output = run_pytest(tests, limit)
            if status != 0:
                return Trial(True, _failed(status, output))
    return Trial(False, " ".join(stages[-1][0]))


def _failed(status: int, output: str) -> str:
    """The test that failed; a mutant may also end the process of its tests or never end."""
    if status == TIMED_OUT:
        return "time limit"
    if failed := _FAILED.search(output) or _NOT_LOADED.search(output):
        return failed[1]
    if status < 0:
        return f"signal {-status}"
    raise RuntimeError(f"pytest ended without a verdict:\n{output[-2000:]}")


def green(tests: Sequence[str]) -> None:
    """Raise RuntimeError unless the tests pass without any mutant."""
    status, output = run_pytest(tests, WIDER_LIMIT)
    if status != 0:
        raise RuntimeError(f"the tests fail without a mutant: {output[-2000:]}")


class Session:
    """Results of a list of mutants, kept in a database of Cosmic Ray."""

    def __init__(self, folder: Path = FOLDER) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self.folder = folder.resolve()

    def results(self) -> dict[str, Trial]:
        """Outcomes by key of mutant."""
        with use_db(self.folder / DATABASE) as database:
            return {
                key: Trial(found.test_outcome is TestOutcome.KILLED, found.output, found.diff or "")
                for key, found in database.results
            }

    def run(
        self,
        mutants: Sequence[Mutant],
        *,
        workers: int,
        wider: bool,
        checked: bool,
        report: Callable[[Mutant, Trial], None],
    ) -> None:
        """Try each mutant, and keep and report its outcome.

        checked: the nearest tests of all mutants are known to pass without one.

        Raises RuntimeError after the others for those whose tests ended without a verdict.
        """
        if not mutants:
            return
        tree = commit()
        copies = [copied(self.folder / f"tree-{i}") for i in range(min(workers, len(mutants)))]
        # a spawned worker has nothing of ours imported, and a folder of its own
        context = multiprocessing.get_context("spawn")
        queue = context.Queue()
        for copy in copies:
            queue.put(copy)
        # no daemons: tests start processes of their own
        with ProcessPoolExecutor(len(copies), context, _enter, (queue,)) as pool:
            if not checked:
                pool.submit(green, sorted({t for mutant in mutants for t in mutant.tests})).result()
            trials = {pool.submit(trial, m, wider=wider): m for m in mutants}
            wrong = list[str]()
            for done in as_completed(trials):
                mutant = trials[done]
                if error := done.exception():
                    wrong.append(f"{mutant.file}: {mutant.name}: {error}")
                    continue
                outcome = replace(done.result(), commit=tree)
                self._keep(mutant, outcome)
                report(mutant, outcome)
        if wrong:
            raise RuntimeError("\n".join(wrong))

    def _keep(self, mutant: Mutant, outcome: Trial) -> None:
        spec = MutationSpec(
            module_path=mutant.file,
            operator_name=mutant.operator or "curated",
            occurrence=0,
            start_pos=(0, 0),
            end_pos=(0, 1),
        )
        found = WorkResult(
            worker_outcome=WorkerOutcome.NORMAL,
            output=outcome.by,
            test_outcome=TestOutcome.KILLED if outcome.killed else TestOutcome.SURVIVED,
            diff=outcome.commit,
        )
        with use_db(self.folder / DATABASE) as database:
            if mutant.key not in {item.job_id for item in database.work_items}:
                database.add_work_item(WorkItem.single(mutant.key, spec))
            database.set_result(mutant.key, found)


def _enter(queue: "multiprocessing.Queue[Path]") -> None:
    root = queue.get()
    os.chdir(root)
    os.environ["PYTHONPATH"] = str(root / "src")  # of processes that tests start
    sys.path[:0] = [str(root / "src"), str(root)]
    warm_up()
