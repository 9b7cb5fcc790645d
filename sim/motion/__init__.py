"""Motions of tool and joints: cutting paths, and programs of moves.

A cut: contour -> path -> timing -> tool motion -> joint reference. A program: instructions ->
curves of motor angles -> timing of moves -> joint motion.

SI units, base axes, quaternions w first (base to tool). Arc length s [m] starts at 0 where the
motion starts. A limit that changed a motion is named as (limit, axis, first time [s]): axis 1..6 is
a motor, axis 0 the tool on its path.
"""
