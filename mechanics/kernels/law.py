"""What a joint obeys, as compiled loops take it: the columns of `law` (j, LAW)."""

# friction (inf: no sliding); share ψ of μ|slip| by which sliding lifts (0: Coulomb's law, 1: the associative one);
# compliance in shear, m/kN; stiffness of the bed, kN/m² (inf: rigid); slip from which the slide counts, m;
# strength, kN/m (inf: none); segments of a bed of points (0: exact); lines, m, above which a bed begins, two values
# each: three that a bed of finite strength remembers of having been crushed (crushing), and that of the dashpots of a
# step (dynamics.gaps)
FRICTION, DILATION, SHEAR, BED, SLID, STRENGTH, SEGMENTS, LEFT = range(8)
DASHPOTS = LEFT + 6
LAW = 15
CRUSHED = 0.99  # of the strength: the force of a joint that is crushed, of a tie that yields
