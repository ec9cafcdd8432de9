"""What is looked at in a capture, real or simulated, by the same code."""
