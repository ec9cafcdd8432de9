"""Reading what cameras and other programs write: one file a family of formats, with a READER."""
