"""The viewer: an arm in a browser page, with what its configuration means for its singularities.

`scene`, `live`, `panel`, `slices`, `trajectory`, `gate` and `session` know nothing of the browser and are tested
without one; `server`, `stage` and `controls` put them on a page by the package viser.
"""
