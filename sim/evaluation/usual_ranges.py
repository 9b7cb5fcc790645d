"""Ranges that the numbers of industrial and collaborative arms usually lie in, by the arm's reach.

A number outside is no error: it is what to look at first. The ranges are ESTIMATES, each around
the arms that are named at it and a third to a half beyond them.
"""

from typing import NamedTuple


class Usual(NamedTuple):
    """Ends of the usual range of a quantity, divided by a power of the reach [m]."""

    quantity: str
    unit: str
    low: float
    high: float
    power: int
    source: str

    def range(self, reach: float) -> tuple[float, float]:
        """Ends for an arm of that reach [m]."""
        scale = reach**self.power
        return self.low * scale, self.high * scale


USUAL = {
    "reach": Usual("reach", "m", 0.4, 4.0, 0,
                   "IRB120 0.58, IRB1400 1.44, IRB6600 2.55 and 2.80 m"),
    "mass": Usual("mass", "kg", 15.0, 200.0, 3,
                  "over reach cubed: UR5e 34, KR 16-2 56, IRB1400 75, IRB6600 103, IRB120 128"),
    "holding": Usual("torque of gravity over the drive's, greatest", "", 0.05, 0.75, 0,
                     "IRB1400 0.3; large robot 0.6 on axis 2, 0.33 on axis 3"),
    "acceleration": Usual("acceleration at the drives' limits", "rad/s^2", 8.0, 400.0, -1,
                          "times reach, m/s^2: large robot 13 to 130, IRB1400 39 to 225"),
    "lowest_mode": Usual("lowest mode, motors locked", "Hz", 7.0, 45.0, -1,
                         "times reach, Hz m: large robot 11 to 21, IRB1400 14 to 25"),
    "gear": Usual("gear ratio", "", 30.0, 260.0, 0,
                  "Manutec r3 60 to 210, RV-E 81 to 192, IRB6620 243; harmonic drives 50 to 160"),
}  # fmt: skip
"""By the name of the quantity; acceleration and gear ratio of axes that turn. Reaches and masses
are those of data sheets by memory (IRB1400, IRB6600, UR5e, KR 16-2, IRB120), the other numbers
those of the robots in `assets`, of Modelica's RobotR3 (Manutec) and of Nabtesco's RV-E manual."""
POSSIBLE = 30.0
"""Factor by which an acceleration may lie beyond the usual range before a drive is called
impossible: units are wrong by a thousand and more. ESTIMATE."""
