"""Noise estimators, one per file and named as its function; of ours they see frames alone.

`correction/` has the steps of the corrected one.
"""
