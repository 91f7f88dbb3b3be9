"""The limit states of NTC 2018, §2.1, in the orders that checks, quotations and indices use."""

CHECKS = ("SLO", "SLD", "SLV linear", "SLV", "SLC")  # beside the nonlinear check at SLV the linear one
QUOTED = ("SLC", "SLV", "SLD", "SLO")  # the farthest first
INDEXED = ("SLV", "SLC")  # where the ratio of a_g borne to a_g demanded is the index ζ_E (NTC 2018, §8.3)
