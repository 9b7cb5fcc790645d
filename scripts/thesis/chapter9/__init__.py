"""Chapter 9 of the thesis: its experiments, designs, figures and bands."""

from .sections import ENTRIES as ENTRIES
