"""Processor seconds of the twenty most expensive tests, fixtures and child processes included.

    python -m pytest -n auto --dist worksteal -p tests.processor_time

A fixture counts for the test that makes it, and so does what is compiled at its first use.
"""

import resource
from collections import Counter

import pytest

SHOWN = 20
NAME = "processor seconds"
USED = Counter[str]()


def used() -> float:
    """Processor seconds of this process and of its children that have ended."""
    each = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(one.ru_utime + one.ru_stime for one in each)


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_setup(item):
    item.used_before = used()
    return (yield)


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_teardown(item):
    try:
        return (yield)
    finally:
        item.user_properties.append((NAME, used() - item.used_before))


def pytest_runtest_logreport(report):
    if report.when == "teardown":
        USED[report.nodeid] += dict(report.user_properties)[NAME]


def pytest_terminal_summary(terminalreporter):
    terminalreporter.section(f"{USED.total():.0f} processor seconds in {len(USED)} tests")
    for test, seconds in USED.most_common(SHOWN):
        terminalreporter.line(f"{seconds:7.1f}  {test}")
