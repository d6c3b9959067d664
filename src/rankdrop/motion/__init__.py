"""Paths: read, judged between their samples, and how near they come to a singularity."""
