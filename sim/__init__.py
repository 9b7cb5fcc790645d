"""Virtual hardware: robots in MuJoCo with motor encoders, an IMU and a laser tracker."""
