"""`python -m tests.pages [NAME ...]`: the numbers of README and docs, made again by their commands.

`make pages` calls it. Without names, what is older than today's code is made again; `--stored` only
writes stored results and their age into the pages.
"""

import argparse
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from ._engine import (
    ROOT,
    Result,
    Source,
    claim_stamped,
    claims,
    code,
    made,
    pages,
    rendered,
    results,
    sources,
    store,
)
from ._pictures import pictures


def main(words: Sequence[str] | None = None) -> int:
    """Run sources and write the pages; 1 where a command fails."""
    parser = argparse.ArgumentParser(prog="python -m tests.pages", description=__doc__)
    parser.add_argument("names", nargs="*", help="sources [default: those that are older]")
    parser.add_argument("--stored", action="store_true", help="run nothing")
    asked = parser.parse_args(words)
    known, found = sources() | pictures(), results()
    if wrong := set(asked.names) - set(known):
        parser.error(f"no source {', '.join(sorted(wrong))}; there are {', '.join(known)}")
    age = {name: code(source.entry) for name, source in known.items()}
    old = [n for n, s in known.items() if n not in found or not _fresh(found[n], s, age[n])]
    todo = [] if asked.stored else asked.names or old
    for name in (n for n in todo if known[n].drawn_by is None):
        print(f"{name}: armside {known[name].lines[-1]}", flush=True)
        try:
            found[name] = made(known[name])
        except RuntimeError as error:
            print(error, file=sys.stderr)
            return 1
        store({name: result for name, result in found.items() if name in known})
    drawn = [name.removesuffix(".png") for name in todo if known[name].drawn_by]
    done = subprocess.call([sys.executable, "-m", "tests.gallery", *drawn]) if drawn else 0
    found = results()
    for name in claims():
        _write(ROOT / f"docs/claims/{name}.md", claim_stamped(name))
    for page in pages():
        text = page.read_text(encoding="utf-8")
        _write(page, rendered(text, known, found, lambda name: found[name].code != age[name]))
    return done


def _write(page: Path, text: str) -> None:
    if page.read_text(encoding="utf-8") != text:
        page.write_text(text, encoding="utf-8")
        print(f"written: {page.relative_to(ROOT)}")


def _fresh(result: Result, source: Source, digest: str) -> bool:
    named = source.drawn_by or result.values.keys() == source.values.keys()
    same = result.lines == source.lines and bool(named)
    return same and result.code == digest


if __name__ == "__main__":
    sys.exit(main())
