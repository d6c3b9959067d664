"""The five source documents, item by item: what they print, what rankdrop computes, and whether the two agree.

    >>> from papers.run import reproduce
    >>> found = reproduce("ML")
    >>> found.differs, found.count("erratum") > 0
    ((), True)

AM is Almarkhi and Maciejewski, Singularity Analysis for Redundant Manipulators of Arbitrary Kinematic Structure; ML
Memon's lecture Kinematic Singularities; GR Gallardo-Alvarado and Rico-Martínez, An Application of the Lie Product to
the Higher Singular Configurations Problem of Serial Manipulators; KG the dependent-screw suppression paper on 7-DOF
redundant manipulators; JL Jin's Lecture 13, Singularity and Redundancy.
"""
