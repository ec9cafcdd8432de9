"""Real against simulated: where a gap lies, which effect causes it, how far it shrinks.

A capture goes through these folders from top to bottom, and each imports only from those above it:

look/        a capture as measured samples, and what is looked at: one file per family of figures
camera/      the base camera, its light, and its twin: the same capture, simulated
calibrate/   the base camera from the capture itself; distances with what calibration takes up
ready/       a capture made ready: which frames, which light, and what the frames tell by themselves
measure/     how far a capture is from a model, and what an effect would take off
suspects/    every effect at the strength that fits, and which of them is the likeliest
verdict/     what may be said of it
diagnose.py  the whole; report.py what comes out
"""
