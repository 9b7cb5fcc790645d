"""Equations of a robot as straight-line programs: kinematics, dynamics, derivatives."""
