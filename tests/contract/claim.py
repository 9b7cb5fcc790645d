"""The contract of a command line, whatever its words are, and lines that are held against it."""

import re
import shlex
import shutil
import tempfile
from collections import Counter
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import islice
from multiprocessing.context import ForkServerContext
from pathlib import Path
from typing import NamedTuple

from armside.sim.evaluation.check import Table, all_hold
from armside.sim.robot.run import cores

from . import files
from .isolated import Outcome, run, server
from .lines import Kind, Line, line

STATUSES = (0, 1, 2, 130)
LARGEST = 2_000_000_000
"""[bytes], resident."""
PATIENCE = 60.0
"""[s] of the processor, for a line that was not asked to take longer."""
LONG = frozenset(("commission", "compare", "identify", "reproduce"))
"""Commands that may take minutes, and are interrupted without having broken the contract."""
NOT_A_NUMBER = re.compile(r"(?<![\w./-])[-+]?(nan|inf|infinity)(?![\w./-])", re.IGNORECASE)
WAITING = re.compile(r"^armside: waiting for .*\n", re.MULTILINE)
"""Said on stderr after seconds, as on a busy machine."""
RULES = (
    "no traceback",
    "the status is 0, 1, 2 or 130",
    "what can never be valid is bad input",
    "status 1 is an outcome, not an exception or an unusable file",
    "a status other than 0 has one line on stderr, and 0 none",
    "no NaN on the screen or in summary.json with status 0",
    "bad input leaves nothing behind",
    "no line runs on, or takes more than 2 GB",
    "an interrupted line ends at once",
)


def broken(line: Line, outcome: Outcome, left: list[str], patience: float) -> list[str]:
    """The rules that the end of a line breaks.

    left: names of what it has left in its folder. patience: [s] of the processor, after which
    it got Ctrl-C; less than PATIENCE breaks no rule.
    """
    status, out, err = outcome.status, outcome.out, WAITING.sub("", outcome.err)
    ran_on = outcome.interrupted and min(patience, outcome.seconds) >= PATIENCE
    found = {
        RULES[0]: "Traceback" in out + err,
        RULES[1]: status not in STATUSES and status is not None,
        RULES[2]: line.kind is Kind.MALFORMED and status not in (2, 130, None),
        RULES[3]: status == 1 and ("failed with" in err or "[Errno" in err or "memory" in err),
        RULES[4]: (err.count("\n") != 1 or not err.startswith("armside: "))
        if status
        else err != "",
        RULES[5]: status == 0 and bool(NOT_A_NUMBER.search(out)),
        RULES[6]: status == 2 and bool(left),
        RULES[7]: outcome.memory > LARGEST or (ran_on and line.words[0] not in LONG),
        RULES[8]: status is None,
    }
    return [rule for rule, is_broken in found.items() if is_broken]


def summaries(folder: Path) -> str:
    """Text of all summaries that a line has left."""
    return "\n".join(file.read_text(errors="replace") for file in folder.rglob("summary.json"))


class Judged(NamedTuple):
    """A line, its end, and the rules that it has broken."""

    line: Line
    outcome: Outcome
    broken: list[str]


def prepared(root: Path) -> ForkServerContext:
    """A server, and `files` in a folder: those that lines name, and a finished run."""
    context, stored = server(), root / "files" / "run"
    for name in ("files", "first"):
        (root / name).mkdir()
    words = ("laser", "--iterations", "0", "--quiet", "--out", str(stored))
    first = run(context, words, root / "first", 10.0 * PATIENCE)
    assert first.status == 0, first.err
    files.make(root / "files", stored)
    return context


def judged(seeds: Iterable[int], patience: float = PATIENCE) -> Iterator[Judged]:
    """Run the lines of the seeds, several at a time, and hold each against the contract."""
    with tempfile.TemporaryDirectory(prefix="armside-input-") as name:
        root = Path(name)
        context = prepared(root)

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
