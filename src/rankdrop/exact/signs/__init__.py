"""The signs of the factors of a determinant: in which aspect a configuration lies, and what parts two of them."""
