"""Options of an earlier run, which hold where none are given now."""

from collections.abc import Collection, Mapping
from dataclasses import MISSING, dataclass, fields, replace
from pathlib import Path
from typing import Any, Generic, TypeVar, get_type_hints

from armside.sim.records.files import InputError

Cfg = TypeVar("Cfg")


@dataclass(frozen=True)
class Carried(Generic[Cfg]):
    """Options of a run that starts from another one."""

    options: Cfg
    before: Cfg
    """Of the earlier run."""
    changed: tuple[str, ...]
    """Names of those that differ."""
    given: tuple[str, ...]
    """Names of those that were said now."""


def carried_options(cfg: Cfg, stored: Mapping[str, Any], free: Collection[str]) -> Carried[Cfg]:
    """Options as given now, elsewhere those of an earlier run as its summary has them.

    free: names of options that a run does not take over.

    Raises InputError for options of the earlier run that this version does not know.
    """
    kind: Any = type(cfg)
    try:
        known = {
            f.name: _typed(kind, f.name, stored[f.name]) for f in fields(kind) if f.name in stored
        }
        before = kind(**known)
        given = {name: getattr(cfg, name) for name in _said(cfg)}
        taken = {name: getattr(before, name) for name in _said(before) if name not in free}
        options = kind(**taken | given)
    except (TypeError, ValueError) as error:
        raise InputError(f"its options cannot be used together with these: {error}") from error
    changed = tuple(
        f.name
        for f in fields(kind)
        if f.name not in free and getattr(options, f.name) != getattr(before, f.name)
    )
    return Carried(options, before, changed, tuple(given))


def _said(cfg: Any) -> list[str]:
    """Names of options that are not what their defaults make of the others."""
    found = []
    for field in fields(cfg):
        default = field.default if field.default is not MISSING else None
        try:
            derived = getattr(replace(cfg, **{field.name: default}), field.name)
        except ValueError:  # the default does not fit the others: it was said
            found.append(field.name)
            continue
        if derived != getattr(cfg, field.name):
            found.append(field.name)
    return found


def _typed(kind: Any, name: str, stored: Any) -> Any:
    """A value of JSON as the option has it."""
    if isinstance(stored, list):
        return tuple(stored)
    hint = get_type_hints(kind)[name]
    is_path = hint is Path or Path in getattr(hint, "__args__", ())
    return Path(stored) if is_path and isinstance(stored, str) else stored
