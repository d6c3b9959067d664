"""Conditions that people write, read exactly and held against the singular set."""
