"""Every curated mutant still changes today's code, in one place."""

from collections import Counter

import pytest

from .mutant import PACKAGES, ROOT, counted, curated

MUTANTS = curated()


@pytest.mark.parametrize("file", sorted({mutant.file for mutant in MUTANTS}))
def test_mutants_of_a_file_apply_to_it_and_change_it(file):
    text = (ROOT / file).read_text(encoding="utf-8")
    for mutant in MUTANTS:
        if mutant.file == file:
            mutated = mutant.applied(text)
            assert mutated != text, mutant.name
            if file.endswith(".py"):
                compile(mutated, file, "exec")


def test_no_fault_stands_twice():
    assert Counter(mutant.key for mutant in MUTANTS).most_common(1)[0][1] == 1
    assert Counter((m.file, m.name) for m in MUTANTS).most_common(1)[0][1] == 1


def test_the_nearest_tests_of_a_mutant_exist():
    for mutant in MUTANTS:
        assert mutant.tests, mutant.name
        for test in mutant.tests:
            file, _, function = test.partition("::")
            assert (ROOT / file).exists(), test
            if function:
                name = function.partition("[")[0]
                assert f"def {name}(" in (ROOT / file).read_text(encoding="utf-8"), test


def test_hundreds_of_faults_over_all_packages_are_counted():
    packages = Counter(mutant.package for mutant in counted(MUTANTS))
    assert sum(packages.values()) >= 200
    assert min(packages[package] for package in PACKAGES) >= 40
    assert sum(mutant.found for mutant in MUTANTS) >= 85
