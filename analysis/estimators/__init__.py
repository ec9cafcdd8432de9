"""Noise estimators, one per file and named as its function; of ours they see frames alone.

Every file here is a `--method` of that name. `parts/` has the steps that several of them share,
`correction/` those of the corrected one alone.
"""
