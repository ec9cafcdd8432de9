"""What is looked at: one file per family of statistics, each a function of one group of frames.

A family is a function from a `Group` to figures by name. Figures are pure numbers, or DN, and do
not depend on the size of the image, so that a crop and a whole frame can be compared.
"""
