"""The mathematics of the core once more, as plain NumPy written for reading: the oracle of the tests.

Nothing here is fast and nothing here is shipped. Import it as `from reference import kinematics`.
"""
