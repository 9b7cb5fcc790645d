"""Runs of whole parts: placed in the cell, cut by the virtual robot, learned and measured.

SI units. A `Job` says what is cut where and by which robot; `prepare` plans it and loads its
reference, `learn` makes the runs.
"""
