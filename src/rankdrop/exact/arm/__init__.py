"""A robot over the exact ring: its twists, lengths and screws, and what its axes have to do with each other."""
