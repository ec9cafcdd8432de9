"""What several estimators share, one step per file: none of them is a method by itself."""
