"""Pixels to knowledge: estimators, round trips, studies, and real against simulated."""
