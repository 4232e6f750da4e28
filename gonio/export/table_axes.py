"""The axes of the tables that exports look up."""

# Cosines of a row of F, evenly spaced from 0 to 1 (Elek, section 3.1).
COSINES = 128

# Sines and widths of D; and the most that are an array in a shader, whose compiler copies it: for proofs.
PLACES = 512
ARRAY_PLACES = 32
