"""The contract of a command line, whatever its words are."""

import re
from pathlib import Path

from .isolated import Outcome
from .lines import Kind, Line

STATUSES = (0, 1, 2, 130)
LARGEST = 2_000_000_000
"""[bytes], resident."""
PATIENCE = 60.0
"""[s] of the processor, for a line that was not asked to take longer."""
LONG = frozenset(
    {
        *("bench", "calibrate", "commission", "compare", "gallery", "identify", "reproduce"),
        "verify",
    }
)
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
