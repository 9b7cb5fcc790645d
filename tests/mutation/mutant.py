"""Mutants: one deliberate fault each, as data."""

import hashlib
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
CURATED = Path(__file__).parent / "curated"
PACKAGES = ("assets", "kinematics", "ilc", "sim", "scripts")
ALL = (*PACKAGES, "tests")
"""With what judges them: claims, calibration."""


@dataclass(frozen=True, kw_only=True)
class Mutant:
    """A replacement of text in one file.

    `old` is replaced where it occurs first behind `at`. `at` occurs once in the file; without `at`,
    `old` does. Raises ValueError for a mutant that changes nothing.
    """

    name: str
    """The fault, as a user would describe it."""
    file: str
    old: str
    new: str
    at: str = ""
    tests: tuple[str, ...]
    """Nearest tests, as arguments of pytest."""
    equivalent: str = ""
    """Reason why no test can notice it; such a mutant is not counted."""
    survives: str = ""
    """Reason why no test notices it yet; such a mutant is counted as survivor."""
    found: bool = False
    """A fault that no close test noticed when it was first tried."""
    operator: str = ""
    """Operator of a generic mutant."""

    def __post_init__(self) -> None:
        if self.old == self.new:
            raise ValueError(f"mutant {self.name!r} changes nothing")

    @property
    def package(self) -> str:
        """Package of the mutated file."""
        return self.file.partition("/")[0]

    @property
    def wider_tests(self) -> str:
        """Tests of the package; those of the folder for what judges the packages."""
        folder = Path(self.file).parent.as_posix()
        return folder if self.package == "tests" else f"tests/{self.package}"

    @property
    def key(self) -> str:
        """Identifier of the replacement, whatever its name and its tests."""
        text = "\0".join((self.file, self.at, self.old, self.new))
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    def start(self, text: str) -> int:
        """Position of the replacement. Raises ValueError where it is not unique or not there."""
        anchor = self.at or self.old
        if (n := text.count(anchor)) != 1:
            raise ValueError(f"{self.file}: {anchor!r} of mutant {self.name!r} occurs {n} times")
        start = text.find(self.old, text.index(anchor))
        if start < 0:
            raise ValueError(f"{self.file}: {self.old!r} of mutant {self.name!r} does not occur")
        return start

    def applied(self, text: str) -> str:
        """The text of the file with the fault."""
        start = self.start(text)
        return text[:start] + self.new + text[start + len(self.old) :]


def curated(folder: Path = CURATED) -> list[Mutant]:
    """The mutants of the TOML files of a folder: faults by file, each a table.

    The nearest tests are those of the fault, or of its file.
    """
    return [
        Mutant(
            file=group["path"],
            **{**fault, "tests": tuple(fault.get("tests", group["tests"]))},
        )
        for path in sorted(folder.glob("*.toml"))
        for group in tomllib.loads(path.read_text(encoding="utf-8"))["file"]
        for fault in group["faults"]
    ]


def counted(mutants: Sequence[Mutant]) -> list[Mutant]:
    """Mutants that are not equivalent."""
    return [mutant for mutant in mutants if not mutant.equivalent]
