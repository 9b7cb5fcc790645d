"""The tool's path over a whole part as measured output."""
