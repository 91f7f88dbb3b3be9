"""Linear algebra: where the numbers of a sparse matrix stand, its factors, and substitution."""
