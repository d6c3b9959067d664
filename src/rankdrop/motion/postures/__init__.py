"""Postures: the solutions of the inverse, the aspects they lie in, and ways from one to another without singularity."""
