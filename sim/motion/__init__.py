"""Tool motion: geometric paths, their timing, and programs of them."""
