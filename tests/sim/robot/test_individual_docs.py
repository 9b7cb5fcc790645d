"""Pages of docs state the distributions and the parameters of individuals as the code has them."""

import re
from dataclasses import fields
from pathlib import Path

import pytest

from armside.sim.robot.individual import Individual
from armside.sim.robot.spread import PRODUCTION, Spread

DOCS = Path(__file__).parents[3] / "docs"


def table(page: str, head: str) -> list[list[str]]:
    """Cells of the rows of a table under a heading `Individuals`."""
    text = (DOCS / page).read_text(encoding="utf-8")
    rows = text.partition("\n## Individuals\n")[2].partition("\n## ")[0].partition(head)[2]
    block = rows.partition("\n\n")[0].splitlines()[1:]
    return [
        [cell.strip() for cell in line.strip("|").split("|")] for line in block if "---" not in line
    ]


def test_the_table_of_distributions_is_that_of_the_production_line():
    rows = table("hardware.md", "| spread |")
    stated = {row[0].strip("`"): float(row[3].split()[0]) for row in rows}
    assert stated == {field.name: getattr(PRODUCTION, field.name) for field in fields(Spread)}


@pytest.mark.parametrize("name", ["position", "centre_of_mass"])
def test_widths_that_are_no_fractions_have_their_unit(name):
    (row,) = [row for row in table("hardware.md", "| spread |") if row[0] == f"`{name}`"]
    assert row[3].endswith(" m")


def test_the_table_of_parameters_names_every_field_of_an_individual():
    rows = table("formats.md", "| parameter |")
    named = [name for row in rows for name in re.findall(r"`\[*(\w+)\]*`", row[0])]
    assert sorted(named) == sorted(field.name for field in fields(Individual))
