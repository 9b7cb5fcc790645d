"""Error measures: norms, circles, ISO 9283."""
