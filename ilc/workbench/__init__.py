"""Workbench: any plant, several laws, one table.

A `Task` is a plant with its reference, a `Setting` the facts that a law is built for, a `LawRun`
one learning experiment with one law. Plants and laws are named in words: `two-mass:k=4`,
`heuristic:gamma=0.9,delta=3`, `file.py:Name`.
"""

from .compare import LawRun as LawRun
from .compare import run_law as run_law
from .laws import LAWS as LAWS
from .laws import build_law as build_law
from .task import Setting as Setting
from .task import Task as Task
