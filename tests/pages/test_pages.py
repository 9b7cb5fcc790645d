"""Numbers of README and docs are those of their commands."""

import re
import shutil
from dataclasses import replace

import pytest
from PIL import Image

from ._engine import (
    ROOT,
    UNKNOWN,
    Result,
    Source,
    claim_page,
    claim_stamped,
    claims,
    code,
    evaluated,
    images,
    made,
    marks,
    pages,
    rendered,
    results,
    sources,
    table,
)
from ._pictures import IMAGES, chunks, digest, pictures, pixels, stamp, stamps

SOURCES, RESULTS = sources() | pictures(), results()
README = ROOT / "README.md"
PNGS = [
    file for at in (ROOT / "docs", ROOT) for file in at.glob("**/*.png" if at != ROOT else "*.png")
]
PAGE = "Ends at <!--cut.rms-->13<!--/--> µm.\n\n<!--cut.rows-->\n| k | RMS |\n|---|---|\n<!--/-->\n"
CUT = Source("cut", ("laser",), {"rms": "1e6 * rms[1] | .1f", "rows": "rows | .0f .2f"})
FOUND = Result("0.1.0", "abc", ("laser",), {"rms": 12.34, "rows": [[0, 1.0], [1, 0.5]]})
SHOWN = (
    "Ends at <!--cut.rms-->12.3<!--/--> µm.\n\n<!--cut.rows-->\n| k | RMS |\n|---|---|\n"
    "| 0 | 1.00 |\n| 1 | 0.50 |\n<!--/-->\n"
)


@pytest.fixture(scope="module")
def old():
    age = {name: code(source.entry) for name, source in SOURCES.items()}
    return lambda name: RESULTS[name].code != age[name]


@pytest.mark.parametrize("page", pages(), ids=lambda page: page.relative_to(ROOT).as_posix())
def test_numbers_and_age_of_a_page_are_those_of_its_sources(page, old):
    check(page.name, page.read_text(encoding="utf-8"), RESULTS, old)


def check(page, text, found, old):
    assert text == rendered(text, SOURCES, found, old), f"{page}: make pages"


def test_a_number_of_the_readme_changed_by_hand_names_the_page(old):
    text = rendered(README.read_text(encoding="utf-8"), SOURCES, RESULTS, old)
    check("README.md", text, RESULTS, old)
    ends = [m.end() - 1 for m in re.finditer(r"\d(?=<!--/-->)", text)]
    assert len(ends) > 20
    for end in ends:
        other = text[:end] + str((int(text[end]) + 1) % 10) + text[end + 1 :]
        with pytest.raises(AssertionError, match=r"README\.md: make pages"):
            check("README.md", other, RESULTS, old)


@pytest.mark.parametrize("name", claims())
def test_the_page_of_a_claim_says_whether_it_is_older_than_the_code(name):
    assert claim_page(name) == claim_stamped(name), "make pages"


def test_each_number_of_the_manifest_stands_in_a_page():
    used = {mark for page in pages() for mark in marks(page.read_text(encoding="utf-8"))}
    assert used == {f"{s.name}.{value}" for s in SOURCES.values() for value in s.values}


def test_results_are_those_of_the_lines_and_values_of_the_manifest():
    for name, source in SOURCES.items():
        assert RESULTS[name].lines == source.lines, f"make pages NAME={name}"
        values = {"seed", "data", "pixels"} if source.drawn_by else source.values.keys()
        assert RESULTS[name].values.keys() == values, f"make pages NAME={name}"
    assert RESULTS.keys() == SOURCES.keys()


@pytest.mark.parametrize("file", PNGS, ids=lambda file: file.name)
def test_a_picture_says_what_made_it_of_which_data(file):
    assert stamps(file) == chunks(file.name, RESULTS[file.name])
    assert pixels(file) == RESULTS[file.name].values["pixels"]


@pytest.mark.parametrize("key", ["Software", "Source", "Seed", "Data", "Code"])
def test_a_picture_without_a_chunk_or_with_another_is_noticed(tmp_path, key):
    for name, value in (("seed", "1"), ("data", "0" * 16)):
        result = RESULTS["why.png"]
        shutil.copy(IMAGES / "why.png", file := tmp_path / "why.png")
        stamp(file, replace(result, values=result.values | {name: value}))
        assert stamps(file) != chunks("why.png", result)
    with Image.open(IMAGES / "why.png") as image:
        image.save(tmp_path / "bare.png")
    assert key in stamps(IMAGES / "why.png").keys() - stamps(tmp_path / "bare.png").keys()


