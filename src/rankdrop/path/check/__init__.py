"""Paths proven free between their samples; what happens where they are not."""
