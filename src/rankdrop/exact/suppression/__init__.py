"""Dependent-screw suppression (KG): disjoint families, proved step by step."""
