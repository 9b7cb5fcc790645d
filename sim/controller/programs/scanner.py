"""Text of a program as tokens with their places, and a cursor over them.

Every byte is one character (latin-1), so that a text is written back as it was read.
"""

import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import NamedTuple, NoReturn

from ...motion.instructions import ProgramError

LARGEST = 9.1e9
"""Largest number that is read: 9E9 stands for an axis that is not there in RAPID."""
DEEPEST = 6
"""Brackets within brackets."""
NUMBER = r"(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)"


@dataclass(frozen=True)
class Text:
    """Text of one file: its bytes as latin-1."""

    name: str
    content: str

    def fail(self, at: int, reason: str) -> NoReturn:
        """Raise ProgramError with file, line and column, both from 1."""
        before = self.content[self.content.rfind("\n", 0, at) + 1 : at]
        with suppress(UnicodeDecodeError):  # a text that is no UTF-8 is latin-1
            self.content.encode("latin-1").decode("utf-8")
            before = before.encode("latin-1").decode("utf-8", "replace")
        place = f"line {self.line(at)}, column {len(before) + 1}"
        raise ProgramError(f"{self.name}, {place}: {reason}")

    def line(self, at: int) -> int:
        """Line of a place, from 1."""
        return self.content.count("\n", 0, at) + 1


class Token(NamedTuple):
    """word, string, number, sign, newline or end; a word in lower case where case is ignored."""

    kind: str
    text: str
    text_of: Text
    start: int
    end: int

    def __str__(self) -> str:
        names = {"newline": "the end of the line", "end": "the end of the file"}
        return names.get(self.kind, self.text[:40])


@dataclass(frozen=True)
class Number:
    """Number with its place in the text, sign included."""

    value: float
    text_of: Text
    start: int
    end: int


@dataclass(frozen=True)
class Group:
    """Bracketed list, with the names of its fields where it has."""

    items: tuple["Value", ...]
    names: tuple[str, ...]
    text_of: Text
    start: int

    def numbers(self, n: int, what: str) -> tuple[Number, ...]:
        """Its items, which are n numbers. Raises ProgramError."""
        found = tuple(item for item in self.items if isinstance(item, Number))
        if not len(found) == len(self.items) == n:
            self.text_of.fail(self.start, f"{what} must be {n} numbers")
        return found


Value = Number | Token | Group


class Cursor:
    """Tokens of a text, read from left to right; every mismatch raises ProgramError."""

    def __init__(self, text: Text, grammar: str, fold: bool) -> None:
        self.text, self.tokens, self.at, end = text, list[Token](), 0, 0
        for found in re.compile(grammar, re.MULTILINE).finditer(text.content):
            if found.start() != end:
                break
            end, kind = found.end(), str(found.lastgroup)
            if kind != "skip":
                word = found.group().lower() if fold and kind == "word" else found.group()
                self.tokens.append(Token(kind, word, text, found.start(), end))
        if end != len(text.content):
            text.fail(end, f"{text.content[end]!a} is not understood")
        self.tokens += [Token("end", "", text, end, end)] * 2

    @property
    def next(self) -> Token:
        """The token that is read next."""
        return self.tokens[self.at]

    def take(self, kind: str = "") -> Token:
        """The next token, of a kind if one is given."""
        if kind not in ("", self.next.kind):
            self.fail(f"a {kind} is expected, not {self.next}")
        self.at = min(self.at + 1, len(self.tokens) - 1)
        return self.tokens[self.at - 1]

    def has(self, *texts: str) -> bool:
        """Take the next tokens if they are these words and signs."""
        ahead = self.tokens[self.at : self.at + len(texts)]
        if [t.text for t in ahead] != list(texts) or any(t.kind == "string" for t in ahead):
            return False
        self.at += len(texts)
        return True

    def expect(self, *texts: str) -> None:
        """Take these words and signs."""
        for text in texts:
            if not self.has(text):
                self.fail(f"{text} is expected, not {self.next}")

    def fail(self, reason: str, token: Token | None = None) -> NoReturn:
        """Raise ProgramError at a token, the next one if none is given."""
        self.text.fail((token or self.next).start, reason)

    def number(self) -> Number:
        """A number, with the signs before it."""
        start, sign = self.next.start, 1.0
        while self.next.text in ("-", "+"):
            sign = -sign if self.take().text == "-" else sign
        token = self.take("number")
        if not (value := float(token.text)) <= LARGEST:
            self.fail(f"numbers are at most {LARGEST:g}, got {token}", token)
        return Number(sign * value, self.text, start, token.end)

    def value(self, brackets: Sequence[str] = "[]", depth: int = 0) -> Value:
        """A number, word or string, or a list of them; one in braces has names of fields."""
        first, (left, right) = self.next, brackets
        if first.kind in ("word", "string"):
            return self.take()
        if first.text != left:
            return self.number()
        if depth == DEEPEST:
            self.fail(f"brackets are at most {DEEPEST} deep")
        self.take()
        items, names = list[Value](), list[str]()
        while not self.has(right):
            if items:
                self.expect(",")
            if left == "{":
                names.append(self.take("word").text)
                self.has("[", "]")
            items.append(self.value(brackets, depth + 1))
        return Group(tuple(items), tuple(names), self.text, first.start)
