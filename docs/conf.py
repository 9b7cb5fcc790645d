"""Configuration of Sphinx: `make docs` builds the pages of this folder, and one a declared module.

Docstrings are plain prose with Markdown's code spans. A module is declared where a name of a stub
`__init__.pyi` is defined in it, or a page links to it; its page is written to `api/modules/`. The
page of a package lists them, the page of commands what each command's `--help-all` prints.
"""

import io
import os
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
copyright = f"2026, {author}"
version = release = version_of("armside")
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
exclude_patterns = ["_build"]
default_role = "code"
myst_heading_anchors = 4
nb_execution_mode = "force"  # numbers of today's code, not of a cache
nb_execution_timeout = 1200
nb_execution_raise_on_error = True
nb_output_stderr = "remove-warn"
nb_merge_streams = True
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # in kernels: threads that wait slow them down
suppress_warnings = ["ref.python"]  # names of arguments are looked up as if they were types
html_theme = "alabaster"
html_static_path = ["_static"]
html_theme_options = {
    "description": "Iterative learning control on the arm side",
    "page_width": "1180px",
    "sidebar_width": "260px",
    "body_max_width": "auto",
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
DOCS = Path(__file__).parent
MODULES = DOCS / "api" / "modules"
PACKAGES = ("armside.kinematics", "armside.ilc", "armside.sim")
"""Packages with a stub; that of the assets has a page for all its modules."""
DECLARED = re.compile(r"^from \.([\w.]+) import (\w+) as \2$", re.MULTILINE)
LINK = re.compile(r"\{py:mod\}`([\w.]+)`")
LINE = 80
"""Characters of the value of a constant that is shown."""
FENCE = re.compile(r"^```\w*\n(.*?)^```$", re.MULTILINE | re.DOTALL)
SPAN = re.compile(r"(``.*?``|`[^`]*`)", re.DOTALL)
MARKUP = re.compile(r"[*|\\]|_(?=\W|$)")
"""Characters of formulas that reStructuredText would read as markup."""


def declared(package: str) -> dict[str, list[str]]:
    """Modules in which the names of a package's stub are defined, with these names."""
    stub = Path(str(import_module(package).__file__)).with_suffix(".pyi")
    found: dict[str, list[str]] = {}
    for module, name in DECLARED.findall(stub.read_text(encoding="utf-8")):
        found.setdefault(f"{package}.{module}", []).append(name)
    pages = "".join(page.read_text(encoding="utf-8") for page in DOCS.rglob("*.md"))
    linked = {name for name in LINK.findall(pages) if name.startswith(package + ".")}
    return dict(sorted(({name: [] for name in linked} | found).items()))


def write_modules(_app: Sphinx) -> None:
    """Write a page for each declared module, and remove those of earlier ones."""
    pages = {f"{name}.rst": name for package in PACKAGES for name in declared(package)}
    MODULES.mkdir(exist_ok=True)
    for old in {page.name for page in MODULES.iterdir()} - set(pages):
        (MODULES / old).unlink()
    for page, name in pages.items():
        title = f"{name}\n{'=' * len(name)}\n\n"
        (MODULES / page).write_text(f"{title}.. automodule:: {name}\n", encoding="utf-8")


def package_page(package: str) -> str:
    """The package's docstring, and a table of its declared modules."""
    text = f"```{{eval-rst}}\n.. automodule:: {package}\n```\n"
    if package not in PACKAGES:
        return text
    rows = declared(package)
    short = {name: name.removeprefix(package + ".") for name in rows}
    table = [
        f"| [{short[name]}](modules/{name}.rst) | {summary_of(name)} "
        f"| {', '.join(f'{{py:obj}}`~{name}.{one}`' for one in names)} |\n"
        for name, names in rows.items()
    ]
    tree = "".join(f"{short[name]} <modules/{name}>\n" for name in rows)
    head = "| module | | declared names |\n|---|---|---|\n"
    return f"{text}\n{head}{''.join(table)}\n```{{toctree}}\n:hidden:\n\n{tree}```\n"


def summary_of(module: str) -> str:
    """First paragraph of a module's docstring, for a cell of a table."""
    paragraph = (import_module(module).__doc__ or "").split("\n\n")[0]
    return " ".join(paragraph.split()).replace("|", "\\|")


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
    if folder == "api" and not name.startswith("modules/"):
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
    app.connect("builder-inited", write_modules)
    app.connect("source-read", fill_page)
    app.connect("object-description-transform", drop_long_value)
    app.connect("autodoc-process-signature", shorten_signature)
    app.connect("autodoc-process-docstring", convert_docstring, priority=100)
