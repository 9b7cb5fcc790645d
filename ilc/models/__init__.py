"""Models of plants: linear systems, and the flexible two-mass joint of thesis chapter 8."""
