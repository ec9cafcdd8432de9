"""Which camera, measured as the paper measured, gives the figures that the paper prints."""
