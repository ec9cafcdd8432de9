"""Add effects to the base camera, one after the other, as long as they explain what is left."""
