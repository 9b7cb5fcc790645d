"""Configuration of Sphinx: `make docs` builds the pages of this folder, and one page per package.

Docstrings are plain prose with Markdown's code spans. An API page lists the modules of its package,
the page of commands what each command's `--help-all` prints.
"""

import io
import pkgutil
import re
from importlib import import_module
from importlib.metadata import version as version_of
from pathlib import Path
from textwrap import indent

import numpy as np
from docutils.nodes import Element
from numpy.typing import ArrayLike, NDArray
from rich.console import Console
from sphinx.addnodes import desc_annotation
from sphinx.application import Sphinx
from sphinx.util.typing import stringify_annotation

import armside
from armside.arrays import Array
from armside.scripts import cli
from armside.scripts.shell.parser import make_app

project = "armside"
author = "the armside authors"
version = release = version_of("armside")
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
exclude_patterns = ["_build"]
default_role = "code"
myst_heading_anchors = 4
suppress_warnings = ["ref.python"]  # names of arguments are looked up as if they were types
html_theme = "alabaster"
html_theme_options = {
    "description": "Iterative learning control on the arm side",
    "page_width": "1100px",
}
# Names that a package hands on are described where they are defined.
autodoc_default_options = {"members": True, "show-inheritance": True, "ignore-module-all": True}
autodoc_member_order = "bysource"
autodoc_mock_imports = ["stable_baselines3"]  # of the extra [learn], which the pages do not need
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True

HERE = str(Path(armside.__file__).parent)
ALIASES = {
    stringify_annotation(alias, "smart"): name
    for alias, name in (
        (ArrayLike, "ArrayLike"),
        (Array, "Array"),
        (NDArray[np.bool_], "NDArray[bool]"),
    )
}
"""Types as autodoc writes them, and as our source does."""
LINE = 80
"""Characters of the value of a constant that is shown."""
FENCE = re.compile(r"^```\w*\n(.*?)^```$", re.MULTILINE | re.DOTALL)
SPAN = re.compile(r"(``.*?``|`[^`]*`)", re.DOTALL)
MARKUP = re.compile(r"[*|\\]|_(?=\W|$)")
"""Characters of formulas that reStructuredText would read as markup."""


def modules(package: str) -> list[str]:
    """Names of a package and of all modules in it, sub-packages before their modules."""
    path = import_module(package).__path__
    inside = pkgutil.walk_packages(path, package + ".")
    return [package, *(found.name for found in inside if not found.name.endswith("__main__"))]


def package_page(package: str) -> str:
    """A section for each module, with its public names."""
    return "\n".join(
        f"## {name}\n\n```{{eval-rst}}\n.. automodule:: {name}\n```\n" for name in modules(package)
    )


def commands_page() -> str:
    """The help of each command, in sections."""
    return "\n".join(f"## {name}\n\n```text\n{help_of(name)}```\n" for name in sorted(cli.COMMANDS))


def help_of(name: str) -> str:
    """Text of `armside NAME --help-all`, without trailing blanks."""
    text = io.StringIO()
    console = Console(file=text, width=98, color_system=None)
    make_app(cli.COMMANDS, cli.load, name, whole=True).help_print([name], console=console)
    here = text.getvalue().replace(HERE, "armside")  # no path of this machine
    return "".join(line.rstrip() + "\n" for line in here.strip().splitlines())


def fill_page(_app: Sphinx, page: str, source: list[str]) -> None:
    """Append what is generated to the introduction of a page under `api/`.

    The page of the assets holds their README, which stands outside of this folder.
    """
    source[0] = source[0].replace("../assets/README.md", "api/assets.md")
    folder, _, name = page.partition("/")
    if folder == "api":
        source[0] += "\n" + (
            commands_page() if name == "commands" else package_page(f"armside.{name}")
        )


def restructured(text: str) -> str:
    """A docstring as reStructuredText: tables and code stay as they are, formulas are escaped.

    A paragraph that is indented below a line that ends with a colon is a table or a formula.
    """
    paragraphs: list[str] = []
    verbatim = False
    for paragraph in FENCE.sub(lambda code: "::\n\n" + indent(code[1], "    "), text).split("\n\n"):
        above = paragraphs[-1] if paragraphs else ""
        verbatim = paragraph.startswith("    ") and (verbatim or above.endswith(":"))
        if not verbatim:
            parts = SPAN.split(paragraph)
            parts[::2] = [MARKUP.sub(r"\\\g<0>", part) for part in parts[::2]]
            paragraph = "".join(parts)
        elif not above.endswith("::") and above.endswith(":"):
            paragraphs[-1] += ":"
        paragraphs.append(paragraph)
    return "\n\n".join(paragraphs)


def convert_docstring(
    _app: Sphinx, _kind: str, _name: str, _thing: object, _options: object, lines: list[str]
) -> None:
    """Replace the lines of a docstring by reStructuredText, in place."""
    lines[:] = restructured("\n".join(lines)).split("\n")


def shorten_signature(
    _app: Sphinx, _kind: str, _name: str, _thing: object, _options: object, *texts: str | None
) -> tuple[str | None, ...]:
    """Arguments and result of a function, with the names of types that its source has."""
    for long, short in ALIASES.items():
        texts = tuple(text and text.replace(long, short) for text in texts)
    return texts


def drop_long_value(_app: Sphinx, _domain: str, _kind: str, content: Element) -> None:
    """Remove the value of a constant where it is longer than a line."""
    description = content.parent
    for value in list(description.findall(desc_annotation)) if description else []:
        if value.astext().startswith(" = ") and len(value.astext()) > LINE:
            value.parent.remove(value)


def setup(app: Sphinx) -> None:
    """Connect the steps above; docstrings are converted before napoleon reads them."""
    app.connect("source-read", fill_page)
    app.connect("object-description-transform", drop_long_value)
    app.connect("autodoc-process-signature", shorten_signature)
    app.connect("autodoc-process-docstring", convert_docstring, priority=100)