def test_each_picture_stands_in_a_page_and_is_made_by_its_name():
    used = {name for page in pages() for name in images(page.read_text(encoding="utf-8"))}
    assert used == pictures().keys() == {file.name for file in PNGS}


def test_the_data_of_a_claims_picture_are_the_rows_of_its_page():
    for name, source in pictures().items():
        if source.claim:
            assert RESULTS[name].values["data"] == digest(table(claim_page(source.claim)))


def test_data_that_differ_have_another_digest_and_rounding_has_none():
    data = {"k": [0, 1.0], "rms": 12.3}
    assert digest(data) == digest({"rms": 12.3 * (1 + 1e-12), "k": (0, 1.0)})
    assert digest(data) != digest(data | {"rms": 12.30001})


def test_few_pictures_have_data_that_nobody_stored():
    unknown = [name for name in pictures() if RESULTS[name].values["data"] == UNKNOWN]
    assert len(unknown) <= 2


def test_the_default_run_gives_the_numbers_that_are_stored(old):
    """To the digits of the page: processors differ in the last bits."""
    today = {"default": made(SOURCES["default"])}
    for page in pages():
        text = page.read_text(encoding="utf-8")
        if any(mark.startswith("default.") for mark in marks(text)):
            assert rendered(text, SOURCES, RESULTS | today, old) == text, page.name


def test_a_page_gets_numbers_tables_and_nothing_else():
    assert rendered(PAGE, {"cut": CUT}, {"cut": FOUND}, lambda _: False) == SHOWN
    assert rendered(SHOWN, {"cut": CUT}, {"cut": FOUND}, lambda _: False) == SHOWN


def test_a_number_changed_by_hand_is_noticed():
    assert (
        rendered(SHOWN.replace("12.3", "12.2"), {"cut": CUT}, {"cut": FOUND}, lambda _: False)
        == SHOWN
    )


def test_a_page_says_by_itself_what_is_older_than_the_code_and_no_longer_once_it_is_not():
    found = rendered(SHOWN, {"cut": CUT}, {"cut": FOUND}, lambda _: True)
    assert (
        found == SHOWN + "\n<!--stamp-->Older than today's code, of version 0.1.0: cut.<!--/-->\n"
    )
    assert rendered(found, {"cut": CUT}, {"cut": FOUND}, lambda _: True) == found
    assert rendered(found, {"cut": CUT}, {"cut": FOUND}, lambda _: False) == SHOWN


def test_a_number_without_a_result_is_named():
    with pytest.raises(ValueError, match=r"no result for cut\.rms: make pages NAME=cut"):
        rendered(PAGE, {"cut": CUT}, {"cut": replace(FOUND, values={})}, lambda _: False)


def test_values_are_expressions_of_the_json():
    json = {"iterations": [{"rms": 2e-6}, {"rms": 1e-6}], "status": "done"}
    values = {"last": "1e6 * iterations[-1].rms | .0f", "all": "[i.rms for i in iterations] | g"}
    assert evaluated(json, values) == {"last": 1.0, "all": [2e-6, 1e-6]}


def test_a_constant_of_the_physics_changes_the_age_of_a_page_and_a_comment_does_not(tmp_path):
    root, entry = tmp_path / "tree", SOURCES["default"].entry
    for folder in ("assets", "kinematics", "ilc", "sim", "scripts", "tests"):
        shutil.copytree(ROOT / folder, root / folder, ignore=shutil.ignore_patterns("*.npz"))
    ages = []
    for text in ("", "# a comment\n", "GRAVITY = 9.9\n"):
        root = root.rename(tmp_path / f"tree-{len(ages)}")  # what was read of a folder is stored
        with (root / "sim/cell.py").open("a", encoding="utf-8") as file:
            file.write(text)
        ages.append(code(entry, root))
    assert ages[0] == ages[1] != ages[2]
    found = RESULTS | {"default": replace(RESULTS["default"], code=ages[0])}
    text = rendered(README.read_text(encoding="utf-8"), SOURCES, found, lambda _: False)
    for age in ages[:2]:
        check("README.md", text, found, lambda n, age=age: n == "default" and found[n].code != age)
    with pytest.raises(AssertionError, match=r"README\.md: make pages"):
        check("README.md", text, found, lambda n: n == "default" and found[n].code != ages[2])
