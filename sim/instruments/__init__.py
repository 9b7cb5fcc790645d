"""Instruments: functions of recorded arrays, from the ideal reading to the sample."""
