"""Whole sets of captures from one specification: planned, made piece by piece, listed."""
