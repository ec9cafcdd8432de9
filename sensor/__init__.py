"""Photo-electrons to pixels: camera, one file per effect, protocol, capture, frames, truth."""
