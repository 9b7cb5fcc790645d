"""Instruments: functions of recorded arrays, from the ideal reading to the sample.

Ideal reading -> bandwidth -> bias -> noise -> range -> quantisation -> sampling. SI units,
quaternions w first; every random draw comes from a Generator that the caller passes in.
"""
