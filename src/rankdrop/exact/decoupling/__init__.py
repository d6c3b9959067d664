"""Block triangular Jacobians (ML, JL): the arm and its wrist, or a planar triple, apart."""
