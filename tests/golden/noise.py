"""Recorded outputs without what differs from run to run."""

from __future__ import annotations

import re


def without_time(text: str) -> str:
    """The same text, whatever the time taken."""
    return re.sub(r"Time\s+taken:\s+[\d.]+\s+s\.", "Time taken: (some) s.", text)


def without_noise(text: str) -> str:
    """The same text, whichever of two equal motions was taken, and however many searches ended at the nearest."""
    text = re.sub(r"\d+\s+of\s+\d+\s+searches agree;\s+σ there at most [^ \n]+", "(most) searches agree", text)
    text = re.sub(r"best (direction|two joints):[^σ]*σ", r"best \1: (motion) σ", text)  # an ascent, near a flat top
    return re.sub(r"[+−](?=[\d.]+(°| m\b))", "±", text)
