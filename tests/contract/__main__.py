"""`python -m tests.contract`: command lines at random, held against the contract.

Not a command of `armside`: it imports all of them.
"""

import argparse
import sys

from .claim import lines


def main() -> int:
    """Run the lines, print the table, and return 1 where one breaks a rule."""
    parser = argparse.ArgumentParser(prog="tests.contract", description=__doc__)
    parser.add_argument("--lines", type=int, default=2500, help="number of command lines")
    parser.add_argument("--first", type=int, default=0, help="seed of the first")
    asked = parser.parse_args()
    table = lines(range(asked.first, asked.first + asked.lines))
    for row in (table.columns, *table.rows):
        print("  ".join(f"{cell!s:>10}" for cell in row))
    for verdict in table.verdicts:
        print(f"{verdict.verdict}: {verdict.statement} ({verdict.ours:g} exceptions)")
    return 0 if all(verdict.holds for verdict in table.verdicts) else 1


if __name__ == "__main__":
    sys.exit(main())
