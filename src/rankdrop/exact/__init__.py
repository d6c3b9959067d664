"""Singularity conditions derived exactly: polynomials in half-angle tangents, factored, split, and checked."""
