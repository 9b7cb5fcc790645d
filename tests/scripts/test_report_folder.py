"""A report shows what is in its folder, and nothing else."""

import pytest

from armside.scripts.shell.errors import InputError
from armside.scripts.thesis.report import ReportFolder, Section


@pytest.mark.parametrize("name", ["../secret.txt", "/etc/hostname", "sub/figure.png"])
def test_a_section_cannot_name_a_file_outside_of_the_figures(tmp_path, name):
    report = ReportFolder(tmp_path / "report")
    report.begin({})
    report.keep(Section("one", "One", "A caption.", figures=("figure.png",)))
    report.keep(Section("two", "Two", "A caption.", figures=(name,)))
    assert report.sections(["one"])[0].figures == ["figure.png"]
    with pytest.raises(InputError, match=r"two\.json is not a section.* folder of figures"):
        report.sections(["one", "two"])
