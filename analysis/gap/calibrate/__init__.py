"""The base camera of a capture, and a space without what calibration takes up."""
