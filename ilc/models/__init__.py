"""Linear systems and the flexible two-mass joint of thesis chapter 8."""
