"""The claim that no command line hurts. A seed is one line."""

import shlex
import shutil
import tempfile
from collections import Counter
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import islice
from pathlib import Path
from typing import NamedTuple

from armside.sim.evaluation.check import Table, all_hold
from armside.sim.robot.run import cores

from . import files
from .isolated import Outcome, run, server
from .lines import Line, line
from .rules import PATIENCE, RULES, broken, summaries


class Judged(NamedTuple):
    """A line, its end, and the rules that it has broken."""

    line: Line
    outcome: Outcome
    broken: list[str]


def judged(seeds: Iterable[int], patience: float = PATIENCE) -> Iterator[Judged]:
    """Run the lines of the seeds, several at a time, and hold each against the contract."""
    context = server()
    with tempfile.TemporaryDirectory(prefix="armside-input-") as name:
        root = Path(name)
        (root / "files").mkdir()
        stored = root / "files" / "run"
        words = ("laser", "--iterations", "0", "--quiet", "--out", str(stored))
        (root / "first").mkdir()
        first = run(context, words, root / "first", 10.0 * PATIENCE)
        assert first.status == 0, first.err
        files.make(root / "files", stored)

        def one(seed: int) -> Judged:
            asked, folder = line(seed), root / f"{seed}"
            folder.mkdir()
            outcome = run(context, asked.words, folder, patience)
            left = sorted(path.name for path in folder.rglob("*"))
            printed = outcome._replace(out=outcome.out + summaries(folder))
            shutil.rmtree(folder, ignore_errors=True)
            return Judged(asked, outcome, broken(asked, printed, left, patience))

        remaining = iter(seeds)
        with ThreadPoolExecutor(cores()) as pool:
            while batch := list(islice(remaining, 8 * cores())):
                yield from pool.map(one, batch)


def lines(seeds: Iterable[int]) -> Table:
    """Command lines drawn from the options of all commands, judged; a row per command."""
    counts: dict[str, Counter[str]] = {}
    wrong: dict[str, list[str]] = {rule: [] for rule in RULES}
    for one in judged(seeds):
        name = one.line.words[0]
        own = counts.setdefault(name if len(name) < 20 else "none", Counter())
        own[f"{one.outcome.status}"] += 1
        for rule in one.broken:
            words = shlex.join(one.line.words)[:200]
            wrong[rule].append(f"{words} (status {one.outcome.status})")
    statuses = ("0", "1", "2", "130")
    rows = [
        (name, own.total(), *(own[status] for status in statuses))
        for name, own in sorted(counts.items())
    ]
    verdicts = [
        all_hold(f"{rule}: {found[0]}" if found else rule, [False] * len(found))
        for rule, found in wrong.items()
    ]
    columns = ("command", "lines", *(f"status {status}" for status in statuses))
    return Table("Command lines at random, and those that once went wrong", columns, rows, verdicts)
