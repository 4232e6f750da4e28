"""What a model is, in words: its description, and the publications it comes from."""
