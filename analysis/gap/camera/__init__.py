"""The base camera, its light, and its twin."""
