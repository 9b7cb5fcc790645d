"""Logs of controllers, ABB's and KUKA's and by a file of columns any other, as our tables.

Angles are those of the axes as the controller shows them: a coupling of axes is not undone.
"""

from .controller_log import ControllerLog as ControllerLog
from .controller_log import read_log as read_log
