"""`armside calibrate-arm`: kinematic calibration of an arm from poses that were measured."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from armside.kinematics.calibration import CalibrationCfg, JointErrors, Priors
from armside.sim.records.summary import summary
from armside.sim.robot_file.find import load_robot

from ..shell.bag_options import BagCfg
from ..shell.console import Report, run_folder
from ..shell.errors import RunFailed, checking_input, one_line
from ..shell.options import SOME, Common, Limits, check_limits, options

MM = 1e-3
LIMITS = {
    "harmonics": Limits(0, 200),
    "prior_length": Limits(0.0, 1e4, "mm", above=True),
    "prior_angle": Limits(0.0, 1e4, "mrad", above=True),
    "next": Limits(0, 100),
}
"""Ten metres and ten radians say nothing of an arm."""


@options
@dataclass(frozen=True, kw_only=True)
class CalibrateArmCfg(BagCfg):
    """The robot, what is fitted, and what the result is judged on."""

    robot: str
    """Robot by name (ur10, irb120, aubo_i5, irb1400, large) or a robot file (TOML, or URDF:
    FILE.urdf, FILE.urdf#TIP_LINK)."""
    fraction: float = 0.5
    """Fraction of the poses that is fitted; the others are held out."""
    fitted: int | None = None
    """Number of poses that are fitted, in place of the fraction."""
    in_order: bool = False
    """Fit the first poses and judge on the last [default: at random by --seed]."""
    parameters: Annotated[tuple[str, ...], SOME] = ()
    """Errors of links to fit, such as theta_2 a_2 beta_2 [default: all that can be identified]."""
    harmonics: int | None = None
    """Order of the harmonics of each joint's error [default: chosen on a part of the fitted]."""
    compliance: bool = False
    """With --harmonics: also compliance under gravity."""
    prior_length: float = 5.0
    """Standard deviation of lengths about the nominal robot [mm]."""
    prior_angle: float = 10.0
    """Standard deviation of angles about the nominal robot [mrad]."""
    noise: float | None = None
    """Standard deviation of a measured coordinate [mm] [default: estimated]."""
    next: int = 10
    """Number of poses to propose for the next measurement."""

    def __post_init__(self) -> None:
        super().__post_init__()
        check_limits(self, LIMITS)
        if self.compliance and self.harmonics is None:
            raise ValueError("compliance needs --harmonics (0 for none)")

    def configuration(self) -> CalibrationCfg:
        """Configuration in SI. Raises ValueError for what is not allowed."""
        errors = None
        if self.harmonics is not None:
            errors = JointErrors(self.harmonics, self.compliance)
        return CalibrationCfg(
            fraction=self.fraction,
            poses=self.fitted,
            in_order=self.in_order,
            parameters=self.parameters,
            joint_errors=errors,
            priors=Priors(
                length=MM * self.prior_length,
                angle=MM * self.prior_angle,
                noise=None if self.noise is None else MM * self.noise,
            ),
        )


def calibrate_arm(data: Path, /, *, cfg: CalibrateArmCfg, common: Common = Common()) -> None:
    """Calibrate a real arm from measured poses, and judge on poses that were held out.

    data: table of poses, a ROS bag, or a published set (docs/real.md). Writes summary.json, the
    calibrated robot (TOML, URDF, C), joint_errors.csv, next_poses.csv, and pictures of the
    residuals.
    """
    from armside.kinematics.calibration import fit_prepared, prepare
    from armside.sim.recordings import read_poses

    from ..figures import calibration as shown

    report = Report(common)
    with checking_input():
        arm, source = load_robot(cfg.robot).arm, read_poses(data, cfg.topics())
        prepared = prepare(arm, source.measurements, cfg.configuration(), seed=common.seed)
    try:
        (done,) = report.each("calibrating", fit_prepared, [prepared])
    except (ValueError, ArithmeticError) as error:
        raise RunFailed(f"the fit failed: {one_line(error)}") from error
    found = {"form": source.form, "notes": source.notes} | shown.results(done)
    outcome = summary("calibrate-arm", cfg, common, data=data, **found)
    with run_folder(outcome, common) as folder:
        shown.write(folder, done, arm, cfg.next, common.seed)
    report.lines(source.notes)
    shown.tables(report, outcome)
    report.results(outcome, folder.path)
