"""Where the printed technique is biased, by how much, and because of what."""
