"""Real against simulated: where a gap lies, which effect causes it, how far it shrinks.

lattices      a capture as stacks of samples that were measured, not interpolated
statistics/   what is looked at: one file per family
observe       every statistic of a capture, in groups of frames, and its mean images
calibrate     the base camera and its light, from the capture itself
twin          the same capture, simulated
metric        distances in standard errors, with what calibration may absorb taken out
suspects      how each effect would show, at which strength it fits
verdict       what may be said of it
"""
