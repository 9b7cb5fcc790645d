"""The laser cutting experiment."""
