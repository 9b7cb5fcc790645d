"""Sections of the report by name: figures, equations and rows of the list of what is reproduced.

A chapter adds a section with one line in ENTRIES: a function `(seed) -> Part` that names the
experiments a section needs and draws it from their results. A chapter is imported when one of its
sections is loaded.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

from ..shell.errors import unknown
from .report import Part


def _chapter5():
    from . import chapter5 as chapter

    return chapter


def _chapter8():
    from . import chapter8 as chapter

    return chapter


def _chapter9():
    from .chapter9 import sections as chapter

    return chapter


class Entry(NamedTuple):
    """One section that can be asked for."""

    id: str
    also: tuple[str, ...]
    """Other names: rows of the map, equations."""
    chapter: str
    """A chapter makes all of its own; empty: only made by name, since it takes minutes."""
    load: Callable[[], Callable[[int], Part]]
    """Import the function of the section."""


ENTRIES = (
    Entry("5.2", ("E02",), "5", lambda: _chapter5().rest),
    Entry("5.3", ("E01",), "5", lambda: _chapter5().mounting),
    Entry("synchronisation", ("E04",), "5", lambda: _chapter5().synchronisation),
    Entry("5.4", ("E05",), "5", lambda: _chapter5().sequential),
    Entry("5.5", ("E03", "E06", "5.6"), "5", lambda: _chapter5().simultaneous),
    Entry("5.7", ("E07",), "5", lambda: _chapter5().position),
    Entry("5.8", ("E08",), "5", lambda: _chapter5().angular_velocity),
    Entry("5.9", ("E09",), "5", lambda: _chapter5().acceleration),
    Entry("5.10", ("E10",), "5", lambda: _chapter5().error_along),
    Entry("8.3", ("S01",), "8", lambda: _chapter8().joint),
    Entry("8.4", ("S02",), "8", lambda: _chapter8().reference),
    Entry("8.5", ("S02",), "8", lambda: _chapter8().tracking),
    Entry("8.6", ("S03",), "8", lambda: _chapter8().criterion),
    Entry("8.7", ("S04",), "8", lambda: _chapter8().admissible_gain),
    Entry("8.8", ("S05",), "8", lambda: _chapter8().learning_curves),
    Entry("8.9", ("S06",), "8", lambda: _chapter8().motor_signals),
    Entry("8.10", ("S06",), "8", lambda: _chapter8().arm_signals),
    Entry("8.11", ("S06",), "8", lambda: _chapter8().model_error),
    Entry("8.12", ("S06",), "8", lambda: _chapter8().arm_signals_with_error),
    Entry("9.5", ("X04",), "9", lambda: _chapter9().by_position),
    Entry("9.6", ("X04",), "9", lambda: _chapter9().by_velocity),
    Entry("repeatability", ("X05", "9.10"), "9", lambda: _chapter9().repeatability),
    Entry("9.7", ("X06",), "9", lambda: _chapter9().ten_iterations),
    Entry("9.8", ("X07", "9.12", "9.13"), "9", lambda: _chapter9().identified_model),
    Entry("9.9", ("X08",), "9", lambda: _chapter9().positions_motor),
    Entry("9.10", ("X08", "9.1"), "9", lambda: _chapter9().circles),
    Entry("9.11", ("X08",), "9", lambda: _chapter9().positions_arm),
    Entry("9.12", ("X09",), "9", lambda: _chapter9().shifts_motor),
    Entry("9.13", ("X09",), "9", lambda: _chapter9().shifts_arm),
    Entry("9.14", ("X10",), "9", lambda: _chapter9().cutoffs_motor),
    Entry("9.15", ("X10",), "9", lambda: _chapter9().cutoffs_spread),
    Entry("9.16", ("X10",), "9", lambda: _chapter9().cutoffs_arm),
    Entry("9.17", ("X10",), "9", lambda: _chapter9().cutoffs_circles),
    Entry("F08", (), "9", lambda: _chapter9().per_motor),
    Entry("F09", (), "9", lambda: _chapter9().friction_feedforward),
    Entry("F07", (), "", lambda: _chapter9().individuals),
    Entry("9-map", (), "", lambda: _chapter9().phenomena_map),
    Entry("9-effects", (), "", lambda: _chapter9().effects),
)
"""In the order of the report."""


def select(ids: Sequence[str]) -> list[Entry]:
    """Entries of these names in the order of the report; no names: those of all chapters.

    Raises InputError for a name that no entry has.
    """
    if not ids:
        return [entry for entry in ENTRIES if entry.chapter]
    names = dict.fromkeys(n for e in ENTRIES for n in (e.chapter, e.id, *e.also) if n)
    for name in ids:
        if name not in names:
            raise unknown("figure, chapter or row", name, names)
    return [e for e in ENTRIES if not {e.chapter, e.id, *e.also}.isdisjoint(ids)]
