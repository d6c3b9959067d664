"""Paths changed so that they are free: local remedies, time laws."""
