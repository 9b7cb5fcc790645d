"""Parser of link parameters, for the argument forms of thesis Table 4.1 and nothing else.

    sum    = [sign] term {sign term}
    term   = factor {("*" | "/") factor}      at most one factor is not a number, and no divisor
    factor = number | "pi" | name ["[" digits "]"] ["(t)"]

Text is cut into tokens and read by this grammar; it is never evaluated as code.
"""

import re
from collections.abc import Iterator

import sympy as sp

from .symbols import Expression, moving, symbol

_TOKEN = re.compile(
    r"\s*(?:(?P<number>\d+(?:\.\d*)?(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?)"
    r"|(?P<name>[^\W\d]\w*)(?:\[(?P<index>\d+)\])?(?P<time>\(\s*t\s*\))?"
    r"|(?P<sign>[-+−])|(?P<operator>[*/]))"
)
_PI = {"pi", "Pi", "π"}
_LONGEST = 200
_SMALLEST, _GREATEST = 1e-300, 1e300
"""Magnitudes of numbers and sums that are read; exact fractions of others would be very long."""


class GrammarError(ValueError):
    """Text outside the grammar of Table 4.1."""


def parse(text: str) -> Expression:
    """The expression of text such as "5", "Pi/2", "phi[1](t) - phi[2](t) - pi/2".

    Raises GrammarError: says at which character reading stopped, and what is allowed.
    """
    tokens = list(_tokens(text))
    total, rest = sp.S.Zero, tokens
    if not tokens:
        raise _error(text, 0)
    while rest:
        sign = 1
        if rest[0].lastgroup == "sign":
            sign = 1 if rest[0]["sign"] == "+" else -1
            rest = rest[1:]
        elif rest is not tokens:
            raise _error(text, rest[0].start())
        term, rest = _term(text, rest)
        total += sign * term
    if total.is_number and abs(total) > _GREATEST:
        raise _out_of_range(text)
    return total


def _tokens(text: str) -> Iterator[re.Match[str]]:
    if len(text) > _LONGEST:
        raise GrammarError(f"an argument has at most {_LONGEST} characters, got {len(text)}")
    position = 0
    while text[position:].strip():
        match = _TOKEN.match(text, position)
        if match is None:
            raise _error(text, position)
        yield match
        position = match.end()


def _term(text: str, tokens: list[re.Match[str]]) -> tuple[Expression, list[re.Match[str]]]:
    """Factors joined by * and /; one of them may be a variable."""
    value, variables = sp.S.One, 0
    operator = "*"
    while True:
        if not tokens or (factor := _factor(tokens[0])) is None:
            raise _error(text, tokens[0].start() if tokens else len(text))
        variables += not factor.is_number
        if variables > 1 or (operator == "/" and (not factor.is_number or factor == 0)):
            raise _error(text, tokens[0].start())
        value = value * factor if operator == "*" else value / factor
        tokens = tokens[1:]
        if not tokens or tokens[0].lastgroup != "operator":
            return value, tokens
        operator, tokens = tokens[0]["operator"], tokens[1:]


def _factor(token: re.Match[str]) -> Expression | None:
    """A number, pi, a symbol or a function of time; None if the token is none of these."""
    if token["number"]:
        return _number(token["number"])
    if not token["name"]:
        return None
    index = int(token["index"]) if token["index"] else None
    if token["name"] in _PI and index is None and not token["time"]:
        return sp.pi
    return (moving if token["time"] else symbol)(token["name"], index)


def _number(text: str) -> Expression:
    digits = re.split("[eE]", text)[0]
    if not digits.strip("0."):
        return sp.S.Zero
    if not _SMALLEST <= float(text) <= _GREATEST:
        raise _out_of_range(text)
    return sp.Rational(text)


def _out_of_range(text: str) -> GrammarError:
    allowed = f"0 and magnitudes from {_SMALLEST:g} to {_GREATEST:g}"
    return GrammarError(f"{text!r} is out of range: allowed are {allowed}")


def _error(text: str, position: int) -> GrammarError:
    return GrammarError(
        f"cannot read {text!r} from character {position + 1}: allowed are sums of numbers, "
        "multiples of pi, and names such as phi, phi[1], phi(t), phi[1](t)"
    )
