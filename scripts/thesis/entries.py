"""Sections of the report by name: figures, equations and rows of the list of what is reproduced.

A module of this folder that is called `chapterNAME` is chapter NAME, and its ENTRIES are the
sections, in the order of the report.
"""

import re
from collections.abc import Sequence
from functools import cache
from importlib import import_module
from pkgutil import iter_modules

from ..shell.errors import unknown
from .report import Entry

CHAPTER = re.compile(r"chapter_?(\w+)")
BY_NAME = ("papers", "real")
"""Chapters that are made by their name alone: of other works, or on files that the reader has."""


@cache
def chapters() -> dict[str, tuple[Entry, ...]]:
    """Sections of each chapter."""
    package = __package__ or ""
    names = [module.name for module in iter_modules(import_module(package).__path__)]
    return {
        match[1]: import_module(f"{package}.{name}").ENTRIES
        for name in sorted(names)
        if (match := CHAPTER.fullmatch(name))
    }


def order() -> list[str]:
    """Ids of all sections."""
    return [entry.id for entries in chapters().values() for entry in entries]


def select(ids: Sequence[str]) -> list[Entry]:
    """Entries of these names in the order of the report; no names: those of all chapters.

    Raises InputError for a name that no entry has.
    """
    named = [
        (entry, {entry.id, *entry.also, *([] if entry.alone else [chapter])}, chapter)
        for chapter, entries in chapters().items()
        for entry in entries
    ]
    if not ids:
        return [entry for entry, _, chapter in named if chapter not in BY_NAME and not entry.alone]
    known = dict.fromkeys(name for _, names, _ in named for name in sorted(names))
    for name in ids:
        if name not in known:
            raise unknown("figure, chapter or row", name, known)
    return [entry for entry, names, _ in named if not names.isdisjoint(ids)]
