"""The paper's own figures and tables, made again: printed values beside ours."""
