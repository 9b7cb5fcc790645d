"""The virtual robot: model, drives, elasticity, servo, and its recorded runs."""
