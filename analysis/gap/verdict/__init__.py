"""What may be said, and the trail that leads there."""
