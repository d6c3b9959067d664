"""Polynomials, irreducible sets, systems of conditions taken apart; nothing here knows of robots."""
