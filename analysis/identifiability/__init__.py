"""What a protocol can tell apart, predicted from simulated signatures without any real frames.

known      a camera whose figures are known, as the diagnosis would have calibrated it
limits     the strength at which an effect stands five standard errors from zero
shots      shots that one might take
subsets    what some of the shots tell of each effect
recommend  the shots that separate most effects for the fewest frames
"""
