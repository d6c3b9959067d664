"""Robots from and to the models of other packages, each imported where it is needed."""
