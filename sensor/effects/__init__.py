"""One file per effect. A file put here is in the catalogue; nothing else needs to change."""
