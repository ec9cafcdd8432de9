"""How far a capture is from a model, and what an effect would take off."""
