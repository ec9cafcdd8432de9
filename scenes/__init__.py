"""What is in front of the camera: chart, lamps, lens and where they stand, as data.

Nothing here computes light; `render` does.
"""
