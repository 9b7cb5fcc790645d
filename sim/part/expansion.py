"""Number of elements of a drawing whose blocks or symbols are taken apart, before they are."""

from collections.abc import Callable, Hashable, Iterable
from typing import TypeVar

MOST = 100_000
"""Elements of a drawing, and points of one of its curves."""
DEEPEST = 100
"""Levels of groups, blocks and uses."""
Node = TypeVar("Node", bound=Hashable)


def check_expansion(
    root: Node, parts: Callable[[Node], Iterable[tuple[int, Node]]], name: Callable[[Node], str]
) -> None:
    """Raise ValueError for a drawing of too many elements or one that contains itself.

    parts: of a node, each with its number. name: of a node, in messages.
    """
    known: dict[Node, tuple[int, int]] = {}
    within: dict[Node, None] = {}

    def measure(node: Node) -> tuple[int, int]:
        """Number of elements and levels of a node."""
        if node in within:
            raise ValueError(f"{name(node)} contains itself")
        within[node] = None
        count, levels = known.get(node, (1, 1))
        for n, part in parts(node) if node not in known and len(within) <= DEEPEST else ():
            elements, deep = measure(part)
            count, levels = count + n * elements, max(levels, 1 + deep)
        known[node] = count, levels
        if len(within) + levels > DEEPEST:
            raise ValueError(f"{name(node)} is nested more than {DEEPEST} levels deep")
        if count > MOST:
            raise ValueError(f"{name(node)} has {count} elements, more than {MOST}")
        del within[node]
        return count, levels

    measure(root)


def check_points(n: int) -> None:
    """Raise ValueError for a curve of too many points."""
    if n > MOST:
        raise ValueError(f"it has {n} points, more than {MOST}")
