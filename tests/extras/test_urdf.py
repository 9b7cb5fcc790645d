"""URDF in and out beside Pinocchio's own reading, of our robots and of files that others wrote."""

import pytest
from tests.claims import _urdf_files as urdf_arms
from tests.claims import urdf

pytest.importorskip("pinocchio", reason="needs the extra [peers]", exc_type=ImportError)


@pytest.mark.parametrize("name", urdf.shipped_robots())
def test_pinocchio_reads_our_robots_with_their_masses(name):
    row = urdf.shipped(name, [0])
    assert row["verdict"] == "agrees"
    has_hardware = name.endswith(".toml") or name in ("irb1400", "large")
    assert isinstance(row["mass matrix"], float) is has_hardware


def test_files_of_others_are_read_alike_or_refused_by_name():
    installed = {file.package.split()[0] for file in urdf_arms.foreign_files()}
    if missing := set(urdf_arms.PACKAGES) - installed:
        pytest.skip(f"packages of URDF files are not installed: {', '.join(sorted(missing))}")
    rows = list(urdf.foreign([0]))
    read = [row for row in rows if row["verdict"] == "agrees"]
    assert len(read) >= urdf.FOREIGN_ARMS
    for row in rows:
        assert row in read or row["verdict"].startswith("refused: "), row
    assert sum(isinstance(row["mass matrix"], float) for row in read) >= 10


def test_another_reading_is_noticed():
    """A mass beside the chain that one of the two readings leaves out."""
    assert urdf._verdict((0.0, 0.0, 1e-3)) == "DIFFERS"
    assert urdf._verdict((1e-12, 1e-12, "-")) == "agrees"
