"""Fixtures of the tests of commands."""

from ..scripts.conftest import armside as armside
from ..scripts.conftest import armside_process as armside_process
