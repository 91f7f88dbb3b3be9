"""What a joint obeys, as compiled loops take it: the columns of `law` (j, LAW)."""

# friction; compliance in shear, m/kN; stiffness of the bed, kN/m² (inf: rigid); slip from which the slide counts, m;
# strength, kN/m (inf: none); segments of a bed of points (0: exact)
FRICTION, SHEAR, BED, SLID, STRENGTH, SEGMENTS = range(6)
# of a bed whose gap is bent, in time stepping: place of the bend, from the middle of the overlap; u and φ of the gaps
# at the start; factors of these below and above the bend (equal: no bend)
KINK, U0, PHI0, BELOW, ABOVE = range(6, 11)
LAW = 11
