"""The chapters of the thesis as reports with computed verdicts."""
