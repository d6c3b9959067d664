"""Exact conditions for people and programs: text, LaTeX, Python, C, numeric equations."""
