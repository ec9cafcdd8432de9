"""Which effect: every one at the strength that fits, the likeliest first."""
